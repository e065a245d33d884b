#!/usr/bin/env python3
"""The container image, built by podman from deploy/container/Containerfile on a bootstrapped Debian: what its build stage
makes is taken from this build. Run as nobody on a read-only root it is healthy, gives the same masks as the daemon
here, drains; as the Quadlet file and the Kubernetes manifest start it, too.

    container_test.py BUILD                 seconds once the Debian root and the image's layers are there
    container_test.py BUILD --from-source   the whole Containerfile on a bare Debian: half an hour on two cores

Needs root, podman and runc (deploy/install-packages containers), mmdebstrap and a package mirror; all that podman keeps
is in BUILD/ops/containers.
"""
import functools
import pathlib
import re
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import quadlet
from booted_root import run
from containers import FILES, IMAGE, Network, Podman
from node import Node, eventually

FROM_SOURCE = "--from-source" in sys.argv and not sys.argv.remove("--from-source")
BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
NOBODY = 65532
SIZE, FRAMES = "320x180", 3
ONE_SCENE = ["--set", "scenes.list=[{name: living_room, file: living_room.glb}]"]
QUICK = ["--set", "render.tracer=bvh"]  # builds nothing at the start
HARDENED = ["--network", "host", "--read-only", "--cap-drop", "all", "--security-opt", "no-new-privileges"]
READY = re.compile(r"gnomond ready control=\S+:(\d+) data=\S+ admin=(\S+) pin=(\S+)")
JSON_FIELD = re.compile(r'"(\w+)":"?([^",}]*)"?,?')  # of the manifest's log, as text has it
TENANT = ("--tenant", "default", "--token-file")


def pictures(server, *trust, wrapper=()):
    """What gnomon-client draws of the bits that it gets, by file."""
    with tempfile.TemporaryDirectory() as folder:
        run(*wrapper, BUILD / "bin/gnomon-client", "--server", server, *trust, "--scene", "living_room", "--scene-dir",
            BUILD / "share/gnomon/scenes", "--size", SIZE, "--frames", FRAMES, "--view", "mask", "--out", folder)
        return {file.name: file.read_bytes() for file in pathlib.Path(folder).glob("mask_*.png")}


def setUpModule():
    podman = Podman(BUILD)
    began = time.monotonic()
    if FROM_SOURCE:
        podman.build_image_from_source()
    else:
        podman.build_image()
    print(f"image: {time.monotonic() - began:.0f} s, {podman.inspect(IMAGE)['Size'] / 1e6:.0f} MB")


@functools.cache
def masks_here():
    with Node(BUILD) as node:
        node.start()
        return pictures(node.control, "--pin", node.pin, "--tenant", "studio")


class Containers(unittest.TestCase):
    """Each with a network and a folder of its own."""

    def setUp(self):
        self.network = Network()
        self.network.__enter__()
        self.addCleanup(self.network.__exit__)
        self.podman = Podman(BUILD, self.network)
        temporary = tempfile.TemporaryDirectory(prefix="gnomon-container-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)

    def ready(self, name):
        def asked():
            text = self.podman("logs", name, check=False).stdout
            if not self.podman.inspect(name)["State"]["Running"]:
                raise AssertionError(f"{name} ended:\n" + text)
            return READY.search(JSON_FIELD.sub(r"\1=\2 ", text))
        found = eventually(asked, f"{name} ready")
        return found.group(1), found.group(3)

    def load(self, port, *options):
        process = subprocess.Popen(self.network.within(
            BUILD / "bin/gnomon-load", "--server", f"127.0.0.1:{port}", "--scene", "living_room", "--size", "160x90",
            "--seconds", 600, *options), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def busy(self, name, load):
        def frames():
            self.assertIsNone(load.poll(), "gnomon-load ended")
            page = self.podman("exec", name, "curl", "-s", "127.0.0.1:7601/metrics").stdout
            return any(float(count) > 0 for count in re.findall(r"^gnomon_sessions\S* (\S+)$", page, re.M))
        eventually(frames, f"{name} busy")

    def same_masks(self, port, *trust):
        here, there = masks_here(), pictures(f"127.0.0.1:{port}", *trust, wrapper=self.network.within())
        self.assertGreaterEqual(len(here), FRAMES)
        self.assertEqual(sorted(here), sorted(there))
        self.assertEqual([name for name in here if here[name] != there[name]], [])

    def confined(self, name):
        """As nobody, without capabilities or the chance of any, system calls filtered, on a root that is read-only."""
        status = dict(re.findall(r"^(\w+):\s*(.*)$", pathlib.Path(f"/proc/{self.podman.pid(name)}/status").read_text(), re.M))
        self.assertEqual(status["Name"], "gnomond")
        self.assertEqual(status["Uid"].split(), [str(NOBODY)] * 4)
        self.assertEqual(status["Gid"].split(), [str(NOBODY)] * 4)
        for kind in ("CapPrm", "CapEff", "CapBnd", "CapAmb"):
            self.assertEqual(int(status[kind], 16), 0, kind)
        self.assertEqual((status["NoNewPrivs"], status["Seccomp"]), ("1", "2"))
        for place in ("/trace", "/etc/trace", "/usr/trace"):
            refused = self.podman("exec", "--user", "0", name, "touch", place, check=False)
            self.assertIn("Read-only file system", refused.stdout)


class Image(Containers):
    def start(self, *options):
        """On volumes of its own; its configuration as it comes, less one scene."""
        self.addCleanup(self.podman.remove, "gnomond")
        self.podman("run", "--detach", "--name", "gnomond", *HARDENED, *options, IMAGE, *ONE_SCENE)
        return self.ready("gnomond")

    def private(self):
        """The folder with what the first start made for clients, brought out of the container."""
        self.podman("cp", "gnomond:/var/lib/gnomon/private", self.folder)
        return self.folder / "private"

    def test_no_secret_is_in_it(self):
        files = self.podman("run", "--rm", *HARDENED, "--user", "0", "--entrypoint", "find", IMAGE, "/etc/gnomon",
                            "/var/lib/gnomon").stdout
        self.assertIn("/etc/gnomon/gnomond.yaml", files)
        self.assertNotRegex(files, r"\.(pem|token|sha256)")

    def test_its_secrets_outlive_it_and_others_are_refused(self):
        keep = ("--volume", "gnomon-state:/var/lib/gnomon:U")
        self.addCleanup(self.podman, "volume", "rm", "--force", "gnomon-state", check=False)
        port, pin = self.start(*keep)
        token = self.private() / "default.token"
        pictures(f"127.0.0.1:{port}", "--ca", token.with_name("ca.pem"), *TENANT, token, wrapper=self.network.within())
        with self.assertRaises(AssertionError):
            pictures(f"127.0.0.1:{port}", "--pin", pin, wrapper=self.network.within())
        self.podman("rm", "--force", "--time", 30, "gnomond")
        self.assertEqual(self.start(*keep)[1], pin)

    def test_it_is_confined_healthy_exact_and_drains(self):
        began = time.monotonic()
        port, pin = self.start()
        print(f"run to ready: {time.monotonic() - began:.1f} s")
        self.confined("gnomond")
        self.assertTrue(self.podman.healthy("gnomond"))
        self.assertEqual(self.podman.inspect("gnomond")["State"]["Health"]["Status"], "healthy")
        token = self.private() / "default.token"
        self.same_masks(port, "--ca", token.with_name("ca.pem"), *TENANT, token)
        self.assertIn("reloaded", self.podman("exec", "gnomond", "gnomonctl", "reload").stdout)
        changed = self.podman("diff", "gnomond").stdout
        self.assertNotRegex(changed, r"(?m)^[ACD] /(usr|etc/(?!hosts|hostname|resolv|mtab))")

        self.podman.kill("gnomond", signal.SIGSTOP)
        healthy = self.podman.healthy("gnomond")  # the check does not hang with the daemon
        self.podman.kill("gnomond", signal.SIGCONT)
        self.assertFalse(healthy)

        load = self.load(port, "--pin", pin, "--tenant", f"default:{token}:2", "--rate", 0)
        self.busy("gnomond", load)
        began = time.monotonic()
        self.podman("stop", "--time", 30, "gnomond")
        print(f"drained in {time.monotonic() - began:.1f} s")
        self.assertEqual(self.podman.inspect("gnomond")["State"]["ExitCode"], 0, self.podman("logs", "gnomond").stdout)
        load.kill()

class AsQuadletStartsIt(Containers):
    def setUp(self):
        super().setUp()
        try:
            program = quadlet.fetch(BUILD)
        except SystemExit:
            self.skipTest("no Quadlet here")
        unit = quadlet.generate(program, FILES)[2]["gnomond.service"]
        self.lines = {key: re.findall(rf"^{key}=(.*)$", unit, re.M) for key in ("ExecStart", "ExecReload", "ExecStop")}
        config = self.folder / "gnomon"
        config.mkdir()
        text = (BUILD / "deploy/gnomond.yaml").read_text()
        (config / "gnomond.yaml").write_text(text.replace(" credentials/", " own/"))
        run(BUILD / "libexec/gnomon/first-start", config / "own", config / "private", "127.0.0.1")
        for file in (config / "own", *(config / "own").iterdir()):
            shutil.chown(file, NOBODY, NOBODY)
        (config / "own/server-key.pem").chmod(0o400)  # a key that a group reads has to be root's
        self.folder.chmod(0o755)

    def execute(self, line, **more):
        """With this test's podman; its control groups are nobody's here."""
        line = line.replace("%t/%N", str(self.folder / "unit")).replace("/etc/gnomon:", f"{self.folder}/gnomon:", 1)
        program, *arguments = shlex.split(line)
        self.assertEqual(program, "/usr/bin/podman")
        arguments = [argument for argument in arguments if argument != "--cgroups=split"]
        return self.podman(*arguments, *more.pop("extra", []), **more)

    def test_it_says_when_it_is_ready_reloads_and_stops(self):
        manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(manager.close)
        manager.bind(str(self.folder / "notify"))
        (self.folder / "notify").chmod(0o777)
        manager.settimeout(120)
        self.addCleanup(self.podman.remove, "gnomond")
        self.addCleanup(self.podman, "volume", "rm", "--force", "gnomon-cache", "gnomon-state", check=False)
        self.execute(self.lines["ExecStart"][0], extra=[*ONE_SCENE, *QUICK],
                     env={**self.podman.environment, "NOTIFY_SOCKET": str(self.folder / "notify")})
        told = ""
        while "READY=1" not in told:
            told += manager.recv(4096).decode() + "\n"
        self.ready("gnomond")
        self.confined("gnomond")
        self.assertTrue(self.podman.healthy("gnomond"))

        config = self.folder / "gnomon/gnomond.yaml"
        good = config.read_text()
        config.write_text(good.replace("policy: fair", "policy: whoever"))
        refused = self.execute(self.lines["ExecReload"][0], check=False)
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("policy", refused.stdout)
        config.write_text(good.replace("policy: fair", "policy: deadline"))
        for line in self.lines["ExecReload"]:
            self.execute(line)
        status = lambda: self.podman("exec", "gnomond", "curl", "-s", "127.0.0.1:7601/status").stdout
        eventually(lambda: '"deadline"' in status(), "the policy that was configured")

        began = time.monotonic()
        self.execute(self.lines["ExecStop"][0])
        print(f"stopped in {time.monotonic() - began:.1f} s")
        self.assertNotEqual(self.podman("container", "exists", "gnomond", check=False).returncode, 0)


class AsKubernetesStartsIt(Containers):
    """What podman 4.3 knows of it: the pod of a node. Neither does it know that a device is to be requested,
    nor does it give a secret's files the mode and the group that they are to have."""

    def manifest(self):
        # Debian's Python has the library, whichever runs this.
        done = subprocess.run(["/usr/bin/python3", pathlib.Path(__file__).with_name("pod.py"), self.hash], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        if done.returncode == 77:
            self.skipTest(done.stdout.strip())
        self.assertEqual(done.returncode, 0, done.stdout)
        file = self.folder / "pod.yaml"
        file.write_text(done.stdout)
        return file

    def make_credentials(self):
        run(BUILD / "bin/gnomonctl", "make-certs", "--out", self.folder / "certs", "--host", "127.0.0.1")
        made = run(BUILD / "bin/gnomonctl", "make-token").stdout
        token, self.hash = re.search(r"token +(\w+)\ntoken_sha256 +(\w+)", made).groups()
        (self.folder / "token").write_text(token + "\n")

    def place_credentials(self):
        """As a kubelet does it with defaultMode and fsGroup."""
        place = self.podman.volume("gnomon-credentials")
        (self.folder / "admin-token").write_text("an operator's token\n")
        for name, source in (("tls.crt", "certs/server.pem"), ("tls.key", "certs/server-key.pem"),
                             ("admin-token", "admin-token")):
            file = place / name
            shutil.copy(self.folder / source, file)
            shutil.chown(file, 0, NOBODY)
            file.chmod(0o440)

    def test_it_is_probed_serves_and_ends_in_time(self):
        self.make_credentials()
        file = self.manifest()
        self.addCleanup(self.podman, "volume", "rm", "--force", "--all", check=False)
        self.addCleanup(self.podman, "pod", "rm", "--force", "--time", 0, "gnomon", check=False)
        self.podman("kube", "play", "--start=false", file)
        self.place_credentials()
        self.podman("pod", "start", "gnomon")
        port, _ = self.ready("gnomon-gnomond")
        self.confined("gnomon-gnomond")
        self.assertIn("/healthz", str(self.podman.inspect("gnomon-gnomond")["Config"]["Healthcheck"]))
        self.assertTrue(self.podman.healthy("gnomon-gnomond"))
        self.podman("exec", "gnomon-gnomond", "curl", "-fsS", "-m2", "http://127.0.0.1:7601/readyz")
        self.same_masks(port, "--ca", self.folder / "certs/ca.pem", "--tenant", "default", "--token-file",
                        self.folder / "token")
        self.podman("pod", "stop", "--time", 30, "gnomon")
        self.assertEqual(self.podman.inspect("gnomon-gnomond")["State"]["ExitCode"], 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
