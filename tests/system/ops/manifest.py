"""The Kubernetes manifests as data, and what Kubernetes' own API has to say of them: Debian's python3-kubernetes, whose
classes are made from its schema."""
import json
import pathlib
import sys

try:
    import yaml
    from kubernetes import client
    from kubernetes.utils.quantity import parse_quantity
except ModuleNotFoundError as error:
    print(f"skipped: Debian's python3-kubernetes is missing ({error.name}): deploy/install-packages containers")
    sys.exit(77)

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "deploy/kubernetes"
BASE, OVERLAY, AGONES, EXAMPLE = FOLDER / "base", FOLDER / "two-gpus", FOLDER / "agones", FOLDER / "example"
QUANTITY = parse_quantity
# Debian's library is of Kubernetes 1.22, which had these fields under the name before the last.
CLASSES = {"V2HorizontalPodAutoscaler": "V2beta2HorizontalPodAutoscaler"}


def load(text):
    return yaml.safe_load(text)


def dump(documents):
    return yaml.safe_dump_all(documents)


def kustomization(folder):
    return load((folder / "kustomization.yaml").read_text())


def documents():
    """Those of the base, by kind and name."""
    all_of_them = [document for resource in kustomization(BASE)["resources"]
                   for document in yaml.safe_load_all((BASE / resource).read_text())]
    return by_name(all_of_them)


def by_name(all_of_them):
    return {f"{document['kind']}/{document['metadata']['name']}": document for document in all_of_them}


class Answer:
    """As the client reads one from a server."""

    def __init__(self, document):
        self.data = json.dumps(document)


def understood(document):
    """As much of it as the schema knows; an error if something that must stand there does not."""
    name = document["apiVersion"].split("/")[-1].capitalize() + document["kind"]
    api = client.ApiClient()
    return api.sanitize_for_serialization(api.deserialize(Answer(document), CLASSES.get(name, name)))
