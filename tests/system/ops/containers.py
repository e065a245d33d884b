"""Gnomon's container image from this build's package, on a bootstrapped Debian in the place of the registry's; a podman
that keeps all it has in BUILD/ops/containers; a network of the test's own, so that the image's ports may stay as they are."""
import hashlib
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import subprocess

from booted_root import run
from debian_root import build_package, kept_root, root_with_dependencies
from node import eventually, skip

SOURCE = pathlib.Path(__file__).resolve().parents[3]
FILES = SOURCE / "deploy/container"
IMAGE = "localhost/gnomon:latest"
MOST = 16384  # descriptors and processes: podman's own million is not every root's to give
UNREACHABLE = re.compile("Temporary failure resolving|Could not (resolve|connect)|(Failed|Unable) to fetch")


class Network:
    """A network namespace with a loopback and nothing else."""

    def __enter__(self):
        self.process = subprocess.Popen(["unshare", "--net", "sh", "-c", "ip link set lo up && exec sleep infinity"])
        eventually(lambda: "sleep" in pathlib.Path(f"/proc/{self.process.pid}/comm").read_text(), "a network", 10)
        return self

    def within(self, *command):
        # Of the namespaces only this one: podman's mounts are to be seen by the next podman.
        return ["nsenter", f"--net=/proc/{self.process.pid}/ns/net", "--", *map(str, command)]

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()


class Podman:
    def __init__(self, build, network=None):
        if os.geteuid() != 0 or not shutil.which("podman") or not shutil.which("runc"):
            skip("containers need root, podman and runc (deploy/install-packages containers)")
        self.build = pathlib.Path(build).resolve()
        self.folder = self.build / "ops/containers"
        self.folder.mkdir(parents=True, exist_ok=True)
        self.network = network
        self.configure()

    def configure(self):
        """Nothing of the machine's own containers; limits that this process may give."""
        limits = {"nofile": resource.RLIMIT_NOFILE, "nproc": resource.RLIMIT_NPROC}
        ulimits = []
        for name, limit in limits.items():
            most = resource.getrlimit(limit)[1]
            most = MOST if most == resource.RLIM_INFINITY else min(most, MOST)
            ulimits.append(f"{name}={most}:{most}")
        (self.folder / "containers.conf").write_text(
            f"[containers]\ndefault_ulimits = {json.dumps(ulimits)}\n"
            '[engine]\nruntime = "runc"\ncgroup_manager = "cgroupfs"\nevents_logger = "none"\n')
        (self.folder / "storage.conf").write_text(
            f'[storage]\ndriver = "{self.driver()}"\ngraphroot = "{self.folder}/store"\n'
            f'runroot = "{self.folder}/run"\n')
        self.environment = {**os.environ, "CONTAINERS_CONF": str(self.folder / "containers.conf"),
                            "CONTAINERS_STORAGE_CONF": str(self.folder / "storage.conf")}
        self.environment.pop("NOTIFY_SOCKET", None)

    def driver(self):
        """Layers upon each other where the file system can; copies of them (slow) elsewhere."""
        trial = self.folder / "trial"
        for name in ("lower", "upper", "work", "root"):
            (trial / name).mkdir(parents=True, exist_ok=True)
        options = ",".join(f"{name}dir={trial / name}" for name in ("lower", "upper", "work"))
        works = run("mount", "-t", "overlay", "overlay", "-o", options, trial / "root", check=False).returncode == 0
        if works:
            run("umount", trial / "root")
        shutil.rmtree(trial, ignore_errors=True)
        return "overlay" if works else "vfs"

    def command(self, *arguments):
        command = ["podman", *map(str, arguments)]
        return self.network.within(*command) if self.network else command

    def __call__(self, *arguments, **more):
        """What it says on both its outputs, without its complaints that nobody runs timers for health checks here."""
        more.setdefault("env", self.environment)
        done = run(*self.command(*arguments), **more)
        done.stdout = "".join(line for line in done.stdout.splitlines(keepends=True) if "systemd connection" not in line)
        return done

    def inspect(self, name):
        return json.loads(self("inspect", name).stdout)[0]

    def volume(self, name):
        """Where its files are."""
        return pathlib.Path(json.loads(self("volume", "inspect", name).stdout)[0]["Mountpoint"])

    def pid(self, name):
        return self.inspect(name)["State"]["Pid"]

    def healthy(self, name):
        """Whether the health check passes that a timer would run."""
        return self("healthcheck", "run", name, check=False, timeout=60).returncode == 0

    def has(self, image):
        return self("image", "exists", image, check=False).returncode == 0

    def base(self, tar):
        name = "localhost/" + tar.stem
        if not self.has(name):
            self("import", tar, name)
        return name

    def build_image(self):
        """From this build's package, on a Debian that has what it depends on."""
        package = build_package(self.build)
        base = self.base(root_with_dependencies(self.build, package))
        contents = run("dpkg-deb", "-I", package, "control", "md5sums").stdout
        digest = hashlib.sha256((contents + base + (FILES / "Containerfile").read_text()
                                 + (FILES / "start").read_text()).encode()).hexdigest()
        if self.has(IMAGE) and (self.inspect(IMAGE)["Labels"] or {}).get("test.of") == digest:
            return
        stage = self.folder / "build"
        shutil.rmtree(stage, ignore_errors=True)
        (stage / "source/build/release").mkdir(parents=True)
        shutil.copy(package, stage / "source/build/release")
        # As one layer: what changes with every build is worth no cache.
        self.build_from(base, "--layers=false", "--build-context", f"build={stage}", "--label", "test.of=" + digest)

    def build_image_from_source(self):
        """All of it, on a Debian that has nothing."""
        self.build_from(self.base(kept_root(self.build)))

    def build_from(self, base, *options):
        # The host's network, for packages: this test's own leads nowhere.
        done = run("podman", "build", "--format", "docker", "--network", "host", "--build-arg", "BASE=" + base,
                   "-f", FILES / "Containerfile", "-t", IMAGE, *options, SOURCE, env=self.environment, check=False)
        if done.returncode != 0 and UNREACHABLE.search(done.stdout):
            skip("the image's packages cannot be fetched here")
        if done.returncode != 0:
            raise AssertionError("podman build:\n" + done.stdout[-4000:])
        self("image", "prune", "--force")

    def kill(self, name, number=signal.SIGKILL):
        self("kill", "--signal", int(number), name)

    def remove(self, *names):
        self("rm", "--force", "--volumes", "--time", 0, *names, check=False)
