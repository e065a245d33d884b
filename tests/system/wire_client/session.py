"""A session of a client, after protocol/WIRE.md alone: cameras go out, frames come back."""
import hashlib
import hmac
import select
import socket
import struct
import time
from collections import Counter, OrderedDict
from dataclasses import replace

import messages
import seal
from arrivals import Arrivals
from context_codec import NoReference
from control import Closed, Control
from datagrams import (MOST_ACKNOWLEDGEMENTS, PING, TOKEN_BYTES, FrameParity, FrameSlice, Kind, camera_update,
                       feedback)
from fields import Malformed, require
from frame import Frame
from mask_codecs import CONTEXT

SO_TIMESTAMPNS = 35  # of Linux; Python has no name for it
FRAMES_KEPT = 32
REFERENCES_KEPT = 16
LONGEST_PROBED = 8952
SETTLED_S = 1  # what has not come by then does not come


class RefusedBy(Exception):
    def __init__(self, refused):
        super().__init__(f"refused, {refused.code.name.lower()}: {refused.text}")
        self.refused = refused


def now_us():
    return time.monotonic_ns() // 1000


class Session:
    def __init__(self, host, port, pin, hello, certificate=None, key=None, patience_s=60, fleet=None):
        """`fleet`: its name, where `host` is its door."""
        name = messages.server_name(hello.scene, fleet) if fleet else None
        self.door = host, port
        self.connect = lambda where=(host, port): self._connect(*where, pin, certificate, key, name)
        self.control = self.connect()
        features = hello.features | messages.PATHS | messages.WAITING
        self.hello = replace(hello, features=features | (messages.FLEET if fleet else 0))
        self.udp = None
        self.counts = Counter()
        self.news = []  # messages after Welcome
        self.waited_for = []  # texts of the messages Waiting
        try:
            self.control.send(self.hello.message())
            self.welcome = self._answer(patience_s)
            self._open_data_channel()
        except BaseException:
            self.control.close()
            raise
        self._adopt(self.welcome)
        self.arrivals = Arrivals()
        self.frames = OrderedDict()
        self.kept = {}  # words of whole frames that slices may refer to
        self.number = 0
        self.last_update = None
        self.last_sent = self.last_asked = 0.0
        self._begin_path()

    # ---- opening

    def _adopt(self, welcome):
        self.size, self.rate_hz = welcome.size, welcome.rate_hz
        self.soft = bool(welcome.features & messages.SOFT)
        self._light(welcome)

    def _light(self, message):
        """Takes the lights of a Welcome or a SceneChanged, and their samples."""
        self.areas, self.samples = message.areas, message.samples
        self.granted_samples = message.samples
        self.planes = messages.planes_of(message.samples, message.areas, len(message.scene.lights))

    @staticmethod
    def _connect(host, port, pin, certificate, key, name):
        return Control(host, port, pin, certificate, key, name=name)

    def _connect_again(self):
        """To the server itself where it has said how, as its door may know another one."""
        if self.welcome.features & messages.FLEET:
            try:
                return self.connect((self.welcome.home_host, self.welcome.home_port))
            except (OSError, Closed):
                pass
        return self.connect()

    def _answer(self, patience_s):
        deadline = time.monotonic() + patience_s
        while time.monotonic() < deadline:
            select.select([self.control.socket], [], [], deadline - time.monotonic())
            for message in self.control.messages():
                if isinstance(message, messages.Refused):
                    raise RefusedBy(message)
                if isinstance(message, messages.Welcome):
                    return message
                if isinstance(message, messages.Waiting):
                    deadline = time.monotonic() + patience_s
                    self.waited_for.append(message.text)
                    continue
                if not isinstance(message, int):
                    raise Malformed(f"{message} before Welcome")
        raise Closed("no answer to Hello")

    def _open_data_channel(self):
        welcome = self.welcome
        context = seal.exporter_context(welcome.session, welcome.cipher)
        secrets = [self.control.exported(label, context) for label in (seal.CLIENT_LABEL, seal.SERVER_LABEL)]
        self.feedback = bool(welcome.features & messages.FEEDBACK)
        self.sizes = bool(welcome.features & messages.SIZES)
        kinds = {Kind.FRAME_SLICE, Kind.PONG}
        kinds |= {Kind.PATH_CHALLENGE} if welcome.features & messages.PATHS else set()
        kinds |= {Kind.PROBE} if self.feedback else set()
        kinds |= {Kind.FRAME_PARITY} if welcome.features & messages.PARITY else set()
        self.sealer = seal.Sealer(seal.Keys(secrets[0], welcome.cipher), welcome.session)
        self.opener = seal.Opener(seal.Keys(secrets[1], welcome.cipher), welcome.session, kinds,
                                  LONGEST_PROBED if self.feedback else 1200)
        self.resumption = self.control.exported(seal.RESUMPTION_LABEL, struct.pack("<Q", welcome.session))
        self.open_socket()

    def resume(self, patience_s=60):
        """Goes on with the session on another control connection, whatever became of the one before."""
        control = self._connect_again()
        challenge = control.exported(seal.CHALLENGE_LABEL, struct.pack("<Q", self.welcome.session))
        proof = hmac.new(self.resumption, challenge, hashlib.sha256).digest()
        before, self.control = self.control, control
        before.socket.close()
        control.send(messages.Resume(self.welcome.session, proof).message())
        welcome = self._answer(patience_s)
        if welcome.session != self.welcome.session:
            raise Malformed("another session than the one to be resumed")
        self.welcome = welcome
        self._drop_frames()
        self._adopt(welcome)
        self.udp.close()
        self.open_socket()
        self._begin_path()

    def _begin_path(self):
        """The server challenges the address that this comes from, while the first camera is made."""
        if self.welcome.features & messages.PATHS:
            self._send(Kind.PING, PING)

    def open_socket(self):
        """Anew where the client's address has changed: the session goes on."""
        host, family = self.control.socket.getpeername()[0], self.control.socket.family
        if self.welcome.features & messages.FLEET:
            host = self.welcome.data_host
            family = socket.AF_INET6 if ":" in host else socket.AF_INET
        self.udp = socket.socket(family, socket.SOCK_DGRAM)
        self.udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self.udp.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.udp.setblocking(False)
        self.udp.connect((host, self.welcome.data_port))

    # ---- asking

    def ask(self, camera, deadline_us=0):
        """Sends a camera; the frame that its slices will fill. The server answers the newest alone if it is busy."""
        if self.rate_hz:
            self.listen(self.last_asked + 1 / self.rate_hz - time.monotonic())
        self.number = (self.number + 1) % (1 << 32)
        frame = self.frames[self.number] = Frame(self.number, self.size, self.planes, self.kept)
        while len(self.frames) > FRAMES_KEPT:
            self.frames.popitem(last=False)
        self.last_update = self.number, camera, now_us(), deadline_us
        self.last_asked = time.monotonic()
        self._send_update()
        return frame

    def picture(self, camera, patience_s=60):
        """A whole frame. An update without any answer is sent again, as it may be lost; a frame that stays without some
        slices, or was dropped, is asked for anew."""
        deadline = time.monotonic() + patience_s
        while time.monotonic() < deadline:
            frame = self.ask(camera)
            while self.frames.get(frame.number) is frame and time.monotonic() < deadline:
                had = len(frame.slices)
                self.settle(frame, SETTLED_S)
                if frame.complete():
                    return frame
                if frame.slices and len(frame.slices) == had:
                    break
                if not frame.slices:
                    self._send_update()
            self.counts["incomplete"] += 1
        raise Closed(f"no whole frame within {patience_s} s")

    def listen(self, time_s):
        """Takes what comes for so long."""
        until = time.monotonic() + time_s
        while time.monotonic() < until:
            self.poll(until - time.monotonic())

    def settle(self, frame, patience_s):
        """Takes what comes until the frame is whole or the time is over."""
        until = time.monotonic() + patience_s
        while not frame.complete() and time.monotonic() < until:
            self.poll(until - time.monotonic())

    def _send_update(self):
        acknowledgements = [] if self.feedback else self._acknowledgements()
        self._send(Kind.CAMERA_UPDATE, camera_update(*self.last_update, acknowledgements, max(self.kept, default=0)))

    def _acknowledgements(self):
        """Of the newest frames; said again with every update while there is room."""
        all_ = []
        for frame in reversed(self.frames.values()):
            for first in sorted({s // 64 * 64 for s in frame.slices}):
                bits = sum(1 << s - first for s in frame.slices if first <= s < first + 64)
                all_.append((frame.number, first, bits))
        return all_[:MOST_ACKNOWLEDGEMENTS]

    def _send(self, kind, body):
        self.send_datagram(self.sealer.seal(kind, body))

    def send_datagram(self, datagram):
        self.last_datagram, self.last_sent = datagram, time.monotonic()
        try:
            self.udp.send(datagram)
        except (BlockingIOError, ConnectionRefusedError):
            self.counts["not_sent"] += 1  # lost, like others

    # ---- receiving

    def poll(self, timeout_s):
        """Takes what comes within the time, until something has; sends what is due."""
        wait = min(timeout_s, self.welcome.silence_timeout_ms / 1000 / 4)
        if self.feedback and self.arrivals.since_last:
            wait = min(wait, 0.002)
        select.select([self.udp, self.control.socket], [], [], max(0, wait))
        self._take_datagrams()
        for message in self.control.messages():
            self._heed(message)
        self._say_what_is_due()

    def _take_datagrams(self):
        while True:
            try:
                datagram, ancillary, _, _ = self.udp.recvmsg(1 << 14, 64)
            except BlockingIOError:
                return
            except ConnectionRefusedError:
                continue
            opened = self.opener.open(datagram)
            if opened is None:
                self.counts["dropped"] += 1
                continue
            kind, sequence, body = opened
            self.arrivals.note(sequence, self._arrival_us(ancillary))
            self._say_what_is_due()  # before a slice that may take long to decode
            try:
                self._take(kind, body)
            except NoReference:
                self.counts["no_reference"] += 1
            except Malformed as error:
                self.counts["malformed"] += 1
                self.last_malformed = error

    @staticmethod
    def _arrival_us(ancillary):
        """By the clock of now_us(); the kernel's stamp is by the wall clock."""
        for level, type_, data in ancillary:
            if (level, type_) == (socket.SOL_SOCKET, SO_TIMESTAMPNS):
                seconds, nanoseconds = struct.unpack("@qq", data)
                return now_us() - max(0, time.time_ns() - (seconds * 10**9 + nanoseconds)) // 1000
        return now_us()

    def _take(self, kind, body):
        self.counts[Kind(kind).name.lower()] += 1
        if kind == Kind.PATH_CHALLENGE:
            require(len(body) >= TOKEN_BYTES, "a challenge without its token")
            self._send(Kind.PATH_RESPONSE, body[:TOKEN_BYTES])
        if kind in (Kind.PROBE, Kind.PONG, Kind.PATH_CHALLENGE):
            return
        part = (FrameSlice if kind == Kind.FRAME_SLICE else FrameParity).read(body)
        frame = self.frames.get(part.frame)
        if frame is None:
            self.counts["late"] += 1
            return
        if kind == Kind.FRAME_SLICE and (part.size or self.welcome.size) != self.size and self.sizes:
            self.counts["other_size"] += 1
        elif kind == Kind.FRAME_SLICE and self.soft and (part.samples or self.granted_samples) != self.samples:
            self.counts["other_samples"] += 1
        elif kind == Kind.FRAME_SLICE:
            self.counts["repeated"] += not frame.add_slice(body)
            self.counts["references"] += part.codec == CONTEXT and part.payload[0] == 1
        else:
            frame.add_parity(part)
        self.counts["recovered"] += frame.rebuild()
        if self.welcome.features & messages.REFERENCES and frame.complete() and frame.codecs == {CONTEXT}:
            self.kept[frame.number] = frame.words
            while len(self.kept) > REFERENCES_KEPT:
                del self.kept[min(self.kept)]

    def _heed(self, message):
        if isinstance(message, int):
            return
        if isinstance(message, (messages.Welcome, messages.Refused)):
            raise Malformed("a second answer to Hello")
        self.news.append(message)
        if isinstance(message, messages.Bye):
            stay_out = f"; stay out for {message.stay_out_ms} ms" if message.stay_out_ms else ""
            raise Closed(f"the server says Bye: {message.reason}{stay_out}")
        if isinstance(message, messages.SceneChanged):
            self.welcome.scene, before = message.scene, self.planes
            self._light(message)
            if self.planes != before:
                self._drop_frames()
        if isinstance(message, messages.LightsChanged):
            if len(message.lights) != len(self.welcome.scene.lights):
                raise Malformed("LightsChanged of another number of lights")
            self.welcome.scene.lights = message.lights
        if isinstance(message, messages.Degraded):
            samples = message.samples or self.samples
            if (message.size, samples) != (self.size, self.samples):
                self._drop_frames()
            self.size, self.rate_hz, self.samples = message.size, message.rate_hz, samples
            self.planes = messages.planes_of(samples, self.areas, len(self.welcome.scene.lights))

    def _drop_frames(self):
        """Of another shape than those to come."""
        self.frames.clear()
        self.kept = {}

    def _say_what_is_due(self):
        now = now_us()
        if self.feedback and self.arrivals.due(now):
            first, ages = self.arrivals.report(now)
            self._send(Kind.FEEDBACK, feedback(now, first, self.counts["recovered"], self.counts["incomplete"], ages))
        if self.last_update and time.monotonic() - self.last_sent > self.welcome.silence_timeout_ms / 1000 / 4:
            self._send_update()

    def close(self, reason="done"):
        try:
            self.control.send(messages.Bye(reason).message())
        except Closed:
            pass
        self.abandon()

    def abandon(self):
        """Without a Bye."""
        self.control.close()
        if self.udp:
            self.udp.close()

    def __enter__(self):
        return self

    def __exit__(self, type_, *_):
        self.close("failed" if type_ else "done")
