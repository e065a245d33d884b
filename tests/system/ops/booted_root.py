"""This machine's root with Gnomon installed into a layer above it, booted with its own systemd in systemd-nspawn."""
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile

from node import eventually, skip


def run(*command, check=True, **more):
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, **more)
    if check and done.returncode != 0:
        raise AssertionError(f"{command}: exit status {done.returncode}\n{done.stdout}")
    return done


class BootedRoot:
    def __init__(self, build):
        self.build = pathlib.Path(build).resolve()
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="gnomon-booted-"))
        self.root = self.folder / "root"
        self.process = self.leader = None
        self.mounts = []

    def __enter__(self):
        if os.geteuid() != 0 or not shutil.which("systemd-nspawn"):
            skip("booting a systemd needs root and systemd-nspawn; notify_test checks the protocol")
        try:
            self.mount_layers()
            self.install()
            self.boot()
        except (AssertionError, OSError) as error:
            self.__exit__()
            skip(f"no systemd boots here ({error}); notify_test checks the protocol")
        return self

    def mount_layers(self):
        layer = self.folder / "layer"
        layer.mkdir()
        self.root.mkdir()
        run("mount", "-t", "tmpfs", "tmpfs", layer)
        self.mounts.append(layer)
        for name in ("upper", "work"):
            (layer / name).mkdir()
        run("mount", "-t", "overlay", "overlay", "-o",
            f"lowerdir=/,upperdir={layer / 'upper'},workdir={layer / 'work'}", self.root)
        self.mounts.append(self.root)

    def install(self):
        run("cmake", "--install", self.build, "--prefix", "/usr", env={**os.environ, "DESTDIR": str(self.root)})
        shutil.copytree(self.build / "faults", self.root / "opt/faults")

    def boot(self):
        self.log = open(self.folder / "log", "w")
        self.process = subprocess.Popen(
            ["systemd-nspawn", "--quiet", "--directory", self.root, "--boot", "--register=no", "--keep-unit",
             "--private-network", "--link-journal=no", "--machine=gnomon-test", "systemd.unit=basic.target"],
            stdin=subprocess.DEVNULL, stdout=self.log, stderr=subprocess.STDOUT)
        self.leader = eventually(self.find_leader, "a systemd in systemd-nspawn", 20)
        eventually(lambda: self.systemctl("is-system-running", check=False).stdout.strip() in ("running", "degraded"),
                   "a booted systemd", 40)

    def find_leader(self):
        if self.process.poll() is not None:
            raise AssertionError("systemd-nspawn ended: " + (self.folder / "log").read_text()[-500:])
        children = pathlib.Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children").read_text().split()
        # Before that, it is a process that prepares the root.
        return next((pid for pid in children if pathlib.Path(f"/proc/{pid}/comm").read_text() == "systemd\n"), None)

    def command(self, *command):
        return ["nsenter", "-t", self.leader, "--all", "--", *map(str, command)]

    def run(self, *command, **more):
        return run(*self.command(*command), **more)

    def systemctl(self, *arguments, **more):
        return self.run("systemctl", "--no-pager", *arguments, **more)

    def start(self, *units):
        done = self.systemctl("start", *units, check=False)
        if done.returncode != 0:
            raise AssertionError(done.stdout + self.journal())

    def journal(self):
        return self.run("journalctl", "--no-pager", "-u", "gnomond", "-n", 40, check=False).stdout

    def property(self, name, unit="gnomond.service"):
        return self.systemctl("show", "--value", "-p", name, unit).stdout.strip()

    def write(self, path, text):
        file = self.root / path.lstrip("/")
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def __exit__(self, *_):
        if self.process and self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)  # of systemd-nspawn: powers its system off
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        for mount in reversed(self.mounts):
            run("umount", "--lazy", mount, check=False)
        shutil.rmtree(self.folder, ignore_errors=True)
