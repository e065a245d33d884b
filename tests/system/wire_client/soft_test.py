#!/usr/bin/python3
"""Soft shadows and ambient occlusion of the real daemon, counted once more from protocol/WIRE.md alone: a floor, a plate
above it, and an area light. Each pixel's points are known, and so is by arithmetic which of them the plate hides.

    soft_test.py BUILD
"""
import base64
import json
import math
import pathlib
import struct
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "ops"))
from node import Node, skip

try:
    from messages import FULL, HALF, OPEN_SEGMENTS, SOFT, Camera, Hello
    from session import Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")

from mask_codecs import CONTEXT, RAW32, TILES
from sample_points import around_surface, offsets

BUILD = sys.argv.pop(1)
SIZE = 128, 64
FLOOR, PLATE, HEIGHT = 4.0, 0.5, 1.0  # half sides, and how high the plate lies
LIGHT = 0.25, 3.0, -0.125
LIGHTS = {"sphere": {"radius": 0.25}, "disc": {"shape": "disc", "radius": 0.25},
          "rectangle": {"width": 0.5, "height": 0.25}}
REACH = 2.5  # of what occludes ambient light: beyond the plate
TILT = 0.4  # radians, downwards
EYE = 0.0, 2.0, 4.0


def scene(area):
    """A glTF file of the floor, the plate, and one light of each kind of area or none."""
    def square(half, y):
        return struct.pack("<12f", -half, y, -half, half, y, -half, half, y, half, -half, y, half)
    binary = square(FLOOR, 0) + square(PLATE, HEIGHT) + struct.pack("<6H", 0, 2, 1, 0, 3, 2)
    positions = [{"bufferView": 0, "byteOffset": 48 * i, "componentType": 5126, "count": 4, "type": "VEC3",
                  "min": [-half, y, -half], "max": [half, y, half]}
                 for i, (half, y) in enumerate(((FLOOR, 0), (PLATE, HEIGHT)))]
    down = [-math.sqrt(0.5), 0, 0, math.sqrt(0.5)]  # its X and Y axes lie in the plane y = const
    lamp = {"translation": LIGHT, "rotation": down, "extensions": {"KHR_lights_punctual": {"light": 0}}}
    return {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
        "buffers": [{"byteLength": len(binary),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(binary).decode()}],
        "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 12}],
        "accessors": [*positions, {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i}, "indices": 2}]} for i in range(2)],
        "nodes": [{"mesh": 0}, {"mesh": 1}, lamp, {**lamp, "extras": {"gnomon": {"light": area}}}],
        "scenes": [{"nodes": [0, 1, 2, 3], "extras": {"gnomon": {"ambient": {"reach": REACH}}}}], "scene": 0,
    }


def camera():
    return Camera(EYE, (-math.sin(TILT / 2), 0, 0, math.cos(TILT / 2)), 1.0, 1.0, 0.5, 0.5, 0.0625)


def floor_point(x, y):
    """What the pixel shows of the floor; None if it shows something else."""
    right, up = (x + 0.5) / SIZE[0] * 2 - 1, 0.5 - (y + 0.5) / SIZE[1]
    ray = right, up * math.cos(TILT) - math.sin(TILT), -up * math.sin(TILT) - math.cos(TILT)
    for height, half in ((HEIGHT, PLATE), (0, FLOOR)):
        if ray[1] >= 0:
            return None
        far = (height - EYE[1]) / ray[1]
        at = EYE[0] + far * ray[0], EYE[2] + far * ray[2]
        if max(map(abs, at)) <= half:
            return at if height == 0 else None
    return None


def is_hidden(at, point):
    """By the plate, of the floor's point (x, z)."""
    share = HEIGHT / point[1]
    return all(abs(from_ + share * (to - from_)) <= PLATE for from_, to in zip(at, (point[0], point[2])))


def is_open(at, on_sphere):
    """The segment from the floor's point (x, z): not hidden by the plate."""
    along = [REACH / 2 * (n + q) for n, q in zip((0, 1, 0), on_sphere)]
    share = HEIGHT / along[1] if along[1] > 0 else 2
    return share >= 1 or any(abs(from_ + share * to) > PLATE for from_, to in zip(at, (along[0], along[2])))


class Soft(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = Node(BUILD)
        cls.addClassCleanup(cls.node.__exit__)
        cls.node.config["scenes"]["list"] = []
        for name, area in LIGHTS.items():
            file = cls.node.folder / f"{name}.gltf"
            file.write_text(json.dumps(scene(area)))
            cls.node.config["scenes"]["list"].append({"name": name, "file": str(file)})
        cls.node.start()

    def session(self, scene_, samples, codec=TILES, features=SOFT):
        host, port = self.node.control.rsplit(":", 1)
        session = Session(host, int(port), self.node.pin, Hello(
            scene_, *SIZE, tenant="studio", codecs=(codec,), features=features, samples=samples))
        self.addCleanup(session.abandon)
        return session

    def frame(self, session):
        """Once its light buffers are there too, frames are the same."""
        return session.picture(camera())

    def counted(self, area, samples):
        """For each pixel of the floor, how many points it sees."""
        for y in range(SIZE[1]):
            for x in range(SIZE[0]):
                at = floor_point(x, y)
                if at is None:
                    continue
                points = [tuple(a + b for a, b in zip(LIGHT, offset)) for offset in offsets(area, x, y, samples)]
                yield (x, y), sum(not is_hidden(at, point) for point in points)

    def compare(self, name, samples, codec):
        session = self.session(name, samples, codec)
        welcome = session.welcome
        self.assertEqual((welcome.samples, [area.shape > 0 for area in welcome.areas]), (samples, [False, True]))
        frame = self.frame(session)
        session.close()
        compared = wrong = partly = 0
        for (x, y), seen in self.counted(welcome.areas[1], samples):
            compared += 1
            partly += 0 < seen < samples
            wrong += frame.seen(1, x, y) != seen
        print(f"{name}, k = {samples}: of {compared} pixels {partly} in the penumbra, {wrong} otherwise than counted")
        self.assertGreater(compared, 2000)
        self.assertGreater(partly, 50)
        # Arithmetic here is in binary64 and from the surface itself: a point at the plate's very edge may differ.
        self.assertLess(wrong, 0.02 * partly + 1)

    def test_counts_are_those_of_the_points(self):
        for codec, (samples, name) in zip((RAW32, TILES, CONTEXT), ((4, "disc"), (16, "sphere"), (16, "rectangle"))):
            with self.subTest(name):
                self.compare(name, samples, codec)

    def compare_occlusion(self, samples, codec):
        session = self.session("disc", samples, codec)
        self.assertEqual(session.welcome.samples, samples)
        frame = self.frame(session)
        session.close()
        compared = wrong = partly = 0
        for y in range(SIZE[1]):
            for x in range(SIZE[0]):
                at = floor_point(x, y)
                if at is None or (samples & HALF and (x | y) & 1):
                    continue
                count = sum(is_open(at, q) for q in around_surface(x, y, OPEN_SEGMENTS))
                compared += 1
                partly += count < OPEN_SEGMENTS
                wrong += frame.seen(2, x, y) != count
        print(f"occlusion {samples}: of {compared} pixels {partly} in part occluded, {wrong} otherwise than counted")
        self.assertGreater(compared, 500)
        self.assertGreater(partly, 50)
        self.assertLess(wrong, 0.02 * partly + 1)

    def test_occlusion_is_that_of_the_segments(self):
        for samples, codec in ((1 + FULL, RAW32), (4 + FULL, CONTEXT), (1 + HALF, TILES)):
            with self.subTest(samples):
                self.compare_occlusion(samples, codec)

    def test_who_does_not_ask_gets_bits(self):
        for session in (self.session("sphere", 1), self.session("sphere", 16, features=0)):
            self.assertEqual(session.welcome.samples, 1)
            frame = self.frame(session)
            self.assertEqual(len(frame.words), 2)
            self.assertEqual(frame.words[0], frame.words[1], "an area light is a point")


if __name__ == "__main__":
    unittest.main(verbosity=2)
