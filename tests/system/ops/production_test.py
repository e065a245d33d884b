#!/usr/bin/env python3
"""The four steps of docs/production.md in a booted systemd, with the package alone; then credentials that systemd hands
over.

    production_test.py BUILD

Needs root, mmdebstrap, systemd-nspawn and a package mirror; the root is kept in BUILD/ops for the next time.
"""
import pathlib
import re
import shutil
import sys
import unittest
import uuid

from booted_root import BootedRoot, run
from debian_root import build_package, root_with_dependencies
from node import eventually

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
CONFIG = "/etc/gnomon/gnomond.yaml"
CLIENTS = "/etc/gnomon/private/clients"
HOST = "127.0.0.2"  # an address of the machine that the package alone does not serve
HANDED_OVER = """[Service]
LoadCredential=server.pem:/srv/secrets/server.pem
LoadCredential=server-key.pem:/srv/secrets/server-key.pem
"""


class PackagedRoot(BootedRoot):
    """A minimal bookworm with what the package depends on, and a systemd."""

    def mount_layers(self):
        self.package = build_package(self.build)
        self.root.mkdir()
        run("tar", "-C", self.root, "-xf", root_with_dependencies(self.build, self.package, "systemd-sysv"))

    def install(self):
        shutil.copy(self.package, self.root / "gnomon.deb")
        (self.root / "etc/machine-id").write_text(uuid.uuid4().hex + "\n")  # no first boot that asks for more


class Production(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.system = cls.enterClassContext(PackagedRoot(BUILD))
        cls.system.run("dpkg", "--install", "/gnomon.deb")
        # Frames of lavapipe beside the build of light buffers, on busy cores, are no sign of a device that hangs.
        cls.system.write("/etc/systemd/system/gnomond.service.d/patience.conf", "[Service]\nWatchdogSec=5min\n")
        cls.system.systemctl("daemon-reload")
        cls.system.start("gnomond.socket", "gnomond.service")  # policy-rc.d of such a root starts nothing

    def load(self, folder, tenant, server=f"{HOST}:7600", clients=2):
        return self.system.run("gnomon-load", "--server", server, "--ca", f"{folder}/ca.pem", "--tenant",
                               f"{tenant}:{folder}/token:{clients}", "--scene", "living_room", "--size", "160x90",
                               "--rate", 0, "--seconds", 0.5, check=False)

    def restart(self, init):
        """As the output of `gnomonctl init` says."""
        done = self.system.run("sh", "-c", re.search(r"systemctl daemon-reload .*", init).group(0), check=False)
        self.assertEqual(done.returncode, 0, done.stdout + self.system.journal())
        for unit in ("gnomond.socket", "gnomond.service"):
            self.assertEqual(self.system.property("ActiveState", unit), "active", unit)

    def served(self, folder, tenant):
        for _ in range(5):  # the first frames of lavapipe beside the build of light buffers may take a quarter of a minute
            done = self.load(folder, tenant)
            if done.returncode != 3:
                break
        self.assertEqual(done.returncode, 0, done.stdout + self.system.journal())

    def test_1_as_installed_it_serves_this_machine_alone(self):
        self.assertIn("serving", self.system.property("StatusText"))
        self.assertIn("127.0.0.1:7600", self.system.property("Listen", "gnomond.socket"))

    def test_2_init_writes_all_of_it(self):
        done = self.system.run("gnomonctl", "init", "--host", HOST, "--host", "edge.example", "--tenant", "lab",
                               "--tenant", "arcade", "--scene", "living_room")
        type(self).printed = done.stdout
        for part in ("systemctl daemon-reload", "firewall", f"{CLIENTS}/lab", "ca-key.pem"):
            self.assertIn(part, done.stdout)
        checked = self.system.run("gnomond", "--config", CONFIG, "--check-config", check=False)
        self.assertEqual(checked.returncode, 0, checked.stdout)
        listed = self.system.run("sh", "-c", "stat -c '%a %G %n' /etc/gnomon/credentials/*").stdout
        for name in ("server.pem", "server-key.pem", "lab.sha256", "arcade.sha256"):
            self.assertIn(f"640 gnomon /etc/gnomon/credentials/{name}\n", listed)
        self.assertEqual(self.system.run("stat", "-c", "%a", "/etc/gnomon/private").stdout, "700\n")
        self.assertNotEqual((self.system.root / "etc/gnomon/gnomond.yaml.before").read_text(), "")

    def test_3_and_4_it_serves_who_has_a_tenants_folder(self):
        self.restart(self.printed)
        self.assertIn("0.0.0.0:7600", self.system.property("Listen", "gnomond.socket"))
        for tenant in ("lab", "arcade"):
            self.served(f"{CLIENTS}/{tenant}", tenant)
        stranger = self.load(f"{CLIENTS}/lab", "arcade")
        self.assertNotEqual(stranger.returncode, 0, "with another tenant's token")
        self.assertIn("bad_token", stranger.stdout)

    def test_5_init_again_keeps_clients_served(self):
        self.system.run("cp", "-r", f"{CLIENTS}/lab", "/root/lab")  # as it was handed over
        done = self.system.run("gnomonctl", "init", "--host", HOST, "--tenant", "lab", "--tenant", "museum", "--scene",
                               "living_room")
        self.assertIn("     gnomonctl reload\n", done.stdout)
        self.assertNotIn("systemctl daemon-reload", done.stdout)
        reloaded = self.system.run("gnomonctl", "reload", check=False)
        self.assertEqual(reloaded.returncode, 0, reloaded.stdout)
        self.served("/root/lab", "lab")
        self.served(f"{CLIENTS}/museum", "museum")

    def test_6_credentials_that_systemd_hands_over(self):
        self.system.run("sh", "-c", "install -d -m 700 /srv/secrets && cd /etc/gnomon/credentials && "
                                    "mv server.pem server-key.pem /srv/secrets && chmod 600 /srv/secrets/*")
        config = self.system.root / CONFIG.lstrip("/")
        config.write_text(re.sub(r"credentials/(server\S*pem)", r"${CREDENTIALS_DIRECTORY}/\1", config.read_text()))
        self.system.systemctl("restart", "gnomond.service", check=False)
        eventually(lambda: "CREDENTIALS_DIRECTORY" in self.system.journal(), "why it does not start")
        self.system.systemctl("stop", "gnomond.service", check=False)
        self.system.write("/etc/systemd/system/gnomond.service.d/credentials.conf", HANDED_OVER)
        self.system.systemctl("daemon-reload")
        self.system.start("gnomond.service")
        self.served("/root/lab", "lab")


if __name__ == "__main__":
    unittest.main(verbosity=2)
