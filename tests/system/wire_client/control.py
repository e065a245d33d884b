"""The control connection: TLS 1.3 to a server that is known by its certificate's fingerprint."""
import datetime
import hashlib
import select
import socket
import time

from cryptography.hazmat.primitives.serialization import Encoding
from OpenSSL import SSL

from messages import take_message

ALPN = b"gnomon"


class NotTheServer(Exception):
    """Its certificate is another one, or has expired, or it speaks something else."""


class Closed(Exception):
    """The control connection is gone, and the session with it."""


class Control:
    def __init__(self, host, port, pin, certificate=None, key=None, patience_s=10, alpn=ALPN, name=None):
        """`pin`: "sha256:" and 64 hexadecimal digits. `certificate`, `key`: files with the client's own. `name`: what it
        says in TLS whom it wants."""
        context = SSL.Context(SSL.TLS_CLIENT_METHOD)
        context.set_min_proto_version(SSL.TLS1_3_VERSION)
        context.set_alpn_protos([alpn])
        self.alpn = alpn
        context.set_verify(SSL.VERIFY_NONE)  # the pin decides, whoever has signed
        if certificate:
            context.use_certificate_file(str(certificate))
            context.use_privatekey_file(str(key))
        self.socket = socket.create_connection((host, port), timeout=patience_s)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.socket.setblocking(False)
        self.tls = SSL.Connection(context, self.socket)
        self.tls.set_connect_state()
        if name:
            self.tls.set_tlsext_host_name(name.encode())
        self.received = bytearray()
        try:
            self._finish(self.tls.do_handshake, time.monotonic() + patience_s)
            self._check_server(pin)
        except BaseException:
            self.socket.close()
            raise

    def _check_server(self, pin):
        certificate = self.tls.get_peer_certificate().to_cryptography()
        fingerprint = "sha256:" + hashlib.sha256(certificate.public_bytes(Encoding.DER)).hexdigest()
        if fingerprint != pin.lower():
            raise NotTheServer(f"its certificate is {fingerprint}, not {pin}")
        now = datetime.datetime.utcnow()
        if not certificate.not_valid_before <= now <= certificate.not_valid_after:
            raise NotTheServer("its certificate is not valid today")
        if self.tls.get_alpn_proto_negotiated() != self.alpn:
            raise NotTheServer(f"it does not speak {self.alpn.decode()}")

    def _finish(self, operation, deadline):
        while True:
            try:
                return operation()
            except SSL.WantReadError:
                ready = select.select([self.socket], [], [], max(0, deadline - time.monotonic()))
            except SSL.WantWriteError:
                ready = select.select([], [self.socket], [], max(0, deadline - time.monotonic()))
            except (SSL.Error, OSError) as error:
                raise Closed(f"the control connection broke: {error!r}") from error
            if not any(ready):
                raise Closed("the server does not answer")

    def exported(self, label, context):
        """32 bytes of the session's exporter (RFC 8446, 7.5)."""
        return self.tls.export_keying_material(label, 32, context)

    def send(self, message, patience_s=10):
        deadline = time.monotonic() + patience_s
        while message:
            message = message[self._finish(lambda: self.tls.send(message), deadline):]

    def messages(self):
        """Those that have come, without waiting."""
        closed = None
        try:
            while True:
                self.received += self.tls.recv(1 << 16)
        except (SSL.WantReadError, SSL.WantWriteError):
            pass
        except (SSL.Error, OSError) as error:
            closed = Closed(f"the control connection broke: {error!r}")
        while (message := take_message(self.received)) is not None:
            yield message
        if closed:
            raise closed

    def close(self):
        try:
            self.tls.shutdown()
        except (SSL.Error, OSError):
            pass
        self.socket.close()
