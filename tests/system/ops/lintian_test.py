#!/usr/bin/env python3
"""Debian's own checker finds nothing wrong with the packages but their licence, which the source leaves to its owner.

    lintian_test.py BUILD
"""
import gzip
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from debian_root import build_packages
from node import skip

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
LICENCE = {"copyright-without-copyright-notice", "copyright-not-using-common-license-for-gpl",
           "missing-license-paragraph-in-dep5-copyright", "no-copyright-file", "initial-upload-closes-no-bugs"}
FOUND = re.compile(r"^([EW]): (\S+?)(?: \w+)?: (\S+)(.*)$", re.M)


def lintian(*packages):
    """What it finds: severity, package, tag, detail."""
    done = subprocess.run(["lintian", "--allow-root", "--no-cfg", *map(str, packages)], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode not in (0, 2):
        raise AssertionError(done.stdout)
    return FOUND.findall(done.stdout)


class Lintian(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        if not shutil.which("lintian"):
            skip("there is no lintian")
        cls.packages = build_packages(BUILD)

    def test_packages_are_clean_but_for_the_licence(self):
        found = [finding for finding in lintian(*self.packages.values()) if finding[2] not in LICENCE]
        self.assertEqual(found, [])

    def test_it_would_find_something(self):
        """A package whose maintainer has no address and which has no changelog."""
        with tempfile.TemporaryDirectory(prefix="gnomon-lintian-") as folder:
            tree = pathlib.Path(folder, "tree")
            subprocess.run(["dpkg-deb", "-R", self.packages["gnomon"], tree], check=True)
            control = tree / "DEBIAN/control"
            control.write_text(re.sub(r"(?m)^Maintainer: .*$", "Maintainer: Gnomon <gnomon@localhost>", control.read_text()))
            (tree / "usr/share/doc/gnomon/changelog.gz").unlink()
            subprocess.run(["dpkg-deb", "-Znone", "-b", tree, f"{folder}/gnomon.deb"], check=True,
                           stdout=subprocess.DEVNULL)
            self.assertLessEqual({"bogus-mail-host", "no-changelog"}, {tag for _, _, tag, _ in lintian(f"{folder}/gnomon.deb")})

    def test_it_can_be_read_without_the_source(self):
        listed = subprocess.run(["dpkg-deb", "-c", self.packages["gnomon"]], text=True, capture_output=True,
                                check=True).stdout
        for name in ("README.md.gz", "protocol/WIRE.md.gz", "operations.md", "docs/production.md.gz", "changelog.gz",
                     "examples/development.yaml"):
            self.assertRegex(listed, rf"/usr/share/doc/gnomon/(\./)?{re.escape(name)}\n")

    def test_links_of_its_pages_lead_to_what_it_has(self):
        with tempfile.TemporaryDirectory(prefix="gnomon-links-") as folder:
            subprocess.run(["dpkg-deb", "-x", self.packages["gnomon"], folder], check=True)
            pages = sorted(pathlib.Path(folder, "usr/share/doc/gnomon").rglob("*.md*"))
            checked, broken = 0, []
            for page in pages:
                text = (gzip.decompress(page.read_bytes()) if page.suffix == ".gz" else page.read_bytes()).decode()
                text = re.sub(r"^```.*?^```|`[^`\n]+`", "", text, flags=re.S | re.M)
                for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)\s]*)?\)", text):
                    checked += 1
                    if not (page.parent / target).exists():
                        broken.append(f"{page.relative_to(folder)}: {target}")
            self.assertEqual(broken, [])
            self.assertGreater(checked, 100)


if __name__ == "__main__":
    unittest.main(verbosity=2)
