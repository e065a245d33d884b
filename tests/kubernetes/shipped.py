"""The shipped manifests as kustomize assembles them, which Debian does not have: as much of it as deploy/kubernetes uses.
And what this cluster needs otherwise, each with its reason."""
import copy
import hashlib
import pathlib
import re

import yaml

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "deploy/kubernetes"
# By what entries of a list are told apart where a patch is laid upon them.
KEYS = {"containers": "name", "initContainers": "name", "volumes": "name", "env": "name", "volumeMounts": "mountPath"}
# What is not as it is shipped, as the report says it.
CHANGES = []


def assembled(folder):
    """All documents of an overlay or of a base, and the texts of its maps."""
    made = yaml.safe_load((folder / "kustomization.yaml").read_text())
    documents, maps = [], {}
    for resource in made["resources"]:
        path = (folder / resource).resolve()
        if path.is_dir():
            below, maps_below = assembled(path)
            documents += below
            maps.update(maps_below)
        else:
            documents += list(yaml.safe_load_all(path.read_text()))
    for each in made.get("configMapGenerator", []):
        maps[each["name"]] = {name: (folder / name).read_text() for name in each["files"]}
    for patch in made.get("patches", []):
        lay(yaml.safe_load((folder / patch["path"]).read_text()), documents)
    for image in made.get("images", []):
        for container in containers(documents):
            if container["image"].rsplit(":", 1)[0] == image["name"]:
                container["image"] = f"{image['newName']}:{image['newTag']}"
    return documents, maps


def lay(patch, documents):
    merge(named(documents, patch["kind"], patch["metadata"]["name"]), patch)


def merge(below, above, key=None):
    if isinstance(below, list):
        if key not in KEYS:
            return above
        for entry in above:
            same = [each for each in below if each[KEYS[key]] == entry[KEYS[key]]]
            if same:
                merge(same[0], entry)
            else:  # kustomize puts what is new first
                below.insert(0, entry)
        return below
    if not isinstance(below, dict):
        return above
    for name, value in above.items():
        below[name] = merge(below[name], value, name) if name in below else value
    return below


def named(documents, kind, name):
    return next(each for each in documents if (each["kind"], each["metadata"]["name"]) == (kind, name))


def pods(documents):
    return [each["spec"]["template"]["spec"] for each in documents if each["kind"] == "Deployment"]


def containers(documents):
    return [container for pod in pods(documents) for container in (*pod.get("initContainers", []), *pod["containers"])]


def with_maps(documents, maps):
    """Maps are named by what is in them, and pods know them by these names."""
    documents = copy.deepcopy(documents)
    for name, data in maps.items():
        full = f"{name}-{hashlib.sha256(repr(sorted(data.items())).encode()).hexdigest()[:10]}"
        documents.insert(0, {"apiVersion": "v1", "kind": "ConfigMap", "metadata": {"name": full}, "data": data})
        for volume in (volume for pod in pods(documents) for volume in pod["volumes"] if "configMap" in volume):
            if volume["configMap"]["name"] == name:
                volume["configMap"]["name"] = full
    return documents


def changed(why):
    if why not in CHANGES:
        CHANGES.append(why)


def replaced(text, old, new, why):
    if old not in text:
        raise AssertionError(f"the shipped files have no {old!r} any more")
    changed(why)
    return text.replace(old, new)


def for_kubernetes_1_20(documents):
    older = {"HorizontalPodAutoscaler": "autoscaling/v2beta2", "PodDisruptionBudget": "policy/v1beta1"}
    for each in documents:
        if each["kind"] in older:
            changed(f"apiVersion {each['apiVersion']} is {older[each['kind']]}: Kubernetes 1.20")
            each["apiVersion"] = older[each["kind"]]


def for_this_machine(documents, maps, scenes, door_image):
    """`scenes`: names of files on the volume."""
    for container in containers(documents):
        if container["name"] == "haproxy":
            changed(f"the doors' image {container['image']} is Debian's {door_image}")
            container["image"] = door_image
        if container["name"] == "gnomond":
            cpu = container["resources"]["requests"]["cpu"]
            changed(f"a node asks for 1 processor in the place of {cpu}: both machines are this one")
            container["resources"]["requests"]["cpu"] = "1"
    doors, nodes = maps["gnomon-door"], maps["gnomon"]
    doors["haproxy.cfg"] = replaced(doors["haproxy.cfg"], " hash-key addr", "",
                                    "the doors' hash-key is left out: HAProxy 2.6")
    doors["haproxy.cfg"] = replaced(doors["haproxy.cfg"], "maxconn 20000", "maxconn 2000",
                                    "a door takes 2,000 connections: this account's descriptors")
    listed = "\n".join(f"    - {{name: {name.split('.')[0]}, file: /srv/scenes/{name}}}" for name in scenes)
    own = re.sub(r"(?m)^    - \{name: hall, .*$", listed, nodes["gnomond.yaml"])
    if own == nodes["gnomond.yaml"]:
        raise AssertionError("the example has another scene")
    changed(f"{len(scenes)} scenes of one triangle are on the volume")
    changed("nodes admit whatever comes (scheduler.admit_percent: 0): their devices are processors that others use too")
    nodes["gnomond.yaml"] = own + "scheduler: {admit_percent: 0}\n"


def volume(folder):
    """What fills the example's claim: here a folder."""
    claim = yaml.safe_load((FOLDER / "example/scenes.yaml").read_text())["spec"]
    changed(f"the storage class `{claim['storageClassName']}` is a folder that both nodes see")
    return {"apiVersion": "v1", "kind": "PersistentVolume", "metadata": {"name": "scenes"},
            "spec": {"capacity": claim["resources"]["requests"], "accessModes": claim["accessModes"],
                     "storageClassName": claim["storageClassName"], "hostPath": {"path": str(folder)}}}


def fleet(scenes, door_image):
    """The example overlay, for this cluster."""
    documents, maps = assembled(FOLDER / "example")
    for_kubernetes_1_20(documents)
    for_this_machine(documents, maps, scenes, door_image)
    return with_maps(documents, maps)
