#!/usr/bin/python3
"""What tests/kubernetes applies is what kustomize makes of the shipped folders, but for what it says of itself.

    shipped_test.py
"""
import json
import shutil
import subprocess
import unittest

try:
    import yaml
except ModuleNotFoundError:
    print("skipped: Debian's python3-yaml is missing")
    raise SystemExit(77) from None

import shipped


def by_name(documents):
    return {f"{each['kind']}/{each['metadata']['name']}": each for each in documents}


def sorted_lists(node):
    """Lists whose entries have names, in the order of these."""
    if isinstance(node, dict):
        return {key: sorted_lists(value) for key, value in node.items()}
    if isinstance(node, list):
        return sorted((sorted_lists(each) for each in node), key=lambda each: json.dumps(each, sort_keys=True))
    return node


class Shipped(unittest.TestCase):
    @unittest.skipUnless(shutil.which("kubectl"), "there is no kubectl")
    def test_it_is_what_kustomize_assembles(self):
        for overlay in ("base", "two-gpus", "example"):
            done = subprocess.run(["kubectl", "kustomize", shipped.FOLDER / overlay], text=True, stdout=subprocess.PIPE)
            if done.returncode:
                self.skipTest("a kubectl without today's kustomize")
            theirs = list(yaml.safe_load_all(done.stdout))
            ours, maps = shipped.assembled(shipped.FOLDER / overlay)
            ours = shipped.with_maps(ours, maps)
            self.rename_maps(theirs)
            self.rename_maps(ours)
            self.assertEqual(sorted_lists(by_name(ours)), sorted_lists(by_name(theirs)))

    def rename_maps(self, documents):
        """The digest in a map's name is another one here; that it is the pods' is seen here."""
        names = {each["metadata"]["name"] for each in documents if each["kind"] == "ConfigMap"}
        self.assertEqual(len(names), 2)
        for each in documents:
            if each["kind"] == "ConfigMap":
                each["metadata"]["name"] = each["metadata"]["name"].rsplit("-", 1)[0]
        for volume in (volume for pod in shipped.pods(documents) for volume in pod["volumes"] if "configMap" in volume):
            self.assertIn(volume["configMap"]["name"], names)
            volume["configMap"]["name"] = volume["configMap"]["name"].rsplit("-", 1)[0]

    def test_what_is_changed_is_said(self):
        made = by_name(shipped.fleet(["scene1.gltf", "scene2.gltf"], "localhost/haproxy:2.6"))
        self.assertEqual(made["HorizontalPodAutoscaler/gnomon"]["apiVersion"], "autoscaling/v2beta2")
        self.assertEqual(made["PodDisruptionBudget/gnomon"]["apiVersion"], "policy/v1beta1")
        config, = (each for name, each in made.items() if name.startswith("ConfigMap/gnomon-") and
                   "gnomond.yaml" in each["data"])
        scenes = yaml.safe_load(config["data"]["gnomond.yaml"])["scenes"]["list"]
        self.assertEqual([scene["file"] for scene in scenes], ["/srv/scenes/scene1.gltf", "/srv/scenes/scene2.gltf"])
        for word in ("autoscaling/v2beta2", "policy/v1beta1", "localhost/haproxy:2.6", "hash-key", "scenes of one triangle"):
            self.assertIn(word, "\n".join(shipped.CHANGES))

    def test_a_map_that_is_changed_rolls_the_pods(self):
        documents, maps = shipped.assembled(shipped.FOLDER / "base")
        one = by_name(shipped.with_maps(documents, maps))
        maps["gnomon"]["gnomond.yaml"] += "# changed\n"
        other = by_name(shipped.with_maps(documents, maps))
        self.assertNotEqual(one["Deployment/gnomon"], other["Deployment/gnomon"])
        self.assertEqual(one["Deployment/gnomon-door"], other["Deployment/gnomon-door"])


if __name__ == "__main__":
    unittest.main(verbosity=2)
