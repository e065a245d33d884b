"""A session as browsers have it: all of it in a WebSocket, without datagrams, seal and resumption."""
import select
import time

from context_codec import NoReference
from fields import Malformed
from messages import FEEDBACK, PARITY, RESUME
from session import Session
from websocket import WebSocket


class BrowserSession(Session):
    def _connect(self, host, port, pin, certificate, key, name):
        assert not (self.hello_features & (FEEDBACK | PARITY | RESUME)), "no browser asks for these"
        return WebSocket(host, port, pin)

    def __init__(self, host, port, pin, hello, patience_s=60):
        self.hello_features = hello.features
        super().__init__(host, port, pin, hello, patience_s=patience_s)

    def _open_data_channel(self):
        self.feedback = False
        self.sizes = True

    def _begin_path(self):
        """Nothing is to be shown: there is no address but that of the connection."""

    def _send(self, kind, body):
        self.last_sent = time.monotonic()
        self.control.send_data(kind, body)

    def poll(self, timeout_s):
        wait = min(timeout_s, self.welcome.silence_timeout_ms / 1000 / 4)
        select.select([self.control.socket], [], [], max(0, wait))
        for message in self.control.messages():
            if isinstance(message, tuple):
                self._take_data(*message)
            else:
                self._heed(message)
        self._say_what_is_due()

    def _take_data(self, kind, body):
        try:
            self._take(kind, body)
        except NoReference:
            self.counts["no_reference"] += 1
        except Malformed as error:
            self.counts["malformed"] += 1
            self.last_malformed = error
