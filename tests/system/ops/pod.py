#!/usr/bin/python3
"""Prints the manifest's pod as podman 4.3 can play it: with the secret that it asks for, one scene and a tracer
that is ready at once, and without the device that it requests.

    pod.py TOKEN_SHA256
"""
import sys

import manifest

documents = manifest.documents()
template = documents["DaemonSet"]["spec"]["template"]
for resources in template["spec"]["containers"][0]["resources"].values():
    resources.pop("nvidia.com/gpu")
secret, = (volume["secret"] for volume in template["spec"]["volumes"] if "secret" in volume)
secret["optional"] = False  # the default; this podman falls over its own feet where it is not said
template["metadata"]["name"] = "gnomon"

data = documents["ConfigMap"]["data"]
config = manifest.load(data["gnomond.yaml"])
config["scenes"]["list"] = config["scenes"]["list"][:1]
config["render"]["tracer"] = "bvh"
config["tenants"][0]["token_sha256"] = [sys.argv[1]]
data["gnomond.yaml"] = manifest.dump([config])

print(manifest.dump([
    documents["ConfigMap"],
    {"apiVersion": "v1", "kind": "Secret", "metadata": {"name": secret["secretName"]},
     "data": {"tls.crt": "", "tls.key": ""}},
    {"apiVersion": "v1", "kind": "Pod", **template}]))
