#!/usr/bin/env python3
"""The unit under a real systemd: a first start that makes a certificate and a token, then started, reloaded, killed,
hung, drained; its ports outlive it.

    booted_test.py BUILD
"""
import re
import subprocess
import sys
import unittest

from booted_root import BootedRoot
from node import eventually

BUILD = sys.argv.pop(1)
CONFIG = "/etc/gnomon/gnomond.yaml"
PRIVATE = "/etc/gnomon/private"
CONFIG_TEXT = """
server: {tls: {certificate: credentials/server.pem, key: credentials/server-key.pem}}
render: {device: cpu, cache_folder: /var/cache/gnomon}
scenes: {list: [{name: living_room, file: living_room.glb}]}
tenants: [{name: default, weight: %d, token_sha256_file: credentials/default.sha256}]
"""
ROTATED = """
server: {tls: {certificate: credentials/own.pem, key: credentials/own-key.pem}}
render: {device: cpu, cache_folder: /var/cache/gnomon}
scenes: {list: [{name: living_room, file: living_room.glb}]}
tenants: [{name: studio, open: true}]
"""
CREDENTIALS = "/etc/gnomon/credentials"
FAULTS = """[Service]
Environment=VK_ADD_LAYER_PATH=/opt/faults VK_INSTANCE_LAYERS=VK_LAYER_GNOMON_faults GNOMON_FAULTS=/run/gnomon
"""
KNOWS = ("gnomon-load", "--server", "127.0.0.1:7600", "--ca", f"{PRIVATE}/ca.pem", "--scene", "living_room",
         "--size", "160x90", "--rate", 0)
LOAD = (*KNOWS, "--tenant", f"default:{PRIVATE}/default.token:2")


class Booted(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.system = cls.enterClassContext(BootedRoot(BUILD))
        cls.system.write(CONFIG, CONFIG_TEXT % 1)
        cls.system.write("/etc/systemd/system/gnomond.service.d/faults.conf", FAULTS)
        cls.system.systemctl("daemon-reload")
        cls.system.start("gnomond.socket", "gnomond.service")

    def setUp(self):
        if self.system.property("ActiveState") != "active":
            self.system.start("gnomond.service")
        self.restarts = int(self.system.property("NRestarts"))

    def serves(self):
        def answers():  # beside builds of light buffers, and on a machine that may be busy with more
            return self.system.run(*LOAD, "--seconds", 0.5, "--may-miss", 99, check=False).returncode == 0
        eventually(answers, "frames for clients")

    def restarted(self):
        eventually(lambda: int(self.system.property("NRestarts")) > self.restarts, "a restart")
        eventually(lambda: self.system.property("ActiveState") == "active", "active after a restart")
        down = (int(self.system.property("ActiveEnterTimestampMonotonic"))
                - int(self.system.property("InactiveEnterTimestampMonotonic")))
        return down / 1e6

    def test_verify(self):
        """With everything installed, the manual pages too."""
        units = ("/usr/lib/systemd/system/gnomond.service", "/usr/lib/systemd/system/gnomond.socket")
        self.assertEqual(self.system.run("systemd-analyze", "verify", *units).stdout, "")

    def test_started(self):
        self.assertIn("serving 1 scenes", self.system.property("StatusText"))
        self.serves()
        without = self.system.run(*KNOWS, "--tenant", "default::2", "--seconds", 0.5, check=False)
        self.assertNotEqual(without.returncode, 0, without.stdout)

    def test_first_start_is_once(self):
        """By the unit that the daemon's asks for; what it made is root's alone, and the next start leaves it."""
        first = "gnomon-first-start.service"
        self.assertEqual(self.system.property("Result", first), "success")
        listed = lambda: self.system.run("stat", "-c", "%n %a %U %Y", *(f"{PRIVATE}/{name}" for name in (
            "ca.pem", "ca-key.pem", "default.token")), "/etc/gnomon/credentials/server-key.pem").stdout
        made = listed()
        for line in made.splitlines():
            self.assertRegex(line, r" 6[04][04] root \d+$")
        self.system.start(first)
        self.assertEqual(self.system.property("ConditionResult", first), "no")
        self.assertEqual(listed(), made)

    def test_reloaded(self):
        main = self.system.property("MainPID")
        self.system.write(CONFIG, CONFIG_TEXT % 3)
        self.system.systemctl("reload", "gnomond.service")
        eventually(lambda: '"weight": 3' in self.system.run("curl", "-s", "127.0.0.1:7601/status").stdout,
                   "the new weight")
        self.system.write(CONFIG, CONFIG_TEXT % -1)
        self.assertNotEqual(self.system.systemctl("reload", "gnomond.service", check=False).returncode, 0)
        self.assertIn("weight", self.system.journal())
        self.assertIn('"weight": 3', self.system.run("curl", "-s", "127.0.0.1:7601/status").stdout)
        self.assertEqual(self.system.property("ActiveState"), "active")
        self.assertEqual(self.system.property("MainPID"), main)
        self.system.write(CONFIG, CONFIG_TEXT % 1)

    def test_operators_come_through_the_socket(self):
        """Which is there anew after a crash, for root and nobody else."""
        for _ in range(2):
            owner = self.system.run("stat", "-c", "%a %F", "/run/gnomon/admin.sock").stdout
            self.assertEqual(owner.strip(), "660 socket")
            self.assertEqual(self.system.run("gnomonctl", "reload").stdout, "reloaded; no key has changed\n")
            self.assertIn("audit action operator=root(0) address=socket action=reload", self.system.journal())
            stranger = self.system.run("setpriv", "--reuid", "nobody", "--clear-groups", "gnomonctl", "reload",
                                       check=False)
            self.assertEqual(stranger.returncode, 1)
            self.assertIn("/run/gnomon/admin.sock", stranger.stdout, "over TCP it is told where to go")
            self.system.systemctl("kill", "-s", "KILL", "gnomond.service")
            self.restarted()
            self.restarts = int(self.system.property("NRestarts"))

    def test_a_group_of_operators(self):
        """The sandbox shows the daemon no group but its own."""
        self.system.run("groupadd", "--force", "operators")
        drop_in = "/etc/systemd/system/gnomond.service.d/operators.conf"
        self.system.write(drop_in, "[Service]\nGroup=operators\n")
        self.system.write(CONFIG, CONFIG_TEXT % 1 + "admin: {group: operators}\nlog: {audit_file: /var/log/gnomon/audit.log}\n")
        self.system.systemctl("daemon-reload")
        self.system.systemctl("restart", "gnomond.service")
        member = self.system.run("setpriv", "--reuid", "nobody", "--groups", "operators", "gnomonctl", "reload",
                                 check=False)
        self.assertEqual((member.returncode, member.stdout), (0, "reloaded; no key has changed\n"), self.system.journal())
        self.assertIn("action=reload", self.system.run("cat", "/var/log/gnomon/audit.log").stdout)
        self.system.run("sh", "-c", f"rm {drop_in}")
        self.system.write(CONFIG, CONFIG_TEXT % 1)
        self.system.systemctl("daemon-reload")
        self.system.systemctl("restart", "gnomond.service")

    def load(self):
        """Two clients, until the test ends."""
        load = subprocess.Popen(list(map(str, self.system.command(*LOAD, "--seconds", 600))),
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(load.wait)
        self.addCleanup(self.end_load)

    def end_load(self):
        self.system.run("pkill", "-x", "gnomon-load", check=False)  # it would go on with the next daemon
        eventually(lambda: not self.sessions(), "no sessions any more")

    def sessions(self):
        lines = self.system.run("gnomonctl", "sessions", check=False).stdout.splitlines()[1:]
        return sorted(line.split()[0] for line in lines)

    def test_killed(self):
        """Sessions go on with the same keys: systemd keeps their memory."""
        self.load()
        eventually(lambda: len(self.sessions()) == 2, "sessions")
        before = self.sessions()
        self.system.systemctl("kill", "-s", "KILL", "gnomond.service")
        print(f"kill -9 to READY, cache warm: {self.restarted():.2f} s")
        eventually(lambda: self.sessions() == before, "the same sessions")
        me = f"gnomond[{self.system.property('MainPID')}]"
        eventually(lambda: sum(me in line and "session resumed" in line
                               for line in self.system.journal().splitlines()) == 2, "both in the journal")
        self.end_load()
        self.serves()

    def test_hung(self):
        self.load()
        eventually(self.sessions, "sessions")
        self.system.run("touch", "/run/gnomon/hang")
        print(f"down after a tripped watchdog: {self.restarted():.2f} s")
        self.assertIn("Watchdog timeout", self.system.journal())
        self.end_load()
        self.serves()

    def test_stopped(self):
        self.system.systemctl("stop", "gnomond.service")
        self.assertEqual(self.system.property("Result"), "success")
        self.assertEqual(self.system.property("ExecMainStatus"), "0")
        self.system.start("gnomond.service")
        self.system.run("gnomonctl", "stop")
        eventually(lambda: self.system.property("ActiveState") == "inactive", "inactive after gnomonctl stop")
        self.assertEqual(self.system.property("ExecMainStatus"), "0")
        self.assertEqual(int(self.system.property("NRestarts")), 0, "who was asked to go is not started again")

    def shown_pin(self):
        """Of the certificate that new connections get."""
        ask = "openssl s_client -connect 127.0.0.1:7600 -alpn gnomon </dev/null | openssl x509 -noout -fingerprint -sha256"
        shown = self.system.run("sh", "-c", ask).stdout
        return "sha256:" + re.search(r"Fingerprint=(\S+)", shown).group(1).replace(":", "").lower()

    def place_certificate(self, *how):
        self.system.run("gnomonctl", "make-certs", "--out", "/root/certs", "--host", "127.0.0.1", *how)
        for made, name in (("server.pem", "own.pem"), ("server-key.pem", "own-key.pem")):
            self.system.run("install", "-m", "640", f"/root/certs/{made}", f"{CREDENTIALS}/{name}")

    def back_to_first(self):
        self.system.write(CONFIG, CONFIG_TEXT % 1)
        self.system.systemctl("restart", "gnomond.service")

    def test_rotated(self):
        """A reload shows new clients the new certificate, and sessions go on."""
        self.place_certificate()
        self.assertEqual(self.system.run("stat", "-c", "%A %U %G", CREDENTIALS).stdout, "drwxr-s--- root gnomon\n")
        self.assertEqual(self.system.run("stat", "-c", "%A %U %G", CREDENTIALS + "/own-key.pem").stdout,
                         "-rw-r----- root gnomon\n")
        self.system.write(CONFIG, ROTATED)
        self.addCleanup(self.back_to_first)
        self.system.systemctl("restart", "gnomond.service")
        before, main = self.shown_pin(), self.system.property("MainPID")
        load = subprocess.Popen(
            list(map(str, self.system.command("gnomon-load", "--server", "127.0.0.1:7600", "--pin", before, "--scene",
                                              "living_room", "--size", "160x90", "--rate", 5, "--tenant", "studio::2",
                                              "--seconds", 600))), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(load.wait)
        self.addCleanup(self.end_load)
        eventually(lambda: len(self.sessions()) == 2, "sessions")
        sessions = self.sessions()
        self.place_certificate("--renew")
        self.system.systemctl("reload", "gnomond.service")
        eventually(lambda: self.shown_pin() != before, "the new certificate")
        self.assertEqual(self.system.property("MainPID"), main)
        self.assertEqual(self.sessions(), sessions)
        self.system.write(CREDENTIALS + "/own.pem", "half a certificate")
        second = self.shown_pin()
        self.system.systemctl("reload", "gnomond.service")
        eventually(lambda: "reloaded in part" in self.system.journal(), "what could not be applied")
        self.assertEqual(self.shown_pin(), second)

    def test_whoever_connects_starts_it(self):
        self.system.systemctl("stop", "gnomond.service")
        self.serves()
        self.assertEqual(self.system.property("ActiveState"), "active")


if __name__ == "__main__":
    unittest.main(verbosity=2)
