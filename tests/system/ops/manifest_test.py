#!/usr/bin/python3
"""The Kubernetes manifests by Kubernetes' schema, and what no schema says: that its parts fit each other, the image and
the daemon. container_test runs it.

    manifest_test.py SOURCE BUILD
"""
import copy
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import manifest
from node import Node

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1)).resolve()
CONTAINERFILE = (SOURCE / "deploy/container/Containerfile").read_text()
QUADLET = (SOURCE / "deploy/container/gnomond.container").read_text()
# Below these a manifest may name what it likes.
OPEN = ("labels", "matchLabels", "annotations", "requests", "limits")


def keys(node, path=()):
    """The path of every key that the schema knows."""
    if isinstance(node, dict):
        for key, value in node.items():
            if "/" in key:  # a label's
                continue
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
        documents = manifest.documents()
        self.assertGreaterEqual(set(documents), {"Deployment/gnomon", "Deployment/gnomon-door", "Service/gnomon",
                                                 "HorizontalPodAutoscaler/gnomon", "PodDisruptionBudget/gnomon"})
        for document in documents.values():
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
        self.assertGreater(noticed, 200)


class Assembly(unittest.TestCase):
    """What kustomize makes of the folders."""

    def test_every_file_is_used(self):
        for folder in (manifest.BASE, manifest.OVERLAY, manifest.EXAMPLE, manifest.AGONES, manifest.AGONES / "fleet"):
            made = manifest.kustomization(folder)
            used = {"kustomization.yaml", *made["resources"], *made.get("configurations", [])}
            used |= {patch["path"] for patch in made.get("patches", []) if "path" in patch}
            for each in made.get("configMapGenerator", []):
                used |= set(each["files"])
            elsewhere = {name for name in used if name.startswith("../")}
            self.assertEqual(used - elsewhere, {file.name for file in folder.iterdir()})
            self.assertEqual({(folder / name).resolve() for name in elsewhere} - {manifest.BASE}, set())

    def test_maps_are_those_that_pods_mount(self):
        made = {each["name"] for each in manifest.kustomization(manifest.BASE)["configMapGenerator"]}
        mounted = {volume["configMap"]["name"] for document in manifest.documents().values()
                   if document["kind"] == "Deployment"
                   for volume in document["spec"]["template"]["spec"]["volumes"] if "configMap" in volume}
        self.assertEqual(made, mounted)

    def test_the_overlay_has_as_many_devices_as_it_asks_for(self):
        base, overlay = (manifest.load((folder / "gnomond.yaml").read_text())
                         for folder in (manifest.BASE, manifest.OVERLAY))
        devices = overlay["render"].pop("devices")
        self.assertEqual(base, overlay)
        patch = manifest.load((manifest.OVERLAY / "nodes.yaml").read_text())
        self.assertIn(f"Deployment/{patch['metadata']['name']}", manifest.documents())
        container, = patch["spec"]["template"]["spec"]["containers"]
        for resources in container["resources"].values():
            self.assertEqual(int(resources["nvidia.com/gpu"]), len(devices))

    @unittest.skipUnless(shutil.which("kubectl"), "there is no kubectl")
    def test_kubectl_assembles_it(self):
        for folder, gpus in ((manifest.BASE, "1"), (manifest.OVERLAY, "2")):
            text = subprocess.run(["kubectl", "kustomize", folder], check=True, text=True, stdout=subprocess.PIPE).stdout
            made = manifest.by_name(manifest.yaml.safe_load_all(text))
            for document in made.values():
                self.assertEqual(manifest.understood(document), document)
            pod = made["Deployment/gnomon"]["spec"]["template"]["spec"]
            self.assertEqual(pod["containers"][0]["resources"]["limits"]["nvidia.com/gpu"], gpus)
            name, = (volume["configMap"]["name"] for volume in pod["volumes"] if "configMap" in volume)
            self.assertRegex(name, "^gnomon-[a-z0-9]+$")
            self.assertIn("gnomond.yaml", made[f"ConfigMap/{name}"]["data"])


class Example(unittest.TestCase):
    """The overlay for scenes, tenants and an image of one's own."""

    @classmethod
    def setUpClass(cls):
        cls.made = manifest.kustomization(manifest.EXAMPLE)
        cls.config = manifest.load((manifest.EXAMPLE / "gnomond.yaml").read_text())
        patch = manifest.load((manifest.EXAMPLE / "nodes.yaml").read_text())
        cls.patched = f"Deployment/{patch['metadata']['name']}"
        pod = patch["spec"]["template"]["spec"]
        cls.container, = pod["containers"]
        cls.mounts = {mount["name"]: mount for mount in cls.container["volumeMounts"]}
        cls.volumes = {volume["name"]: volume for volume in pod["volumes"]}

    def test_it_adds_to_the_pod_of_the_base(self):
        pod = manifest.documents()[self.patched]["spec"]["template"]["spec"]
        self.assertEqual([each["name"] for each in pod["containers"]], [self.container["name"]])
        self.assertEqual(set(self.mounts), set(self.volumes))
        self.assertEqual(set(self.volumes) & {volume["name"] for volume in pod["volumes"]}, set())
        taken = {mount["mountPath"] for mount in pod["containers"][0]["volumeMounts"]}
        for mount in self.mounts.values():
            self.assertNotIn(mount["mountPath"], taken)
            self.assertTrue(mount["readOnly"])

    def test_scenes_are_on_a_volume_that_all_nodes_may_read(self):
        claim = manifest.load((manifest.EXAMPLE / "scenes.yaml").read_text())
        self.assertEqual(manifest.understood(claim), claim)
        self.assertEqual(claim["spec"]["accessModes"], ["ReadOnlyMany"])
        self.assertEqual(self.volumes["scenes"]["persistentVolumeClaim"],
                         {"claimName": claim["metadata"]["name"], "readOnly": True})
        for scene in self.config["scenes"]["list"]:
            self.assertEqual(str(pathlib.Path(scene["file"]).parent), self.mounts["scenes"]["mountPath"])

    def test_tokens_are_in_a_secret_that_the_head_of_the_file_makes(self):
        secret = self.volumes["tokens"]["secret"]
        self.assertEqual(secret["defaultMode"], 0o440)
        text = (manifest.EXAMPLE / "kustomization.yaml").read_text()
        for tenant in self.config["tenants"]:
            file = pathlib.Path(tenant["token_sha256_file"])
            self.assertEqual(str(file.parent), self.mounts["tokens"]["mountPath"])
            self.assertRegex(text, rf"create secret generic {secret['secretName']} .*--from-file={file.name}\b")

    def test_the_rest_of_the_configuration_is_the_bases(self):
        base, own = manifest.load((manifest.BASE / "gnomond.yaml").read_text()), copy.deepcopy(self.config)
        for config in (base, own):
            config["scenes"].pop("list")
            config.pop("tenants")
        self.assertEqual(base, own)

    @unittest.skipUnless(shutil.which("kubectl"), "there is no kubectl")
    def test_kubectl_assembles_it(self):
        text = subprocess.run(["kubectl", "kustomize", manifest.EXAMPLE], check=True, text=True, stdout=subprocess.PIPE).stdout
        made = manifest.by_name(manifest.yaml.safe_load_all(text))
        for document in made.values():
            self.assertEqual(manifest.understood(document), document)
        pod = made[self.patched]["spec"]["template"]["spec"]
        image, = self.made["images"]
        for container in (*pod["containers"], *pod["initContainers"]):
            self.assertEqual(container["image"], f"{image['newName']}:{image['newTag']}")
        self.assertNotIn(image["name"], text, "a name that the base has otherwise would be left as it is")
        mounted = {mount["mountPath"] for mount in pod["containers"][0]["volumeMounts"]}
        base = manifest.documents()[self.patched]["spec"]["template"]["spec"]["containers"][0]
        self.assertEqual(mounted - {mount["mountPath"] for mount in base["volumeMounts"]},
                         {mount["mountPath"] for mount in self.mounts.values()})
        name, = (volume["configMap"]["name"] for volume in pod["volumes"] if "configMap" in volume)
        self.assertIn("/srv/scenes/hall.glb", made[f"ConfigMap/{name}"]["data"]["gnomond.yaml"])


def paths(node, path=""):
    """Of all keys below it, without numbers of lists."""
    if isinstance(node, list):
        return set().union(*(paths(each, path) for each in node))
    if not isinstance(node, dict):
        return {path}
    return {path} | set().union(*(paths(value, f"{path}.{key}".lstrip(".")) for key, value in node.items()))


class Agones(unittest.TestCase):
    """The overlay for Agones. No schema of its is here: the keys are those of its fleet.go and gameserver.go."""

    KNOWN = {"apiVersion", "kind", "metadata", "spec", *(f"spec.{key}" for key in (
        "replicas", "scheduling", "strategy", "strategy.type", "strategy.rollingUpdate", "strategy.rollingUpdate.maxSurge",
        "strategy.rollingUpdate.maxUnavailable", "template", "template.metadata", "template.spec", "template.spec.container",
        "template.spec.health", "template.spec.health.periodSeconds", "template.spec.health.failureThreshold",
        "template.spec.health.initialDelaySeconds", "template.spec.eviction", "template.spec.eviction.safe",
        "template.spec.template"))}

    def test_agones_knows_the_fleets_keys(self):
        fleet = manifest.load((manifest.AGONES / "fleet/fleet.yaml").read_text())
        self.assertEqual((fleet["apiVersion"], fleet["kind"]), ("agones.dev/v1", "Fleet"))
        used = {path for path in paths(fleet) if ".labels" not in path and not path.startswith("metadata.")}
        self.assertEqual(used - {""} - self.KNOWN, set())
        health = fleet["spec"]["template"]["spec"]["health"]
        self.assertGreater(health["periodSeconds"], 2, "signs of life come every 2 s (agones_life.h)")
        self.assertEqual(fleet["spec"]["template"]["spec"]["template"], {}, "it is the Deployment's")

    def test_nodes_differ_by_agones_alone(self):
        base, here = (manifest.load((folder / "gnomond.yaml").read_text())
                      for folder in (manifest.BASE, manifest.AGONES / "fleet"))
        self.assertEqual(here.pop("fleet"), {"agones": True})
        self.assertEqual(base, here)

    @unittest.skipUnless(shutil.which("kubectl"), "there is no kubectl")
    def test_its_pods_are_the_deployments(self):
        text = subprocess.run(["kubectl", "kustomize", manifest.AGONES], check=True, text=True, stdout=subprocess.PIPE).stdout
        made = manifest.by_name(manifest.yaml.safe_load_all(text))
        self.assertNotIn("Deployment/gnomon", made)
        self.assertNotIn("HorizontalPodAutoscaler/gnomon", made)
        for name, document in made.items():
            if name != "Fleet/gnomon":
                self.assertEqual(manifest.understood(document), document)
        fleet = made["Fleet/gnomon"]["spec"]
        budget = made["PodDisruptionBudget/gnomon"]["spec"]
        self.assertNotIn("maxUnavailable", budget, "Kubernetes does not know how many a Fleet wants")
        self.assertLess(budget["minAvailable"], fleet["replicas"])
        pod = copy.deepcopy(fleet["template"]["spec"]["template"])
        template = {"apiVersion": "v1", "kind": "PodTemplate", "metadata": {"name": "gnomon"}, "template": pod}
        self.assertEqual(manifest.understood(template), template)
        self.assertEqual([each["name"] for each in pod["spec"]["containers"]], [fleet["template"]["spec"]["container"]])
        maps = [volume["configMap"] for volume in pod["spec"]["volumes"] if "configMap" in volume]
        self.assertIn("agones: true", made[f"ConfigMap/{maps[0]['name']}"]["data"]["gnomond.yaml"])
        # But for the token of the sidecar and the name of its map it is the same pod.
        wanted = copy.deepcopy(manifest.documents()["Deployment/gnomon"]["spec"]["template"])
        self.assertFalse(wanted["spec"].pop("automountServiceAccountToken"))
        maps[0]["name"] = "gnomon"
        self.assertEqual(pod, wanted)


class Fleet(unittest.TestCase):
    """Doors, services, budgets and the autoscaler are those of the nodes."""

    @classmethod
    def setUpClass(cls):
        cls.documents = manifest.documents()
        cls.doors = (manifest.BASE / "haproxy.cfg").read_text()

    def test_all_select_the_pods_they_are_for(self):
        for name in ("gnomon", "gnomon-door"):
            labels = self.documents[f"Deployment/{name}"]["spec"]["template"]["metadata"]["labels"]
            budget = self.documents[f"PodDisruptionBudget/{name}"]["spec"]["selector"]["matchLabels"]
            for wanted in (self.documents[f"Service/{name}"]["spec"]["selector"], budget,
                           self.documents[f"Deployment/{name}"]["spec"]["selector"]["matchLabels"]):
                self.assertEqual({**labels, **wanted}, labels)
        target = self.documents["HorizontalPodAutoscaler/gnomon"]["spec"]["scaleTargetRef"]
        self.assertEqual(self.documents["Deployment/gnomon"]["apiVersion"], target["apiVersion"])
        self.assertEqual((target["kind"], target["name"]), ("Deployment", "gnomon"))
        self.assertNotIn("replicas", self.documents["Deployment/gnomon"]["spec"], "that is the autoscaler's")

    def test_doors_find_nodes_by_the_headless_service(self):
        service = self.documents["Service/gnomon"]
        self.assertEqual(service["spec"]["clusterIP"], "None")
        self.assertTrue(service["spec"]["publishNotReadyAddresses"], "who drains keeps its connections")
        port, = service["spec"]["ports"]
        self.assertRegex(self.doors, rf"server-template \w+ \d+ _{port['name']}\._tcp\.{service['metadata']['name']}\.")
        maximum = self.documents["HorizontalPodAutoscaler/gnomon"]["spec"]["maxReplicas"]
        self.assertGreaterEqual(int(re.search(r"server-template \w+ (\d+) ", self.doors)[1]), maximum)

    def test_doors_do_what_the_door_without_kubernetes_does(self):
        def directives(text):
            return {line.strip() for line in text.splitlines() if line.strip() and not line.strip().startswith("#")}
        alone = directives((SOURCE / "deploy/fleet/haproxy.cfg").read_text())
        here = directives(self.doors)
        # A pod has an account and a root of its own.
        elsewhere = re.compile("(server|user|group|chroot|stats) ")
        self.assertTrue(all(elsewhere.match(line) for line in alone - here), alone - here)

    @unittest.skipUnless(shutil.which("haproxy"), "there is no haproxy")
    def test_haproxy_takes_the_configuration(self):
        known = self.doors.replace(" hash-key addr", "")  # of HAProxy 3.0; Debian's is 2.6
        self.assertNotEqual(known, self.doors)
        with tempfile.NamedTemporaryFile("w", suffix=".cfg") as file:
            file.write(known)
            file.flush()
            done = subprocess.run(["haproxy", "-c", "-f", file.name], text=True, env={**os.environ, "NAMESPACE": "gnomon"},
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_the_autoscaler_asks_for_what_a_node_exports(self):
        metric, = self.documents["HorizontalPodAutoscaler/gnomon"]["spec"]["metrics"]
        with Node(BUILD, render={"tracer": "bvh"}) as node:
            node.start()
            names = {line.split("{")[0].split(" ")[0] for line in node.page("/metrics").splitlines()}
        self.assertIn(metric["pods"]["metric"]["name"], names)


class Fit(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.text = (manifest.BASE / "gnomond.yaml").read_text()
        cls.config = manifest.load(cls.text)
        cls.deployment = manifest.documents()["Deployment/gnomon"]
        cls.pod = cls.deployment["spec"]["template"]["spec"]
        cls.container, = cls.pod["containers"]
        cls.volumes = {volume["name"]: volume for volume in cls.pod["volumes"]}
        cls.mounts = {mount["mountPath"]: mount for mount in cls.container["volumeMounts"]}

    def test_volumes_are_there_and_used(self):
        self.assertEqual(len(self.volumes), len(self.pod["volumes"]))
        self.assertEqual({mount["name"] for mount in self.mounts.values()}, set(self.volumes))
        config, = re.findall(r"--config (\S+)", " ".join(self.container["args"]))
        folder, name = config.rsplit("/", 1)
        self.assertEqual(self.mounts[folder]["name"], "config")
        generated = manifest.kustomization(manifest.BASE)["configMapGenerator"]
        self.assertIn({"name": self.volumes["config"]["configMap"]["name"], "files": [name]}, generated)

    def test_changed_lights_are_fetched_before_the_daemon_starts(self):
        """The container's script with a resolver and a gnomonctl that are the test's."""
        first, = self.pod["initContainers"]
        for key in ("image", "imagePullPolicy", "securityContext"):
            self.assertEqual(first[key], self.container[key])
        mounts = {mount["mountPath"]: mount["name"] for mount in first["volumeMounts"]}
        written = self.config["scenes"]["lights_file"]
        self.assertEqual(mounts[str(pathlib.Path(written).parent)], self.mounts[str(pathlib.Path(written).parent)]["name"])
        environment = {variable["name"]: variable["value"] for variable in first["env"]}
        self.assertEqual(environment["GNOMON_TOKEN_FILE"], self.config["admin"]["token_file"])
        self.assertIn(f"--from-file={pathlib.Path(environment['GNOMON_ADMIN_CA']).name}=",
                      (manifest.BASE / "kustomization.yaml").read_text())
        with tempfile.TemporaryDirectory() as folder:
            def ran(answer, result):
                for program, script in (("getent", f"printf '%s' '{answer}'"), ("gnomonctl", f"echo \"$@\" >&2; exit {result}")):
                    (pathlib.Path(folder) / program).write_text(f"#!/bin/sh\n{script}\n")
                    (pathlib.Path(folder) / program).chmod(0o755)
                done = subprocess.run(first["command"], text=True, stderr=subprocess.PIPE,
                                      env={"PATH": f"{folder}:{os.environ['PATH']}"})
                self.assertEqual(done.returncode, 0, "a node starts in any case")
                return done.stderr.strip()
            nodes = "192.0.2.7 STREAM gnomon\n192.0.2.8 STREAM\n192.0.2.7 DGRAM"
            port = self.config["admin"]["port"]
            wanted = f"--fleet 192.0.2.7=https://192.0.2.7:{port},192.0.2.8=https://192.0.2.8:{port} scene lights --file {written}"
            self.assertEqual(ran(nodes, 0), wanted)
            self.assertEqual(ran(nodes, 1), wanted)
            self.assertEqual(ran("", 0), "", "the first one has nobody to ask")

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
        for file in [*self.config["server"]["tls"].values(), self.config["admin"]["token_file"]]:
            self.assertEqual(self.mounts[file.rsplit("/", 1)[0]]["name"], "credentials")

    def test_user_and_image_are_those_of_the_containerfile_and_of_quadlet(self):
        context = self.pod["securityContext"]
        self.assertRegex(CONTAINERFILE, rf"(?m)^USER {context['runAsUser']}:{context['runAsGroup']}$")
        self.assertTrue(context["runAsNonRoot"])
        self.assertIn(f"\nImage={self.container['image']}\n", QUADLET)

    def test_an_image_that_a_node_has_is_not_fetched(self):
        """Without a word on it, Kubernetes fetches an image that is called latest, from a registry that nobody has."""
        self.assertTrue(self.container["image"].startswith("localhost/"))
        self.assertEqual(self.container["imagePullPolicy"], "IfNotPresent")

    def test_ports_are_the_daemons(self):
        server, ports = self.config["server"], self.container["ports"]
        self.assertTrue(self.pod["hostNetwork"])
        for port in ports:
            self.assertEqual(port["containerPort"], port["hostPort"])
        defaults = manifest.load((SOURCE / "config/gnomond.yaml").read_text())
        wanted = {"control": ("TCP", server.get("control_port", defaults["server"]["control_port"])),
                  "data": ("UDP", server.get("data_port", defaults["server"]["data_port"])),
                  "admin": ("TCP", self.config["admin"]["port"]), "door": ("TCP", defaults["fleet"]["door_port"])}
        self.assertEqual({port["name"]: (port["protocol"], port["containerPort"]) for port in ports}, wanted)
        for name in ("control", "data"):
            protocol, port = wanted[name]
            self.assertRegex(CONTAINERFILE, rf"(?m)^EXPOSE .*\b{port}/{protocol.lower()}")
        self.assertIn(f"check port {wanted['door'][1]} ", (manifest.BASE / "haproxy.cfg").read_text())
        annotations = self.deployment["spec"]["template"]["metadata"]["annotations"]
        self.assertEqual(annotations["prometheus.io/port"], str(wanted["admin"][1]))

    def test_probes_ask_at_the_operators_socket(self):
        runtime, = (variable["value"] for variable in self.container["env"] if variable["name"] == "RUNTIME_DIRECTORY")
        self.assertFalse(self.mounts[runtime].get("readOnly"))
        for probe, page in (("startupProbe", "/readyz"), ("livenessProbe", "/healthz"), ("readinessProbe", "/readyz")):
            command = self.container[probe]["exec"]["command"]
            self.assertEqual(command[-3:], ["--unix-socket", f"{runtime}/admin.sock", "http://localhost" + page])

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
        address, = (variable["name"] for variable in self.container["env"]
                    if variable.get("valueFrom") == {"fieldRef": {"fieldPath": "status.hostIP"}})
        arguments = [argument.replace(f"$({address})", "192.0.2.7") for argument in self.container["args"]]
        self.assertNotIn("$(", " ".join(arguments))
        with tempfile.TemporaryDirectory() as volumes:
            shutil.copy(BUILD / "share/gnomon/scenes/living_room.glb", f"{volumes}/hall.glb")
            (pathlib.Path(volumes) / "lab.sha256").write_text(64 * "0" + "\n")
            (pathlib.Path(volumes) / "lab.sha256").chmod(0o440)
            for folder in (manifest.BASE, manifest.OVERLAY, manifest.EXAMPLE, manifest.AGONES / "fleet"):
                text = (folder / "gnomond.yaml").read_text()
                file = pathlib.Path(volumes) / "gnomond.yaml"
                file.write_text(text.replace("/srv/scenes", volumes).replace("/run/tokens", volumes))
                arguments[arguments.index("--config") + 1] = file
                done = subprocess.run([BUILD / "bin/gnomond", *arguments, "--check-config",
                                       "--for-reload"], text=True,  # the other files that it names are in the container
                                      stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
                self.assertEqual(done.returncode, 0, f"{folder}: {done.stdout}")


if __name__ == "__main__":
    unittest.main(verbosity=2)
