#!/usr/bin/env python3
"""Every alert is raised by what it is for: done to a real daemon, scraped before and after, and handed to the shipped
rules as it would go on. No series and no label here is anybody's idea of what the daemon exports: rules, dashboard and
documents name only what these scrapes have.

    alerts_test.py BUILD
"""
import http.client
import json
import os
import re
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import threading
import time
import unittest
import urllib.error
import urllib.request

from node import ROOT, Node, eventually, skip
from scrapes import ALERTS, RULES, Scrape, alert_names, family_of, what_fires

BUILD = sys.argv.pop(1)
TOKEN = "0123456789abcdef, the operators' token"
WINDOW_S = 3  # of what goes on
raised = set()


class Happens(unittest.TestCase):
    def start(self, **config):
        config.setdefault("render", {"tracer": "bvh"})
        self.node = Node(BUILD, faults=True, **config)
        self.addCleanup(self.node.__exit__)
        (self.node.folder / "admin.token").write_text(TOKEN)
        (self.node.folder / "admin.token").chmod(0o600)
        self.node.start()
        return self.node

    def load(self, clients, size="64x64", rate=10, **more):
        load = self.node.load(clients, size=size, rate=rate, seconds=600, **more)
        self.addCleanup(load.kill)
        return load

    def frames(self, **labels):
        return self.node.metric("gnomon_visibility_buffers_total", **labels)

    def flying(self, **labels):
        served = self.frames(**labels)
        eventually(lambda: self.frames(**labels) > served + 2, "frames")

    def start_in_fleet(self, **config):
        """A node of a fleet. A door asks for it all the time, until what is returned is called."""
        fleet = {"door_listen": "127.0.0.1", "door_port": 0, **config.pop("fleet", {})}
        self.start(fleet=fleet, server={"public_address": "127.0.0.1"}, **config)
        port = int(re.search(r"door port open .*port=(\d+)", self.node.log_text())[1])
        silent = threading.Event()

        def ask():
            while not silent.wait(0.2):
                with socket.create_connection(("127.0.0.1", port)) as door:
                    door.sendall(b"agent\n")
                    door.recv(100)
        asking = threading.Thread(target=ask)
        asking.start()

        def stop():
            silent.set()
            asking.join()
        self.addCleanup(stop)
        return stop

    def browser(self):
        """One that takes any certificate: asks for the first page, and yields the status of each answer."""
        context = ssl._create_unverified_context()
        context.set_alpn_protocols(["http/1.1"])
        host, port = self.node.control.rsplit(":", 1)
        connection = http.client.HTTPSConnection(host, int(port), context=context)
        self.addCleanup(connection.close)
        while True:
            connection.request("GET", "/")
            answer = connection.getresponse()
            answer.read()
            yield answer.status

    def scrapes(self, happen=lambda: None, window_s=WINDOW_S, settled=False, shows=lambda scrape: True):
        """Two of the calm before, and one after that `shows` it, as gauges of a second do now and then on a busy machine;
        of what has to have `settled`, the second one too."""
        earlier = Scrape(self.node)
        time.sleep(WINDOW_S)
        if settled:
            happen()
        before = Scrape(self.node)
        if not settled:
            happen()
        time.sleep(window_s)

        def after():
            scrape = Scrape(self.node)
            return scrape if shows(scrape) else time.sleep(0.5)
        return earlier, before, eventually(after, "a scrape that shows it")

    def raises(self, alert, happen, also=(), window_s=WINDOW_S, settled=False, shows=lambda scrape: True, **how):
        """Its labels. `happen` begins what it is for; `also`: alerts that may be raised beside it."""
        fired = what_fires(self.node.folder, self.scrapes(happen, window_s, settled, shows), **how)
        self.assertIn(alert, fired)
        self.assertEqual(set(fired) - {alert, *also}, set())
        raised.add(alert)
        return fired[alert]


class Alerts(Happens):
    def test_a_calm_node_raises_none(self):
        """Also not for hours, nor for those who stand still: they send datagrams, and get no frames."""
        self.start()
        self.load({"studio": 2}, still=True)
        eventually(lambda: self.frames() >= 2, "a frame for each of them")
        self.assertEqual(what_fires(self.node.folder, self.scrapes()), {})
        self.load({"studio": 1, "arcade": 1}, rate=5)
        self.flying(tenant="arcade")
        self.assertEqual(what_fires(self.node.folder, self.scrapes(), for_s=7200), {})

    def test_a_browser_that_asks_too_often_raises_none(self):
        """It is answered 429 and counted; nobody has to get up for it."""
        node = self.start(web={"listen": True, "requests_per_s": 10})
        self.load({"studio": 1})
        self.flying()

        def ask():
            self.assertIn(429, self.browser())
            self.assertGreater(node.metric("gnomon_refusals_total", reason="web_rate"), 0)
        self.assertEqual(what_fires(node.folder, self.scrapes(ask)), {})

    def test_a_daemon_that_is_gone(self):
        self.start()
        self.raises("GnomonDown", self.node.stop, window_s=0)

    def test_a_daemon_that_drains(self):
        self.start(web={"listen": True})
        self.assertEqual(next(self.browser()), 200)
        self.load({"studio": 1})
        self.flying()
        self.raises("GnomonNotReady", lambda: self.assertEqual(self.node.ctl("drain")[0], 0))

    def test_a_device_that_is_lost(self):
        node = self.start()
        self.load({"studio": 1})
        self.flying()

        def lose():
            node.order("lose_device")
            eventually(lambda: node.metric("gnomon_device_losses_total") == 1, "the loss")
            self.flying()
        self.raises("GnomonDeviceLost", lose, once=True, for_s=120)

    def test_a_device_that_starts_nothing(self):
        node = self.start()
        self.load({"studio": 2})
        self.flying()

        def refuse():
            node.order("refuse_submits")
            eventually(lambda: node.metric("gnomon_frames_dropped_total", reason="submit_failed") > 5, "refused frames")
            time.sleep(1)  # for frames that are under way
        # Cameras that nothing answers replace each other, more of them on a busy machine.
        self.raises("GnomonNodeStalled", refuse, also=("GnomonTenantFloods",), settled=True)

    def test_clients_whose_datagrams_are_lost(self):
        self.start(server={"silence_timeout_ms": 60000})
        load = self.load({"studio": 1})
        self.flying()

        def stop():
            load.process.send_signal(signal.SIGSTOP)
            time.sleep(1)  # for datagrams that are under way
        self.raises("GnomonLinkDead", stop, settled=True)

    def test_a_tenant_that_asks_for_more_than_there_is(self):
        self.start()

        def flood():
            self.load({"studio": 8}, size="320x180", rate=120)
            self.load({"arcade": 1}, rate=2)
            self.flying(tenant="arcade")
        labels = self.raises("GnomonTenantFloods", flood, also=("GnomonFramesLate",))
        self.assertEqual({one["tenant"] for one in labels}, {"studio"})

    def test_a_tenant_that_gets_less_than_its_part(self):
        self.start(scheduler={"policy": "priority"},
                   tenants=[{"name": "studio", "priority": 1}, {"name": "arcade"}])

        def push():
            self.load({"studio": 8}, size="640x360", rate=60)
            self.load({"arcade": 2}, size="640x360", rate=60)
            self.flying(tenant="studio")

        def rivals(scrape):
            return scrape.value("gnomon_tenant_expected_share_ratio", tenant="arcade") > 0
        labels = self.raises("GnomonTenantStarves", push, also=("GnomonTenantFloods", "GnomonFramesLate"), settled=True,
                             shows=rivals, calm=False)
        self.assertEqual({one["tenant"] for one in labels}, {"arcade"})

    def test_frames_that_come_too_late(self):
        self.start()

        def hurry():
            self.load({"studio": 8}, size="320x180", rate=30, deadline_ms=5)
            eventually(lambda: self.node.metric("gnomon_frames_late_total") > 10, "late frames")
        labels = self.raises("GnomonFramesLate", hurry, also=("GnomonTenantFloods", "GnomonNodeStalled"))
        self.assertEqual({one["tenant"] for one in labels}, {"studio"})

    def test_forged_datagrams(self):
        node = self.start()
        flood = []

        def forge():
            flood.append(subprocess.Popen(
                [node.bin / "gnomon-flood", "--control-port", node.control.rsplit(":", 1)[1], "--scene", "living_room",
                 "--tenant", "arcade", "--rate", "5000", "--seconds", "60"], stdout=subprocess.DEVNULL))
            self.addCleanup(flood[0].wait)
            self.addCleanup(flood[0].kill)
            eventually(lambda: node.metric("gnomon_datagrams_rejected_total", reason="forged") > 0, "forged datagrams")
        self.raises("GnomonForgedDatagrams", forge, also=("GnomonTenantFloods", "GnomonFramesLate"))

    def test_who_has_no_right_to_be_here(self):
        self.start(tenants=[{"name": "studio", "token_sha256": ["00" * 32]}, {"name": "arcade"}])

        def knock():
            for tenant in ("nobody", "studio"):
                self.assertNotEqual(self.refused({tenant: 12}), 0)
        self.raises("GnomonRefusesTokens", knock, window_s=0)

    def refused(self, clients, **more):
        load = self.node.load(clients, size="64x64", rate=10, seconds=0.1, **more)
        load.process.communicate()
        return load.process.returncode

    def test_guesses_at_the_admin_token(self):
        node = self.start(admin={"port": 0, "token_file": "admin.token"})

        def guess():
            for number in range(12):
                request = urllib.request.Request(node.admin + "/drain", b"{}", {"Authorization": f"Bearer guess{number}"})
                with self.assertRaises(urllib.error.HTTPError):
                    urllib.request.urlopen(request, timeout=10)
        self.raises("GnomonAdminTokenGuessed", guess, window_s=0)

    def test_more_clients_than_there_is_room_for(self):
        self.start(tenants=[{"name": "studio", "max_sessions": 1}, {"name": "arcade", "max_vbps": 5}])
        for clients in ({"studio": 8}, {"arcade": 2}):
            self.raises("GnomonOverCapacity", lambda: self.refused(clients), window_s=0)

    def test_a_configuration_with_a_mistake(self):
        node = self.start()

        def reload():
            node.config["tenants"].append({"name": "studio"})
            node.write_config()
            self.assertEqual(node.ctl("reload")[0], 1)
        self.raises("GnomonReloadFailed", reload, window_s=0, once=True, for_s=60)

    def test_an_audit_log_on_a_full_disk(self):
        node = self.start(log={"audit_file": "/dev/full"})
        self.raises("GnomonAuditLogNotWritten", lambda: self.assertEqual(node.ctl("undrain")[0], 0), window_s=0, once=True,
                    for_s=60)

    def test_memory_that_grows(self):
        node = self.start()

        def grow():
            self.load({"studio": 1}, size="1920x1080", still=True)
            eventually(lambda: self.frames() > 0, "a frame")
        self.raises("GnomonMemoryGrows", grow, also=("GnomonLinkDead",), for_s=10800, interval_s=60,
                    trending=("process_resident_memory_bytes",))

    def test_a_door_that_does_not_ask(self):
        """The node is ready, and nobody is sent to it."""
        self.raises("GnomonDoorSilent", self.start_in_fleet(), settled=True)

    def test_sessions_that_find_no_other_node(self):
        self.start_in_fleet()
        self.load({"studio": 1})
        self.flying()

        def drain():
            self.assertEqual(self.node.ctl("drain")[0], 0)
            eventually(lambda: self.node.metric("gnomon_refusals_total", reason="draining") > 0, "no other node")
        self.raises("GnomonDrainStuck", drain, also=("GnomonNotReady",))

    def test_nodes_that_are_nearly_full(self):
        self.start_in_fleet(fleet={"assumed_rate_hz": 1000})

        def fill():
            self.load({"studio": 1}, size="320x180", rate=0)
            self.flying()

        def booked(scrape):
            return scrape.value("gnomon_load_ratio") > 0.6
        self.raises("GnomonFleetFull", fill, also=("GnomonFramesLate", "GnomonTenantFloods"), shows=booked)

    def test_a_certificate_about_to_end_and_a_cache_that_is_full(self):
        """A production node, whose clients show tokens; its light buffers find no room on the disk."""
        scratch = Node(BUILD)
        self.addCleanup(scratch.__exit__)
        certificates = scratch.folder / "certificates"
        subprocess.run([scratch.bin / "gnomonctl", "make-certs", "--out", certificates, "--host", "127.0.0.1", "--days",
                        "5"], check=True, stdout=subprocess.DEVNULL)
        tls = {"certificate": str(certificates / "server.pem"), "key": str(certificates / "server-key.pem")}
        scene = scratch.folder / "small.gltf"
        scene.write_text(json.dumps(SMALL_SCENE))
        self.node = node = Node(BUILD, faults=True, server={"mode": "production", "tls": tls},
                                scenes={"list": [{"name": "small", "file": str(scene)}]}, render={"cache_mb": 1},
                                tenants=[{"name": "studio", "token_sha256": ["00" * 32]}])
        self.addCleanup(node.__exit__)
        node.cache.mkdir()
        for name, age_s in (("older", 2000), ("newer", 1000)):
            file = node.cache / f"{name}.lightbuffer"
            file.write_bytes(bytes(600_000))
            os.utime(file, (time.time() - age_s,) * 2)
        node.order("disk_full")
        node.start(preload=node.build / "faults/libgnomon_fault_files.so")
        eventually(lambda: "light buffer not cached" in node.log_text(), "a cache without room")
        self.assertEqual([file.stem for file in node.cache.glob("*.lightbuffer")], ["newer"], "render.cache_mb holds")
        self.assertRegex(node.log_text(), r"cache trimmed files=1 bytes=600000")
        fired = what_fires(node.folder, self.scrapes(), calm=False)
        self.assertEqual(set(fired), {"GnomonCertificateExpires", "GnomonCacheNotKept"})
        self.assertEqual({one["scene"] for one in fired["GnomonCacheNotKept"]}, {"small"})
        raised.update(fired)


class Told(unittest.TestCase):
    """After Alerts, by its name: what is written of metrics holds for some daemon that was scraped."""
    SELECTED = re.compile(r"\b((?:\w+:)?(?:gnomon|process)_\w+(?::\w+)?)(?:\{([^}]*)\})?")
    WANTED = re.compile(r'(\w+)(=~|=)"([^"]*)"')

    @classmethod
    def setUpClass(cls):
        # The names of families and of their series, and the values of each label of these.
        cls.labels = {}
        for scrape in Scrape.everything:
            for name, labels in scrape.samples:
                for known in (name, family_of(name)):
                    of = cls.labels.setdefault(known, {})
                    for label, value in labels:
                        of.setdefault(label, set()).add(value)
        recorded = re.findall(r"- record: (\S+)\n +expr: (>-\n(?: {10}.*\n)+|.*\n)", RULES.read_text())
        for name, expression in recorded:  # one that is an alias comes after what it stands for
            of = cls.labels.setdefault(name, {})
            for source, _ in cls.SELECTED.findall(expression):
                for label, values in cls.labels.get(source, {}).items():
                    of.setdefault(label, set()).update(values)

    def test_every_alert_was_raised(self):
        self.assertEqual(set(alert_names()) - raised, set())

    def test_every_alert_leads_to_its_runbook(self):
        sections = re.findall(r"^### (\w+)$", (ROOT / "docs/operations.md").read_text(), re.M)
        links = re.findall(r'- alert: (\w+)\n(?: {8}.*\n)*? {10}runbook_url: "file://\S+/operations.md#(\w+)"', ALERTS.read_text())
        self.assertEqual(links, [(name, name.lower()) for name in alert_names()])
        self.assertEqual(set(alert_names()) - set(sections), set())

    def wrong_in(self, text):
        for name, selectors in self.SELECTED.findall(text):
            known = self.labels.get(name)
            if known is None:
                yield f"{name}: no daemon exports it"
                continue
            for label, _, values in self.WANTED.findall(selectors):
                if label not in known:
                    yield f"{name} has no label {label}, but {sorted(known)}"
                elif not values.startswith("$"):
                    yield from (f'{name} was never seen with {label}="{value}", but with {sorted(known[label])}'
                                for value in values.split("|") if value not in known[label])

    def test_rules_and_alerts_name_what_is_exported(self):
        for file in (RULES, ALERTS):
            text = file.read_text()
            self.assertGreater(len(self.SELECTED.findall(text)), 10)
            self.assertEqual(list(self.wrong_in(text)), [])
        for grouping in re.findall(r"\b(?:by|ignoring) \(([^)]*)\)", RULES.read_text() + ALERTS.read_text()):
            for label in grouping.split(", "):
                self.assertTrue(any(label in known for known in self.labels.values()), label)

    def test_the_dashboards_name_what_is_exported(self):
        files = sorted((ROOT / "deploy/grafana").glob("*.json"))
        self.assertGreater(len(files), 1)
        panels = [panel for file in files for panel in json.loads(file.read_text())["panels"]]
        queries = [(target["expr"], target["legendFormat"]) for panel in panels for target in panel["targets"]]
        self.assertGreater(len(queries), 20)
        for expression, legend in queries:
            self.assertEqual(list(self.wrong_in(expression)), [])
            labels = {label for name, _ in self.SELECTED.findall(expression) for label in self.labels[name]}
            self.assertEqual(set(re.findall(r"\{\{(\w+)\}\}", legend)) - labels, set(), expression)

    def test_documents_name_what_is_exported(self):
        pages = [ROOT / "README.md", ROOT / "CHANGELOG.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "deploy/man").iterdir()]
        found = 0
        for page in set(pages) - {ROOT / "docs/library.md"}:  # which has functions
            code = " ".join(re.findall(r"`([^`\n]+)`", page.read_text()))
            code = re.sub(r"\w+_\*", "", code)  # of several
            found += len(self.SELECTED.findall(code))
            self.assertEqual(list(self.wrong_in(code)), [], page.name)
        self.assertGreater(found, 20)


# A triangle and a light: its light buffers take no time.
SMALL_SCENE = {
    "asset": {"version": "2.0"},
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,"
                                          "AACAvwAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, 0],
                   "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "nodes": [{"mesh": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}}],
    "scenes": [{"nodes": [0, 1]}], "scene": 0,
    "extensionsUsed": ["KHR_lights_punctual"],
    "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
}


if __name__ == "__main__":
    if not shutil.which("promtool"):
        skip("no promtool here (apt-get install prometheus)")
    unittest.main(verbosity=2)
