#!/usr/bin/python3
"""A real browser comes to a fleet by its own name, and is served by the node of its scene, also when that drains. Two doors
of real HAProxy, three gnomonds.

    browser_test.py BUILD
"""
import pathlib
import sys
import threading
import time
import unittest

from namespaces import enter_own_network, run

enter_own_network()

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "web"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/ops"))
import chromium  # noqa: E402
from browsing import SIZE, browser_or_skip  # noqa: E402
from world import FLEET, World, eventually  # noqa: E402

BUILD = sys.argv.pop(1)
SCENES = 3
PAUSE_S = 0.05  # between changes of the network


class Browsers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world = World(BUILD)
        cls.addClassCleanup(cls.world.end)
        host, port = cls.world.doors["east"].where
        eventually(lambda: set(cls.world.states(cls.world.doors["east"]).values()) == {"UP"}, "all nodes are up")
        key = chromium.trusting(chromium.key_hash(host, port))
        cls.resolver = f"--host-resolver-rules=MAP {FLEET} {host},MAP *.{FLEET} {host}"
        cls.browser = chromium.Chromium(chromium.find(), (*chromium.LLVMPIPE, key, cls.resolver))
        cls.addClassCleanup(cls.browser.close)
        cls.url = f"https://{FLEET}:{port}/"

    def nodes_of(self, scene):
        """Where sessions of the scene are, and where it is resident."""
        used, resident = set(), set()
        for node in self.world.nodes.values():
            status = node.status()
            used |= {node.name for session in status["sessions"] if pathlib.Path(session["scene"]).name == scene}
            resident |= {node.name for each in status["scenes"] if pathlib.Path(each["name"]).name == scene}
        return used, resident

    def shows(self, what):
        """Waits until the page shows a picture with masks."""
        shown = "!!(window.gnomon?.viewer.masks && window.gnomon.viewer.drawn)"
        try:
            eventually(lambda: self.browser.evaluate(shown), what)
        except AssertionError as error:
            said = self.browser.evaluate("document.querySelector('#poster-text')?.textContent")
            raise AssertionError(f"{error}; {self.browser.evaluate('location.href')} says {said!r}; "
                                 f"{self.browser.errors}") from None

    def where(self):
        return self.browser.evaluate("location.hostname")

    def test_a_browser_is_served_by_the_node_of_its_scene(self):
        hosts, nodes = set(), set()
        for number in range(1, SCENES + 1):
            scene = self.world.scene(number)
            self.browser.open("about:blank")
            self.browser.open(f"{self.url}#scene={scene}&token=secret", **SIZE)
            self.shows("a picture")
            hosts.add(self.where())
            self.assertRegex(self.where(), rf"^s-[0-9a-f]{{16}}\.{FLEET}$")
            self.assertNotIn("token", self.browser.evaluate("location.href"))
            self.assertEqual(self.browser.evaluate("sessionStorage.getItem('gnomon-token')"), "secret")
            name = pathlib.Path(scene).name
            eventually(lambda: self.nodes_of(name)[0], "a session")
            used, resident = self.nodes_of(name)
            self.assertEqual(used, resident, "it has loaded the scene nowhere else")
            self.assertEqual(len(used), 1)
            nodes |= used
        self.assertEqual(len(hosts), SCENES)
        print(f"{SCENES} scenes: {sorted(nodes)}")

    def change_network(self, times):
        """The machine of the browser gets another address and loses it; what is under way is ended by Chromium each time."""
        for _ in range(times):
            for act in ("add", "del"):
                run("ip", "address", act, "10.78.0.1/32", "dev", "bridge")
                time.sleep(PAUSE_S)

    def test_it_comes_while_its_network_changes(self):
        self.browser.call("Network.setCacheDisabled", cacheDisabled=True)
        self.addCleanup(self.browser.call, "Network.setCacheDisabled", cacheDisabled=False)
        self.browser.open("about:blank")
        changes = threading.Thread(target=self.change_network, args=(20,))
        changes.start()
        self.addCleanup(changes.join)
        self.browser.open(f"{self.url}#scene={self.world.scene(SCENES + 2)}", **SIZE)
        self.shows("a picture")
        self.assertTrue(any("ERR_NETWORK_CHANGED" in error for error in self.browser.errors), "it did not change")

    def test_it_moves_when_its_node_drains(self):
        scene = self.world.scene(SCENES + 1)
        name = pathlib.Path(scene).name
        self.browser.open("about:blank")
        self.browser.open(f"{self.url}#scene={scene}", **SIZE)
        self.shows("a picture")
        before = eventually(lambda: self.nodes_of(name)[0], "a session")
        node = self.world.nodes[min(before)]
        self.assertEqual(node.ctl("drain")[0], 0)
        self.addCleanup(node.ctl, "undrain")
        look = "gnomon.gaze.yaw += 0.01"

        def moved():
            self.browser.evaluate(look)
            used = self.nodes_of(name)[0]
            return used and not used & before
        eventually(moved, "a session elsewhere, and none here")
        self.shows("a picture")
        self.assertEqual(self.browser.evaluate("gnomon.viewer.pack !== null"), True)


if __name__ == "__main__":
    browser_or_skip(BUILD)
    unittest.main(verbosity=2)
