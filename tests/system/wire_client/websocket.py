"""A browser's connection: HTTP/1.1 over TLS, and the WebSocket (RFC 6455) that a session's control messages go over."""
import base64
import hashlib
import os
import select
import struct
import time

from OpenSSL import SSL

from control import Closed, Control
from fields import Malformed, require
from messages import framed, take_message

GUID = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG = 0, 1, 2, 8, 9, 10
DATA = 10  # the control message


class Answer:
    """Of an HTTP server: status, fields by their names in lower case, body."""

    def __init__(self, status, fields, body):
        self.status, self.fields, self.body = status, fields, body

    def __str__(self):
        return f"{self.status} {self.fields} {self.body[:200]!r}"


class Browser(Control):
    """A connection on which requests are made one after the other."""

    def __init__(self, host, port, pin, patience_s=10):
        super().__init__(host, port, pin, patience_s=patience_s, alpn=b"http/1.1")
        self.host, self.patience_s = f"{host}:{port}", patience_s

    def take(self, wait_s):
        """Adds what comes within the time to `received`, until something has. False if the server has closed."""
        while True:
            try:
                self.received += self.tls.recv(1 << 16)
                return True
            except SSL.WantReadError:
                if not select.select([self.socket], [], [], wait_s)[0]:
                    raise Closed("the server does not answer") from None
            except (SSL.Error, OSError):
                return False

    def until(self, complete):
        deadline = time.monotonic() + self.patience_s
        while not complete():
            if not self.take(max(0, deadline - time.monotonic())):
                raise Closed("the server has closed the connection")

    def ask(self, target, method="GET", **fields):
        """`fields`: an underscore in a name stands for a hyphen; None leaves one out."""
        self.write(target, method, **fields)
        return self.answer(method)

    def write(self, target, method="GET", **fields):
        fields = {"Host": self.host, **{name.replace("_", "-"): value for name, value in fields.items()}}
        lines = [f"{method} {target} HTTP/1.1", *(f"{name}: {value}" for name, value in fields.items() if value)]
        self.send(("\r\n".join(lines) + "\r\n\r\n").encode())

    def answer(self, method="GET"):
        self.until(lambda: b"\r\n\r\n" in self.received)
        head, _, _ = bytes(self.received).partition(b"\r\n\r\n")
        del self.received[:len(head) + 4]
        first, *lines = head.decode().split("\r\n")
        fields = {name.lower(): value.strip() for name, _, value in (line.partition(":") for line in lines)}
        length = 0 if method == "HEAD" else int(fields.get("content-length", 0))
        self.until(lambda: len(self.received) >= length)
        body = bytes(self.received[:length])
        del self.received[:length]
        return Answer(int(first.split()[1]), fields, body)


class WebSocket(Browser):
    """Has the interface of Control; a Data is yielded as the pair (kind, body)."""

    def __init__(self, host, port, pin, **fields):
        super().__init__(host, port, pin)
        key = base64.b64encode(os.urandom(16)).decode()
        asked = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec_WebSocket_Version": "13",
                 "Sec_WebSocket_Key": key, "Sec_WebSocket_Protocol": "gnomon", "Origin": "https://" + self.host}
        self.answered = self.ask("/session", **{**asked, **fields})
        if self.answered.status != 101:
            self.close()
            raise Closed(f"no WebSocket: {self.answered}")
        accept = base64.b64encode(hashlib.sha1((key + GUID).encode()).digest()).decode()
        require(self.answered.fields["sec-websocket-accept"] == accept, "another Sec-WebSocket-Accept")
        require(self.answered.fields["sec-websocket-protocol"] == "gnomon", "another subprotocol")
        self.closed_with = None
        self.pongs = []

    def send_frame(self, opcode, payload, final=True, mask=b"\x5a\x01\xff\x80", reserved=0):
        first = (0x80 if final else 0) | reserved | opcode
        size = len(payload)
        length = bytes([size]) if size < 126 else b"\x7e" + struct.pack(">H", size) if size < 1 << 16 else \
            b"\x7f" + struct.pack(">Q", size)
        if mask:
            payload = bytes(byte ^ mask[i % 4] for i, byte in enumerate(payload))
            length = bytes([length[0] | 0x80]) + length[1:] + mask
        self.send_raw(bytes([first]) + length + payload)

    def send_raw(self, data):
        super().send(data)

    def send(self, message, patience_s=10):
        if not hasattr(self, "closed_with"):
            return super().send(message, patience_s)  # still HTTP
        self.send_frame(BINARY, message)

    def send_data(self, kind, body):
        self.send(framed(DATA, struct.pack("<BQ", kind, 0) + struct.pack("<H", len(body)) + body))

    def frames(self):
        """Those that have come whole: opcode, payload."""
        while len(self.received) >= 2:
            require(self.received[0] & 0x70 == 0, "a reserved bit")
            require(self.received[0] & 0x80, "a server's frame in fragments")
            require(self.received[1] & 0x80 == 0, "a server's frame with a mask")
            length, at = self.received[1], 2
            if length >= 126:
                extra = 2 if length == 126 else 8
                if len(self.received) < 2 + extra:
                    return
                length, at = int.from_bytes(self.received[2:2 + extra], "big"), 2 + extra
            if len(self.received) < at + length:
                return
            opcode, payload = self.received[0] & 15, bytes(self.received[at:at + length])
            del self.received[:at + length]
            yield opcode, payload

    def messages(self):
        closed = None
        try:
            while True:
                self.received += self.tls.recv(1 << 16)
        except (SSL.WantReadError, SSL.WantWriteError):
            pass
        except (SSL.Error, OSError) as error:
            closed = Closed(f"the WebSocket broke: {error!r}")
        for opcode, payload in self.frames():
            if opcode == CLOSE:
                self.closed_with = int.from_bytes(payload[:2], "big")
                closed = Closed(f"the server closed the WebSocket: {self.closed_with}")
            elif opcode == PONG:
                self.pongs.append(payload)
            elif opcode == BINARY:
                yield self.message(payload)
            else:
                raise Malformed(f"a frame of opcode {opcode}")
        if closed:
            raise closed

    @staticmethod
    def message(payload):
        require(struct.unpack_from("<I", payload)[0] == len(payload) - 4, "not one control message in a WebSocket's")
        if struct.unpack_from("<H", payload, 4)[0] == DATA:
            kind, _, size = struct.unpack_from("<BQH", payload, 6)
            require(len(payload) == 17 + size, "a Data of another length")
            return kind, payload[17:]
        return take_message(bytearray(payload))
