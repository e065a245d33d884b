#!/usr/bin/python3
"""The Kubernetes manifest by Kubernetes' schema, and what no schema says: that its parts fit each other, the image and
the daemon. container_test runs it.

    manifest_test.py SOURCE BUILD
"""
import copy
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import manifest

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1)).resolve()
CONTAINERFILE = (SOURCE / "deploy/container/Containerfile").read_text()
QUADLET = (SOURCE / "deploy/container/gnomond.container").read_text()
# Below these a manifest may name what it likes.
OPEN = ("labels", "matchLabels", "requests", "limits", "data")


def keys(node, path=()):
    """The path of every key that the schema knows."""
    if isinstance(node, dict):
        for key, value in node.items():
            yield (*path, key)
            if key not in OPEN:
                yield from keys(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from keys(value, (*path, index))


def misspelt(document, path):
    spoiled = copy.deepcopy(document)
    node = spoiled
    for step in path[:-1]:
        node = node[step]
    node[path[-1] + "s"] = node.pop(path[-1])
    return spoiled


class Schema(unittest.TestCase):
    def test_kubernetes_knows_all_of_it(self):
        self.assertEqual(sorted(manifest.documents()), ["ConfigMap", "DaemonSet"])
        for document in manifest.documents().values():
            self.assertEqual(manifest.understood(document), document)

    def test_a_misspelt_key_is_noticed_wherever_it_is(self):
        noticed = 0
        for document in manifest.documents().values():
            for path in keys(document):
                if path[-1] in ("apiVersion", "kind") and len(path) == 1:
                    continue
                spoiled = misspelt(document, path)
                try:
                    same = manifest.understood(spoiled) == spoiled
                except ValueError:  # it misses what it does not know any more
                    same = False
                self.assertFalse(same, path)
                noticed += 1
        print(f"{noticed} keys")
        self.assertGreater(noticed, 60)


class Fit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        documents = manifest.documents()
        cls.text = documents["ConfigMap"]["data"]["gnomond.yaml"]
        cls.config = manifest.load(cls.text)
        cls.config_map, cls.set = documents["ConfigMap"], documents["DaemonSet"]
        cls.pod = cls.set["spec"]["template"]["spec"]
        cls.container, = cls.pod["containers"]
        cls.volumes = {volume["name"]: volume for volume in cls.pod["volumes"]}
        cls.mounts = {mount["mountPath"]: mount for mount in cls.container["volumeMounts"]}

    def test_the_set_finds_its_pods(self):
        wanted = self.set["spec"]["selector"]["matchLabels"]
        labels = self.set["spec"]["template"]["metadata"]["labels"]
        self.assertEqual({**labels, **wanted}, labels)

    def test_volumes_are_there_and_used(self):
        self.assertEqual(len(self.volumes), len(self.pod["volumes"]))
        self.assertEqual({mount["name"] for mount in self.mounts.values()}, set(self.volumes))
        self.assertEqual(self.volumes["config"]["configMap"]["name"], self.config_map["metadata"]["name"])
        config, = re.findall(r"--config (\S+)", " ".join(self.container["args"]))
        folder, name = config.rsplit("/", 1)
        self.assertEqual(self.mounts[folder]["name"], "config")
        self.assertIn(name, self.config_map["data"])

    def test_all_that_is_written_has_a_volume(self):
        self.assertTrue(self.container["securityContext"]["readOnlyRootFilesystem"])
        written = re.search(r"^VOLUME \[(.*)\]$", CONTAINERFILE, re.M).group(1)
        for folder in [*re.findall(r'"([^"]+)"', written), self.config["render"]["cache_folder"], "/tmp"]:
            self.assertFalse(self.mounts[folder].get("readOnly"), folder)

    def test_secrets_are_readable_by_the_daemon_alone(self):
        """As root's with mode 0440, and the group by fsGroup: what check_private in daemon/ takes."""
        secret = self.volumes["credentials"]["secret"]
        self.assertEqual(secret["defaultMode"], 0o440)
        self.assertEqual(self.pod["securityContext"]["fsGroup"], self.pod["securityContext"]["runAsGroup"])
        for file in self.config["server"]["tls"].values():
            self.assertEqual(self.mounts[file.rsplit("/", 1)[0]]["name"], "credentials")

    def test_user_and_image_are_those_of_the_containerfile_and_of_quadlet(self):
        context = self.pod["securityContext"]
        self.assertRegex(CONTAINERFILE, rf"(?m)^USER {context['runAsUser']}:{context['runAsGroup']}$")
        self.assertTrue(context["runAsNonRoot"])
        self.assertIn(f"\nImage={self.container['image']}\n", QUADLET)

    def test_ports_are_the_daemons(self):
        server = {"control_port": 7600, "data_port": 7600, **self.config["server"]}
        ports = {(port["protocol"], port["containerPort"], port["hostPort"]) for port in self.container["ports"]}
        self.assertEqual(ports, {("TCP", server["control_port"], server["control_port"]),
                                 ("UDP", server["data_port"], server["data_port"])})
        for protocol, port, _ in ports:
            self.assertRegex(CONTAINERFILE, rf"(?m)^EXPOSE .*\b{port}/{protocol.lower()}")

    def test_probes_ask_the_admin_server(self):
        admin = f"http://127.0.0.1:{self.config['admin']['port']}"
        for probe, page in (("startupProbe", "/readyz"), ("livenessProbe", "/healthz"), ("readinessProbe", "/readyz")):
            self.assertEqual(self.container[probe]["exec"]["command"][-1], admin + page)
        self.assertIn(admin + "/healthz", CONTAINERFILE)

    def test_it_may_drain(self):
        grace = self.pod["terminationGracePeriodSeconds"]
        self.assertGreater(grace * 1000, self.config["server"]["drain_timeout_ms"] + 5000)

    def test_resources(self):
        asked, most = self.container["resources"]["requests"], self.container["resources"]["limits"]
        self.assertEqual(set(asked) | set(most), {"cpu", "memory", "nvidia.com/gpu"})
        for name in set(asked) & set(most):
            self.assertLessEqual(manifest.QUANTITY(asked[name]), manifest.QUANTITY(most[name]), name)
        # A device cannot be overcommitted.
        self.assertEqual(asked["nvidia.com/gpu"], most["nvidia.com/gpu"])

    def test_the_daemon_takes_the_configuration(self):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write(self.text)
            file.flush()
            done = subprocess.run([BUILD / "bin/gnomond", "--config", file.name, "--check-config",
                                   "--for-reload"], text=True,  # the files that it names are in the container
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
