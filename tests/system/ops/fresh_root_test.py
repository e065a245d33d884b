#!/usr/bin/env python3
"""The two commands of the README on a truly fresh Debian 12: a minimal root, made by mmdebstrap with this machine's
package sources, the committed tree in it, and nothing else. Each runs twice, the second time without a network. Then
the root is robbed of single packages, to see that a list without them would have been noticed.

    fresh_root_test.py BUILD                     minutes with a warm compiler cache; as long as a whole build without
    fresh_root_test.py BUILD --without PACKAGE   deploy/install-packages loses a package before all else: ends red
    GNOMON_FRESH_ROOT=demo fresh_root_test.py    the first of the two commands alone, and the package

Needs root, mmdebstrap, systemd-nspawn and a package mirror; packages are kept in BUILD/ops/packages for the next time.
"""
import os
import pathlib
import re
import struct
import subprocess
import sys
import unittest

from fresh_root import FreshRoot

WITHOUT = None
if "--without" in sys.argv:
    at = sys.argv.index("--without")
    WITHOUT = sys.argv.pop(at + 1)
    sys.argv.pop(at)
BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
THE_DEMO_ALONE = os.environ.get("GNOMON_FRESH_ROOT") == "demo"

PICTURES, PICTURE_SIZE = ("living_room", "temple"), (320, 180)
SHORT = {"SECONDS_OF_LOAD": 2, "SIZE": "160x90", "PICTURE_SIZE": "{}x{}".format(*PICTURE_SIZE)}
DARK = 16  # of 255
MESA_WITH_RAY_QUERY = 24
# Installed only because a list names them: nothing else depends on them, or dpkg would not take them away. What CMake
# says of them, because a list that lost one cannot name it.
RUN_ALONE = {"libmeshoptimizer-dev": "meshoptimizer", "libasio-dev": "asio.hpp", "libcli11-dev": "CLI11"}
TESTS_ALONE = {"libgtest-dev": "GTest"}


def lose(package):
    """A shell command: deploy/install-packages without it."""
    return f"sed -i -E '/^#/!s/(^|[ (]){package}([ )]|$)/\\1\\2/' deploy/install-packages"


def picture(file):
    """Its width and height, and how much of it is not black."""
    data = file.read_bytes()
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        raise AssertionError(f"{file}: no PNG")
    grey = subprocess.check_output(["ffmpeg", "-loglevel", "error", "-i", file, "-pix_fmt", "gray", "-f", "rawvideo", "-"])
    return struct.unpack(">II", data[16:24]), sum(value > DARK for value in grey) / len(grey)


class AsAStranger(unittest.TestCase):
    """In the order of their names; after one that fails none is tried."""

    @classmethod
    def setUpClass(cls):
        cls.fresh = FreshRoot(BUILD)
        cls.enterClassContext(cls.fresh)
        cls.built = cls.fresh.source / "build/release"
        if WITHOUT:
            listed = (cls.fresh.source / "deploy/install-packages").read_text()
            cls.fresh.run("bash", "-c", lose(WITHOUT))
            if (cls.fresh.source / "deploy/install-packages").read_text() == listed:
                raise AssertionError(f"deploy/install-packages does not name {WITHOUT}")

    def succeeds(self, *command, **more):
        done = self.fresh.run(*command, **more)
        print(f"{' '.join(command)}{'' if more.get('network', True) else ', offline'}: {done.seconds:.0f} s", flush=True)
        self.assertEqual(done.returncode, 0, done.stdout[-8000:])
        return done

    def objects(self):
        """When each was made."""
        return {file: file.stat().st_mtime_ns for file in [*self.built.rglob("*.o"), *(self.built / "bin").iterdir()]}

    def offline_and_idle(self, *command, **more):
        """It succeeds without a network, installs nothing and compiles nothing."""
        packages, objects = self.fresh.installed(), self.objects()
        done = self.succeeds(*command, network=False, **more)
        self.assertEqual(self.fresh.installed(), packages)
        self.assertEqual(self.objects(), objects)
        return done

    def pictures(self):
        for scene in PICTURES:
            files = sorted((self.fresh.source / "out" / scene).glob("frame_*.png"))
            self.assertTrue(files, scene)
            for file in files:
                size, drawn = picture(file)
                self.assertEqual(size, PICTURE_SIZE, file)
                self.assertGreater(drawn, 0.1, file)

    def test_1_the_demo_brings_pictures(self):
        self.succeeds("deploy/demo", **SHORT)
        self.pictures()
        installed = self.fresh.installed()
        self.assertGreaterEqual(int(installed["mesa-vulkan-drivers"].split(".")[0]), MESA_WITH_RAY_QUERY)
        for package in TESTS_ALONE:
            self.assertNotIn(package, installed, "the demo needs nothing of the tests")

    def test_2_the_demo_again(self):
        for file in (self.fresh.source / "out").rglob("*.png"):
            file.unlink()
        self.offline_and_idle("deploy/demo", **SHORT)
        self.pictures()

    @unittest.skipIf(THE_DEMO_ALONE, "GNOMON_FRESH_ROOT=demo")
    def test_3_a_package_that_the_demo_needs_is_missed(self):
        self.missed("deploy/demo", "run", RUN_ALONE)

    def test_3_a_mirror_that_is_away_is_named(self):
        done = self.fresh.run("bash", "-c", "dpkg --purge libasio-dev && deploy/demo", network=False, layer=True)
        self.assertNotEqual(done.returncode, 0, done.stdout)
        self.assertIn("fetching the package lists (apt-get update) failed three times", done.stdout)
        self.assertIn("E: Failed to fetch", done.stdout)

    def test_4_the_debian_package(self):
        self.succeeds("cmake", "--build", "--preset", "release", "--target", "package", network=False)
        self.assertTrue(list(self.built.glob("gnomon_*.deb")))

    @unittest.skipIf(THE_DEMO_ALONE, "GNOMON_FRESH_ROOT=demo")
    def test_5_the_unit_tests_pass(self):
        objects = self.objects()
        self.all_unit_tests(self.succeeds("tests/run", "-L", "unit"))
        self.assertEqual({file: made for file, made in self.objects().items() if file in objects}, objects)

    @unittest.skipIf(THE_DEMO_ALONE, "GNOMON_FRESH_ROOT=demo")
    def test_6_the_demo_after_the_tests(self):
        self.offline_and_idle("deploy/demo", **SHORT)

    @unittest.skipIf(THE_DEMO_ALONE, "GNOMON_FRESH_ROOT=demo")
    def test_7_the_unit_tests_after_the_demo(self):
        self.all_unit_tests(self.offline_and_idle("tests/run", "-L", "unit"))

    @unittest.skipIf(THE_DEMO_ALONE, "GNOMON_FRESH_ROOT=demo")
    def test_8_a_package_that_the_tests_need_is_missed(self):
        self.missed("tests/run -L unit", "tests", TESTS_ALONE)

    def all_unit_tests(self, done):
        listed = self.fresh.run("ctest", "--test-dir", "build/release", "-N", "-L", "unit", network=False).stdout
        count = int(re.search(r"Total Tests: (\d+)", listed).group(1))
        self.assertGreater(count, 0)
        self.assertIn(f"100% tests passed, 0 tests failed out of {count}\n", done.stdout)
        self.assertNotIn("The following tests did not run", done.stdout)
        print(f"{count} tests passed")

    def missed(self, command, purpose, packages):
        """In layers above the root, each without one of the packages: whoever configures by hand is told its name; with a
        list that has lost it, too, the command fails while it configures and says what it did not find."""
        by_hand = "cmake --preset release" + (" -DGNOMON_TESTS=ON" if purpose == "tests" else "")
        for package, told in packages.items():
            with self.subTest(package):
                gone = f"dpkg --purge {package} >&2 && rm -r build/release"
                named = self.fresh.run("bash", "-c", f"{gone} && {by_hand}", network=False, layer=True)
                self.assertNotEqual(named.returncode, 0, named.stdout)
                self.assertIn(f"not installed: {package}\n", named.stdout)
                self.assertIn(f"deploy/install-packages {purpose}", named.stdout)
                done = self.fresh.run("bash", "-c", f"{gone} && {lose(package)} && {command}", network=False, layer=True)
                self.assertNotEqual(done.returncode, 0, done.stdout)
                self.assertIn("packages: all present", done.stdout)
                self.assertIn("Configuring incomplete, errors occurred!", done.stdout)
                self.assertIn(told, done.stdout)
                print(f"without {package}: {named.seconds + done.seconds:.0f} s", flush=True)


if __name__ == "__main__":
    unittest.main(verbosity=2, failfast=True)
