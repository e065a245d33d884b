#!/usr/bin/env python3
"""The systemd unit as a file: no finding of systemd-analyze verify, exposure 1.5 or lower.

    unit_test.py SOURCE BUILD
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from node import skip

MOST_EXPOSURE = 1.5
SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1))
UNITS = [file for file in sorted((SOURCE / "deploy/systemd").iterdir()) if file.suffix in (".service", ".socket")]


def analyze(*arguments):
    done = subprocess.run(["systemd-analyze", *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT)
    return done.returncode, done.stdout


class Unit(unittest.TestCase):
    def test_verify(self):
        """With this build's program in the place of the installed one; manual pages are looked for once installed."""
        with tempfile.TemporaryDirectory() as folder:
            for unit in UNITS:
                text = unit.read_text().replace("/usr/bin/gnomond", str(BUILD / "bin/gnomond"))
                pathlib.Path(folder, unit.name).write_text(text)
            status, output = analyze("verify", "--man=no", *(pathlib.Path(folder, unit.name) for unit in UNITS))
        self.assertEqual((status, output), (0, ""))

    def test_exposure(self):
        unit = SOURCE / "deploy/systemd/gnomond.service"
        status, output = analyze("security", "--offline=true", "--no-pager", unit)
        exposure = float(re.search(r"Overall exposure level for gnomond.service: (\S+)", output).group(1))
        print(f"exposure {exposure}, at most {MOST_EXPOSURE}")
        self.assertEqual(status, 0, output)
        self.assertLessEqual(exposure, MOST_EXPOSURE, output)

    def test_shaders_may_be_compiled_at_run_time(self):
        text = (SOURCE / "deploy/systemd/gnomond.service").read_text()
        self.assertNotRegex(text, r"(?m)^MemoryDenyWriteExecute=(yes|true|1|on)")
        self.assertRegex(text, r"(?m)^WatchdogSec=\d")


if __name__ == "__main__":
    if not shutil.which("systemd-analyze"):
        skip("no systemd-analyze here")
    unittest.main(verbosity=2)
