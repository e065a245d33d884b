#!/usr/bin/env python3
"""The Debian package in a clean Debian root: dependencies are enough, it serves whoever has the token of its first start
and nobody else, upgrades keep what the operator edited, purge leaves nothing.

    package_test.py BUILD

Needs root, mmdebstrap and a package mirror; the root is kept in BUILD/ops for the next time.
"""
import contextlib
import os
import pathlib
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest
import urllib.request

from booted_root import run
from debian_root import build_package, root_with_dependencies
from node import ROOT as SOURCE, eventually, skip

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
CONFIG = "etc/gnomon/gnomond.yaml"
SOCKET = "/var/cache/gnomon/admin.sock"
CREDENTIALS, PRIVATE = "etc/gnomon/credentials", "etc/gnomon/private"
NOBODY, GROUP = 65534, 65530  # who runs the daemon, and the group that reads its credentials
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

    def secrets(self):
        """By name: mode, owner and content of all that a first start makes."""
        files = [file for folder in (CREDENTIALS, PRIVATE) for file in (self.root / folder).glob("*")]
        return {file.name: (oct(file.stat().st_mode & 0o777), file.stat().st_uid, file.read_bytes()) for file in files}

    def first_start(self):
        """What the unit of that name runs. It does something once; nobody but root may read it."""
        self.assertEqual(self.secrets(), {}, "a package that brings secrets, or makes them, gives them to every copy")
        self.assertFalse((self.root / PRIVATE).exists())
        os.chown(self.root / CREDENTIALS, 0, GROUP)  # as systemd-sysusers and systemd-tmpfiles do
        (self.root / CREDENTIALS).chmod(0o2750)
        unit = (self.root / "usr/lib/systemd/system/gnomon-first-start.service").read_text()
        command = shlex.split(re.search(r"^ExecStart=(.*)$", unit, re.M).group(1))
        said = self.chroot(*command).stdout
        made = self.secrets()
        self.assertEqual(sorted(made), ["ca-key.pem", "ca.pem", "default.sha256", "default.token", "server-key.pem",
                                        "server.pem"], said)
        self.assertEqual({uid for _, uid, _ in made.values()}, {0})
        self.assertEqual((self.root / PRIVATE).stat().st_mode & 0o777, 0o700)
        for name in ("ca-key.pem", "default.token"):
            self.assertEqual(made[name][0], "0o600", name)
        for name in ("server.pem", "server-key.pem", "default.sha256"):
            self.assertEqual(made[name][0], "0o640", name)
            self.assertEqual((self.root / CREDENTIALS / name).stat().st_gid, GROUP, name)
        self.assertIn("--token-file default.token", said)
        self.assertEqual(self.chroot(*command).stdout, "")
        self.assertEqual(self.secrets(), made)

    def folder_of_nobody(self, name):
        folder = self.root / name
        folder.mkdir(parents=True, exist_ok=True)
        os.chown(folder, NOBODY, NOBODY)

    @contextlib.contextmanager
    def serving(self, *command, **environment):
        """The daemon as nobody, with one scene on free ports, until it has drained; control address, admin server, pin."""
        log = pathlib.Path(self.temporary.name, "log")
        with open(log, "w") as out:
            daemon = subprocess.Popen(
                ["chroot", f"--userspec={NOBODY}:{NOBODY}", f"--groups={GROUP}", self.root, *command, "--set",
                 "scenes.list=[{name: living_room, file: living_room.glb}]", "--set", "server.control_port=0", "--set",
                 "server.data_port=0", "--set", "admin.port=0", "--set", f"admin.socket={SOCKET}"], stdout=out,
                stderr=subprocess.STDOUT, env={**os.environ, **environment})
        try:
            ready = eventually(lambda: daemon.poll() is not None
                               or re.search(r"ready control=(\S+) data=\S+ admin=(\S+) pin=(\S+)", log.read_text()), "ready")
            self.assertIsNone(daemon.poll(), log.read_text())
            yield ready.groups()
            self.assertIn("ready", self.chroot("gnomonctl", "--admin", ready.group(2), "status").stdout)
            self.chroot("gnomonctl", "--admin", f"unix:{SOCKET}", "stop")
            self.assertEqual(daemon.wait(60), 0, log.read_text())
        finally:
            daemon.kill()
            daemon.wait()

    def self_test(self):
        """The packaged configuration, by the packaged clients."""
        self.folder_of_nobody("var/cache/gnomon")  # as the unit makes it
        with self.serving("gnomond", "--config", "/" + CONFIG) as (server, admin, _):
            self.only_with_the_token(server, "/" + PRIVATE)
            load = subprocess.Popen(
                ["chroot", self.root, "gnomon-load", "--server", server, "--ca", f"/{PRIVATE}/ca.pem", "--tenant",
                 f"default:/{PRIVATE}/default.token:2", "--scene", "living_room", "--size", "160x90", "--rate", "0",
                 "--seconds", "600"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
            try:
                eventually(lambda: load.poll() is not None or self.frames(admin) >= FRAMES, "frames")
                load.send_signal(signal.SIGINT)
                output = load.communicate(timeout=60)[0]
            finally:
                load.kill()
            print(output[-400:])
            self.assertEqual(load.returncode, 0, output)
            self.assertGreaterEqual(self.frames(admin), FRAMES)

    def image_entry(self):
        """What the container's image starts, twice on one volume. container_test starts the image itself."""
        entry, state = self.root / "gnomon-start", "/var/lib/gnomon"
        shutil.copy(SOURCE / "deploy/container/start", entry)
        self.folder_of_nobody(state[1:])
        pins = []
        for _ in range(2):
            with self.serving("/gnomon-start", STATE_DIRECTORY=state, GNOMON_HOSTS="edge.test 192.0.2.7") as (
                    server, _, pin):
                self.assertTrue(server.startswith("0.0.0.0:"), server)
                self.only_with_the_token(server.replace("0.0.0.0", "127.0.0.1"), state + "/private")
                pins.append(pin)
        self.assertEqual(pins[0], pins[1])
        self.assertIn("ok", self.chroot("/gnomon-start", "--config", "/" + CONFIG, "--check-config").stdout)
        entry.unlink()

    def only_with_the_token(self, server, private):
        asks = ("gnomon-client", "--server", server, "--scene", "living_room", "--size", "160x90", "--frames", "1")
        knows, shows = ("--ca", f"{private}/ca.pem"), ("--tenant", "default", "--token-file", f"{private}/default.token")
        home = {**os.environ, "XDG_CACHE_HOME": "/tmp"}  # for what Mesa compiles
        self.chroot(*asks, *knows, *shows, env=home)
        (self.root / "guess").write_text("0" * 64)
        for more in ((), shows, knows, (*knows, *shows[:3], "/guess")):
            refused = self.chroot(*asks, *more, env=home, check=False)
            self.assertNotEqual(refused.returncode, 0, more)
            if knows[0] in more:
                said = "the token is not that of this tenant" if "/guess" in more else "no token was sent"
                self.assertIn(said, refused.stdout)
        (self.root / "guess").unlink()

    def test_from_nothing_to_nothing(self):
        before = self.files()
        self.install(self.package)
        alerts = (self.root / "usr/share/gnomon/prometheus/gnomon.alerts.yml").read_text()
        runbooks = re.findall(r'runbook_url: "file://(/[^#]+)#', alerts)
        self.assertGreater(len(runbooks), 10)
        for file in runbooks:
            self.assertTrue((self.root / file[1:]).is_file(), f"{file}, to which an alert points")
        unmade = self.chroot("gnomond", "--config", "/" + CONFIG, "--check-config", check=False)
        self.assertNotEqual(unmade.returncode, 0)
        self.assertIn("No such file or directory", unmade.stdout, "the first start makes the certificate")
        self.first_start()
        self.assertIn("ok", self.chroot("gnomond", "--config", "/" + CONFIG, "--check-config").stdout)
        self.self_test()
        self.image_entry()

        config = self.root / CONFIG
        made = self.secrets()
        edited = config.read_text().replace("policy: fair", "policy: deadline")
        config.write_text(edited)
        self.install(self.newer(), "--force-confold")
        self.assertEqual(config.read_text(), edited)
        self.assertEqual(self.chroot("dpkg-query", "-W", "-f", "${Version}", "gnomon").stdout, "99.0")
        self.assertIn("2500", (self.root / (CONFIG + ".dpkg-dist")).read_text())
        self.assertEqual(self.secrets(), made)

        (self.root / "etc/gnomon/credentials/tls.key").write_text("secret")
        self.chroot("dpkg", "--remove", "gnomon")
        self.assertEqual(config.read_text(), edited, "removing keeps the configuration")
        self.chroot("dpkg", "--purge", "gnomon")
        self.assertEqual(sorted(self.files() - before), [])


if __name__ == "__main__":
    if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
        skip("a clean Debian root needs root and mmdebstrap")
    unittest.main(verbosity=2)
