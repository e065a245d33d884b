#!/usr/bin/python3
"""libgnomon as the developers of an engine get it: installed into a folder, found by pkg-config, by CMake and as a
subdirectory, packaged for Debian. The example in C, built in both ways, gets from the real daemon what the client in
Python gets that was written from protocol/WIRE.md alone.

    library_test.py SOURCE BUILD
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "wire_client"))
from booted_root import run
from debian_root import build_packages, root_with_dependencies
from node import Node, skip

try:
    from messages import Hello
    from session import Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")
from mask_codecs import TILES
from wire_client import STEP_RADIANS, turned

SOURCE, BUILD = (pathlib.Path(argument).resolve() for argument in (sys.argv.pop(1), sys.argv.pop(1)))
SCENE, SIZE, STEPS = "living_room", (250, 122), 3  # the last tiles lie in part beyond the picture
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Werror")
# Cryptography, LZ4, erasure codes, and the languages' own: nothing that draws, logs or reads scenes.
MAY_NEED = {"libssl.so.3", "libcrypto.so.3", "liblz4.so.1", "libisal.so.2", "libstdc++.so.6", "libgcc_s.so.1",
            "libm.so.6", "libc.so.6", "ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1"}


def node():
    """Serves whoever names no tenant, and has patience with a client in Python."""
    return Node(BUILD, render={"tracer": "bvh"}, server={"silence_timeout_ms": 10_000}, tenants=[{"name": "default"}])


class Library(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.node = node()
        cls.addClassCleanup(cls.node.__exit__)
        cls.prefix = cls.node.folder / "prefix"
        for component in ("library", "development"):
            run("cmake", "--install", BUILD, "--component", component, "--prefix", cls.prefix)
        cls.shared = next(cls.prefix.rglob("libgnomon.so.0"))
        cls.example = next(cls.prefix.rglob("example.c"))
        cls.environment = {**os.environ, "LD_LIBRARY_PATH": str(cls.shared.parent),
                           "PKG_CONFIG_PATH": str(next(cls.prefix.rglob("gnomon.pc")).parent)}
        cls.node.start()

    def folder(self, **files):
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.node.folder))
        for name, text in files.items():
            (folder / name.replace("_", ".")).write_text(text)
        return folder

    # ---- what engines build with

    def by_pkg_config(self):
        program = self.folder() / "example"
        flags = run("pkg-config", "--cflags", "--libs", "gnomon", env=self.environment).stdout.split()
        run("cc", "-std=c99", *STRICT, self.example, *flags, "-lm", "-o", program)
        return program

    def by_cmake(self):
        folder = self.folder(CMakeLists_txt="cmake_minimum_required(VERSION 3.16)\nproject(engine C)\n"
                                            "find_package(gnomon 0.1 REQUIRED)\n"
                                            f"add_executable(engine {self.example})\n"
                                            "target_link_libraries(engine PRIVATE gnomon::gnomon m)\n")
        run("cmake", "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={self.prefix}",
            "-DCMAKE_C_STANDARD=99", "-DCMAKE_C_EXTENSIONS=OFF")
        run("cmake", "--build", folder / "build")
        return folder / "build/engine"

    def arguments(self, *more):
        return [self.node.control, self.node.pin, SCENE, "x".join(map(str, SIZE)), STEPS, *more]

    def flight(self, program):
        """How many pixels each light lights, for each camera; the first light's mask of the last one."""
        picture = self.folder() / "picture.pgm"
        output = run(program, *self.arguments(picture), env=self.environment).stdout
        print(output)
        lit = [list(map(int, counts.split())) for counts in
               re.findall(r"^camera \d+: [\d.]+ ms, lit ([\d ]+) of \d+ pixels$", output, re.M)]
        return lit, picture.read_bytes(), output

    def other_flight(self):
        """The same of the client in Python."""
        host, port = self.node.control.rsplit(":", 1)
        pixels = [(x, y) for y in range(SIZE[1]) for x in range(SIZE[0])]
        with Session(host, int(port), self.node.pin, Hello(SCENE, *SIZE, codecs=(TILES,))) as session:
            camera = session.welcome.scene.default_camera
            frames = [session.picture(turned(camera, STEP_RADIANS * step)) for step in range(STEPS)]
            lit = [[sum(frame.bit(light, x, y) for x, y in pixels) for light in range(len(frame.words))]
                   for frame in frames]
        picture = b"P5\n%d %d\n255\n" % SIZE + bytes(255 * frames[-1].bit(0, x, y) for x, y in pixels)
        return lit, picture

    def test_bits_are_those_of_the_other_client(self):
        lit, picture = self.other_flight()
        self.assertEqual(len(lit), STEPS)
        self.assertNotEqual(lit[0], lit[-1], "cameras see different things")
        for light in lit[0]:
            self.assertTrue(0 < light < SIZE[0] * SIZE[1], "some of it is lit and some is dark")
        for program in (self.by_pkg_config(), self.by_cmake()):
            its_lit, its_picture, _ = self.flight(program)
            self.assertEqual(its_lit, lit)
            self.assertEqual(its_picture, picture)

    def test_the_scene_hash_is_that_of_the_file(self):
        checked = run(BUILD / "bin/gnomond", "--check-scene", BUILD / f"share/gnomon/scenes/{SCENE}.glb").stdout
        digest = re.search(r"\b[0-9a-f]{32}\b", checked).group(0)
        self.assertIn(f"scene {SCENE}, 3 lights, hash {digest}\n", self.flight(self.by_pkg_config())[2])

    def test_errors_are_for_people(self):
        program, arguments = self.by_pkg_config(), self.arguments()
        arguments[2] = "nowhere"
        done = run(program, *arguments, env=self.environment, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, r"the server refuses this: refused \(unknown_scene\)")
        arguments = self.arguments()
        arguments[1] = "sha256:" + 64 * "0"
        done = run(program, *arguments, env=self.environment, check=False)
        self.assertRegex(done.stdout, "certificate of .* is refused")

    def test_the_header_is_plain_c_and_cpp(self):
        include = self.prefix / "include"
        source = self.folder(use_c="#include <gnomon/gnomon.h>\nextern gnomon_options used; gnomon_options used;\n")
        for language in (("cc", "-std=c99"), ("c++", "-x", "c++", "-std=c++11"), ("c++", "-x", "c++", "-std=c++20")):
            run(*language, *STRICT, "-fsyntax-only", f"-I{include}", source / "use.c")

    # ---- what the library is

    def test_only_what_the_header_declares_is_exported(self):
        header = (self.prefix / "include/gnomon/gnomon.h").read_text()
        declared = set(re.findall(r"^GNOMON_API [^;(]*?\b(gnomon_\w+)\(", header, re.M))
        table = run("nm", "--dynamic", "--defined-only", "--without-symbol-versions", self.shared).stdout
        exported = {line.split()[-1] for line in table.splitlines()} - {"GNOMON_0"}  # the version that they carry
        self.assertGreater(len(declared), 20)
        self.assertEqual(exported, declared)

    def test_it_needs_what_the_network_needs(self):
        dynamic = run("readelf", "--dynamic", self.shared).stdout
        self.assertEqual(re.findall(r"\(SONAME\).*\[(.*)\]", dynamic), ["libgnomon.so.0"])
        needed = set(re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic))
        self.assertIn("libssl.so.3", needed)
        self.assertLessEqual(needed, MAY_NEED)

    def test_as_a_subdirectory_it_is_the_library_alone(self):
        folder = self.folder(CMakeLists_txt="cmake_minimum_required(VERSION 3.25)\nproject(engine C CXX)\n"
                                            f"enable_testing()\nadd_subdirectory({SOURCE} gnomon)\n"
                                            "add_executable(engine main.c)\n"
                                            "target_link_libraries(engine PRIVATE gnomon::gnomon)\n",
                             main_c="#include <gnomon/gnomon.h>\nint main(void) { return gnomon_version() == 0; }\n")
        build = folder / "build"
        run("cmake", "-G", "Ninja", "-S", folder, "-B", build, f"-DCMAKE_INSTALL_PREFIX={folder / 'usr'}")
        targets = run("ninja", "-C", build, "-t", "targets", "all").stdout
        self.assertIn("libgnomon.so:", targets)
        self.assertNotRegex(targets, r"gnomond|gnomon-client|_test\b")
        cache = (build / "CMakeCache.txt").read_text()
        self.assertNotRegex(cache, "(?i)vulkan|gtest|spdlog|glslang")
        self.assertNotIn("No tests", run("ctest", "-N", "--test-dir", BUILD).stdout)
        self.assertIn("Total Tests: 0", run("ctest", "-N", "--test-dir", build).stdout)
        for script in build.rglob("cmake_install.cmake"):
            self.assertNotRegex(script.read_text(), "systemd|/etc")


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.packages = build_packages(BUILD)

    def field(self, package, name):
        return run("dpkg-deb", "-f", self.packages[package], name).stdout.strip()

    def files(self, package):
        listed = run("dpkg-deb", "-c", self.packages[package]).stdout
        return {line.split()[5].lstrip(".") for line in listed.splitlines() if not line.startswith("d")}

    def test_each_has_its_own(self):
        self.assertEqual(set(self.packages), {"gnomon", "libgnomon0", "libgnomon-dev"})
        programs, library, development = map(self.files, ("gnomon", "libgnomon0", "libgnomon-dev"))
        self.assertLessEqual({"/usr/bin/gnomond", "/usr/bin/gnomon-client", "/etc/gnomon/gnomond.yaml",
                              "/usr/lib/systemd/system/gnomond.service"}, programs)
        self.assertFalse([path for path in programs if "libgnomon" in path or "/include/" in path])
        version = self.field("libgnomon0", "Version")
        self.assertEqual({pathlib.Path(path).name for path in library},
                         {"copyright", "changelog.gz", "libgnomon.so.0", f"libgnomon.so.{version}",
                          "libgnomon0"}, "the last one: what lintian is told")
        self.assertLessEqual({"gnomon.h", "version.h", "libgnomon.so", "gnomonConfig.cmake", "gnomon.pc", "library.md",
                              "example.c"}, {pathlib.Path(path).name for path in development})
        self.assertFalse((programs & library) | (programs & development) | (library & development))

    def test_dependencies(self):
        version = self.field("libgnomon0", "Version")
        self.assertEqual(self.field("libgnomon-dev", "Depends"), f"libgnomon0 (= {version})")
        needs = self.field("libgnomon0", "Depends")
        self.assertRegex(needs, "libssl3")
        self.assertNotRegex(needs, "vulkan|png|spdlog|fmt|systemd|yaml|prometheus")
        self.assertRegex(self.field("gnomon", "Depends"), r"mesa-vulkan-drivers \| vulkan-icd")
        self.assertNotRegex(self.field("gnomon", "Depends"), "libgnomon")

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("mmdebstrap"), "a clean Debian root needs root, mmdebstrap")
    def test_in_a_clean_root_a_program_finds_the_library(self):
        try:
            made = root_with_dependencies(BUILD, self.packages["libgnomon0"])
        except SystemExit:
            self.skipTest("no Debian root can be made here")
        with tempfile.TemporaryDirectory(prefix="gnomon-library-") as folder:
            root = pathlib.Path(folder)
            run("tar", "-C", root, "-xf", made)
            for name in ("libgnomon0", "libgnomon-dev"):
                shutil.copy(self.packages[name], root / f"{name}.deb")
            run("chroot", root, "dpkg", "--install", "/libgnomon0.deb", "/libgnomon-dev.deb")
            # Built outside, against what is inside: a compiler there would be most of a gigabyte.
            config = next((root / "usr/lib").rglob("gnomon.pc")).parent
            flags = subprocess.check_output(["pkg-config", "--cflags", "--libs", "gnomon"], text=True,
                                            env={**os.environ, "PKG_CONFIG_PATH": str(config)}).split()
            example = next((root / "usr/share/doc").rglob("example.c"))
            run("cc", "-std=c99", *STRICT, example, *flags, "-lm", "-o", root / "example")
            with node() as server:
                server.start()
                print(run("chroot", root, "/example", server.control, server.pin, SCENE, "64x64", 2).stdout)
            run("chroot", root, "dpkg", "--purge", "libgnomon-dev", "libgnomon0")
            self.assertFalse(list((root / "usr").rglob("*libgnomon*")))


if __name__ == "__main__":
    unittest.main(verbosity=2)
