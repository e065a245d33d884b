#!/usr/bin/env python3
"""Reload and drain under load, and sessions that come and go.

    load_test.py BUILD [--sessions N]     N: short sessions whose memory is watched, 1000 if not said
"""
import sys
import time
import unittest

from node import Node, eventually

BUILD = sys.argv.pop(1)
SESSIONS = int(sys.argv.pop(1)) if sys.argv[1:2] == ["--sessions"] and sys.argv.pop(1) else 1000
RELOADS = 200
AT_A_TIME = 100
MOST_GROWTH = 5e6  # bytes, from the first half of the short sessions to the second


class UnderLoad(unittest.TestCase):
    def setUp(self):
        self.node = Node(BUILD, render={"tracer": "bvh"}, server={"drain_timeout_ms": 3000},
                         tenants=[{"name": "studio", "weight": 1}, {"name": "arcade", "weight": 1}])
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def load(self, clients, **more):
        load = self.node.load(clients, **{"seconds": 600, **more})
        self.addCleanup(load.kill)
        return load

    def share(self, tenant):
        return self.node.metric("gnomon_tenant_share_ratio", tenant=tenant)

    def reload(self, weight):
        self.node.config["tenants"][0]["weight"] = weight
        self.node.write_config()
        return self.node.ctl("reload")

    def test_reload(self):
        node = self.node
        load = self.load({"studio": 3, "arcade": 3}, seconds=30)
        eventually(lambda: abs(self.share("studio") - 0.5) < 0.1, "equal shares")
        self.assertEqual(self.reload(4), (0, "reloaded\n"))
        since = time.monotonic()
        eventually(lambda: abs(self.share("studio") - 0.8) < 0.1, "the shares of the new weights")
        print(f"shares follow new weights within {time.monotonic() - since:.1f} s of the reload")

        status, output = self.reload(-1)
        self.assertEqual(status, 1)
        self.assertIn("weight", output)
        self.assertIn("gnomond.json:1", output)
        self.assertEqual(node.status()["tenants"][0]["weight"], 4)
        self.assertEqual(node.code("/readyz"), 200)

        descriptors = node.metric("gnomon_process_open_fds")
        for number in range(RELOADS):
            self.assertEqual(self.reload(1 + number % 4)[0], 0)
        self.assertLessEqual(node.metric("gnomon_process_open_fds"), descriptors + 8, "descriptors leak")
        self.assertEqual(node.metric("gnomon_config_reloads_total", result="done"), RELOADS + 1)
        rows = load.rows()
        total = rows[-1]
        self.assertEqual(load.process.returncode, 0, load.output)
        self.assertEqual((total["lost_slices"], total["wrong_frames"]), (0, 0), total)

    def test_drain(self):
        node = self.node
        load = self.load({"studio": 2, "arcade": 2})
        eventually(lambda: node.metric("gnomon_visibility_buffers_total") > 20, "frames")
        self.assertEqual(node.ctl("drain")[0], 0)
        self.assertEqual(node.code("/readyz") in (503, 0), True)
        self.assertEqual(node.wait(), 0, node.log_text())
        output = load.process.communicate(timeout=60)[0]
        self.assertIn("the server", output)
        self.assertRegex(output, r"total, 4 clients .* 0 *$|total, 4 clients", "no wrong frame")

    def test_sessions_that_come_and_go_leave_no_memory(self):
        node, grown = self.node, []
        for _ in range(2):
            for _ in range(SESSIONS // 2 // AT_A_TIME):
                self.load({"studio": AT_A_TIME}, size="32x32", seconds=0.1).rows()
                eventually(lambda: node.metric("gnomon_sessions") == 0, "all sessions closed")
            grown.append(node.metric("gnomon_process_resident_memory_bytes"))
        print(f"{SESSIONS} short sessions: {grown[0] / 1e6:.1f} MB after the first half, "
              f"{grown[1] / 1e6:.1f} MB at the end")
        self.assertLess(grown[1] - grown[0], MOST_GROWTH)


if __name__ == "__main__":
    unittest.main(verbosity=2)
