"""A node of the cluster: a kubelet and a containerd on a machine that is a network namespace, whose pods have a network of
their own behind it."""
import json
import os
import pathlib
import signal
import subprocess

from cluster import HERE, Program
from namespaces import NETWORK, Machine, run
from node import eventually

NUMBERS = {"node1": 11, "node2": 12}
CGROUPS, CGROUP = pathlib.Path("/sys/fs/cgroup"), "gnomon-kubernetes"
CNI = "/usr/lib/cni"
# The kubelet writes these for the whole machine. In its own sight files lie above them, so that nothing is to be put back.
SYSCTLS = {"vm/overcommit_memory": "1", "vm/panic_on_oom": "0", "kernel/panic": "10", "kernel/panic_on_oops": "1",
           "kernel/keys/root_maxkeys": "1000000", "kernel/keys/root_maxbytes": "25000000"}
CONTAINERD = """version = 2
root = "{folder}/containerd"
state = "/run/containerd-state"
[grpc]
  address = "{socket}"
[ttrpc]
  address = "{socket}.ttrpc"
[plugins."io.containerd.grpc.v1.cri"]
  sandbox_image = "{pause}"
  disable_apparmor = true
  restrict_oom_score_adj = true
  [plugins."io.containerd.grpc.v1.cri".cni]
    bin_dir = "{cni}"
    conf_dir = "{folder}/cni"
  [plugins."io.containerd.grpc.v1.cri".containerd.runtimes.runc]
    runtime_type = "io.containerd.runc.v2"
"""
# A sight of the files of its own: mounts for pods come to both programs and to nobody else, and what both write to fixed
# places lies nowhere.
OWN_SIGHT = """set -e
mount --make-rshared /
for place in /run /var/log; do mount -t tmpfs tmpfs $place; done
for name in {sysctls}; do mount --bind {folder}/sysctl/$(echo $name | tr / _) /proc/sys/$name; done
containerd --config {folder}/containerd.toml >{folder}/containerd.log 2>&1 &
exec {kubelet}
"""


def subnet(name):
    return f"10.88.{NUMBERS[name]}.0/24"


def hierarchies():
    """Where this machine's control groups are: one folder for each of version 1, and for the one of version 2 beside them."""
    if not CGROUPS.is_dir() or (CGROUPS / "cgroup.procs").exists():
        return []  # of version 2 alone
    return [folder for folder in CGROUPS.iterdir() if (folder / "cgroup.procs").exists() and not folder.is_symlink()]


def make_cgroups():
    remove_cgroups()
    for hierarchy in hierarchies():
        (hierarchy / CGROUP).mkdir(exist_ok=True)


def end_pods():
    """What is left in them when the kubelet is gone; all of it is of this test's own processes."""
    for hierarchy in hierarchies():
        for file in (hierarchy / CGROUP).rglob("cgroup.procs"):
            for process in file.read_text().split():
                try:
                    os.kill(int(process), signal.SIGKILL)
                except ProcessLookupError:
                    pass


def remove_cgroups():
    """Those of pods that have ended; from the inside out, as they are no folders that one may empty."""
    for hierarchy in hierarchies():
        for folder, _, _ in os.walk(hierarchy / CGROUP, topdown=False):
            try:
                os.rmdir(folder)
            except OSError:
                pass


class KubeNode:
    def __init__(self, cluster, name, pause):
        self.cluster, self.name = cluster, name
        self.machine = Machine(NUMBERS[name])
        self.folder = cluster.folder / name
        self.socket = f"{self.folder}/containerd.sock"
        (self.folder / "cni").mkdir(parents=True)
        (self.folder / "sysctl").mkdir()
        for sysctl, value in SYSCTLS.items():
            (self.folder / "sysctl" / sysctl.replace("/", "_")).write_text(value + "\n")
        (self.folder / "containerd.toml").write_text(
            CONTAINERD.format(folder=self.folder, socket=self.socket, pause=pause, cni=CNI))
        (self.folder / "cni/10-bridge.conf").write_text(json.dumps(
            {"cniVersion": "0.4.0", "name": "pods", "type": "bridge", "bridge": "cni0", "isGateway": True,
             "ipam": {"type": "host-local", "dataDir": f"{self.folder}/addresses", "routes": [{"dst": "0.0.0.0/0"}],
                      "ranges": [[{"subnet": subnet(name)}]]}}))
        self.lead_ways()
        self.program = None

    def lead_ways(self):
        """Pods are reached by their own addresses, from here and from the other machine."""
        run("ip", "route", "add", subnet(self.name), "via", self.machine.address)
        run(*self.machine.inside, "ip", "route", "add", "default", "via", HERE)
        for other, number in NUMBERS.items():
            if other != self.name:
                run(*self.machine.inside, "ip", "route", "add", subnet(other), "via", f"{NETWORK}.{number}")
        run(*self.machine.inside, "sh", "-c", "echo 1 >/proc/sys/net/ipv4/ip_forward")

    def start(self):
        flags = {"kubeconfig": self.cluster.kubeconfig, "container-runtime": "remote",
                 "container-runtime-endpoint": f"unix://{self.socket}", "root-dir": f"{self.folder}/kubelet",
                 "cert-dir": f"{self.folder}/pki", "cgroup-driver": "cgroupfs", "cgroups-per-qos": "false",
                 "cgroup-root": f"/{CGROUP}", "enforce-node-allocatable": "", "fail-swap-on": "false",
                 "hostname-override": self.name, "node-ip": self.machine.address, "eviction-hard": "",
                 "image-gc-high-threshold": "100", "make-iptables-util-chains": "false", "resolv-conf": "",
                 "authorization-mode": "AlwaysAllow", "anonymous-auth": "true", "healthz-port": "0",
                 "read-only-port": "0", "cluster-dns": HERE, "cluster-domain": "cluster.local"}
        kubelet = " ".join([str(self.cluster.bin / "kubelet"), *(f"--{key}={value}" for key, value in flags.items())])
        script = OWN_SIGHT.format(folder=self.folder, sysctls=" ".join(SYSCTLS), kubelet=kubelet)
        self.program = Program(self.folder, "kubelet",
                               [*self.machine.inside, "unshare", "--mount", "bash", "-c", script])
        self.cluster.programs.append(self.program)

    def ctr(self, *arguments):
        return subprocess.run(["ctr", "--address", self.socket, "--namespace", "k8s.io", *map(str, arguments)], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=600)

    def answers(self):
        return self.program.must_live() and self.ctr("version").returncode == 0

    def load_images(self, archives):
        """`archives`: files by the names that their images get here."""
        eventually(self.answers, f"containerd of {self.name} answers; see {self.folder}/containerd.log")
        for names, file in archives:
            done = self.ctr("images", "import", file)
            if done.returncode:
                raise AssertionError(f"{file} cannot be imported: {done.stdout}")
            first, *others = names
            for other in others:
                self.ctr("images", "tag", first, other)

    def end(self):
        """The kubelet has ended before; its pods and their containers go with the test's processes."""
        self.machine.end()
        run("ip", "route", "flush", subnet(self.name))

