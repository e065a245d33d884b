#!/usr/bin/python3
"""The client that was written from protocol/WIRE.md alone, with the real daemon: it gets the same bits as
gnomon-client, by every codec and cipher, over a bad link too; what strangers send has no effect.

    session_test.py BUILD
"""
import hashlib
import pathlib
import re
import signal
import socket
import ssl
import subprocess
import sys
import time
import unittest
from dataclasses import replace

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "ops"))
from node import Node, eventually, skip

try:
    import png
    from messages import (FEEDBACK, MOMENTS, PARITY, PATHS, REFERENCES, RESUME, Bye, Draining, Hello, LightsChanged,
                          Refusal, Stats, WAITING)
    from session import RefusedBy, Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")

from control import Closed, NotTheServer
from datagrams import Kind, camera_update
from mask_codecs import CONTEXT, LIT, RAW32, TILES
from seal import AES_128_GCM, CHACHA20_POLY1305
from wire_client import turned

BUILD = sys.argv.pop(1)
# The tangents of a camera twice as wide as high are exact, whoever computes them.
SIZE = 256, 128
ASKED_NOTHING = {(0, 0, 0), (70, 70, 85)}  # gnomon-client's colours of bits that mean nothing
COLOUR_OF_BIT = {1: (255, 255, 255), 0: (120, 30, 50)}
CAMERAS, STEP = 3, 0.05  # and radians between them
FAR, FRAMES = "127.0.0.9", 60  # of a bad link
SHORT_SILENCE_MS = 4000  # of the server that is listened to for longer than that


def fields_of(output):
    return dict(line.split() for line in output.splitlines())


class Sessions(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = Node(BUILD, render={"tracer": "bvh"}, server={"silence_timeout_ms": 60_000})  # decoding is slow here
        cls.addClassCleanup(cls.node.__exit__)
        token = fields_of(subprocess.check_output([cls.node.bin / "gnomonctl", "make-token"], text=True))
        cls.token = token["token"]
        cls.node.config["tenants"].append({"name": "vault", "token_sha256": [token["token_sha256"]]})
        cls.node.start()

    def session(self, host=None, node=None, **hello):
        node = node or self.node
        own_host, port = node.control.rsplit(":", 1)
        hello = {"scene": "living_room", "tenant": "studio", "width": SIZE[0], "height": SIZE[1], **hello}
        session = Session(host or own_host, int(port), node.pin, Hello(**hello))
        self.addCleanup(session.abandon)
        return session

    # ---- what comes

    def pictures_of_gnomon_client(self):
        """By light, rows of colours: what its own rasteriser makes of the bits that it gets for the first camera."""
        folder = self.node.folder / "view"
        subprocess.run([self.node.bin / "gnomon-client", "--server", self.node.control, "--pin", self.node.pin,
                        "--tenant", "arcade", "--scene", "living_room", "--size", f"{SIZE[0]}x{SIZE[1]}",
                        "--scene-dir", self.node.build / "share/gnomon/scenes",
                        "--frames", "1", "--view", "mask", "--out", folder],
                       check=True, stdout=subprocess.DEVNULL)
        files = sorted(folder.glob("mask_0000_light*.png"), key=lambda f: int(re.search(r"light(\d+)", f.name)[1]))
        for file in files:
            _, _, rows, _ = png.Reader(bytes=file.read_bytes()).asRGBA8()
            yield [[tuple(row[4 * x:4 * x + 3]) for x in range(SIZE[0])] for row in map(bytes, rows)]

    def test_bits_are_those_of_the_other_client(self):
        pictures = list(self.pictures_of_gnomon_client())
        for codec in (RAW32, TILES, CONTEXT):
            session = self.session(codecs=(codec,))
            frame = session.picture(session.welcome.scene.default_camera)
            session.close()
            self.assertEqual(frame.codecs, {codec})
            self.assertEqual(len(pictures), len(frame.words))
            self.compare(frame, pictures)

    def compare(self, frame, pictures):
        for light, picture in enumerate(pictures):
            compared = {0: 0, 1: 0}
            for y, row in enumerate(picture):
                for x, colour in enumerate(row):
                    if colour not in ASKED_NOTHING:
                        bit = frame.bit(light, x, y)
                        self.assertEqual(colour, COLOUR_OF_BIT[bit], f"light {light} at {x}, {y}")
                        compared[bit] += 1
            print(f"codec {frame.codecs}, light {light}: {compared[1]} lit and {compared[0]} dark pixels are the same")
            self.assertGreater(min(compared.values()), 1000)

    def flight(self, codec, cipher, features):
        """Frames at a few cameras, of a session of its own."""
        features |= PATHS | WAITING  # as every session's
        session = self.session(codecs=(codec,), ciphers=(cipher,), features=features)
        welcome = session.welcome
        self.assertEqual((welcome.codec, welcome.cipher, welcome.size), (codec, cipher, SIZE))
        self.assertIn(welcome.features, (features, features & ~REFERENCES))  # servers need not have these
        frames = [session.picture(turned(welcome.scene.default_camera, STEP * step)) for step in range(CAMERAS)]
        session.close()
        self.assertEqual([frame.codecs for frame in frames], CAMERAS * [{codec}])
        self.assertEqual((session.counts["malformed"], session.counts["dropped"]), (0, 0))
        self.assertEqual(session.counts["references"] > 0, bool(welcome.features & REFERENCES))
        return frames

    def test_codecs_and_ciphers_agree(self):
        frames = self.flight(TILES, AES_128_GCM, 0)
        for frame in frames:
            mixed = sum(word not in (0, LIT) for light in frame.words for word in light)
            self.assertGreater(mixed, 100)
        self.assertEqual(len({str(frame.words) for frame in frames}), CAMERAS)
        for codec, cipher, features in ((TILES, CHACHA20_POLY1305, FEEDBACK), (RAW32, AES_128_GCM, MOMENTS),
                                        (CONTEXT, AES_128_GCM, MOMENTS),
                                        (CONTEXT, CHACHA20_POLY1305, FEEDBACK | REFERENCES)):
            for frame, other in zip(frames, self.flight(codec, cipher, features)):
                self.agree(frame, other)

    def agree(self, frame, other):
        """All tiles are the same but those without a bit that means something, which are coded as lit or as dark."""
        for tiles, others in zip(frame.words, other.words, strict=True):
            for tile, same in zip(tiles, others, strict=True):
                if tile != same:
                    self.assertEqual(other.codecs, {CONTEXT})
                    self.assertEqual({tile, same}, {0, LIT})

    def over_a_bad_link(self, delay):
        """A session that has asked for frames at a steady pace while every tenth datagram was lost, each way."""
        control = self.node.control.rsplit(":", 1)[1]
        data = re.search(r" data=(\d+)", self.node.log_text())[1]
        log = self.node.folder / "netsim"
        with open(log, "w") as output:
            netsim = subprocess.Popen([self.node.bin / "netsim", "--listen", FAR, "--tcp", control, "--udp", data,
                                       "--loss", "10%", "--delay", delay], stdout=output, stderr=subprocess.STDOUT)
        self.addCleanup(netsim.wait)
        self.addCleanup(netsim.kill)
        eventually(lambda: "relaying" in log.read_text(), "netsim relays")
        far = self.session(FAR, features=FEEDBACK | PARITY)
        asked = []
        for step in range(FRAMES):
            camera = turned(far.welcome.scene.default_camera, 0.05 * step)
            asked.append((camera, far.ask(camera)))
            far.listen(0.1)
        far.listen(2)
        netsim.kill()
        whole = [(camera, frame) for camera, frame in asked if frame.complete()]
        answered = sum(bool(frame.slices) for _, frame in asked)
        print(f"{delay} each way: of {answered} frames that were answered {len(whole)} came whole; "
              f"{far.counts['frame_parity']} datagrams of parity, {far.counts['recovered']} slices rebuilt")
        self.assertEqual(far.counts["malformed"], 0)
        self.assertGreater(len(whole), answered / 2)
        near = self.session()
        for camera, frame in whole[-5:]:
            self.assertEqual(frame.words, near.picture(camera).words)
        return far

    def test_losses_are_sent_again(self):
        def again():
            return self.node.metric("gnomon_datagrams_retransmitted_total")
        before = again()
        self.over_a_bad_link("20ms")
        eventually(lambda: again() > before, "lost ones are sent again")

    def test_losses_are_rebuilt_where_sending_again_takes_too_long(self):
        self.assertGreater(self.over_a_bad_link("300ms").counts["recovered"], 0)

    def frames(self, node=None):
        """Answered to the tenant arcade, whose sessions go over no bad link."""
        return (node or self.node).metric("gnomon_visibility_buffers_total", tenant="arcade")

    def after_one_frame(self, node=None):
        """A session, and frames() with the one that it has got."""
        before = self.frames(node)
        session = self.session(node=node, tenant="arcade")
        session.picture(session.welcome.scene.default_camera)
        eventually(lambda: self.frames(node) == before + 1, "a frame is counted")
        return session, before + 1

    def test_signs_of_life(self):
        node = Node(BUILD, render={"tracer": "bvh"}, server={"silence_timeout_ms": SHORT_SILENCE_MS})
        self.addCleanup(node.__exit__)
        node.start()
        session, frames = self.after_one_frame(node)
        silence_s = session.welcome.silence_timeout_ms / 1000
        self.assertEqual(silence_s, SHORT_SILENCE_MS / 1000)
        sent = session.sealer.sequence
        session.listen(1.5 * silence_s)
        self.assertGreaterEqual(session.sealer.sequence - sent, 4)
        self.assertEqual(self.frames(node), frames, "an update said again asks for nothing")
        session.picture(session.welcome.scene.default_camera)

    # ---- who may

    def refusal(self, **hello):
        with self.assertRaises(RefusedBy) as raised:
            self.session(**hello)
        return raised.exception.refused

    def test_refusals(self):
        self.assertEqual(self.refusal(tenant="nobody").code, Refusal.BAD_TOKEN)
        self.assertEqual(self.refusal(tenant="vault").code, Refusal.BAD_TOKEN)
        self.assertEqual(self.refusal(tenant="vault", token="0" * 64).code, Refusal.BAD_TOKEN)
        self.assertEqual(self.refusal(scene="nowhere").code, Refusal.UNKNOWN_SCENE)
        self.assertEqual(self.refusal(passes=("sharpen",)).code, Refusal.UNKNOWN_PASS)
        self.assertEqual(self.refusal(version_min=1, version_max=1).code, Refusal.VERSION)
        self.assertEqual(self.refusal(version_min=3, version_max=2).code, Refusal.MALFORMED)
        too_large = self.refusal(width=65535, height=65535)
        self.assertEqual(too_large.code, Refusal.BAD_SIZE)
        self.assertTrue(too_large.fit_width and too_large.fit_height)
        session = self.session(tenant="vault", token=self.token)
        self.assertTrue(session.picture(session.welcome.scene.default_camera).complete())

    def test_another_certificate(self):
        host, port = self.node.control.rsplit(":", 1)
        with self.assertRaises(NotTheServer):
            Session(host, int(port), "sha256:" + "0" * 64, Hello("living_room", *SIZE))

    # ---- news

    def news(self, session, kind):
        """The first message of that kind."""
        def come():
            session.poll(0.5)
            return next((message for message in session.news if isinstance(message, kind)), None)
        return eventually(come, kind.__name__)

    def test_lights_that_change(self):
        session = self.session(features=MOMENTS)
        before = session.welcome.lights_version
        lights = session.welcome.scene.lights
        status, said = self.node.post("/scenes/living_room/lights/0", intensity=lights[0].intensity / 2)
        self.assertEqual(status, 202, said)
        changed = self.news(session, LightsChanged)
        self.assertGreater(changed.version, before)
        self.assertEqual(changed.lights, [replace(lights[0], intensity=lights[0].intensity / 2), *lights[1:]])
        camera = session.welcome.scene.default_camera
        eventually(lambda: session.picture(camera).moment[1] == changed.version, "frames of the new lights")

    def test_being_shown_out(self):
        session = self.session()
        self.assertEqual(self.node.ctl("kick", str(session.welcome.session), "--for", "2s",
                                       "--why", "too loud")[0], 0)
        with self.assertRaises(Closed) as raised:
            session.listen(60)
        self.assertIn("Bye: too loud; stay out for 2000 ms", str(raised.exception))
        refused = self.refusal()
        self.assertEqual(refused.code, Refusal.KEPT_OUT, refused.text)
        self.assertRegex(refused.text, r"kept out for another [12] s: too loud")
        time.sleep(2)
        self.session()

    # ---- what strangers send

    def rejected(self, **labels):
        return self.node.metric("gnomon_datagrams_rejected_total", **labels)

    def update(self, session, number):
        """A datagram that asks for a frame, not sent."""
        camera = session.welcome.scene.default_camera
        return session.sealer.seal(Kind.CAMERA_UPDATE, camera_update(number, camera, 0, 0, []))

    def test_tampering_has_no_effect(self):
        session, frames = self.after_one_frame()
        datagram = self.update(session, session.number + 1)
        before = self.rejected()
        touched = [bytes(b ^ (0x10 if i == place else 0) for i, b in enumerate(datagram))
                   for place in range(len(datagram))]
        touched += [datagram[:length] for length in range(len(datagram))]
        for bad in touched:
            session.send_datagram(bad)
        eventually(lambda: self.rejected() == before + len(touched), "all that was touched is counted")
        self.assertGreaterEqual(self.rejected(reason="forged"), len(datagram) - 20)
        session.send_datagram(datagram)
        eventually(lambda: self.frames() > frames, "the untouched one is answered")
        self.assertEqual(self.frames(), frames + 1, "and no other")

    def test_replays_are_counted_and_draw_nothing_to_a_stranger(self):
        session = self.session()
        frame = session.ask(session.welcome.scene.default_camera)
        session.settle(frame, 60)
        self.assertTrue(frame.complete())
        before = self.rejected(reason="replayed")
        with socket.socket(session.udp.family, socket.SOCK_DGRAM) as stranger:
            stranger.connect(session.udp.getpeername())
            for _ in range(10):
                stranger.send(session.last_datagram)
            eventually(lambda: self.rejected(reason="replayed") == before + 10, "replays are counted")
            self.assertTrue(session.picture(session.welcome.scene.default_camera).complete())
            stranger.setblocking(False)
            with self.assertRaises(BlockingIOError):
                stranger.recv(2048)

    def test_a_client_whose_address_changes_goes_on(self):
        session = self.session()
        camera = session.welcome.scene.default_camera
        here = session.picture(camera)
        session.udp.close()
        session.open_socket()
        there = session.picture(camera)
        self.assertEqual(there.words, here.words)

    def test_a_session_goes_on_with_another_control_connection(self):
        features = FEEDBACK | PARITY | REFERENCES | RESUME
        session = self.session(codecs=(CONTEXT,), features=features)
        self.assertEqual(session.welcome.features & RESUME, RESUME)
        camera, number = session.welcome.scene.default_camera, session.welcome.session
        before = session.picture(camera)
        for _ in range(3):
            session.control.socket.close()
            session.resume()
            self.assertEqual(session.welcome.session, number)
            self.agree(before, session.picture(camera))
        self.assertEqual((session.counts["malformed"], session.counts["dropped"]), (0, 0))
        secret, session.resumption = session.resumption, bytes(32)
        with self.assertRaises(RefusedBy) as raised:
            session.resume()
        self.assertEqual(raised.exception.refused.code, Refusal.UNKNOWN_SESSION)
        session.resumption = secret
        session.resume()
        self.agree(before, session.picture(camera))
        session.close()
        with self.assertRaises(RefusedBy):
            session.resume()


class Certificates(unittest.TestCase):
    """Of a server in production, whose tenants have certificates in the place of tokens."""

    def test_names_decide(self):
        node = Node(BUILD, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        subprocess.run([node.bin / "gnomonctl", "make-certs", "--out", node.folder / "tls", "--host", "127.0.0.1",
                        "--client", "studio", "--client", "ghost"], check=True, stdout=subprocess.DEVNULL)
        of = {name: node.folder / "tls" / name for name in ("server.pem", "server-key.pem", "ca.pem")}
        node.config["server"].update(mode="production", tls={
            "certificate": str(of["server.pem"]), "key": str(of["server-key.pem"]), "client_ca": str(of["ca.pem"])})
        node.start()
        pem = re.match("-.*?-----END CERTIFICATE-----\n", of["server.pem"].read_text(), re.S)[0]
        pin = "sha256:" + hashlib.sha256(ssl.PEM_cert_to_DER_cert(pem)).hexdigest()
        host, port = node.control.rsplit(":", 1)

        def session(tenant, names):
            files = [node.folder / "tls" / f"{names}{end}.pem" for end in ("", "-key")] if names else []
            made = Session(host, int(port), pin, Hello("living_room", *SIZE, tenant=tenant), *files)
            self.addCleanup(made.abandon)
            return made

        def refusal(tenant, names):
            with self.assertRaises(RefusedBy) as raised:
                session(tenant, names)
            return raised.exception.refused.code

        self.assertEqual(refusal("studio", None), Refusal.BAD_TOKEN)
        self.assertEqual(refusal("ghost", "ghost"), Refusal.UNKNOWN_TENANT)
        self.assertEqual(refusal("arcade", "studio"), Refusal.BAD_TOKEN)
        guest = session("studio", "studio")
        self.assertTrue(guest.picture(guest.welcome.scene.default_camera).complete())
        # A server that drains says so first, and Bye at the end.
        node.signal(signal.SIGTERM)
        with self.assertRaises(Closed):
            guest.listen(60)
        self.assertEqual([type(message) for message in guest.news if not isinstance(message, Stats)], [Draining, Bye])
        self.assertEqual(node.wait(), 0)


if __name__ == "__main__":
    unittest.main()
