#!/usr/bin/python3
"""Browsers as clients of the real daemon: the page, sessions in a WebSocket with the same masks as over UDP, and what
strangers may not do.

    browser_test.py BUILD
"""
import base64
import ctypes
import gzip
import hashlib
import json
import os
import pathlib
import re
import socket
import subprocess
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "ops"))
from node import ROOT, Node, eventually, skip

try:
    from messages import MOMENTS, PATHS, REFERENCES, Bye, Hello, Refusal, Stats
    from session import RefusedBy, Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")

from browser_session import BrowserSession
from control import Closed, NotTheServer
from mask_codecs import CONTEXT, RAW32, TILES
from websocket import BINARY, CLOSE, CONTINUATION, PING, TEXT, Browser, WebSocket
from wire_client import turned

BUILD = sys.argv.pop(1)
SIZE = 256, 128
CAMERAS, STEP = 3, 0.05
MOST_BYTES = 150_000  # what a browser loads before the first scene, each file compressed by itself


def fields_of(output):
    return dict(line.split() for line in output.splitlines())


def preloads_of(page):
    return re.findall(r'<link rel="modulepreload" href="([^"]*)">', page.body.decode())


def imported(module, seen=None):
    """The modules of web/ that this one imports, itself first: as its text says, which is not what the daemon goes by."""
    seen = {} if seen is None else seen
    if module not in seen:
        text = (ROOT / "web" / module).read_text()
        seen[module] = re.findall(r"^(?:import|export|\})[^'\n]*'(\.[^']*)';$", text, re.MULTILINE)
        for path in seen[module]:
            imported(os.path.normpath(pathlib.PurePosixPath(module).parent / path), seen)
    return list(seen)


class Browsers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = Node(BUILD, render={"tracer": "bvh"}, server={"silence_timeout_ms": 60_000},
                        web={"listen": True, "progress_timeout_ms": 3000}, log={"level": "debug"})
        cls.addClassCleanup(cls.node.__exit__)
        token = fields_of(subprocess.check_output([cls.node.bin / "gnomonctl", "make-token"], text=True))
        cls.token = token["token"]
        cls.node.config["tenants"].append({"name": "vault", "token_sha256": [token["token_sha256"]]})
        cls.node.start()

    @classmethod
    def where(cls, node=None):
        host, port = (node or cls.node).control.rsplit(":", 1)
        return host, int(port), (node or cls.node).pin

    def opened(self, connection):
        self.addCleanup(connection.close)
        return connection

    def browser(self):
        return self.opened(Browser(*self.where()))

    def websocket(self, **fields):
        return self.opened(WebSocket(*self.where(), **fields))

    def session(self, kind=BrowserSession, **hello):
        hello = {"scene": "living_room", "tenant": "studio", "width": SIZE[0], "height": SIZE[1], **hello}
        session = kind(*self.where(), Hello(**hello))
        self.addCleanup(session.abandon)
        return session

    # ---- the page

    def test_the_page_and_its_guards(self):
        browser = self.browser()
        page = browser.ask("/")
        self.assertEqual((page.status, page.fields["content-type"]), (200, "text/html; charset=utf-8"))
        preloads = b"".join(b'<link rel="modulepreload" href="%s">\n' % each.encode() for each in preloads_of(page))
        (script,) = re.findall(rb"<script>(.*?)</script>", page.body, re.S)
        source = page.body.replace(preloads, b"").replace(b">" + script + b"<", b' src="start.js"><')
        self.assertEqual(source, (ROOT / "web/index.html").read_bytes())
        self.assertEqual(page.fields["cache-control"], "no-cache")
        policy = page.fields["content-security-policy"]
        self.assertNotIn("unsafe-inline", policy)
        self.assertIn(f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'", policy)
        for rule in ("default-src 'none'", "connect-src 'self'", "frame-ancestors 'none'", "base-uri 'none'"):
            self.assertIn(rule, policy)
        self.assertEqual(page.fields["x-content-type-options"], "nosniff")
        self.assertEqual(page.fields["referrer-policy"], "no-referrer")
        # On the same connection: from the cache, its header alone, in Brotli.
        again = browser.ask("/", If_None_Match=page.fields["etag"])
        self.assertEqual((again.status, again.body), (304, b""))
        head = browser.ask("/index.html", method="HEAD")
        self.assertEqual((head.status, head.fields["content-length"]), (200, str(len(page.body))))
        packed = browser.ask("/", Accept_Encoding="gzip, br")
        if packed.fields.get("content-encoding") == "br":
            self.assertLess(len(packed.body), len(page.body))
            self.assertNotEqual(packed.fields["etag"], page.fields["etag"])
        self.assertEqual(browser.ask("/nothing").status, 404)
        self.assertEqual(browser.ask("/../../etc/passwd").status, 404)

    def test_the_page_names_the_modules_that_it_imports(self):
        preloads = preloads_of(self.browser().ask("/"))
        self.assertEqual(sorted(preloads), sorted(imported("app.js")))
        self.assertGreater(len(preloads), 40)

    def test_the_page_with_its_decoder_is_small(self):
        browser = self.browser()
        files = [file.relative_to(ROOT / "web") for kind in ("html", "css", "js", "svg")
                 for file in (ROOT / "web").glob(f"**/*.{kind}")]
        bodies = {file: browser.ask(f"/{file}") for file in [*files, pathlib.PurePosixPath("wasm/decoder.wasm")]}
        served = {file: answer for file, answer in bodies.items() if answer.status == 200}
        self.assertLessEqual(set(files), set(served))
        modules = {name for first in ("app.js", "worker.js", "lane.js") for name in imported(first)}
        loaded = {file: answer for file, answer in served.items() if file.suffix != ".js" or str(file) in modules}
        size = sum(len(gzip.compress(answer.body)) for answer in loaded.values())
        print(f"{len(loaded)} files of {len(served)}, {size} bytes compressed by gzip", flush=True)
        self.assertGreater(len(loaded), 40)
        self.assertLessEqual(size, MOST_BYTES)

    def test_what_is_no_request_is_refused(self):
        self.assertEqual(self.browser().ask("/", method="DELETE").status, 405)
        long = self.browser()
        long.write("/", X=9000 * "x")
        self.assertEqual(long.answer().status, 431)
        for request in (b"\x16\x03\x01 nonsense\r\n\r\n", b"GET / HTTP/1.1\r\n\r\n",
                        b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"):
            other = self.browser()
            other.send(request)
            answer = other.answer()
            self.assertEqual((answer.status, answer.fields["connection"]), (400, "close"))
        body = self.browser()
        body.write("/", method="GET", Content_Length="5")
        self.assertEqual(body.answer().status, 413)

    def test_one_address_asks_for_so_much(self):
        """Then it is told to come back later; what costs more counts as more, and who has a session is left alone."""
        with Node(BUILD, web={"listen": True, "requests_per_s": 10}, log={"level": "debug"}) as node:
            node.start()
            session = BrowserSession(*self.where(node), Hello(scene="living_room", tenant="studio", width=64, height=64))
            self.addCleanup(session.abandon)

            def answers(target):
                browser, taken = self.opened(Browser(*self.where(node))), 0
                while (answer := browser.ask(target)).status == 200:
                    taken += 1
                self.assertEqual((answer.status, answer.fields["connection"], answer.fields["retry-after"]),
                                 (429, "close", "1"))
                with self.assertRaises(Closed):
                    browser.ask(target)
                return taken
            self.assertGreaterEqual(answers("/"), 199)  # of 200, the session's apart, and what came meanwhile
            self.assertEqual(answers("/qr/token.svg"), 0)
            self.assertGreater(node.metric("gnomon_refusals_total", reason="web_rate"), 0)
            session.picture(session.welcome.scene.default_camera)
            eventually(lambda: self.opened(Browser(*self.where(node))).ask("/").status == 200, "it may ask again")

    def test_foreign_names_are_refused(self):
        browser = self.browser()
        self.assertEqual(browser.ask("/", Host="attacker.example").status, 403)
        self.assertEqual(browser.ask("/", Host=f"localhost:{self.where()[1]}").status, 200)
        foreign = {"Origin": "https://attacker.example"}
        for fields in (foreign, {"Origin": "http://" + browser.host}, {"Origin": None}, {"Origin": "null"},
                       {"Host": "attacker.example", **foreign}):
            with self.assertRaisesRegex(Closed, "403"):
                self.websocket(**fields)
        with self.assertRaisesRegex(Closed, "400"):
            self.websocket(Sec_WebSocket_Protocol="chat")
        with self.assertRaisesRegex(Closed, "400"):
            self.websocket(Sec_WebSocket_Key="short")
        with self.assertRaisesRegex(Closed, "426"):
            self.websocket(Sec_WebSocket_Version="8")
        self.assertEqual(browser.ask("/session").status, 426)

    def test_a_daemon_that_was_not_told_so_serves_no_browsers(self):
        node = Node(BUILD, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        node.start()
        with self.assertRaises((Closed, NotTheServer)):
            Browser(*self.where(node))
        session = Session(*self.where(node), Hello(scene="living_room", tenant="studio", width=64, height=32))
        session.abandon()

    # ---- sessions

    def test_masks_are_those_that_come_by_udp(self):
        native = self.session(Session, codecs=(TILES,))
        cameras = [turned(native.welcome.scene.default_camera, STEP * step) for step in range(CAMERAS)]
        expected = [native.picture(camera).words for camera in cameras]
        native.close()
        for codec, features in ((TILES, MOMENTS), (RAW32, 0)):
            session = self.session(codecs=(codec,), features=features)
            frames = [session.picture(camera) for camera in cameras]
            self.assertEqual([frame.words for frame in frames], expected)
            self.assertEqual((session.counts["malformed"], session.counts["incomplete"]), (0, 0))
            session.close()
        print(f"{CAMERAS} cameras, {sum(map(len, expected[0]))} tiles each: the same bits over a WebSocket as over UDP")

    def test_references_and_statistics(self):
        session = self.session(codecs=(CONTEXT,), features=MOMENTS | REFERENCES)
        for step in range(CAMERAS):
            session.picture(turned(session.welcome.scene.default_camera, STEP * step))
        self.assertEqual(session.counts["references"] > 0, bool(session.welcome.features & REFERENCES))
        session.news.clear()
        while not any(isinstance(message, Stats) for message in session.news):
            session.poll(1)
        session.close()

    def test_a_frame_that_is_larger_than_the_connections_room_arrives_whole(self):
        session = self.session(codecs=(RAW32,), width=1600, height=896)
        frame = session.picture(session.welcome.scene.default_camera)
        sizes = sum(map(len, frame.slices.values()))
        print(f"a frame of {sizes} bytes in {frame.slice_count} slices came whole")
        self.assertGreater(sizes, 128 * 1024)
        self.assertEqual(session.counts["incomplete"], 0)

    def test_who_may_have_a_session_is_decided_as_elsewhere(self):
        before = self.node.log_text()
        with self.assertRaises(RefusedBy) as refused:
            self.session(tenant="vault", token="f" * 64)
        self.assertEqual(refused.exception.refused.code, Refusal.BAD_TOKEN)
        session = self.session(tenant="vault", token=self.token)
        session.picture(session.welcome.scene.default_camera)
        session.close()
        eventually(lambda: "session closed" in self.node.log_text()[len(before):], "the session is closed")
        self.assertNotIn(self.token, self.node.log_text())
        self.assertNotIn("f" * 64, self.node.log_text())

    def test_an_operator_sees_its_transport(self):
        session = self.session(tenant="arcade")
        before = self.node.metric("gnomon_transport_bytes_sent_total", transport="websocket")
        session.picture(session.welcome.scene.default_camera)
        mine = eventually(lambda: [s for s in self.node.status()["sessions"]
                                   if s["id"] == str(session.welcome.session) and s["transport"] == "websocket"],
                          "the session is shown")[0]
        self.assertEqual(mine["address"], self.where()[0])
        code, output = self.node.ctl("sessions")
        self.assertRegex(output, rf"{session.welcome.session} +arcade +living_room +\d+x\d+ +as granted +websocket")
        self.assertGreater(self.node.metric("gnomon_transport_sessions", transport="websocket"), 0)
        self.assertGreater(self.node.metric("gnomon_transport_bytes_sent_total", transport="websocket"), before)
        self.assertEqual(self.browser().ask("/").status, 200)
        self.assertGreater(self.node.metric("gnomon_web_requests_total", **{"class": "2xx"}), 0)
        session.close()
        eventually(lambda: all(s["id"] != str(session.welcome.session) for s in self.node.status()["sessions"]),
                   "the session is gone")

    def test_an_operator_closes_it(self):
        session = self.session()
        code, output = self.node.ctl("kick", str(session.welcome.session), "--why", "tested", "--for", "0s")
        self.assertEqual(code, 0, output)
        with self.assertRaisesRegex(Closed, "Bye: tested"):
            session.listen(10)
        with self.assertRaisesRegex(Closed, "WebSocket: 1000"):
            while True:
                list(session.control.messages())
                session.control.take(10)

    # ---- scenes

    def pack(self, browser, scene, **fields):
        """The page of a scene, and its pack, which is what the page says of it."""
        fields = {"Gnomon_Tenant": "studio", **fields}
        page = browser.ask(f"/scene/{scene}", **fields)
        self.assertEqual((page.status, page.fields["cache-control"]), (200, "no-store"), page)
        said = json.loads(page.body)
        self.assertEqual(said["pack"], f"/scene/{scene}/{said['sha256']}.pack")
        packed = browser.ask(said["pack"], Accept_Encoding="br", **fields)
        self.assertEqual((packed.status, packed.fields["content-encoding"]), (200, "br"), packed)
        self.assertEqual(packed.fields["cache-control"], "private, max-age=31536000, immutable")
        return said, packed.body

    def test_a_scene_is_packed_once_and_counted(self):
        def account():
            return next(scene["account_bytes"] for scene in self.node.status()["scenes"] if scene["name"] == "living_room")
        browser = self.browser()
        before = account()
        said, packed = self.pack(browser, "living_room")
        self.assertEqual(self.pack(self.browser(), "living_room"), (said, packed))
        self.assertEqual(self.node.log_text().count("scene packed for browsers"), 1)
        self.assertIn(account() - before, (len(packed), 0))  # 0: another test has asked before
        print(f"the pack of living_room: {said['bytes']} bytes, {len(packed)} in Brotli")
        studio = {"Gnomon_Tenant": "studio"}
        head = browser.ask(said["pack"], method="HEAD", Accept_Encoding="br", **studio)
        self.assertEqual((head.status, head.fields["content-length"]), (200, str(len(packed))))
        self.assertEqual(browser.ask(said["pack"], **studio).status, 406)
        other = browser.ask(f"/scene/living_room/{64 * '0'}.pack", Accept_Encoding="br", **studio)
        self.assertEqual(other.status, 404)
        unpacked = self.unpacked(packed)
        self.assertEqual((len(unpacked), hashlib.sha256(unpacked).hexdigest()), (said["bytes"], said["sha256"]))
        self.assertEqual(unpacked[:8], b"GNPACK01")

    @staticmethod
    def unpacked(packed):
        library = ctypes.CDLL("libbrotlidec.so.1")
        out = ctypes.create_string_buffer(1 << 28)
        size = ctypes.c_size_t(len(out))
        if library.BrotliDecoderDecompress(ctypes.c_size_t(len(packed)), packed, ctypes.byref(size), out) != 1:
            raise AssertionError("no Brotli")
        return out.raw[:size.value]

    def test_scenes_are_for_those_who_may_have_sessions(self):
        vault = {"Gnomon_Tenant": "vault"}
        wrong = self.browser().ask("/scene/living_room", Authorization="Bearer " + 64 * "f", **vault)
        unknown = self.browser().ask("/scene/living_room", Authorization="Bearer " + 64 * "f", Gnomon_Tenant="nobody")
        self.assertEqual((wrong.status, wrong.fields["connection"]), (401, "close"))
        self.assertEqual((unknown.status, unknown.body), (wrong.status, wrong.body))  # names are not given away
        self.assertEqual(self.browser().ask("/scene/no_such_scene", **vault).status, 401)
        mine = {"Authorization": "Bearer " + self.token, **vault}
        said, _ = self.pack(self.browser(), "living_room", **mine)
        self.assertEqual(self.browser().ask("/scene/no_such_scene", **mine).status, 404)
        self.assertEqual(self.browser().ask(said["pack"], Accept_Encoding="br", **vault).status, 401)
        for secret in (self.token, 64 * "f"):
            self.assertNotIn(secret, self.node.log_text())

    # ---- the WebSocket itself

    def closed_with(self, send):
        websocket = self.websocket()
        send(websocket)
        with self.assertRaises(Closed):
            while websocket.take(10):
                list(websocket.messages())
            raise Closed("the end")
        return websocket.closed_with

    def test_what_no_client_may_send_closes_it(self):
        hello = Hello(scene="living_room", tenant="studio", width=64, height=32).message()
        for code, send in ((1003, lambda w: w.send_frame(TEXT, b"hello")),
                           (1002, lambda w: w.send_frame(BINARY, hello, mask=b"")),
                           (1002, lambda w: w.send_frame(BINARY, hello, reserved=0x40)),
                           (1002, lambda w: w.send_frame(CONTINUATION, hello)),
                           (1002, lambda w: w.send_frame(3, b"")),
                           (1002, lambda w: w.send_frame(PING, 126 * b"x")),
                           (1003, lambda w: w.send_frame(BINARY, hello + hello)),
                           (1003, lambda w: w.send_frame(BINARY, hello[:-1])),
                           (1009, lambda w: w.send_frame(BINARY, 17_000 * b"x")),
                           (1000, lambda w: w.send_frame(CLOSE, b""))):
            self.assertEqual(self.closed_with(send), code)

    def test_fragments_and_pings(self):
        websocket = self.websocket()
        websocket.send_frame(PING, b"are you there?")
        hello = Hello(scene="living_room", tenant="studio", width=64, height=32, features=PATHS).message()
        websocket.send_frame(BINARY, hello[:10], final=False)
        websocket.send_frame(PING, b"between fragments")
        websocket.send_frame(CONTINUATION, hello[10:20], final=False)
        websocket.send_frame(CONTINUATION, hello[20:])
        got = []
        while not any(hasattr(message, "session") for message in got):
            self.assertTrue(websocket.take(30))
            got += websocket.messages()
        self.assertEqual(websocket.pongs, [b"are you there?", b"between fragments"])
        websocket.send(Bye("done").message())

    # ---- strangers' time

    def test_who_dawdles_is_cut_and_who_is_slow_is_not(self):
        idle = self.browser()
        self.assertFalse(idle.take(60))  # closed by the server, as nothing was asked
        slow = self.browser()
        for letter in b"GET / HTT":
            slow.send(bytes([letter]))
        eventually(lambda: not slow.take(60), "a request that is never complete is cut")
        self.assertGreater(self.node.metric("gnomon_refusals_total", reason="web_stalled"), 0)

    def test_a_flood_leaves_native_clients_their_places(self):
        flood = []
        for _ in range(64):
            connection = socket.create_connection(self.where()[:2])
            flood.append(self.opened(connection))
        session = self.session(Session)
        session.picture(session.welcome.scene.default_camera)
        session.close()


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[1:], verbosity=2)
