#!/usr/bin/env python3
"""The page's prediction along a scene's camera path beside the native client's: the same cameras, the same masks at the
same times, in Chromium on llvmpipe. Each picture's camera, masks, share of predicted pixels and error are compared.

    flight_test.py BUILD

Skipped (77) without Chromium or WebGL2.
"""
import pathlib
import statistics
import subprocess
import sys
import tempfile
import unittest

import draw_pictures

if draw_pictures.chromium.find() is None:
    print("web_flight: skipped, there is no Chromium (deploy/install-packages tests)")
    sys.exit(77)
BUILD = pathlib.Path(sys.argv[1])
WIDTH, HEIGHT, CAMERAS = 320, 184, 48
POINT = 0.001  # a tenth of a point of a hundred


class Flights(unittest.TestCase):
    def flown(self, scene):
        with tempfile.TemporaryDirectory(prefix="gnomon-flight-") as folder:
            file = BUILD / "share" / "gnomon" / "scenes" / f"{scene}.glb"
            command = (BUILD / "bin" / "web_flight_inputs", file, folder, WIDTH, HEIGHT, CAMERAS)
            subprocess.run([str(part) for part in command], check=True)
            with draw_pictures.Browser(folder) as browser:
                if not browser.has_webgl2():
                    self.skipTest("Chromium has no WebGL2 here (libegl1 and libgl1-mesa-dri are wanted)")
                browser.start()
                got = browser.run("return (await import('/checks/flight_checks.mjs')).fly(checks.renderer, '/inputs')")
        return got["mine"], got["native"]

    def compare(self, scene):
        mine, native = self.flown(scene)
        self.assertEqual(len(mine), len(native))
        self.assertGreater(len(native), 0.8 * CAMERAS)
        alike = [(a, b) for a, b in zip(mine, native) if (a["camera"], a["seen"]) == (b["camera"], b["seen"])]
        predicted = [sum(each["camera"] != each["seen"] for each in all) / len(all) for all in (mine, native)]
        wrong = [statistics.fmean(each["wrong"] for each in all) for all in (mine, native)]
        known = [statistics.fmean(each["known"] for each in all) for all in (mine, native)]
        worst = {key: max(abs(a[key] - b[key]) for a, b in alike) for key in ("known", "wrong")}
        print(f"{scene}: {len(alike)} of {len(native)} pictures of the same camera; predicted {predicted}, "
              f"pixels with a source {known}, wrong bits {wrong}, worst picture {worst}", flush=True)
        self.assertGreaterEqual(len(alike), 0.95 * len(native))
        self.assertGreater(native[-1]["camera"], native[-1]["seen"])
        self.assertGreater(wrong[1], 0)
        for each in (predicted, known, wrong):
            self.assertAlmostEqual(*each, delta=POINT)
        self.assertLessEqual(worst["known"], 2 * POINT)
        self.assertLessEqual(worst["wrong"], 2 * POINT)

    def test_temple(self):
        self.compare("temple")

    def test_living_room(self):
        self.compare("living_room")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
