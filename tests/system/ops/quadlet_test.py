#!/usr/bin/env python3
"""The Quadlet files, by podman's own generator, and the units that it makes of them, by systemd. container_test runs
what they start.

    quadlet_test.py SOURCE BUILD

Needs root, mmdebstrap and a package mirror that has Debian 13; what it needs of it is kept in BUILD/ops.
"""
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import quadlet
from node import skip

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1)).resolve()
FILES = [file for file in (SOURCE / "deploy/container").iterdir() if file.suffix in (".container", ".volume")]


class Quadlet(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.program = quadlet.fetch(BUILD)

    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="gnomon-quadlet-")
        self.addCleanup(temporary.cleanup)
        self.files, self.units = pathlib.Path(temporary.name, "files"), pathlib.Path(temporary.name, "units")
        self.files.mkdir()
        self.units.mkdir()
        for file in FILES:
            shutil.copy(file, self.files)

    def generate(self):
        return quadlet.generate(self.program, self.files)

    def spoil(self, name, change):
        file = self.files / name
        text = change(file.read_text())
        self.assertNotEqual(text, file.read_text())
        file.write_text(text)

    def test_every_file_becomes_a_unit(self):
        status, complaints, units = self.generate()
        self.assertEqual((status, complaints), (0, []))
        self.assertEqual(sorted(units), ["gnomon-cache-volume.service", "gnomon-state-volume.service",
                                         "gnomond.service"])
        self.assertEqual(len(units), len(FILES))
        # Each volume of ours, not one that podman makes for a name that it does not know.
        for volume in ("gnomon-cache", "gnomon-state"):
            self.assertIn(f"Requires={volume}-volume.service", units["gnomond.service"])
            self.assertIn(f"volume create --ignore {volume}", units[f"{volume}-volume.service"])

    def test_systemd_has_no_finding(self):
        _, _, units = self.generate()
        for name, text in units.items():
            # Whoever checks need not have podman; what is for Quadlet alone is nothing to systemd.
            (self.units / name).write_text(text.replace("/usr/bin/podman", "/bin/true"))
        done = subprocess.run(["systemd-analyze", "verify", "--man=no", *self.units.iterdir()], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual((done.returncode, done.stdout), (0, ""))

    def test_mistakes_are_noticed(self):
        self.spoil("gnomond.container", lambda text: text.replace("HealthInterval=", "HealthIntervall="))
        status, complaints, units = self.generate()
        self.assertNotEqual(status, 0)
        self.assertIn("HealthIntervall", "\n".join(complaints))
        self.assertNotIn("gnomond.service", units)

    def test_a_volume_that_is_not_there_is_noticed(self):
        (self.files / "gnomon-cache.volume").unlink()
        status, complaints, _ = self.generate()
        self.assertNotEqual(status, 0)
        self.assertIn("gnomon-cache", "\n".join(complaints))


if __name__ == "__main__":
    if not shutil.which("systemd-analyze"):
        skip("no systemd-analyze here")
    unittest.main(verbosity=2)
