"""The Kubernetes manifest as data, and what Kubernetes' own API has to say of it: Debian's python3-kubernetes, whose
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

FILE = pathlib.Path(__file__).resolve().parents[3] / "deploy/container/kubernetes.yaml"
QUANTITY = parse_quantity


def documents():
    """By kind."""
    return {document["kind"]: document for document in yaml.safe_load_all(FILE.read_text())}


def dump(documents):
    return yaml.safe_dump_all(documents)


def load(text):
    return yaml.safe_load(text)


class Answer:
    """As the client reads one from a server."""

    def __init__(self, document):
        self.data = json.dumps(document)


def understood(document):
    """As much of it as the schema knows; an error if something that must stand there does not."""
    version = document["apiVersion"].split("/")[-1]
    api = client.ApiClient()
    return api.sanitize_for_serialization(api.deserialize(Answer(document), version.capitalize() + document["kind"]))
