#!/usr/bin/env python3
"""deploy/install-packages with an apt that fails as networks do, and with the package sources that machines have.
Nothing is installed: apt-get, dpkg-query and their kin are programs of this test, /etc/apt is a folder of its own.

    install_packages_test.py SOURCE
"""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(sys.argv.pop(1)).resolve()
SCRIPT = SOURCE / "deploy/install-packages"

# Notes what it is asked for in `calls`. Fails, once for each file named after the command in `failures`; what it
# installs is installed from then on.
APT_GET = """#!/bin/bash
echo "$*" >>calls
for word; do
  case $word in
    --assume-no) echo "0 upgraded, 7 newly installed, 0 to remove"; echo "Need to get 0 B/12.3 MB of archives."; exit 1 ;;
    update | install) command=$word ;;
  esac
done
failure=$(find failures -name "$command.*" | sort | head -n 1)
if [ -n "$failure" ]; then
  cat "$failure"
  rm "$failure"
  exit 100
fi
if [ "$command" = install ]; then
  while [ "$1" != install ]; do shift; done
  shift
  printf '%s\\n' "$@" | grep -vx -e -t -e bookworm-backports >>installed
fi
exit 0
"""
DPKG_QUERY = """#!/bin/bash
echo dpkg-query >>calls
version=1
[ -e mesa ] && version=$(cat mesa)
while read -r name; do
  if [ "$name" = mesa-vulkan-drivers ]; then echo "installed $name $version"; else echo "installed $name 1.0"; fi
done <installed
exit 1
"""
# Writes on after what was looked for, as the real one does: whoever stops reading there kills it.
APT_CACHE = """#!/bin/bash
if [ -e etc/sources.list.d/gnomon-backports.sources ] || [ -e etc/sources.list.d/gnomon-backports.list ]; then
  echo "mesa-vulkan-drivers | 25.0.7 | bookworm-backports/main"
  sleep 0.2
fi
echo "mesa-vulkan-drivers | 22.3.6 | bookworm/main" || exit 1
"""
DEB822 = """# Written by the installer.
Types: deb
URIs: http://old.invalid/debian
Suites: bookworm
Components: main
Enabled: no

Types: deb-src
URIs: http://sources.invalid/debian
Suites: bookworm
Components: main

Types: deb
# The mirror in the cellar.
URIs: http://mirror.invalid/debian
Suites: bookworm
 bookworm-updates
Components: main contrib
Signed-By: /etc/keyrings/cellar.gpg

Types: deb
URIs: http://security.invalid/debian-security
Suites: bookworm-security
Components: main
"""
ONE_LINE = """# deb http://old.invalid/debian bookworm main
deb-src http://sources.invalid/debian bookworm main
deb http://security.invalid/debian-security bookworm-security main
deb [arch=amd64 signed-by=/etc/keyrings/cellar.gpg]  http://mirror.invalid/debian bookworm main contrib
deb http://second.invalid/debian bookworm main
"""


class InstallPackages(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="gnomon-install-packages-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        for name in ("bin", "failures", "etc/sources.list.d", "etc/apt.conf.d"):
            (self.folder / name).mkdir(parents=True)
        self.program("apt-get", APT_GET)
        self.program("dpkg-query", DPKG_QUERY)
        self.program("apt-cache", APT_CACHE)
        self.program("id", "#!/bin/sh\necho 0\n")
        self.program("sleep", '#!/bin/sh\n[ "$1" = 5 ] || exec /bin/sleep "$1"\n')
        (self.folder / "apt.conf").write_text(f'Dir::Etc "{self.folder}/etc/";\n')
        (self.folder / "etc/sources.list.d/debian.sources").write_text(DEB822)
        (self.folder / "installed").touch()
        (self.folder / "calls").touch()

    def program(self, name, text):
        file = self.folder / "bin" / name
        file.write_text(text)
        file.chmod(0o755)

    def run_script(self, *arguments):
        environment = {**os.environ, "PATH": f"{self.folder}/bin:{os.environ['PATH']}",
                       "APT_CONFIG": str(self.folder / "apt.conf"), "TMPDIR": str(self.folder)}
        return subprocess.run([SCRIPT, *arguments], cwd=self.folder, env=environment, text=True, timeout=60,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def installs(self, *arguments):
        done = self.run_script(*arguments)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def fails(self, *arguments):
        done = self.run_script(*arguments)
        self.assertNotIn(done.returncode, (0, 2), done.stdout)
        return done.stdout

    def let_fail(self, command, times, text="E: Unable to connect to the mirror"):
        for number in range(times):
            (self.folder / "failures" / f"{command}.{number}").write_text(text + "\n")

    def calls(self, command):
        lines = (self.folder / "calls").read_text().splitlines()
        return [line for line in lines if command in line.split() and "--assume-no" not in line]

    def have_all(self, *purpose, mesa="25.0.7-2~bpo12+1"):
        """As if everything had been installed."""
        names = self.run_script("--missing", *purpose).stdout
        (self.folder / "installed").write_text(names)
        (self.folder / "mesa").write_text(mesa)
        (self.folder / "calls").write_text("")

    def test_names_what_is_missing_in_one_question(self):
        missing = self.installs("--missing", "run").split()
        self.assertIn("libasio-dev", missing)
        self.assertIn("mesa-vulkan-drivers", missing)
        self.assertNotIn("libgtest-dev", missing)
        self.assertIn("libgtest-dev", self.installs("--missing", "tests").split())
        (self.folder / "calls").write_text("")
        (self.folder / "installed").write_text("\n".join(set(missing) - {"libasio-dev", "libglm-dev"}) + "\n")
        (self.folder / "mesa").write_text("25.0.7-2")
        self.assertEqual(self.installs("--missing", "run").split(), ["libglm-dev", "libasio-dev"])
        self.assertEqual((self.folder / "calls").read_text(), "dpkg-query\n")

    def test_a_kubernetes_is_beside_what_containers_need(self):
        containers, more = (set(self.installs("--missing", purpose).split()) for purpose in ("containers", "kubernetes"))
        self.assertLess(containers, more)
        self.assertLessEqual({"golang-1.19-go", "etcd-server", "containerd"}, more - containers)

    def test_asks_no_network_when_all_is_there(self):
        self.have_all("tests")
        self.assertIn("all present", self.installs("tests"))
        self.assertEqual((self.folder / "calls").read_text(), "dpkg-query\n")

    def test_says_how_much_comes(self):
        self.assertIn("7 packages with what they need, 0 B/12.3 MB to fetch", self.installs("run"))

    def test_the_second_time_nothing_is_missing(self):
        (self.folder / "mesa").write_text("25.0.7-2")
        self.installs("run")
        self.assertEqual(self.installs("--missing", "run"), "")
        self.assertIn("all present", self.installs("run"))

    def test_survives_a_network_that_fails_once(self):
        for command in ("update", "install"):
            with self.subTest(command):
                (self.folder / "installed").write_text("")
                self.let_fail(command, 1)
                self.assertIn("packages: done", self.installs("run"))

    def test_survives_a_network_that_fails_twice(self):
        self.let_fail("update", 2)
        self.let_fail("install", 2)
        self.installs("run")
        self.assertEqual(len(self.calls("update")), 3)

    def test_says_which_step_failed_and_what_apt_said(self):
        self.let_fail("update", 9, "E: Failed to fetch the list of the cellar")
        said = self.fails("run")
        self.assertIn("fetching the package lists (apt-get update) failed", said)
        self.assertIn("E: Failed to fetch the list of the cellar", said)
        self.assertEqual(len(self.calls("update")), 3)
        self.assertEqual(self.calls("install"), [], "nothing is installed from lists that did not come")

    def test_says_which_packages_failed_and_what_apt_said(self):
        self.let_fail("install", 9, "E: Unable to locate package libasio-dev")
        said = self.fails("run")
        self.assertRegex(said, r"installing .*libasio-dev.* failed")
        self.assertIn("E: Unable to locate package libasio-dev", said)

    def test_an_update_that_fetches_nothing_is_an_error(self):
        self.installs("run")
        for call in self.calls("update"):
            self.assertIn("APT::Update::Error-Mode=any", call)

    def test_takes_mesa_from_backports_whenever_they_are_there(self):
        for attempt in range(5):  # a race would lose now and then
            self.installs("run")
            self.assertIn("-t bookworm-backports mesa-vulkan-drivers", self.calls("install")[-1])

    def test_a_mesa_without_ray_query_is_replaced(self):
        self.have_all("run", mesa="22.3.6-1+deb12u1")
        self.installs("run")
        self.assertEqual(len(self.calls("install")), 1)
        self.assertIn("-t bookworm-backports mesa-vulkan-drivers", self.calls("install")[0])

    def test_a_mesa_without_ray_query_is_kept_where_there_is_no_other(self):
        (self.folder / "etc/sources.list.d/debian.sources").unlink()
        self.have_all("run", mesa="22.3.6-1+deb12u1")
        self.assertIn("all present", self.installs("run"))

    def test_a_mirror_without_backports_gives_its_own_mesa(self):
        self.let_fail("update", 3, "E: The repository 'x bookworm-backports Release' does not have a Release file.")
        self.installs("run")
        self.assertNotIn("bookworm-backports", self.calls("install")[-1])
        self.assertIn("mesa-vulkan-drivers", self.calls("install")[-1])
        self.assertEqual([file.name for file in (self.folder / "etc/sources.list.d").iterdir()], ["debian.sources"])

    def test_backports_come_from_where_bookworm_comes_from(self):
        self.installs("run")
        self.assertEqual((self.folder / "etc/sources.list.d/gnomon-backports.sources").read_text(), (
            "Suites: bookworm-backports\nTypes: deb\nURIs: http://mirror.invalid/debian\nComponents: main contrib\n"
            "Signed-By: /etc/keyrings/cellar.gpg\n"))

    def test_backports_come_from_where_bookworm_comes_from_in_a_list(self):
        (self.folder / "etc/sources.list.d/debian.sources").unlink()
        (self.folder / "etc/sources.list").write_text(ONE_LINE)
        self.installs("run")
        self.assertEqual(
            (self.folder / "etc/sources.list.d/gnomon-backports.list").read_text(),
            "deb [arch=amd64 signed-by=/etc/keyrings/cellar.gpg]  http://mirror.invalid/debian bookworm-backports "
            "main contrib\n")

    def test_adds_backports_once(self):
        (self.folder / "etc/sources.list").write_text("deb http://mirror.invalid/debian bookworm-backports main\n")
        self.installs("run")
        self.assertEqual([file.name for file in (self.folder / "etc/sources.list.d").iterdir()], ["debian.sources"])

    def test_without_root_it_names_the_packages_and_the_command(self):
        self.program("id", "#!/bin/sh\necho 1000\n")
        said = self.fails("tests")
        self.assertIn("libasio-dev", said)
        self.assertIn("deploy/install-packages tests", said)
        self.assertEqual(self.calls("update") + self.calls("install"), [])

    def test_an_unknown_purpose_is_refused(self):
        self.assertEqual(self.run_script("test").returncode, 2)


if __name__ == "__main__":
    unittest.main(verbosity=2)
