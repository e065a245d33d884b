#!/usr/bin/env python3
"""The SPDX document of a build names every package whose headers the compiler read and whose libraries the programs load,
and has what SPDX 2.3 demands.

    sbom_test.py SOURCE BUILD
"""
import json
import pathlib
import re
import shutil
import subprocess
import sys
import unittest

from node import skip

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1)).resolve()
FILE = BUILD / "deploy/gnomon.spdx.json"
PROGRAMS = ("bin/gnomond", "bin/gnomonctl", "bin/gnomon-client", "bin/gnomon-load",
            "libexec/gnomon/gnomon-scene-worker", "lib/libgnomon.so")
# Of SPDX 2.3: clauses 6 (document), 7 (package), 10 (extracted licences), 11 (relationships).
DOCUMENT = ("spdxVersion", "dataLicense", "SPDXID", "name", "documentNamespace", "creationInfo")
PACKAGE = ("SPDXID", "name", "downloadLocation", "filesAnalyzed", "licenseDeclared", "licenseConcluded", "copyrightText")
ID = re.compile(r"SPDXRef-[A-Za-z0-9.-]+")
NAMES = {"MIT", "X11", "ISC", "BSL-1.0", "BSD-2-Clause", "BSD-3-Clause", "Apache-2.0", "Zlib", "CC0-1.0", "0BSD",
         "Unlicense", "GPL-2.0-only", "GPL-2.0-or-later", "GPL-3.0-or-later", "LGPL-2.1-only", "LGPL-2.1-or-later"}


def output(*command):
    return subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL).stdout


def findings(document):
    """What SPDX 2.3 does not allow in it."""
    wrong = [f"no {key}" for key in DOCUMENT if not document.get(key)]
    if (document.get("spdxVersion"), document.get("dataLicense"), document.get("SPDXID")) != (
            "SPDX-2.3", "CC0-1.0", "SPDXRef-DOCUMENT"):
        wrong.append("version, licence or id of the document")
    if not re.fullmatch(r"https?://[^#\s]+", document.get("documentNamespace", "")):
        wrong.append("documentNamespace")
    creation = document.get("creationInfo", {})
    if not re.fullmatch(r"\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ", creation.get("created", "")):
        wrong.append("created")
    if not all(re.match(r"(Tool|Person|Organization): ", name) for name in creation.get("creators") or [""]):
        wrong.append("creators")
    ids = [package.get("SPDXID", "") for package in document.get("packages", [])]
    own_names = {text.get("licenseId") for text in document.get("hasExtractedLicensingInfos", [])
                 if text.get("extractedText")}
    if len(set(ids)) != len(ids) or not all(ID.fullmatch(name) for name in ids):
        wrong.append("ids of packages")
    for package in document.get("packages", []):
        wrong += [f"{package.get('name')}: no {key}" for key in PACKAGE if key not in package]
        for name in re.split(r" (?:AND|OR) ", package.get("licenseDeclared", "")):
            if name not in NAMES | own_names | {"NOASSERTION", "NONE"}:
                wrong.append(f"{package.get('name')}: licence {name}")
    for relation in document.get("relationships", []):
        if not {relation.get("spdxElementId"), relation.get("relatedSpdxElement")} <= {*ids, "SPDXRef-DOCUMENT"}:
            wrong.append(f"relationship {relation}")
    described = [relation for relation in document.get("relationships", [])
                 if relation.get("relationshipType") == "DESCRIBES"]
    return wrong + (["nothing is described"] if not described else [])


class Sbom(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.document = json.loads(FILE.read_text())
        cls.packages = {package["name"]: package for package in cls.document["packages"]}

    def test_it_is_spdx(self):
        self.assertEqual(findings(self.document), [])

    def test_what_is_not_spdx_is_noticed(self):
        for spoil in (lambda d: d.pop("documentNamespace"), lambda d: d.update(spdxVersion="SPDX-1.0"),
                      lambda d: d["packages"][1].pop("downloadLocation"),
                      lambda d: d["packages"][1].update(licenseDeclared="Expat"),
                      lambda d: d["packages"].pop(1), lambda d: d.pop("relationships"),
                      lambda d: d["creationInfo"].update(created="today")):
            document = json.loads(FILE.read_text())
            spoil(document)
            self.assertNotEqual(findings(document), [])

    def test_every_package_whose_headers_were_read_is_in_it(self):
        """By ninja's own tool, and of the objects in every library of ours that a program links."""
        commands = output("ninja", "-C", BUILD, "-t", "commands", *PROGRAMS)
        objects = set(re.findall(r" -o (\S+\.o) ", commands))
        headers, current = set(), None
        for line in output("ninja", "-C", BUILD, "-t", "deps").splitlines():
            if not line.startswith(" "):
                current = line.split(":")[0]
            elif current in objects and line.strip().startswith("/usr/include/"):
                headers.add(line.strip())
        self.assertGreater(len(headers), 500)
        owners = output("dpkg-query", "-S", *sorted(headers))
        names = {owner.split(":")[0] for line in owners.splitlines() for owner in line.rsplit(": ", 1)[0].split(", ")}
        for library in ("libtinygltf-dev", "libstb-dev", "nlohmann-json3-dev", "libasio-dev", "libcli11-dev",
                        "libglm-dev", "libseccomp-dev"):
            self.assertIn(library, names)
        self.assertEqual(names - set(self.packages), set())
        installed = dict(re.findall(r"^(\S+)\t(\S+)$", output("dpkg-query", "-W", "-f", "${Package}\t${Version}\n"), re.M))
        for name in names:
            self.assertEqual(self.packages[name]["versionInfo"], installed[name])

    def test_every_library_that_is_loaded_is_in_it(self):
        linked = {relation["relatedSpdxElement"] for relation in self.document["relationships"]
                  if relation["relationshipType"] == "DYNAMIC_LINK"}
        for library in ("libssl3", "libvulkan1", "libyaml-cpp0.7", "libseccomp2", "libstdc--6", "libc6"):
            self.assertIn("SPDXRef-" + library, linked)

    def test_where_dpkg_is_missing_the_build_goes_on(self):
        done = subprocess.run([sys.executable, SOURCE / "deploy/sbom", BUILD, "1", "/nowhere/out", *PROGRAMS],
                              env={"PATH": "/nowhere"}, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        self.assertIn("no SBOM: it needs dpkg-query", done.stdout)

    def test_licences_are_those_of_debians_files(self):
        self.assertEqual(self.packages["libcli11-dev"]["licenseDeclared"], "BSD-3-Clause")
        self.assertEqual(self.packages["nlohmann-json3-dev"]["licenseDeclared"], "MIT")
        own = {text["licenseId"]: text for text in self.document["hasExtractedLicensingInfos"]}
        stb = self.packages["libstb-dev"]["licenseDeclared"]
        self.assertIn("public domain", own[stb]["extractedText"].lower())


if __name__ == "__main__":
    if not shutil.which("dpkg-query") or not FILE.is_file():
        skip("no dpkg, or no SBOM in this build")
    unittest.main(verbosity=2)
