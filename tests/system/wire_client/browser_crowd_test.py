#!/usr/bin/python3
"""Many browsers beside native clients of the real daemon: who is slow, who dawdles, who floods, and whose share it is.

    browser_crowd_test.py BUILD
"""
import pathlib
import select
import socket
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "ops"))
from node import Node, eventually, skip

try:
    from messages import MOMENTS, PATHS, WAITING, Hello, Welcome
    from session import Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")

from control import Closed
from datagrams import Kind, camera_update
from websocket import Browser, WebSocket

BUILD = sys.argv.pop(1)
PLACES = 32  # of connections that have not shown who they are
CROWD = 100
SIZE = 96, 64


class Tab:
    """A session in a WebSocket that asks for one frame after the other, and looks at none."""

    def __init__(self, where, tenant):
        self.websocket = WebSocket(*where)
        self.websocket.send(Hello(scene="living_room", tenant=tenant, width=SIZE[0], height=SIZE[1],
                                  features=MOMENTS | PATHS | WAITING).message())
        while not any(isinstance(message, Welcome) for message in self._news(60)):
            pass
        self.frame, self.slices, self.frames = 0, 0, 0

    def _news(self, wait_s):
        self.websocket.take(wait_s)
        news = list(self.websocket.messages())
        for message in news:
            if isinstance(message, Welcome):
                self.camera = message.scene.default_camera
        return news

    def ask(self):
        self.frame += 1
        self.slices = 0
        self.asked = time.monotonic()
        self.websocket.send_data(Kind.CAMERA_UPDATE, camera_update(self.frame, self.camera, 0, 0, [], 0))

    def poll(self):
        for message in self.websocket.messages():
            if isinstance(message, tuple) and message[0] == Kind.FRAME_SLICE:
                frame, number, count = (int.from_bytes(message[1][at:at + size], "little")
                                        for at, size in ((0, 4), (4, 2), (6, 2)))
                self.slices += frame == self.frame
                if self.slices == count:
                    self.frames += 1
                    self.ask()


class Crowds(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = Node(BUILD, render={"tracer": "bvh"},
                        server={"silence_timeout_ms": 900_000, "handshake_timeout_ms": 60_000, "max_half_open": PLACES},
                        web={"listen": True, "progress_timeout_ms": 2000})
        cls.addClassCleanup(cls.node.__exit__)
        cls.node.start()
        host, port = cls.node.control.rsplit(":", 1)
        cls.where = host, int(port), cls.node.pin

    def stalled(self):
        return self.node.metric("gnomon_refusals_total", reason="web_stalled")

    def slow_reader(self):
        """Has asked for the pack of a scene, and its connection holds little that was not read."""
        browser = Browser(*self.where, patience_s=60)
        self.addCleanup(browser.close)
        page = browser.ask("/scene/living_room", Gnomon_Tenant="studio")
        self.assertEqual(page.status, 200)
        browser.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 16 * 1024)
        browser.write(page.body.decode().split('"pack":"')[1].split('"')[0], Accept_Encoding="br",
                      Gnomon_Tenant="studio")
        browser.until(lambda: b"\r\n\r\n" in browser.received)
        head, _, _ = bytes(browser.received).partition(b"\r\n\r\n")
        length = int(head.lower().split(b"content-length: ")[1].split(b"\r\n")[0])
        return browser, len(head) + 4 + length

    def test_who_is_slow_but_steady_is_served_to_the_end(self):
        browser, bytes_ = self.slow_reader()
        before = self.stalled()
        began = time.monotonic()
        while len(browser.received) < bytes_:
            wanted = min(bytes_, len(browser.received) + bytes_ // 12)
            time.sleep(0.5)  # several times the patience in all
            browser.until(lambda goal=wanted: len(browser.received) >= goal)
        print(f"{bytes_} bytes taken in {time.monotonic() - began:.1f} s by a reader whose patience is 2 s a step")
        self.assertEqual(self.stalled(), before)

    def test_who_dawdles_over_an_answer_is_cut(self):
        browser, bytes_ = self.slow_reader()
        before = self.stalled()
        eventually(lambda: self.stalled() > before, "the dawdler is cut")
        with self.assertRaises(Closed):
            browser.until(lambda: len(browser.received) >= bytes_)

    def test_a_flood_of_requests_pushes_out_its_own(self):
        """Of one network, as many again as there are places; each has asked for something and waits."""
        flood = []
        native = Browser(*self.where)  # of the same network as the flood, so that it may be pushed out
        native.close()
        source = "127.0.0.9"
        create = socket.create_connection
        try:
            socket.create_connection = lambda address, timeout: create(address, timeout, (source, 0))
            for _ in range(2 * PLACES):
                browser = Browser(*self.where)
                self.addCleanup(browser.close)
                browser.write("/")
                flood.append(browser)
        finally:
            socket.create_connection = create
        session = Session(*self.where, Hello(scene="living_room", tenant="studio", width=64, height=32))
        session.picture(session.welcome.scene.default_camera)
        session.close()
        pushed_out = self.node.metric("gnomon_refusals_total", reason="half_open_replaced")
        print(f"{len(flood)} connections of one network over HTTP, {PLACES} places: {pushed_out:.0f} pushed out")
        self.assertGreater(pushed_out, 0)

    def test_a_crowd_of_browsers_has_its_tenants_share_and_no_more(self):
        tabs = [Tab(self.where, "studio") for _ in range(CROWD)]
        for tab in tabs:
            self.addCleanup(tab.websocket.close)
        native = self.node.load({"arcade": 8}, size=f"{SIZE[0]}x{SIZE[1]}", rate=1000, seconds=3600)
        self.addCleanup(native.kill)
        for tab in tabs:
            tab.ask()
        by_socket = {tab.websocket.socket: tab for tab in tabs}

        def serve_for(frames):
            """Until both tenants have got so many frames each from now on."""
            def sent():
                return self.node.metric_by_tenant("gnomon_visibility_buffers_total")
            before, looked = sent(), time.monotonic()
            while True:
                for ready in select.select(list(by_socket), [], [], 0.1)[0]:
                    by_socket[ready].poll()
                if time.monotonic() - looked > 0.5:
                    looked = time.monotonic()
                    now = sent()
                    if all(now.get(name, 0) - before.get(name, 0) >= frames for name in ("studio", "arcade")):
                        return
        serve_for(20)  # until both are busy
        before = self.node.metric_by_tenant("gnomon_tenant_gpu_seconds_total")
        serve_for(200)
        after = self.node.metric_by_tenant("gnomon_tenant_gpu_seconds_total")
        spent = {name: after[name] - before[name] for name in ("studio", "arcade")}
        share = spent["studio"] / sum(spent.values())

        def served():
            return sum(tab.frames > 0 for tab in tabs)
        rounds = 5  # 200 frames are two for each, but for those that were sent and not yet read
        print(f"{CROWD} browsers of one tenant beside 8 native clients of another, both always with work: "
              f"{share:.3f} of the device's time for the browsers; {served()} of them were served by then")
        while served() < CROWD and rounds > 0:
            rounds -= 1
            serve_for(CROWD)
        self.assertEqual(self.node.metric("gnomon_transport_sessions", transport="websocket"), CROWD)
        self.assertEqual(served(), CROWD)
        self.assertAlmostEqual(share, 0.5, delta=0.1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
