#!/usr/bin/env python3
"""The operators' page in headless Chromium: plots move under load, a stop shows, nothing is logged as an error.

    page_test.py BUILD [PICTURE.png]     with a picture: of two minutes of three tenants, for the documentation
"""
import signal
import sys
import time
import unittest

import chromium
from node import Node, eventually, skip

BUILD = sys.argv.pop(1)
PICTURE = sys.argv.pop(1) if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else None
TENANTS = [{"name": "studio", "weight": 2}, {"name": "arcade"}, {"name": "museum"}]
PLOTS = ("vbps", "share", "latency", "rate")


class LivePage(unittest.TestCase):
    def setUp(self):
        self.node = Node(BUILD, tenants=TENANTS, server={"drain_timeout_ms": 4000}, render={"tracer": "bvh"})  # nothing to build
        self.addCleanup(self.node.__exit__)
        self.node.start()
        self.browser = chromium.Chromium(chromium.find())
        self.addCleanup(self.browser.close)
        self.browser.open(self.node.admin + "/")

    def line(self, plot, tenant):
        return self.browser.evaluate(f"""document.querySelector('#{plot} path[data-tenant="{tenant}"]')
                                         ?.getAttribute('d') ?? ''""")

    def state(self):
        return self.browser.evaluate("document.getElementById('state').textContent")

    def text(self, selector):
        return self.browser.evaluate(f"document.querySelector('{selector}').innerText")

    def test_plots_move_and_a_stop_shows(self):
        eventually(lambda: self.state() == "ready", "a page that says ready")
        load = self.node.load({"studio": 2, "arcade": 1, "museum": 1}, seconds=600)
        self.addCleanup(load.kill)
        eventually(lambda: "living_room" in self.text("#sessions"), "sessions in the table")
        for plot in PLOTS:
            seen = self.line(plot, "arcade")
            eventually(lambda: len(self.line(plot, "arcade")) > len(seen) > 0 or not seen and self.line(plot, "arcade"),
                       f"a longer line in {plot}")
        eventually(lambda: "arcade 0" not in self.text("#vbps .keys"), "vbps of a tenant under load")
        self.assertEqual(self.browser.errors, [])
        if PICTURE:
            time.sleep(125)
            self.browser.picture(PICTURE)

        self.node.signal(signal.SIGTERM)
        eventually(lambda: self.state() in ("stopping", "stopped"), "the stop on the page")
        self.node.wait()
        eventually(lambda: self.state() in ("stopped", "does not answer"), "its end on the page")

    def test_nothing_comes_from_elsewhere(self):
        eventually(lambda: self.state() == "ready", "a page that says ready")
        loaded = self.browser.evaluate("performance.getEntriesByType('resource').map((entry) => entry.name)")
        self.assertTrue(loaded)
        self.assertEqual([name for name in loaded if not name.startswith(self.node.admin)], [])

    def test_a_narrow_window_has_no_horizontal_scroll(self):
        self.browser.open(self.node.admin + "/", width=390, height=800)
        eventually(lambda: self.state() == "ready", "a page that says ready")
        self.assertLessEqual(self.browser.evaluate("document.documentElement.scrollWidth"), 390)


if __name__ == "__main__":
    if not chromium.find():
        skip("no Chromium here (apt-get install chromium)")
    unittest.main(verbosity=2)
