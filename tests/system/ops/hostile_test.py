#!/usr/bin/env python3
"""Strangers who mean no good, beside a real daemon with honest clients: floods of datagrams, connections that never
get to the point. Nobody dies, strangers are not answered, what they take is bounded, operators and clients are served.

    hostile_test.py BUILD [--seconds 60] [--rate 200000] [--connections 1000]
"""
import argparse
import json
import pathlib
import subprocess
import sys
import time
import unittest

from node import Node, eventually, is_sanitized

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("build")
parser.add_argument("--seconds", type=float, default=3, help="of each attack")
parser.add_argument("--rate", type=float, default=50e3, help="datagrams a second")
parser.add_argument("--connections", type=int, default=400, help="half-open at a time")
OPTIONS, sys.argv[1:] = parser.parse_known_args()
HERE = pathlib.Path(__file__).resolve().parent
MOST_GROWTH = 5e6  # bytes
PATIENCE_S = 2  # for a page; the promise is of 0.1, which is for a machine that does nothing else
REJECTED = "gnomon_datagrams_rejected_total"


class Hostile(unittest.TestCase):
    def setUp(self):
        self.node = Node(OPTIONS.build, render={"tracer": "bvh"})
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def load(self, seconds, clients=4, rate=5):
        load = self.node.load({"studio": clients}, size="64x64", rate=rate, seconds=seconds)
        self.addCleanup(load.kill)
        return load

    def memory(self):
        return self.node.metric("process_resident_memory_bytes")

    def flood(self, seconds):
        return subprocess.Popen(
            [self.node.bin / "gnomon-flood", "--control-port", self.node.control.rsplit(":", 1)[1], "--scene",
             "living_room", "--tenant", "arcade", "--rate", str(OPTIONS.rate), "--seconds", str(seconds)],
            stdout=subprocess.PIPE, text=True)

    def flooded(self, seconds):
        flood = self.flood(seconds)
        self.addCleanup(flood.wait)
        self.addCleanup(flood.kill)
        return flood

    def test_junk_on_the_data_port(self):
        node, seconds = self.node, OPTIONS.seconds
        alone = self.load(seconds).rows()[-1]
        self.flooded(1).wait()  # what is made at the first of each kind
        memory, read = self.memory(), node.metric("gnomon_datagrams_received_total")
        before = {reason: node.metric(REJECTED, reason=reason)
                  for reason in ("header", "unknown_session", "too_long", "replayed", "forged")}
        flood = self.flooded(seconds + 2)  # around all of the flight
        load = self.load(seconds)
        slowest = self.slowest_page(flood)
        beside = load.rows()[-1]
        report = json.loads(flood.communicate()[0])
        growth = self.memory() - memory
        read = node.metric("gnomon_datagrams_received_total") - read
        print(f"{report['datagrams_per_s']:.0f} datagrams of junk a second for {report['seconds']:.0f} s, of which the "
              f"daemon read {read / report['sent']:.0%}: {report['replies']} replies; p99 {beside['p99_ms']:.1f} ms, "
              f"alone {alone['p99_ms']:.1f} ms; {beside['frames']} frames, alone {alone['frames']}; memory "
              f"{growth / 1e6:+.1f} MB; slowest page {slowest * 1e3:.0f} ms; who was listened to got "
              f"{report['victim_served']} of {report['victim_asked']} frames")
        self.assertEqual(report["replies"], 0, "strangers were answered")
        for reason, count in before.items():
            self.assertGreater(node.metric(REJECTED, reason=reason), count, reason)
        if not is_sanitized(OPTIONS.build):  # a sanitizer takes memory of its own
            self.assertLess(growth, MOST_GROWTH)
        self.assertEqual(load.process.returncode, 0, load.output)
        self.assertEqual(beside["invalid_slices"], 0)
        self.assertGreater(beside["frames"], alone["frames"] / 2)
        self.assertGreater(report["victim_served"], report["victim_asked"] / 2)
        self.assertIsNone(node.process.poll())

    def slowest_page(self, while_running):
        slowest = 0
        while while_running.poll() is None:
            for page in ("/metrics", "/readyz"):
                since = time.monotonic()
                self.assertEqual(self.node.code(page), 200, page)
                slowest = max(slowest, time.monotonic() - since)
            time.sleep(0.02)
        return slowest

    def half_open(self, server, sort):
        strangers = subprocess.Popen([sys.executable, HERE / "half_open.py", server, str(OPTIONS.connections), sort],
                                     stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.addCleanup(strangers.wait)
        self.addCleanup(strangers.kill)
        self.assertEqual(strangers.stdout.readline(), "opened\n")
        return strangers

    def pages_and_clients_beside(self, server, sort, name, reasons):
        """What was answered while they were there; that they are closed and counted so, and leave nothing."""
        node = self.node
        self.load(0.5).rows()
        descriptors = node.metric("process_open_fds")
        strangers = self.half_open(server, sort)
        times, until = [], time.monotonic() + OPTIONS.seconds
        while time.monotonic() < until:
            for page in ("/metrics", "/readyz"):
                since = time.monotonic()
                self.assertEqual(node.code(page), 200, page)
                times.append(time.monotonic() - since)
            time.sleep(0.01)
        held = node.metric("process_open_fds") - descriptors
        rows = self.load(0.5).rows()
        eventually(lambda: sum(node.metric(name, reason=reason) for reason in reasons) > 0, "some of them are closed")
        self.assertIsNone(strangers.poll(), "they are still there")
        self.assertEqual(rows[-1]["clients"], 4)
        self.assertGreater(rows[-1]["frames"], 0, "an honest client gets in")
        times.sort()
        print(f"{OPTIONS.connections} half-open {sort} connections, who come again when they are closed: "
              f"{len(times)} pages, median {times[len(times) // 2] * 1e3:.1f} ms, slowest {times[-1] * 1e3:.0f} ms; "
              f"{held:.0f} descriptors held")
        self.assertLess(times[-1], PATIENCE_S)
        self.assertGreater(held, 100, "they were there")
        strangers.stdin.close()
        strangers.wait()
        eventually(lambda: node.metric("process_open_fds") <= descriptors, "their descriptors are free again")

    def test_half_open_connections_to_the_admin_server(self):
        self.pages_and_clients_beside(self.node.admin.removeprefix("http://"), "http",
                                      "gnomon_admin_connections_closed_total", ("replaced", "timeout"))

    def test_half_open_connections_to_the_control_port(self):
        self.pages_and_clients_beside(self.node.control, "tls", "gnomon_refusals_total",
                                      ("half_open_replaced", "handshake_timeout", "connection_rate"))


if __name__ == "__main__":
    unittest.main(verbosity=2)
