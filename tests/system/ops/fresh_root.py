"""A Debian 12 as a stranger has it: a minimal root made for this, with this machine's package sources (but not backports)
and the committed tree in it. Every command has its own /proc, /sys, /dev and /dev/shm from systemd-nspawn, which end
with it whatever happens; nothing is mounted on this machine.

Lent to it, because both only save time: the packages that apt fetched before (BUILD/ops/packages) and the compiler's
cache. ccache itself is installed in the root; with it come no headers and no library that the lists name.
"""
import os
import pathlib
import shutil
import subprocess
import time

from booted_root import run
from debian_root import bootstrap, sources_of_bookworm
from node import ROOT, skip

BROUGHT = "ca-certificates,git,ccache"  # what it takes to have cloned the tree, and the cache
KEPT = "/var/cache/apt/archives"
CACHE = "/var/cache/ccache"


class FreshRoot:
    def __init__(self, build):
        self.work = pathlib.Path(build).resolve() / "ops"
        self.root = self.work / "fresh"
        self.packages = self.work / "packages"
        # The same place as here, so that the compiler's cache knows its files; nspawn puts its own /tmp above ours.
        self.place = ROOT if ROOT.parts[1] not in ("tmp", "run", "dev") else pathlib.Path("/gnomon")
        self.source = self.root / self.place.relative_to("/")

    def __enter__(self):
        if os.geteuid() != 0 or not shutil.which("systemd-nspawn"):
            skip("a fresh Debian root needs root, mmdebstrap and systemd-nspawn")
        self.remove()  # of a run that was killed
        self.packages.mkdir(parents=True, exist_ok=True)
        try:
            self.make()
            self.lend_cache()
            run("git", "clone", "--quiet", ROOT, self.source)
        except BaseException:
            self.remove()
            raise
        return self

    def make(self):
        archives = f'"$1"{KEPT}'
        bootstrap(self.root, "bookworm", "--variant=minbase", f"--include={BROUGHT}", "--skip=essential/unlink",
                  f"--setup-hook=mkdir -p {archives}; cp -al {self.packages}/*.deb {archives} 2>/dev/null || true",
                  f"--customize-hook=cp -aln {archives}/*.deb {self.packages}",
                  sources=sources_of_bookworm(self.work))
        # Nothing in it is worth waiting for the disk.
        (self.root / "etc/dpkg/dpkg.cfg.d/unsafe-io").write_text("force-unsafe-io\n")

    def lend_cache(self):
        """This machine's, with the settings that decide what is the same; one of its own where there is none."""
        self.cache, settings = self.work / "ccache", ""
        if shutil.which("ccache"):
            setting = lambda key: run("ccache", "--get-config", key).stdout.strip()
            self.cache = pathlib.Path(setting("cache_dir"))
            settings = "".join(f"{key} = {setting(key)}\n" for key in ("base_dir", "hash_dir", "sloppiness", "max_size"))
        self.cache.mkdir(parents=True, exist_ok=True)
        (self.root / "etc/ccache.conf").write_text(f"cache_dir = {CACHE}\n{settings}")

    def nspawn(self, *command, network=True, layer=False, **environment):
        """The command line. `layer`: above the root, whatever it changes is gone afterwards."""
        return ["setpriv", "--pdeathsig", "KILL", "systemd-nspawn", "--quiet", "--as-pid2", "--console=pipe",
                "--register=no", "--keep-unit", f"--directory={self.root}", f"--chdir={self.place}",
                f"--bind={self.packages}:{KEPT}", f"--bind={self.cache}:{CACHE}",
                *([] if network else ["--private-network"]), *(["--volatile=overlay"] if layer else []),
                *(f"--setenv={key}={value}" for key, value in environment.items()), *command]

    def run(self, *command, **more):
        """Exit status, output and seconds."""
        began = time.monotonic()
        done = subprocess.run(list(map(str, self.nspawn(*command, **more))), text=True, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        done.seconds = time.monotonic() - began
        return done

    def installed(self):
        """Versions by package."""
        listed = run("dpkg-query", f"--admindir={self.root}/var/lib/dpkg", "-W", "-f",
                     "${db:Status-Status} ${Package} ${Version}\n").stdout
        return {name: version for status, name, version in map(str.split, listed.splitlines()) if status == "installed"}

    def remove(self):
        shutil.rmtree(self.root, ignore_errors=True)

    def __exit__(self, *_):
        self.run("apt-get", "autoclean")  # old versions of what is kept
        self.remove()
