"""Connections that never get to the point, kept open in number: who is closed comes again. A program of its own, so
that what it does takes no time from who measures beside it.

    half_open.py HOST:PORT COUNT http|tls

Of each sort one of these: says nothing; says the beginning of what it should, a byte at a time; `tls` also those that
shake hands and then say nothing. Prints a line when COUNT were opened, ends when its standard input does.
"""
import selectors
import socket
import ssl
import sys
import time

DRIP_S = 0.2
SOURCES = 8  # addresses of ours, as of so many strangers
HTTP = b"GET /metrics HTTP/1.1\r\nHost: localhost\r\nUser-Agent: " + b"slow" * 1000


def client_hello():
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    context.check_hostname, context.verify_mode = False, ssl.CERT_NONE
    out = ssl.MemoryBIO()
    try:
        context.wrap_bio(ssl.MemoryBIO(), out).do_handshake()
    except ssl.SSLWantReadError:
        return out.read()


class Stranger:
    """`words`: what it says at once and what it says slowly."""

    def __init__(self, number, server, words):
        self.at_once, self.slowly = words[number % len(words)]
        self.socket = socket.socket()
        self.socket.bind((f"127.0.0.{2 + number % SOURCES}", 0))
        self.socket.setblocking(False)
        self.socket.connect_ex(server)
        self.said, self.next = 0, time.monotonic()

    def drip(self, now):
        """False: it was closed."""
        try:
            if self.at_once:
                self.socket.send(self.at_once)
                self.at_once = b""
            elif self.said < len(self.slowly) and now >= self.next:
                self.said += self.socket.send(self.slowly[self.said:self.said + 1])
                self.next = now + DRIP_S
            return True
        except BlockingIOError:
            return True
        except OSError:
            return False


def main(server, count, sort):
    host, port = server.rsplit(":", 1)
    hello = client_hello()
    words = {"http": [(b"", b""), (b"", HTTP)], "tls": [(b"", b""), (b"", hello), (hello, b"")]}[sort]
    poll, strangers, opened = selectors.DefaultSelector(), {}, 0
    poll.register(sys.stdin, selectors.EVENT_READ)
    while True:
        for _ in range(min(50, count - len(strangers))):  # a few at a time: the others must not wait
            stranger = Stranger(opened, (host, int(port)), words)
            strangers[stranger.socket] = stranger
            poll.register(stranger.socket, selectors.EVENT_READ)
            opened += 1
            if opened == count:
                print("opened", flush=True)
        now = time.monotonic()
        gone = {s for s, stranger in strangers.items() if not stranger.drip(now)}
        for key, _ in poll.select(0.02):
            if key.fileobj is sys.stdin:
                return
            try:
                if not key.fileobj.recv(65536):
                    gone.add(key.fileobj)
            except BlockingIOError:
                pass
            except OSError:
                gone.add(key.fileobj)
        for s in gone:
            poll.unregister(s)
            del strangers[s]
            s.close()


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), sys.argv[3])
