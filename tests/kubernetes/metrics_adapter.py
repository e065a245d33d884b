"""What Prometheus and its adapter are elsewhere: the autoscaler's metric of pods, as the API custom.metrics.k8s.io, from
what the nodes' own /metrics say at the moment of the question."""
import http.server
import json
import re
import ssl
import subprocess
import threading
import time
import urllib.parse
import urllib.request

GROUP, VERSION, METRIC, PORT = "custom.metrics.k8s.io", "v1beta1", "gnomon_load_ratio", 8443
RESOURCES = {"kind": "APIResourceList", "apiVersion": "v1", "groupVersion": f"{GROUP}/{VERSION}",
             "resources": [{"name": f"pods/{METRIC}", "singularName": "", "namespaced": True,
                            "kind": "MetricValueList", "verbs": ["get"]}]}


def manifests(address):
    """A service with an address outside the cluster, and that the API server asks there."""
    name = "metrics-adapter"
    return [
        {"apiVersion": "v1", "kind": "Service", "metadata": {"name": name},
         "spec": {"ports": [{"port": 443, "targetPort": PORT}]}},
        {"apiVersion": "v1", "kind": "Endpoints", "metadata": {"name": name},
         "subsets": [{"addresses": [{"ip": address}], "ports": [{"port": PORT}]}]},
        {"apiVersion": "apiregistration.k8s.io/v1", "kind": "APIService", "metadata": {"name": f"{VERSION}.{GROUP}"},
         "spec": {"group": GROUP, "version": VERSION, "groupPriorityMinimum": 100, "versionPriority": 100,
                  "insecureSkipTLSVerify": True, "service": {"name": name, "namespace": "default"}}}]


class Adapter:
    """`pods`: of which it is asked, by a function of the selector; `credentials`: the folder with the fleet's."""

    def __init__(self, address, pods, credentials, name):
        self.pods, self.token = pods, (credentials / "admin-token").read_text().strip()
        self.context = ssl.create_default_context(cafile=credentials / "certs/ca.pem")
        self.context.check_hostname = False  # nodes are asked by their addresses; the authority is the fleet's alone
        self.name, self.asked = name, 0
        key, certificate = credentials / "adapter-key.pem", credentials / "adapter.pem"
        subprocess.run(["openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=adapter",
                        "-keyout", key, "-out", certificate], check=True, capture_output=True)
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.load_cert_chain(certificate, key)
        adapter = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def log_message(self, *_):
                pass

            def do_GET(self):
                text = json.dumps(adapter.answer(self.path)).encode()
                self.send_response(200)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", str(len(text)))
                self.end_headers()
                self.wfile.write(text)
        server = http.server.ThreadingHTTPServer((address, PORT), Handler)
        server.daemon_threads = True
        server.socket = context.wrap_socket(server.socket, server_side=True)
        threading.Thread(target=server.serve_forever, daemon=True).start()

    def load(self, address):
        """Of a node, on average over its devices; None if it says nothing."""
        request = urllib.request.Request(f"https://{address}:7601/metrics",
                                         headers={"Authorization": f"Bearer {self.token}"})
        try:
            with urllib.request.urlopen(request, context=self.context, timeout=5) as page:
                text = page.read().decode()
        except OSError:
            return None
        values = [float(value) for value in re.findall(rf"^{METRIC}(?:{{[^}}]*}})? (\S+)$", text, re.M)]
        return sum(values) / len(values) if values else None

    def loads(self, selector=""):
        """By pod."""
        found = {pod["metadata"]["name"]: self.load(pod["status"]["hostIP"])
                 for pod in self.pods(selector) if pod["status"].get("phase") == "Running"}
        return {name: load for name, load in found.items() if load is not None}

    def answer(self, path):
        path = urllib.parse.urlparse(path)
        if "/namespaces/" not in path.path:
            return RESOURCES
        self.asked += 1
        selector, = urllib.parse.parse_qs(path.query).get("labelSelector", [""])
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        items = [{"describedObject": {"kind": "Pod", "namespace": "default", "name": name, "apiVersion": "/v1"},
                  "metricName": METRIC, "timestamp": now, "value": f"{round(load * 1000)}m"}
                 for name, load in self.loads(selector).items()]
        return {"kind": "MetricValueList", "apiVersion": f"{GROUP}/{VERSION}", "metadata": {}, "items": items}
