#!/usr/bin/env python3
"""A real Prometheus scrapes a loaded daemon: all that dashboard, rules and alerts ask for exists and has data, and some
alerts are raised in it (alerts_test raises all). promtool is content with everything.

    prometheus_test.py SOURCE BUILD
"""
import json
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import unittest
import urllib.parse
import urllib.request

from node import Node, eventually, skip
from scrapes import promtool

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), sys.argv.pop(1)
FILES = SOURCE / "deploy/prometheus"
DASHBOARDS = sorted((SOURCE / "deploy/grafana").glob("*.json"))
MOST_SERIES = 500  # of a node with ten tenants, 255 of them in histograms whose buckets end at twice the one before
METRIC = re.compile(r"\b(?:\w+:)?(?:gnomon|process)_\w+(?::\w+)?")


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


def expressions(file):
    """Of a rules file whose expressions stand on one line or are folded: all text behind `expr:`."""
    return re.findall(r"expr: (?:>-\n((?: {10}.*\n)+)|(.*)\n)", file.read_text())


class Promtool(unittest.TestCase):
    def test_config_and_rules(self):
        for check in (("config", "prometheus.yml"), ("rules", "gnomon.rules.yml", "gnomon.alerts.yml")):
            status, output = promtool("check", *check)
            self.assertEqual(status, 0, output)


class Prometheus:
    """With the shipped files, but in a hurry: minutes become seconds."""

    def __init__(self, node):
        self.port = free_port()
        self.url = f"http://127.0.0.1:{self.port}"
        config = (FILES / "prometheus.yml").read_text().replace("5s", "1s").replace("127.0.0.1:7601",
                                                                                     node.admin.removeprefix("http://"))
        (node.folder / "prometheus.yml").write_text(config)
        for rules in FILES.glob("gnomon.*.yml"):
            text = re.sub(r"\[\d+[mh]\]", "[8s]", rules.read_text())
            text = re.sub(r"for: \w+", "for: 2s", text)
            (node.folder / rules.name).write_text(text)
        self.process = subprocess.Popen(
            ["prometheus", f"--config.file={node.folder / 'prometheus.yml'}",
             f"--storage.tsdb.path={node.folder / 'data'}", f"--web.listen-address=127.0.0.1:{self.port}"],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def query(self, expression):
        url = f"{self.url}/api/v1/query?" + urllib.parse.urlencode({"query": expression})
        try:
            with urllib.request.urlopen(url, timeout=10) as answer:
                return json.load(answer)["data"]["result"]
        except OSError:
            return []

    def fires(self, alert, **labels):
        wanted = "".join(f', {key}="{value}"' for key, value in labels.items())
        return self.query(f'ALERTS{{alertname="{alert}", alertstate="firing"{wanted}}}')

    def stop(self):
        self.process.kill()
        self.process.wait()


class Scraped(unittest.TestCase):
    def setUp(self):
        self.node = Node(BUILD, faults=True, tenants=[{"name": "studio"}, {"name": "arcade"}],
                         render={"tracer": "bvh"}, server={"silence_timeout_ms": 120000},
                         fleet={"door_listen": "127.0.0.1", "door_port": 0})
        self.addCleanup(self.node.__exit__)
        self.node.start()
        self.prometheus = Prometheus(self.node)
        self.addCleanup(self.prometheus.stop)

    def refuse_somebody(self):
        load = self.node.load({"nobody": 1}, seconds=0.1)
        load.process.communicate()
        self.assertNotEqual(load.process.returncode, 0)
        self.assertEqual(self.node.ctl("drain", admin=self.node.admin)[0], 1, "over TCP, without a token")

    def asked_for(self):
        panels = [panel for file in DASHBOARDS for panel in json.loads(file.read_text())["panels"]]
        queries = [target["expr"].replace("$instance", ".*") for panel in panels for target in panel["targets"]]
        rules = ["".join(found) for file in ("gnomon.rules.yml", "gnomon.alerts.yml")
                 for found in expressions(FILES / file)]
        self.assertGreater(len(queries), 20)
        self.assertGreater(len(rules), 20)
        metrics = {name for text in queries + rules for name in METRIC.findall(text)}
        recorded = re.findall(r"record: (\S+)", (FILES / "gnomon.rules.yml").read_text())
        return [re.sub(r"\[\d+m\]", "[8s]", query) for query in queries], metrics | set(recorded)

    def test_all_that_is_asked_for_exists_and_alerts_are_raised(self):
        node, prometheus = self.node, self.prometheus
        steady = node.load({"arcade": 1}, seconds=600)
        flood = node.load({"studio": 8}, size="320x180", rate=120, seconds=600)
        self.addCleanup(steady.kill)
        self.addCleanup(flood.kill)
        eventually(lambda: node.metric("gnomon_visibility_buffers_total", tenant="studio") > 0, "frames")
        self.refuse_somebody()
        status, output = promtool("check", "metrics", input=node.page("/metrics"))
        self.assertEqual((status, output), (0, ""))
        eventually(lambda: prometheus.fires("GnomonTenantFloods", tenant="studio"), "an alert for who floods")
        self.assertEqual(prometheus.fires("GnomonTenantFloods", tenant="arcade"), [])

        node.order("lose_device")
        eventually(lambda: prometheus.fires("GnomonDeviceLost"), "an alert for the lost device")
        queries, metrics = self.asked_for()
        for metric in sorted(metrics):
            eventually(lambda: prometheus.query(f"last_over_time({metric}[10m])"), f"data of {metric}", 30)
        for query in queries:
            eventually(lambda: prometheus.query(query), f"data for {query}", 30)

        for load in (steady, flood):
            load.process.send_signal(signal.SIGSTOP)
        eventually(lambda: prometheus.fires("GnomonLinkDead"), "an alert for the dead link")
        node.process.kill()
        node.process.wait()
        eventually(lambda: prometheus.fires("GnomonDown"), "an alert for the daemon that has gone")


class Series(unittest.TestCase):
    def test_ten_tenants_and_two_scenes_are_few_series(self):
        tenants = [{"name": f"tenant{i}"} for i in range(10)]
        scenes = {"list": [{"name": name, "file": f"{name}.glb"} for name in ("living_room", "temple")]}
        with Node(BUILD, tenants=tenants, scenes=scenes, render={"tracer": "bvh"}) as node:
            node.start()
            load = node.load({tenant["name"]: 1 for tenant in tenants}, size="32x32", seconds=1)
            load.rows()
            lines = [line for line in node.page("/metrics").splitlines() if line and not line.startswith("#")]
        print(f"{len(lines)} series at ten tenants, at most {MOST_SERIES}")
        self.assertGreater(len(lines), 100)
        self.assertLessEqual(len(lines), MOST_SERIES, "\n".join(sorted(lines)))


if __name__ == "__main__":
    if not shutil.which("promtool") or not shutil.which("prometheus"):
        skip("no Prometheus here (apt-get install prometheus)")
    unittest.main(verbosity=2)
