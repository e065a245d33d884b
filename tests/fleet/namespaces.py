"""Machines that are network namespaces, on one bridge. Nothing of it is seen outside, and it goes with the process."""
import os
import shutil
import subprocess
import sys

NETWORK = "10.77.0"


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def enter_own_network():
    """Starts this program anew in a network of its own, or skips the test. It has its processes to itself too, so that
    none of them outlives it."""
    for program in ("unshare", "nsenter", "ip", "haproxy"):
        if not shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin:/sbin"):
            skip(f"{program} is not installed (deploy/install-packages tests)")
    if os.environ.get("GNOMON_OWN_NETWORK"):
        return
    alone = ["unshare", "--net", "--pid", "--fork", "--kill-child", "--mount-proc"]
    if subprocess.run([*alone, "true"], capture_output=True).returncode:
        skip("this account may make no network namespaces")
    environment = dict(os.environ, GNOMON_OWN_NETWORK="1", PATH=os.environ["PATH"] + ":/usr/sbin:/sbin")
    os.execvpe("unshare", [*alone, sys.executable, *sys.argv], environment)


def run(*command):
    done = subprocess.run([str(part) for part in command], text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        raise RuntimeError(f"{' '.join(map(str, command))}: {done.stdout}")


def open_bridge():
    """The clients' own machine is this namespace, with the first address."""
    run("ip", "link", "set", "lo", "up")
    run("ip", "link", "add", "bridge", "type", "bridge")
    run("ip", "addr", "add", f"{NETWORK}.1/24", "dev", "bridge")
    run("ip", "link", "set", "bridge", "up")


class Machine:
    """One namespace with one cable to the bridge; it lives as long as a process in it that only sleeps."""

    def __init__(self, number):
        self.address, self.cable = f"{NETWORK}.{number}", f"cable{number}"
        self.holder = subprocess.Popen(["unshare", "--net", "sh", "-c", "echo there; exec sleep 100000"],
                                       stdout=subprocess.PIPE)
        self.holder.stdout.readline()
        pid = self.holder.pid
        self.inside = ["nsenter", "--net", "--target", str(pid)]
        run("ip", "link", "add", self.cable, "type", "veth", "peer", "name", "eth0", "netns", pid)
        run("ip", "link", "set", self.cable, "master", "bridge", "up")
        for arguments in (("addr", "add", f"{self.address}/24", "dev", "eth0"), ("link", "set", "eth0", "up"),
                          ("link", "set", "lo", "up")):
            run(*self.inside, "ip", *arguments)

    def pull_cable(self):
        """Nothing comes through from now on, and nobody is told: no packet says that the machine is gone."""
        run("ip", "link", "set", self.cable, "down")

    def plug_cable(self):
        run("ip", "link", "set", self.cable, "up")

    def end(self):
        self.holder.kill()
        self.holder.wait()
        self.holder.stdout.close()
