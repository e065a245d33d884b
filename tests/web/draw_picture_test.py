#!/usr/bin/env python3
"""The renderer of the page beside the reference client: the same masks, cameras and exposure, in Chromium on llvmpipe, and
on SwiftShader, whose rasteriser rounds corners to another grid than the server's.

    draw_picture_test.py BUILD [KEEP]

KEEP: a folder that gets the pictures, the client's and the page's side by side. Skipped (77) without Chromium or WebGL2.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

import draw_moving
import draw_pictures

SKIPPED = 77
WIDTH, HEIGHT = 640, 360
VIEWS = 3

if draw_pictures.chromium.find() is None:
    print("web_picture: skipped, there is no Chromium (deploy/install-packages tests)")
    sys.exit(SKIPPED)
BUILD = pathlib.Path(sys.argv[1])
KEEP = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else None
SCENES = BUILD / "share" / "gnomon" / "scenes"
LLVMPIPE, SWIFTSHADER = draw_pictures.chromium.LLVMPIPE, draw_pictures.chromium.SWIFTSHADER
SCRATCH = tempfile.TemporaryDirectory(prefix="gnomon-draw-")


def inputs_of(name, scene, at_ms):
    """The folder of what the reference client draws; made once for each scene."""
    folder = pathlib.Path(SCRATCH.name, name)
    if not folder.exists():
        command = (BUILD / "bin" / "web_draw_inputs", scene(), folder, WIDTH, HEIGHT, at_ms)
        subprocess.run([str(part) for part in command], check=True)
    return folder


class Pictures(unittest.TestCase):
    """What is the same for every scene; `scene` makes the file and names it."""
    name, at_ms = None, 0
    device, grid = LLVMPIPE, {"exact": True, "subpixels": 256}
    least = {"fresh": (0.999, 45), "predicted": (0.998, 45), "smooth": (0.997, 45)}  # pixels that are near, and PSNR

    @classmethod
    def setUpClass(cls):
        if cls.name is None:
            raise unittest.SkipTest("of every scene")
        cls.inputs = inputs_of(cls.name, cls.scene, cls.at_ms)
        cls.plan = json.loads((cls.inputs / "views.json").read_text())
        cls.browser = draw_pictures.Browser(cls.inputs, cls.device)
        if not cls.browser.has_webgl2():
            cls.browser.__exit__()
            print("web_picture: skipped, Chromium has no WebGL2 here (libegl1 and libgl1-mesa-dri are wanted)")
            raise SystemExit(SKIPPED)
        cls.facts = cls.browser.start()
        print(cls.name, cls.facts, flush=True)

    @classmethod
    def tearDownClass(cls):
        cls.browser.__exit__()

    @classmethod
    def scene(cls):
        return SCENES / f"{cls.name}.glb"

    def figures(self, name, figures):
        print(f"{self.name} {name}: {json.dumps(figures)}", flush=True)
        return figures

    def picture(self, name, more=""):
        view, *kind = name.split(".")
        taken = f"countedWish({view}, '{kind[0]}')" if kind and kind[0] in ("soft", "half") else f"wish({view})"
        wish = f"{{...await checks.{taken}{more}}}"
        got = self.browser.run(f"return checks.picture({wish}, '{name}', {'true' if KEEP else 'false'})")
        if KEEP:
            KEEP.mkdir(parents=True, exist_ok=True)
            draw_pictures.keep(got, KEEP / f"{self.name}-{name}-page.png", WIDTH, HEIGHT)
            (KEEP / f"{self.name}-{name}-client.png").write_bytes((self.inputs / f"{name}.png").read_bytes())
        self.assertEqual(got["error"], 0)
        return self.figures(name, got)

    def is_like_the_clients(self, kind, got):
        near, psnr = self.least[kind]
        self.assertGreaterEqual(got["near"], near)
        self.assertGreaterEqual(got["psnr"], psnr)

    def are_like_the_clients(self, name, more=""):
        """A fresh picture and a predicted one."""
        self.is_like_the_clients("fresh", self.picture(name, more))
        later = f", camera: checks.plan.views[{name.split('.')[0]}].predicted"
        self.is_like_the_clients("predicted", self.picture(f"{name}.predicted", later + more))

    def test_the_grid_is_found(self):
        self.assertEqual(self.facts["grid"], self.grid)

    def test_fresh_pictures_are_the_clients(self):
        for view in range(VIEWS):
            got = self.picture(f"{view}")
            self.is_like_the_clients("fresh", got)
            self.assertFalse(got["predicted"])

    def test_predicted_pictures_are_the_clients(self):
        for view in range(VIEWS):
            got = self.picture(f"{view}.predicted", f", camera: checks.plan.views[{view}].predicted")
            self.is_like_the_clients("predicted", got)
            self.assertTrue(got["predicted"])

    def test_smooth_pictures_are_the_clients(self):
        for view in range(VIEWS):
            got = self.picture(f"{view}.smooth", ", antialias: true")
            self.is_like_the_clients("smooth", got)

    def test_soft_pictures_are_the_clients(self):
        self.assertIn(True, self.plan["areas"], "a scene with area lights")
        for view in range(VIEWS):
            self.are_like_the_clients(f"{view}.soft")

    def test_bits_are_the_servers(self):
        for view in range(VIEWS):
            off = self.figures(f"{view} bits", self.browser.run(f"return checks.lights({view})"))
            self.assertEqual(len(off), len(self.plan["lights"]))
            self.assertLessEqual(max(off), 0.0001)

    def test_surfaces_are_the_servers(self):
        for view in range(VIEWS):
            got = self.figures(f"{view} ids", self.browser.run(f"return checks.ids({view})"))
            self.assertLessEqual(got["other"], 0.0001)

    def test_exposures_are_the_clients(self):
        for view in range(VIEWS):
            camera = f"checks.plan.views[{view}].camera"
            got = self.browser.run(f"return checks.renderer.suggestExposure({camera})")
            self.assertAlmostEqual(got / self.plan["views"][view]["exposure"], 1, delta=0.001)

    def test_predictions_are_judged_as_the_client_does(self):
        for view in range(VIEWS):
            got = self.figures(f"{view} outcome", self.browser.run(f"return checks.outcome({view})"))
            self.assertAlmostEqual(got["share"], got["native"], delta=0.001)

    def test_what_moves_is_where_the_server_has_it(self):
        got = self.figures("posed", self.browser.run("return checks.posed()"))
        self.assertEqual([got["positions"], got["normals"], got["lights"]], [0, 0, 0])
        self.assertEqual((got["vertices"] > 0, got["lightsMoved"] > 0), (self.at_ms > 0, self.at_ms > 0))

    def test_a_border_of_the_masks_is_left_out(self):
        got = self.figures("cropped", self.browser.run("return checks.cropped(0)"))
        self.assertEqual(got, {"predicted": False, "off": 0})

    def test_halves_have_shadows_of_their_own(self):
        got = self.figures("split", self.browser.run("return checks.split(0)"))
        self.assertEqual(got["right"], 0)
        self.assertGreater(got["left"], 1000)

    def test_lights_are_switched_off(self):
        got = self.figures("dark", self.browser.run("return checks.dark(0)"))
        self.assertLess(got["off"], 0.75 * got["on"])

    def test_the_browser_has_nothing_to_say(self):
        said = [error for error in self.browser.page.errors if "GPU stall due to ReadPixels" not in error]
        self.assertEqual(said, [])


class Temple(Pictures):
    name = "temple"


class LivingRoom(Pictures):
    name = "living_room"

    def one_device_is_enough(self):
        """Of what looks at dozens of pixels for each: SwiftShader takes minutes for it."""
        if self.device != LLVMPIPE:
            self.skipTest("the shader is looked at on llvmpipe")

    def test_filtered_pictures_are_the_clients(self):
        self.one_device_is_enough()
        self.are_like_the_clients("0.soft.filtered", ", filter: true")
        self.is_like_the_clients("smooth", self.picture("0.soft.filtered.smooth", ", filter: true, antialias: true"))

    def test_occlusion_of_half_size_is_filled_in_as_the_client_does(self):
        self.one_device_is_enough()
        self.are_like_the_clients("0.half")
        self.are_like_the_clients("0.half.filtered", ", filter: true")

    def test_masks_are_averaged_where_the_newest_agree(self):
        self.one_device_is_enough()
        got = self.figures("accumulated", self.browser.run("return checks.accumulated()"))
        for same in ("same", "samePredicted", "sameFiltered", "sameHalf"):
            self.assertEqual(got[same], 0, same)
        self.assertGreater(got["shifted"], 1000)
        self.assertLess(got["error"], 0.6)  # squares; as of four times as many points, but where masks are left out
        self.assertEqual((got["otherLights"], got["otherSession"]), (0, 0), "what is over is not averaged")
        self.assertEqual(got["darkBefore"], 0, "a shadow is gone where the newest masks are lit all around")
        self.assertGreater(min(got["afterNoise"][:3]), 1000)
        self.assertEqual(got["afterNoise"][3], 0, "nothing is seen for longer than four masks")
        self.assertEqual(got["glError"], 0)


class Moving(Pictures):
    name, at_ms = "moving", 1234

    @classmethod
    def scene(cls):
        file = pathlib.Path(SCRATCH.name, "moving.glb")
        draw_moving.moving_copy(SCENES / "living_room.glb", file)
        return file

    def test_a_lost_context_comes_back(self):
        got = self.figures("lost", self.browser.run("return checks.lose(0)"))
        self.assertEqual(got["meanwhile"], {"lost": True, "predicted": False})
        self.assertGreaterEqual(got["near"], 0.999)


# What masks were traced for is drawn as the server has it; edges of other pictures lie where the device puts them.
COARSE = {"device": SWIFTSHADER, "grid": {"exact": False, "subpixels": 16},
          "least": {"fresh": (0.998, 45), "predicted": (0.99, 34), "smooth": (0.99, 40)}}
TempleOnACoarseGrid = type("TempleOnACoarseGrid", (Temple,), COARSE)
LivingRoomOnACoarseGrid = type("LivingRoomOnACoarseGrid", (LivingRoom,), COARSE)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=1)
