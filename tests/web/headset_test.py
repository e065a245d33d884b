#!/usr/bin/env python3
"""The viewer in an emulated headset (npm's iwer): two sessions of one tenant, and each eye sees what one eye would.

    headset_test.py BUILD
"""
import pathlib
import shutil
import subprocess
import sys
import unittest

from browsing import Page, browser_or_skip, chromium, eventually, skip, web_node

BUILD = pathlib.Path(sys.argv.pop(1))
IWER = "iwer@2.5.0"
NO_XR_OF_ITS_OWN = "--disable-features=WebXR"
EMULATE = """
(() => {
  const device = new IWER.XRDevice(IWER.metaQuest3)
  device.installRuntime()
  device.stereoEnabled = true
  window.device = device
})()
"""

# What the two eyes had, and what a session of its own gets for the same cameras once the headset is left.
KEEP = "window.kept = new Map([...gnomon.headset.eyes].map(([name, eye]) => [name, { size: eye.size, masks: eye.masks }]))"
COMPARE = """(async (name) => {
  const { viewer } = gnomon
  viewer.pause()
  const { size, masks } = kept.get(name)
  const { Eye } = await import('./eye.js')
  const other = new Eye(viewer.base, () => {})
  other.setSize(size)
  other.connect(viewer.wanted, viewer.picture.codec, 10)
  const alone = await new Promise((done) => {
    const on = other.on.bind(other)
    other.worker.onmessage = ({ data }) => { on(data); if (data.is === 'frame') done(data) }
    other.look(masks.camera, performance.now())
  })
  other.close()
  let wrong = 0, lit = 0
  for (let i = 0; i < masks.words.length; ++i) {
    if (alone.words[i] !== masks.words[i]) ++wrong
    if (masks.words[i]) ++lit
  }
  viewer.goOn()
  return { same: alone.words.length === masks.words.length, wrong, lit, camera: masks.camera }
})"""


def iwer():
    """The emulator's source; ends the test with a line where it cannot be had."""
    folder = BUILD.resolve() / "npm"
    file = folder / "node_modules/iwer/build/iwer.min.js"
    if not file.exists():
        if not shutil.which("npm"):
            skip("no npm here, which the emulated headset comes from")
        folder.mkdir(parents=True, exist_ok=True)
        done = subprocess.run(["npm", "install", "--no-audit", "--no-fund", "--ignore-scripts", "--prefix", folder, IWER],
                              capture_output=True, text=True)
        if done.returncode != 0 or not file.exists():
            skip(f"npm could not fetch {IWER}")
    return file.read_text()


class Emulated(unittest.TestCase):
    def setUp(self):
        self.node = web_node(BUILD)
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def test_each_eye_has_a_session_and_its_own_masks(self):
        page = Page(self.node, before=iwer() + EMULATE, arguments=(*chromium.LLVMPIPE, NO_XR_OF_ITS_OWN))
        self.addCleanup(page.close)
        page.wait_fresh()
        eventually(lambda: not page.evaluate("document.getElementById('headset').hidden"), "a button for the headset")
        eventually(lambda: len(self.node.status()["sessions"]) == 1, "one session")
        page.evaluate("document.getElementById('headset').click()")
        eventually(lambda: page.evaluate("[...gnomon.headset.eyes.values()].filter((eye) => eye.masks).length") == 2,
                   "masks for both eyes")
        eventually(lambda: len(self.node.status()["sessions"]) == 2, "a session for each eye, none for the screen")
        page.evaluate(KEEP)
        page.evaluate("gnomon.headset.session.end()")
        eventually(lambda: len(self.node.status()["sessions"]) == 1, "the eyes' sessions closed")
        page.wait_fresh()
        eyes = {name: page.evaluate(f"{COMPARE}('{name}')") for name in ("left", "right")}
        for name, eye in eyes.items():
            self.assertTrue(eye["same"] and eye["lit"] > 0, f"{name}: {eye}")
            self.assertEqual(eye["wrong"], 0, f"{name}: {eye}")
        self.assertNotEqual(eyes["left"]["camera"]["position"], eyes["right"]["camera"]["position"])
        # Where the processor has no room for two eyes they ask for less, and connections that begin are given up.
        self.assertEqual([error for error in page.browser.errors if "before the connection is established" not in error], [])


if __name__ == "__main__":
    browser_or_skip(BUILD)
    iwer()
    unittest.main(verbosity=2)
