#!/usr/bin/python3
"""Attacks over the data path by clients that have a session: frames aimed at somebody who did not ask, datagrams that were
held back, reports of what was never sent, a clock that runs backwards.

    abuse_link_test.py BUILD
"""
import dataclasses
import os
import pathlib
import socket
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "wire_client"))

from node import Node, eventually, skip

try:
    import messages
    from control import Closed
    from datagrams import PING, Kind, camera_update, feedback
    from mask_codecs import CONTEXT
    from session import Session, now_us
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")

BUILD = sys.argv.pop(1)
HEADERS = 28          # of IPv4 and UDP, which count at whom they reach
MOST_AMPLIFIED = 3    # RFC 9000, section 8
REPORTED = 50_000     # datagrams, as of a fast session in half a minute
FEATURES = {"none": 0, "feedback": messages.FEEDBACK, "feedback and parity": messages.FEEDBACK | messages.PARITY,
            "all": messages.FEEDBACK | messages.PARITY | messages.REFERENCES | messages.SIZES | messages.MOMENTS}


class Silent:
    """Somebody who answers nothing, and in whose name datagrams are sent."""

    def __init__(self, server, port, address="127.0.0.66"):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((address, 0))
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 24)
        self.socket.setblocking(False)
        self.server, self.sent, self.received = (server, port), 0, 0

    def send(self, datagram):
        self.socket.sendto(datagram, self.server)
        self.sent += len(datagram) + HEADERS

    def listen(self, time_s):
        until = time.monotonic() + time_s
        while time.monotonic() < until:
            try:
                self.received += len(self.socket.recv(1 << 16)) + HEADERS
            except BlockingIOError:
                time.sleep(0.005)

    @property
    def factor(self):
        return self.received / self.sent


class Liar(Session):
    """Reports truly what arrived, and by a clock that runs backwards when. Looks at no frame."""
    clock, step_us, reported = 10**15, -10_000, 0

    def _say_what_is_due(self):
        now = now_us()
        if self.arrivals.due(now):
            first, ages = self.arrivals.report(now)
            self.clock += self.step_us
            self.reported += len(ages)
            self._send(Kind.FEEDBACK, feedback(self.clock, first, 0, 0, ages))

    def _take(self, kind, body):
        if kind != Kind.FRAME_SLICE:
            super()._take(kind, body)


class Link(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = Node(BUILD, render={"tracer": "bvh"})
        cls.addClassCleanup(cls.node.__exit__)
        cls.node.start()
        host, port = cls.node.control.rsplit(":", 1)
        cls.server = host, int(port)

    def open(self, features=messages.FEEDBACK, codecs=(), tenant="studio", size=(256, 144), session=Session):
        hello = messages.Hello(scene="living_room", width=size[0], height=size[1], tenant=tenant, features=features,
                               codecs=codecs)
        session = session(*self.server, self.node.pin, hello)
        self.addCleanup(session.abandon)
        self.camera = session.welcome.scene.default_camera
        return session

    def update(self, session):
        session.number += 1
        return session.sealer.seal(Kind.CAMERA_UPDATE,
                                   camera_update(session.number, self.camera, int(time.time() * 1e6), 0, []))

    def silent(self, session):
        silent = Silent(self.server[0], session.welcome.data_port)
        self.addCleanup(silent.socket.close)
        return silent

    def where(self):
        """Where the sessions are, as the status says, which lists a new one and its address within about a second."""
        for _ in range(100):
            sessions = self.node.status()["sessions"]
            if sessions and all(s["address"] for s in sessions):
                return {s["address"].rsplit(":", 1)[0] for s in sessions}
            time.sleep(0.05)
        return set()

    def test_nobody_is_sent_frames_who_did_not_answer(self):
        """A client that has proved its address sends on in the name of another."""
        worst = 0
        for name, features in FEATURES.items():
            for codecs in ((0,), (1,)) + (((CONTEXT,),) if features & messages.REFERENCES else ()):
                with self.subTest(features=name, codecs=codecs):
                    session = self.open(features, codecs)
                    session.picture(self.camera)
                    silent = self.silent(session)
                    for _ in range(12):
                        silent.send(self.update(session))
                        silent.listen(0.05)
                    silent.listen(0.3)
                    self.assertLessEqual(silent.factor, MOST_AMPLIFIED)
                    worst = max(worst, silent.factor)
                    session.picture(self.camera)  # its own address is served on
                    session.close()
        print(f"to an address that answers nothing, in whose name a client goes on: at most {worst:.2f} of what was sent")

    def test_nobody_is_sent_frames_who_never_answered(self):
        session = self.open(tenant="arcade")
        session.udp.close()
        served = self.node.metric("gnomon_visibility_buffers_total", tenant="arcade")
        silent = self.silent(session)
        silent.send(session.sealer.seal(Kind.PING, PING))
        for _ in range(40):
            silent.send(self.update(session))
            silent.listen(0.02)
        silent.listen(0.5)
        print(f"to an address from which everything came, and that answers nothing: {silent.factor:.2f} of what was sent")
        self.assertGreater(silent.received, 0, "it is challenged")
        self.assertLessEqual(silent.factor, MOST_AMPLIFIED)
        self.assertEqual(self.node.metric("gnomon_visibility_buffers_total", tenant="arcade"), served)

    def test_a_datagram_that_was_held_back_moves_nothing(self):
        session = self.open()
        session.picture(self.camera)
        held = self.update(session)
        session.picture(self.camera)
        silent = self.silent(session)
        for _ in range(3):
            silent.send(held)
            silent.listen(0.1)
        self.assertEqual(silent.received, 0, "not even a challenge")
        self.assertEqual(self.where(), {"127.0.0.1"})
        session.picture(self.camera)

    def test_who_reports_what_was_never_sent_is_closed(self):
        session = self.open()
        session.picture(self.camera)
        with self.assertRaises(Closed):
            for first in range(0, 1 << 20, 512):
                session._send(Kind.FEEDBACK, feedback(int(time.time() * 1e6), first, 0, 0, [1] * 512))
                session.listen(0.005)
        eventually(lambda: not self.node.status()["sessions"], "the session closed")

    def processor_seconds(self):
        stat = pathlib.Path(f"/proc/{self.node.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(stat[11]) + int(stat[12])) / os.sysconf("SC_CLK_TCK")

    def cost_of_reports(self, session):
        """The least of three measurements, as the daemon may do other things beside."""
        return min(self.measured_cost_of_reports(session) for _ in range(3))

    def measured_cost_of_reports(self, session, count=6000):
        """Processor time of the daemon for each report that nothing has come, in microseconds."""
        before = self.processor_seconds()
        for number in range(count):
            session.clock += session.step_us
            session._send(Kind.FEEDBACK, feedback(session.clock, 0, 0, 0, []))
            if number % 20 == 19:
                session.poll(0.002)
        return (self.processor_seconds() - before) / count * 1e6

    def test_a_clock_that_runs_backwards_costs_no_more_as_more_is_reported(self):
        liar = self.open(codecs=(0,), size=(1280, 720), session=Liar)
        away = dataclasses.replace(self.camera, position=(1e4, 1e4, 1e4))  # nothing to trace, and frames as large as any
        while not liar.reported:
            liar.ask(away)
            liar.listen(0.5)
        before = self.cost_of_reports(liar)
        while liar.reported < REPORTED:
            liar.ask(away)
            liar.listen(0.005)
        after = self.cost_of_reports(liar)
        print(f"microseconds a report by a clock that runs backwards: {before:.1f}, and when {liar.reported} datagrams had "
              f"been reported {after:.1f}")
        self.assertLess(after, 2 * max(before, 10), "the cost grows with what was reported")
        honest = self.open(tenant="arcade")
        honest.picture(self.camera)
        honest.close()


if __name__ == "__main__":
    unittest.main(verbosity=2)
