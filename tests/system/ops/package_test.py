#!/usr/bin/env python3
"""The Debian package in a clean Debian root: dependencies are enough, it serves, upgrades keep what the operator
edited, purge leaves nothing.

    package_test.py BUILD

Needs root, mmdebstrap and a package mirror; the root is kept in BUILD/ops for the next time.
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
import urllib.request

from booted_root import run
from debian_root import build_package, root_with_dependencies
from node import eventually, skip

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
CONFIG = "etc/gnomon/gnomond.yaml"
SOCKET = "/var/lib/gnomon/admin.sock"
FRAMES = 2  # of a self-test: beside the build of light buffers each may take a second
# What dpkg and the tools that it calls write down for themselves.
BOOKS = re.compile(r"^/(var/lib/(dpkg|systemd/deb-systemd-helper-\w+)|var/log|var/cache/(ldconfig|debconf)|proc|tmp|dev)"
                   r"(/|$)|^/etc/(group|gshadow|ld\.so\.cache)-?$")


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.package = build_package(BUILD)
        cls.temporary = tempfile.TemporaryDirectory(prefix="gnomon-package-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.root = pathlib.Path(cls.temporary.name, "root")
        cls.root.mkdir()
        run("tar", "-C", cls.root, "-xf", root_with_dependencies(BUILD, cls.package))
        # Nothing in it is worth waiting for the disk.
        (cls.root / "etc/dpkg/dpkg.cfg.d/unsafe-io").write_text("force-unsafe-io\n")
        (cls.root / "proc").mkdir(exist_ok=True)
        run("mount", "-t", "proc", "proc", cls.root / "proc")
        cls.addClassCleanup(run, "umount", "--lazy", cls.root / "proc")

    def chroot(self, *command, **more):
        return run("chroot", self.root, *command, **more)

    def files(self):
        found = self.chroot("find", "/", "-xdev", "-path", "/proc", "-prune", "-o", "-print").stdout.split("\n")
        return {path for path in found if not BOOKS.search(path)}

    def install(self, package, *options):
        shutil.copy(package, self.root / "gnomon.deb")
        try:
            self.chroot("dpkg", *options, "--install", "/gnomon.deb")
        finally:
            (self.root / "gnomon.deb").unlink()

    def newer(self):
        """The same with a higher version and another default in its configuration."""
        tree = pathlib.Path(self.temporary.name, "newer")
        run("dpkg-deb", "-R", self.package, tree)
        control, config = tree / "DEBIAN/control", tree / CONFIG
        control.write_text(re.sub(r"^Version: .*$", "Version: 99.0", control.read_text(), flags=re.M))
        config.write_text(config.read_text().replace("drain_timeout_ms: 2000", "drain_timeout_ms: 2500"))
        run("dpkg-deb", "-Znone", "-b", tree, tree.with_suffix(".deb"))
        return tree.with_suffix(".deb")

    @staticmethod
    def frames(admin):
        """Answered so far."""
        with urllib.request.urlopen(admin + "/metrics", timeout=10) as page:
            return sum(float(value) for value in
                       re.findall(r"^gnomon_visibility_buffers_total\S* (\S+)$", page.read().decode(), re.M))

    def self_test(self):
        """The packaged configuration with one scene, as nobody, on the packaged ports, by the packaged clients."""
        for folder in ("var/cache/gnomon", "var/lib/gnomon"):  # as the unit makes them
            (self.root / folder).mkdir(parents=True, exist_ok=True)
            os.chown(self.root / folder, 65534, 65534)
        log = pathlib.Path(self.temporary.name, "log")
        with open(log, "w") as out:
            daemon = subprocess.Popen(
                ["chroot", "--userspec=65534:65534", self.root, "gnomond", "--config", "/" + CONFIG, "--set",
                 "scenes.list=[{name: living_room, file: living_room.glb}]", "--set", "server.control_port=0", "--set",
                 "server.data_port=0", "--set", "server.state_folder=/var/lib/gnomon", "--set", "admin.port=0", "--set",
                 f"admin.socket={SOCKET}"], stdout=out, stderr=subprocess.STDOUT)
        try:
            ready = eventually(lambda: daemon.poll() is not None
                               or re.search(r"ready control=(\S+) data=\S+ admin=(\S+) pin=(\S+)",
                                            log.read_text()), "ready")
            self.assertIsNone(daemon.poll(), log.read_text())
            load = subprocess.Popen(
                ["chroot", self.root, "gnomon-load", "--server", ready.group(1), "--pin", ready.group(3), "--scene",
                 "living_room", "--size", "160x90", "--clients", "2", "--rate", "0", "--seconds", "600"],
                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            try:
                eventually(lambda: load.poll() is not None or self.frames(ready.group(2)) >= FRAMES, "frames")
                load.send_signal(signal.SIGINT)
                output = load.communicate(timeout=60)[0]
            finally:
                load.kill()
            print(output[-400:])
            self.assertEqual(load.returncode, 0, output)
            self.assertGreaterEqual(self.frames(ready.group(2)), FRAMES)
            self.assertIn("ready", self.chroot("gnomonctl", "--admin", ready.group(2), "status").stdout)
            self.chroot("gnomonctl", "--admin", f"unix:{SOCKET}", "drain")
            self.assertEqual(daemon.wait(60), 0, log.read_text())
        finally:
            daemon.kill()
            daemon.wait()

    def test_from_nothing_to_nothing(self):
        before = self.files()
        self.install(self.package)
        self.assertIn("ok", self.chroot("gnomond", "--config", "/" + CONFIG, "--check-config").stdout)
        self.self_test()

        config = self.root / CONFIG
        edited = config.read_text().replace("policy: fair", "policy: deadline")
        config.write_text(edited)
        self.install(self.newer(), "--force-confold")
        self.assertEqual(config.read_text(), edited)
        self.assertEqual(self.chroot("dpkg-query", "-W", "-f", "${Version}", "gnomon").stdout, "99.0")
        self.assertIn("2500", (self.root / (CONFIG + ".dpkg-dist")).read_text())

        (self.root / "etc/gnomon/credentials/tls.key").write_text("secret")
        self.chroot("dpkg", "--remove", "gnomon")
        self.assertEqual(config.read_text(), edited, "removing keeps the configuration")
        self.chroot("dpkg", "--purge", "gnomon")
        self.assertEqual(sorted(self.files() - before), [])


if __name__ == "__main__":
    if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
        skip("a clean Debian root needs root and mmdebstrap")
    unittest.main(verbosity=2)
