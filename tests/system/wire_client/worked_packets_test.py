#!/usr/bin/python3
"""The worked packets of protocol/WIRE.md, read and made by this implementation.

    worked_packets_test.py WIRE.md
"""
import pathlib
import random
import re
import struct
import sys
import unittest
from dataclasses import replace

try:
    import cryptography, lz4, OpenSSL, xxhash  # noqa: E401, F401
except ModuleNotFoundError as error:
    print(f"skipped: Debian's python3-{error.name.lower()} is missing")
    sys.exit(77)

import parity
from context_codec import NoReference
from datagrams import PING, FrameParity, FrameSlice, Kind, age, camera_update, feedback
from fields import Malformed, Reader
from frame import Frame
from mask_codecs import LIT, decode
from messages import (FLEET, MOMENTS, Area, Bye, Camera, Degraded, Draining, Hello, Light, Manifest, Motion, Refusal, Refused,
                      Waiting, Welcome, planes_of, server_name, take_message)
from sample_points import DISC, RECTANGLE, SPHERE, offsets, pattern
from seal import AES_128_GCM, CHACHA20_POLY1305, Keys, Opener, Sealer

WIRE = pathlib.Path(sys.argv.pop(1)).read_text()
SESSION = 0x1122334455667788
SECRETS = bytes(range(32)), bytes(range(32, 64))
CAMERA = Camera((1, 1.5, -2), (0, 0.6, 0, 0.8), 0.75, 0.75, 0.5, 0.5, 0.0625)
ACKNOWLEDGEMENT = (6, 0, 0b111)
LIGHT_0 = [0x00000103070F1F3F, LIT]
LIGHT_1 = [0, 0x0000183C3C180000]


def packet(name):
    block = re.search(rf"^```hex {name}\n(.*?)^```", WIRE, re.M | re.S)
    return bytes.fromhex(re.sub(r"#.*", "", block.group(1)))


def read_back(camera):
    """As it is after the wire's binary32."""
    return Camera.read(Reader(camera.bytes()))


def a_slice(payload, tiles, lights, codec):
    return FrameSlice(1, 0, 1, 0, tiles, 0, lights, codec, 0, 0, (0, 0), None, None, payload)


class Packets(unittest.TestCase):
    def test_hello(self):
        hello = Hello("temple", 1984, 1116, 64, 36, 60, client="probe 1")
        self.assertEqual(hello.message(), packet("hello"))

    def test_welcome(self):
        light = Light(1, (0, 2, 0), (0, -1, 0), (1, 1, 0.5), 40, 8, 0.75, 0.5)
        camera = replace(read_back(CAMERA), tan_left=1, tan_right=1)
        scene = Manifest("temple", bytes(range(16)), 1000, (-1, 0, -1), (1, 2, 1), camera, [light])
        buffer = bytearray(packet("welcome"))
        self.assertEqual(take_message(buffer), Welcome(
            2, MOMENTS | FLEET, SESSION, 7600, AES_128_GCM, (1280, 640), 30, 1, ["shadows"], "bvh", 5000, scene, 3,
            [Motion("fan", 0, (0, 1, 0), 2_000_000)], "192.0.2.7", "192.0.2.7", 7600))
        self.assertEqual(buffer, b"")

    def test_addresses_of_a_fleet_are_numeric(self):
        named = packet("welcome").replace(b"192.0.2.7", b"192.0.2.x")
        with self.assertRaises(Malformed):
            take_message(bytearray(named))

    def test_server_names_of_a_fleet(self):
        said = re.search(r"`(s-[0-9a-f]{16}\.gnomon\.example)` for `temple`", WIRE)
        self.assertEqual(server_name("temple", "gnomon.example"), said[1])

    def test_path_validation(self):
        token = packet("path_token")
        opener = Opener(Keys(SECRETS[1], AES_128_GCM), SESSION, {Kind.PATH_CHALLENGE})
        self.assertEqual(opener.open(packet("path_challenge")), (Kind.PATH_CHALLENGE, 1, token))
        sealer = Sealer(Keys(SECRETS[0], AES_128_GCM), SESSION)
        sealer.seal(Kind.PING, PING)
        self.assertEqual(sealer.seal(Kind.PATH_RESPONSE, token), packet("path_response"))

    def test_refused(self):
        refused = take_message(bytearray(packet("refused")))
        self.assertEqual(refused, Refused(Refusal.OVER_CAPACITY, "full", 640, 320, 15))

    def test_waiting(self):
        waiting = bytearray(packet("waiting"))
        self.assertEqual(take_message(bytearray(waiting)), Waiting("reading the scene", 40))
        for percent, known in ((0, 0), (100, 100), (255, None)):
            self.assertEqual(take_message(waiting[:-1] + bytes([percent])).percent, known)
        with self.assertRaises(Malformed):
            take_message(waiting[:-1] + bytes([101]))

    def test_degraded(self):
        buffer = packet("degraded")
        self.assertEqual(take_message(bytearray(buffer)), Degraded((640, 320), 30, "load", [3], 4))
        older = struct.pack("<I", len(buffer) - 5) + buffer[4:-1]
        self.assertEqual(take_message(bytearray(older)), Degraded((640, 320), 30, "load", [3], None))
        with self.assertRaises(Malformed):
            take_message(bytearray(buffer[:-1] + b"\2"))

    def test_sample_points(self):
        numbers = struct.iter_unpack("<3f", packet("sample_points"))
        a_tenth = struct.unpack("<f", struct.pack("<f", 0.1))[0]
        for area in (Area(RECTANGLE, (0.5, 0, 0), (0, 0, 0.25)), Area(DISC, (0, a_tenth, 0), (0, 0, a_tenth)),
                     Area(SPHERE, (a_tenth, 0, 0), (0, a_tenth, 0))):
            for offset in offsets(area, 5, 2, 4):
                self.assertEqual(offset, next(numbers), area)
        self.assertIsNone(next(numbers, None))

    def test_every_window_has_every_pattern(self):
        for left in range(4):
            for top in range(4):
                window = {pattern(left + x, top + y) for x in range(4) for y in range(4)}
                self.assertEqual(window, set(range(16)))

    def test_counts_of_planes(self):
        planes = planes_of(16, [Area(), Area(SPHERE)], 2)
        self.assertEqual(planes, [(0, 1), (1, 16)])
        frame = Frame(1, (8, 8), planes)
        self.assertEqual(len(frame.words), 6)
        frame.words = [[1], [2], [0b100], [0b101], [0], [0b100]]
        self.assertEqual([frame.seen(0, x, 0) for x in range(3)], [1, 0, 0])
        self.assertEqual([frame.seen(1, x, 0) for x in range(3)], [4, 16, 13])

    def test_draining(self):
        buffer = packet("draining")
        self.assertEqual(take_message(bytearray(buffer)), Draining(40000, True))
        self.assertEqual(take_message(bytearray(buffer[:-1] + b"\xfe")), Draining(40000, False), "other flags are ignored")
        older = struct.pack("<I", len(buffer) - 5) + buffer[4:-1]
        self.assertEqual(take_message(bytearray(older)), Draining(40000, False))
        endless = buffer[:6] + b"\xff" * 4 + b"\1"
        self.assertEqual(take_message(bytearray(endless)), Draining(None, True))

    def test_bye(self):
        buffer = packet("bye")
        self.assertEqual(take_message(bytearray(buffer)), Bye("too far", 60000))
        self.assertEqual(Bye("too far", 60000).message(), buffer)
        older = struct.pack("<I", len(buffer) - 8) + buffer[4:-4]
        self.assertEqual(take_message(bytearray(older)), Bye("too far", 0))

    def test_messages_in_parts_of_later_versions_and_wrong_ones(self):
        welcome, buffer = packet("welcome"), bytearray()
        for byte in welcome[:-1]:
            buffer.append(byte)
            self.assertIsNone(take_message(buffer))
        longer = struct.pack("<I", len(welcome)) + welcome[4:] + b"more"
        self.assertEqual(take_message(bytearray(longer)), take_message(bytearray(welcome)))
        for end in range(6, len(welcome)):
            with self.assertRaises(Malformed):
                take_message(bytearray(struct.pack("<I", end - 4) + welcome[4:end]))
        self.assertEqual(take_message(bytearray(b"\2\0\0\0\x63\0")), 0x63, "an unknown type is skipped")
        with self.assertRaises(Malformed):
            take_message(bytearray(packet("hello")))

    def test_keys(self):
        for name, secret in (("client_keys", SECRETS[0]), ("server_keys", SECRETS[1])):
            keys = Keys(secret, AES_128_GCM)
            made = b"".join(keys.material())
            keys.of(1)
            self.assertIn(packet(name), (made, made + keys.secret), name)

    def camera_update(self):
        return camera_update(7, CAMERA, 1_000_000, 50_000, [ACKNOWLEDGEMENT])

    def test_camera_update(self):
        self.assertEqual(self.camera_update(), packet("camera_update_body"))
        for cipher, name in ((AES_128_GCM, "camera_update"), (CHACHA20_POLY1305, "camera_update_chacha")):
            sealer = Sealer(Keys(SECRETS[0], cipher), SESSION)
            self.assertEqual(sealer.seal(Kind.CAMERA_UPDATE, self.camera_update()), packet(name), name)

    def test_second_epoch(self):
        sealer = Sealer(Keys(SECRETS[0], AES_128_GCM, epoch_datagrams=1), SESSION)
        sealer.seal(Kind.CAMERA_UPDATE, self.camera_update())
        self.assertEqual(sealer.seal(Kind.CAMERA_UPDATE, self.camera_update())[-16:], packet("second_epoch_tag"))

    def test_frame_slice(self):
        opener = Opener(Keys(SECRETS[1], AES_128_GCM), SESSION, {Kind.FRAME_SLICE})
        kind, sequence, body = opener.open(packet("frame_slice"))
        self.assertEqual((kind, sequence, body), (Kind.FRAME_SLICE, 1, packet("frame_slice_body")))
        self.assertIsNone(opener.open(packet("frame_slice")), "a replay")
        frame = Frame(7, (16, 8), 2)
        self.assertTrue(frame.add_slice(body))
        self.assertTrue(frame.complete())
        self.assertEqual(frame.words, [LIGHT_0, LIGHT_1])
        self.assertEqual((frame.server_us, frame.gpu_us), (4200, 1500))
        drawn = re.findall(r"^(?:light 0:)? +([#.]{16})(?: +light 1:)? +([#.]{16})", WIRE, re.M)
        self.assertEqual(len(drawn), 8)
        for y, rows in enumerate(drawn):
            for light, row in enumerate(rows):
                self.assertEqual([frame.bit(light, x, y) for x in range(16)], [c == "#" for c in row])

    def test_feedback(self):
        ages = [age(1_050_000 - 640, 1_050_000), age(None, 1_050_000), age(1_050_000, 1_050_000)]
        self.assertEqual(feedback(1_050_000, 5, 3, 1, ages), packet("feedback_body"))

    def test_parity(self):
        received = FrameParity.read(packet("parity_body"))
        shards = [parity.shard_of(body, 5) for body in (b"\1\2\3", b"\4")]
        self.assertEqual(parity.parity_shard(shards, 0), received.shard)
        for lost in (0, 1):
            kept = {1 - lost: shards[1 - lost]}
            self.assertEqual(parity.rebuild(2, kept, {0: received.shard}), {lost: shards[lost]})

    def test_payloads(self):
        self.assertEqual(decode(a_slice(packet("dark_payload"), 2048, 1, 1)), [[0] * 2048])
        self.assertEqual(decode(a_slice(packet("raw32_payload"), 1, 1, 0)), [[0]])

    def test_payloads_of_tiles_context(self):
        alone, referring = (a_slice(packet(name), 2, 2, 3) for name in ("context_payload", "referenced_payload"))
        self.assertEqual(decode(alone, 2, 1), [LIGHT_0, LIGHT_1])
        self.assertEqual(decode(referring, 2, 1, {6: [LIGHT_0, LIGHT_1]}), [LIGHT_0, LIGHT_1])
        for kept in ({}, {5: [LIGHT_0, LIGHT_1]}, {6: [LIGHT_0, LIGHT_0]}):
            with self.assertRaises(NoReference):
                decode(referring, 2, 1, kept)
        with self.assertRaises(Malformed):
            decode(replace(alone, payload=alone.payload + b"\0\0\0\0"), 2, 1)


class BeyondThePackets(unittest.TestCase):
    """What no packet shows."""

    def test_nothing_touched_is_opened(self):
        datagram = packet("frame_slice")
        opener = Opener(Keys(SECRETS[1], AES_128_GCM), SESSION, {Kind.FRAME_SLICE})
        for bit in range(8 * len(datagram)):
            touched = bytearray(datagram)
            touched[bit // 8] ^= 1 << bit % 8
            self.assertIsNone(opener.open(bytes(touched)), f"bit {bit}")
        for length in range(len(datagram)):
            self.assertIsNone(opener.open(datagram[:length]), f"{length} bytes")
        self.assertIsNotNone(opener.open(datagram))

    def test_window(self):
        sealer = Sealer(Keys(SECRETS[1], AES_128_GCM), SESSION)
        sent = [sealer.seal(Kind.FRAME_SLICE, b"x") for _ in range(1026)]
        opener = Opener(Keys(SECRETS[1], AES_128_GCM), SESSION, {Kind.FRAME_SLICE})
        self.assertIsNotNone(opener.open(sent[1025]))  # sequence 1026
        self.assertIsNone(opener.open(sent[1]), "1,024 below")
        self.assertIsNotNone(opener.open(sent[2]), "1,023 below")
        self.assertIsNone(opener.open(sent[2]), "a replay")

    def test_parity_rebuilds_as_many_as_it_has_shards(self):
        dice = random.Random(1)
        bodies = [dice.randbytes(dice.randint(1, 40)) for _ in range(9)]
        shards = [parity.shard_of(body, 42) for body in bodies]
        codes = {p: parity.parity_shard(shards, p) for p in (0, 3, 63)}
        for _ in range(20):
            lost = dice.sample(range(9), 3)
            rebuilt = parity.rebuild(9, {j: s for j, s in enumerate(shards) if j not in lost}, codes)
            self.assertEqual({j: parity.body_of(s) for j, s in rebuilt.items()}, {j: bodies[j] for j in lost})

    def test_padding_is_no_payload(self):
        body = packet("frame_slice_body")
        padded = body[:21] + b"\2" + struct.pack("<H", 5) + body[24:] + bytes(5)
        self.assertEqual(FrameSlice.read(padded).payload, FrameSlice.read(body).payload)
        with self.assertRaises(Malformed):
            FrameSlice.read(body[:21] + b"\2\xff\xff" + body[24:])

    def test_payloads_with_bytes_too_few_or_too_many_are_malformed(self):
        body = packet("frame_slice_body")
        for wrong in (body[:-1], body + b"\0"):
            with self.assertRaises(Malformed):
                Frame(7, (16, 8), 2).add_slice(wrong)
        with self.assertRaises(Malformed):
            Frame(7, (16, 8), 1).add_slice(body)  # lights beyond the frame
        with self.assertRaises(Malformed):
            Frame(7, (8, 8), 2).add_slice(body)  # tiles beyond the frame


if __name__ == "__main__":
    unittest.main()
