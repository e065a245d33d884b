#!/usr/bin/python3
"""The door's configuration as HAProxy reads it, and as Debian's package has its own.

    config_test.py BUILD
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

GNOMONCTL = pathlib.Path(sys.argv.pop(1)).resolve() / "bin/gnomonctl"
PACKAGED = pathlib.Path("/etc/haproxy/haproxy.cfg")
os.environ["PATH"] += ":/usr/sbin"


def made():
    return subprocess.check_output([GNOMONCTL, "fleet", "haproxy", "--node", "n1=10.0.0.11", "--node", "n2=10.0.0.12"],
                                   text=True)


def directives(text):
    """Of the section `global`, without comments: what each keyword is followed by. The last one counts."""
    lines = re.search(r"^global\n(.*?)(?:^\S|\Z)", text, re.M | re.S)[1].splitlines()
    words = [line.split("#")[0].split() for line in lines]
    return {line[0]: line[1:] for line in words if line}


class Door(unittest.TestCase):
    def test_haproxy_takes_it_and_warns_of_nothing(self):
        with tempfile.NamedTemporaryFile("w", suffix=".cfg") as file:
            file.write(made())
            file.flush()
            done = subprocess.run(["haproxy", "-c", "-f", file.name], text=True, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT)
        self.assertEqual((done.returncode, re.findall("WARNING|ALERT", done.stdout)), (0, []), done.stdout)

    @unittest.skipUnless(PACKAGED.exists(), "HAProxy is not Debian's")
    def test_its_account_its_root_and_its_socket_are_the_packages(self):
        ours, packaged = directives(made()), directives(PACKAGED.read_text())
        for keyword in ("user", "group", "chroot"):
            self.assertEqual(ours.get(keyword), packaged[keyword], keyword)
        self.assertIn("stats socket /run/haproxy/admin.sock mode 660 level admin", made())
        self.assertIn("stats socket /run/haproxy/admin.sock mode 660 level admin", PACKAGED.read_text())


if __name__ == "__main__":
    if not shutil.which("haproxy"):
        print("skipped: haproxy is not installed (deploy/install-packages tests)")
        sys.exit(77)
    unittest.main(verbosity=2)
