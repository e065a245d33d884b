"""A Kubernetes of its own: what keeps it, what decides, and how a test asks it. It is reached at the bridge's own address
(tests/fleet/namespaces.py), and nobody else sees it."""
import json
import pathlib
import ssl
import subprocess
import sys
import time
import urllib.error
import urllib.request

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "fleet"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/ops"))
from namespaces import NETWORK, run  # noqa: E402
from node import eventually  # noqa: E402

HERE, PORT, NAMESPACE = f"{NETWORK}.1", 6443, "default"
ETCD = "http://127.0.0.1:2379"
LONG_S, OFTEN_S = 600, 0.2
TOKEN = "of-the-tests-own-cluster"
# Everything asks as the one administrator: who may do what is not what is tested.
KUBECONFIG = {
    "apiVersion": "v1", "kind": "Config", "current-context": "test",
    "clusters": [{"name": "test", "cluster": {"server": f"https://{HERE}:{PORT}", "insecure-skip-tls-verify": True}}],
    "users": [{"name": "test", "user": {"token": TOKEN}}],
    "contexts": [{"name": "test", "context": {"cluster": "test", "user": "test"}}],
}


def patiently(condition, what):
    """As eventually(), of what takes Kubernetes minutes and costs something to ask."""
    eventually(lambda: time.sleep(OFTEN_S) or condition(), what, LONG_S)


class Api:
    """What the server knows, without a kubectl for every question."""

    def __init__(self):
        self.context = ssl.create_default_context()
        self.context.check_hostname, self.context.verify_mode = False, ssl.CERT_NONE

    def ask(self, path, method="GET", body=None, kind="application/json"):
        request = urllib.request.Request(f"https://{HERE}:{PORT}{path}", method=method,
                                         data=None if body is None else json.dumps(body).encode(),
                                         headers={"Authorization": f"Bearer {TOKEN}", "Content-Type": kind})
        with urllib.request.urlopen(request, context=self.context, timeout=30) as answer:
            return answer.read().decode()

    def get(self, path):
        return json.loads(self.ask(path))

    def items(self, kind, selector=""):
        return self.get(f"/api/v1/namespaces/{NAMESPACE}/{kind}?labelSelector={selector}")["items"]

    def pods(self, name):
        return self.items("pods", f"app.kubernetes.io/name={name}")

    def deployment(self, name):
        return self.get(f"/apis/apps/v1/namespaces/{NAMESPACE}/deployments/{name}")

    def is_ready(self):
        try:
            return self.ask("/readyz") == "ok"
        except (OSError, urllib.error.URLError):
            return False


class Program:
    """One that runs until the test ends, with its own log."""

    def __init__(self, folder, name, command, **more):
        self.name, self.file = name, folder / f"{name}.log"
        self.log = open(self.file, "w")
        self.process = subprocess.Popen([str(part) for part in command], stdout=self.log, stderr=subprocess.STDOUT,
                                        **more)

    def must_live(self):
        if self.process.poll() is not None:
            raise AssertionError(f"{self.name} has ended:\n{self.tail()}")
        return True

    def tail(self, lines=15):
        return "\n".join(self.file.read_text(errors="replace").splitlines()[-lines:])

    def end(self):
        if self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(20)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.log.close()


class Cluster:
    def __init__(self, binaries, folder):
        self.bin, self.folder, self.api = pathlib.Path(binaries), folder, Api()
        self.programs = []
        self.kubeconfig = folder / "kubeconfig"
        self.kubeconfig.write_text(json.dumps(KUBECONFIG))
        (folder / "tokens.csv").write_text(f"{TOKEN},admin,admin,system:masters\n")
        self.key = folder / "accounts.key"
        run("openssl", "genrsa", "-out", self.key, "2048")

    def start(self):
        self.program("etcd", "etcd", "--data-dir", self.folder / "etcd", "--listen-client-urls", ETCD,
                     "--advertise-client-urls", ETCD, "--unsafe-no-fsync")
        self.program("kube-apiserver", self.bin / "kube-apiserver", f"--etcd-servers={ETCD}", f"--secure-port={PORT}",
                     "--bind-address=0.0.0.0", f"--advertise-address={HERE}", f"--cert-dir={self.folder}/certificates",
                     f"--token-auth-file={self.folder}/tokens.csv", "--authorization-mode=RBAC",
                     "--service-account-issuer=https://test", f"--service-account-signing-key-file={self.key}",
                     f"--service-account-key-file={self.key}", "--service-cluster-ip-range=10.99.0.0/24",
                     "--allow-privileged=true", "--kubelet-preferred-address-types=InternalIP",
                     # Without kube-proxy nobody else leads a service's address to who serves it.
                     "--enable-aggregator-routing=true")
        eventually(lambda: self.lives() and self.api.is_ready(), "an API server that is ready")
        common = (f"--kubeconfig={self.kubeconfig}", "--leader-elect=false", "--bind-address=127.0.0.1", "--port=0")
        self.program("kube-controller-manager", self.bin / "kube-controller-manager", *common,
                     f"--service-account-private-key-file={self.key}")
        self.program("kube-scheduler", self.bin / "kube-scheduler", *common)

    def program(self, name, *command, **more):
        self.programs.append(Program(self.folder, name, command, **more))
        return self.programs[-1]

    def lives(self):
        return all(program.must_live() for program in self.programs)

    def kubectl(self, *arguments, text=None):
        done = subprocess.run([str(self.bin / "kubectl"), f"--kubeconfig={self.kubeconfig}", *map(str, arguments)],
                              input=text, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=600,
                              env={"HOME": str(self.folder), "PATH": "/usr/bin:/bin"})
        if done.returncode:
            raise AssertionError(f"kubectl {' '.join(map(str, arguments))}: {done.stdout}")
        return done.stdout

    def end(self):
        for program in reversed(self.programs):
            program.end()
