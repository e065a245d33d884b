"""The shipped fleet on the cluster: gnomond's own image on two kubelets, doors before them, and what a test asks of both."""
import json
import pathlib
import shutil
import ssl
import subprocess
import tempfile
import time
import urllib.request

import kubelet
import metrics_adapter
import names
import shipped
from cluster import HERE, NAMESPACE, Cluster, patiently
from images import DOOR, PAUSE
from namespaces import open_bridge
from node import eventually
from world import TINY_SCENE

# As the example names it, where a registry would have it, and what it is updated to.
FIRST_IMAGE, NEXT_IMAGE = "registry.example/gnomon:0.1.0", "registry.example/gnomon:next"
SCENES = [f"scene{number}" for number in range(1, 7)]


class Fleet:
    fleet = "gnomon.example"  # the manifests' own

    def __init__(self, build, binaries, archives):
        self.bin, self.archives = pathlib.Path(build).resolve() / "bin", archives
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="gnomon-kubernetes-"))
        self.scenes = self.folder / "scenes"
        self.nodes, self.took = {}, {}
        open_bridge()
        self.cluster = Cluster(binaries, self.folder)
        self.api = self.cluster.api

    def timed(self, what, condition, why):
        since = time.monotonic()
        patiently(lambda: self.cluster.lives() and condition(), why)
        self.took[what] = time.monotonic() - since

    def start(self):
        kubelet.make_cgroups()
        since = time.monotonic()
        self.cluster.start()
        self.took["control plane"] = time.monotonic() - since
        names.Names(self.api, HERE, NAMESPACE)
        for name in kubelet.NUMBERS:
            self.nodes[name] = kubelet.KubeNode(self.cluster, name, PAUSE)
            self.nodes[name].start()
        since = time.monotonic()
        images = {DOOR: (DOOR,), PAUSE: (PAUSE,), "localhost/gnomon:latest": ("localhost/gnomon:latest", FIRST_IMAGE,
                                                                              NEXT_IMAGE)}
        for node in self.nodes.values():
            node.load_images([(images[name], file) for name, file in self.archives.items()])
        self.took["images"] = time.monotonic() - since
        self.timed("nodes", lambda: all(self.is_ready(name) for name in self.nodes), "two nodes are ready")
        for name in self.nodes:  # of a device plugin, which would say it; lavapipe is what renders
            self.api.ask(f"/api/v1/nodes/{name}/status", "PATCH", {"status": {"capacity": {"nvidia.com/gpu": "1"}}},
                         "application/merge-patch+json")
        shipped.changed("each node says of itself that it has one nvidia.com/gpu; lavapipe renders")
        self.make_credentials()
        self.make_scenes()
        self.apply(shipped.fleet([f"{scene}.gltf" for scene in SCENES], DOOR))
        self.timed("fleet", lambda: self.available("gnomon") == self.available("gnomon-door") == 2,
                   "two nodes and two doors")

    def is_ready(self, name):
        """As the API server has it of the kubelet's last word."""
        try:
            conditions = self.api.get(f"/api/v1/nodes/{name}")["status"]["conditions"]
        except OSError:
            return False
        return any(each["type"] == "Ready" and each["status"] == "True" for each in conditions)

    def make_credentials(self):
        """By the commands at the heads of the base's and of the example's kustomization.yaml."""
        certs, self.authority = self.folder / "certs", self.folder / "certs/ca.pem"
        self.ctl("make-certs", "--out", certs, "--host", self.fleet, "--fleet", self.fleet)
        (self.folder / "admin-token").write_text("an-operators-token-of-this-test\n")
        made = dict(line.split() for line in self.ctl("make-token").splitlines())
        self.token = self.folder / "token"
        self.token.write_text(made["token"] + "\n")
        (self.folder / "lab.sha256").write_text(made["token_sha256"] + "\n")
        self.cluster.kubectl("create", "secret", "generic", "gnomon-credentials", f"--from-file=tls.crt={certs}/server.pem",
                             f"--from-file=tls.key={certs}/server-key.pem", f"--from-file=ca.crt={certs}/ca.pem",
                             f"--from-file={self.folder}/admin-token")
        self.cluster.kubectl("create", "secret", "generic", "gnomon-tokens", f"--from-file={self.folder}/lab.sha256")

    def make_scenes(self):
        self.scenes.mkdir()
        self.folder.chmod(0o755)
        for scene in SCENES:
            (self.scenes / f"{scene}.gltf").write_text(json.dumps(TINY_SCENE))
        self.apply([shipped.volume(self.scenes)])

    def ctl(self, *arguments):
        return subprocess.check_output([self.bin / "gnomonctl", *map(str, arguments)], text=True)

    def apply(self, documents):
        return self.cluster.kubectl("apply", "-f", "-", text=json.dumps({"apiVersion": "v1", "kind": "List",
                                                                         "items": documents}))

    def available(self, name):
        return self.api.deployment(name)["status"].get("availableReplicas", 0)

    def start_metrics(self):
        adapter = metrics_adapter.Adapter(HERE, lambda selector: self.api.items("pods", selector), self.folder, self.fleet)
        self.apply(metrics_adapter.manifests(HERE))
        return adapter

    def doors(self):
        """Where each is, by the node that it runs on."""
        return {pod["spec"]["nodeName"]: (pod["status"]["podIP"], 7600) for pod in self.api.pods("gnomon-door")
                if pod["status"].get("podIP")}

    def sessions(self, name):
        """Of a node, by the admin server; none of one that does not answer."""
        context = ssl.create_default_context(cafile=self.authority)
        context.check_hostname = False
        request = urllib.request.Request(f"https://{self.nodes[name].machine.address}:7601/status", headers={
            "Authorization": "Bearer " + (self.folder / "admin-token").read_text().strip()})
        try:
            with urllib.request.urlopen(request, context=context, timeout=2) as page:
                return json.loads(page.read())["sessions"]
        except OSError:
            return []

    def served(self):
        """How many sessions each node has."""
        return {name: len(self.sessions(name)) for name in self.nodes}

    def complaints(self):
        """What Kubernetes says of pods that do not come up."""
        said = "\n".join(self.cluster.kubectl(
            "get", "events", "--sort-by=.lastTimestamp", "-o",
            "custom-columns=LAST:.lastTimestamp,OF:.involvedObject.name,SAYS:.message").splitlines()[-40:])
        said += "\n" + self.cluster.kubectl("get", "pods", "-o", "wide")
        for pod in self.api.pods("gnomon") + self.api.pods("gnomon-door"):
            name = pod["metadata"]["name"]
            try:
                said += f"\n--- {name}\n" + self.cluster.kubectl("logs", name, "--all-containers", "--tail=20")
            except AssertionError as error:
                said += f"\n{error}"
        return said

    def end(self, keep):
        self.cluster.end()
        kubelet.end_pods()
        for node in self.nodes.values():
            node.end()
        eventually(self.cgroups_are_gone, "control groups without processes", 30)
        if keep:
            print(f"kept: {self.folder}")
        else:
            shutil.rmtree(self.folder, ignore_errors=True)

    @staticmethod
    def cgroups_are_gone():
        kubelet.remove_cgroups()
        return not any((hierarchy / kubelet.CGROUP).exists() for hierarchy in kubelet.hierarchies())
