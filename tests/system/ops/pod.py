#!/usr/bin/python3
"""Prints a node's pod as podman 4.3 can play it: with the configuration and the secret that it asks for, one scene and a
tracer that is ready at once, on a network of its own, and without the device that it requests.

    pod.py TOKEN_SHA256
"""
import sys

import manifest

template = manifest.documents()["Deployment/gnomon"]["spec"]["template"]
pod = template["spec"]
container, = pod["containers"]
for resources in container["resources"].values():
    resources.pop("nvidia.com/gpu")
# This podman knows neither the host's address nor its network's name server.
container["args"] = container["args"][:container["args"].index("--set")]
container["env"] = [variable for variable in container["env"] if "value" in variable]
for key in ("hostNetwork", "dnsPolicy", "tolerations"):
    pod.pop(key)
secret, = (volume["secret"] for volume in pod["volumes"] if "secret" in volume)
secret["optional"] = False  # the default; this podman falls over its own feet where it is not said
pod["restartPolicy"] = "OnFailure"  # this podman would start again what prepares the pod, too, each time that it has ended
template["metadata"]["name"] = "gnomon"

config = manifest.load((manifest.BASE / "gnomond.yaml").read_text())
config["server"]["proxies"] = []
config["scenes"]["list"] = config["scenes"]["list"][:1]
config["render"]["tracer"] = "bvh"
config["tenants"][0]["token_sha256"] = [sys.argv[1]]

print(manifest.dump([
    {"apiVersion": "v1", "kind": "ConfigMap", "metadata": {"name": "gnomon"},
     "data": {"gnomond.yaml": manifest.dump([config])}},
    {"apiVersion": "v1", "kind": "Secret", "metadata": {"name": secret["secretName"]},
     "data": {"tls.crt": "", "tls.key": "", "admin-token": ""}},
    {"apiVersion": "v1", "kind": "Pod", **template}]))
