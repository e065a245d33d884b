#!/usr/bin/env python3
"""Every program and library in the Debian packages is hardened, by readelf; and programs that are not are noticed.

    hardening_test.py BUILD
"""
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

from booted_root import run
from debian_root import build_packages
from node import skip

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
PROGRAM = "#include <vector>\n#include <cstdio>\nint main(int count, char** names) { char copy[64]; std::vector<int> v(3);" \
          " std::snprintf(copy, count * 8, \"%s\", names[0]); std::puts(copy); return v[count]; }\n"
HARDENED = ("-O2", "-fPIE", "-pie", "-fstack-protector-strong", "-U_FORTIFY_SOURCE", "-D_FORTIFY_SOURCE=2",
            "-D_GLIBCXX_ASSERTIONS", "-Wl,-z,relro,-z,now,-z,noexecstack")


def findings(file):
    """What is missing in this ELF file, or too much."""
    text = subprocess.run(["readelf", "-W", "--file-header", "--program-headers", "--dynamic", "--dyn-syms", file],
                          text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=True).stdout
    stack = re.search(r"^ +GNU_STACK .* (R?W?E?) +0x", text, re.M)
    checks = {
        "position independent": re.search(r"^ +Type: +DYN", text, re.M),
        "relocations read-only": re.search(r"^ +GNU_RELRO ", text, re.M),
        "bound at the start": re.search(r"\((FLAGS|FLAGS_1)\).*\b(BIND_NOW|NOW)\b", text),
        "no executable stack": stack and "E" not in stack.group(1),
        "stack protector": " UND __stack_chk_fail" in text,
        "fortified calls": re.search(r" UND __(?!stack)\w+_chk(@|\s)", text),
        "asserting containers": re.search(r" UND _ZSt\d+__glibcxx_assert_fail", text),
        "no search path of its own": not re.search(r"\((RPATH|RUNPATH)\)", text),
    }
    return [name for name, holds in checks.items() if not holds]


def is_elf(file):
    with open(file, "rb") as opened:
        return opened.read(4) == b"\x7fELF"


class Packages(unittest.TestCase):
    def test_everything_in_them_is_hardened(self):
        found = {}
        with tempfile.TemporaryDirectory(prefix="gnomon-hardening-") as folder:
            for name, package in build_packages(BUILD).items():
                run("dpkg-deb", "-x", package, f"{folder}/{name}")
            for file in sorted(pathlib.Path(folder).rglob("*")):
                if file.is_file() and not file.is_symlink() and is_elf(file):
                    found[str(file.relative_to(folder))] = findings(file)
        print("\n".join(found))
        for name in ("gnomond", "gnomonctl", "gnomon-client", "gnomon-load", "gnomon-scene-worker", "libgnomon.so"):
            self.assertTrue(any(name in file for file in found), name)
        self.assertEqual({file: missing for file, missing in found.items() if missing}, {})


class SelfTest(unittest.TestCase):
    """One program that has it all, and one for each thing that it lacks."""

    def findings(self, *flags):
        with tempfile.TemporaryDirectory(prefix="gnomon-hardening-") as folder:
            source, program = pathlib.Path(folder, "a.cpp"), pathlib.Path(folder, "a")
            source.write_text(PROGRAM)
            run("c++", *HARDENED, *flags, source, "-o", program)
            return findings(program)

    def test_what_is_missing_is_noticed(self):
        for flags, missing in (
                ((), []),
                (("-fno-pie", "-no-pie"), ["position independent"]),
                (("-Wl,-z,norelro",), ["relocations read-only"]),
                (("-Wl,-z,lazy",), ["bound at the start"]),
                (("-Wl,-z,execstack",), ["no executable stack"]),
                (("-fno-stack-protector",), ["stack protector"]),
                (("-U_FORTIFY_SOURCE",), ["fortified calls"]),
                (("-U_GLIBCXX_ASSERTIONS",), ["asserting containers"]),
                (("-Wl,-rpath,/opt/lib",), ["no search path of its own"])):
            with self.subTest(flags):
                self.assertEqual(self.findings(*flags), missing)


if __name__ == "__main__":
    if not shutil.which("readelf") or not shutil.which("dpkg-deb"):
        skip("no readelf or dpkg-deb here")
    unittest.main(verbosity=2)
