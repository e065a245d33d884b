#!/usr/bin/env python3
"""The viewer in Firefox beside a real daemon, and its pictures beside Chromium's of the same views.

    firefox_test.py BUILD [PICTURE.png]     with a picture: of the page
"""
import sys
import unittest

from browsing import Page, browser_or_skip, eventually, skip, web_node
import firefox

BUILD = sys.argv.pop(1)
PICTURE = sys.argv.pop(1) if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else None
VIEWS = ("cam=0,1.5,2,0.3,-0.1,0.9", "cam=1,1.2,1.5,0.9,-0.2,0.8")
CLOSE = 2  # of 255
SAME = 0.999


class Firefox(unittest.TestCase):
    def setUp(self):
        self.node = web_node(BUILD)
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def page(self, view, **more):
        page = Page(self.node, f"scene=living_room&tenant=studio&{view}", **more)
        self.addCleanup(page.close)
        return page

    def pixels(self, page):
        """With an exposure of the test's own, as that of the page is of the view and size that it opened with."""
        page.wait_fresh()
        page.evaluate("Object.assign(gnomon.viewer, {exposure: 0.5, changed: true}).set({smooth: false})")
        page.wait("!viewer.changed", "a picture")
        return page.evaluate("Array.from(gnomon.viewer.renderer.readPixels())")

    def looked_elsewhere(self, page):
        page.evaluate(f"(location.hash = 'scene=living_room&tenant=studio&{VIEWS[1]}')")
        eventually(lambda: abs(page.gaze()["yaw"] - 0.9) < 1e-6, "the other view")
        asked = page.viewer("viewer.order.count")
        page.wait(f"viewer.order.count > {asked}  || viewer.masks.index + 1 === viewer.order.count", "a camera there")
        return self.pixels(page)

    def test_a_person_sees_in_it_what_chromium_shows(self):
        page = self.page(VIEWS[0], browser=firefox.Firefox(firefox.find()))
        here = [self.pixels(page), self.looked_elsewhere(page)]
        self.assertEqual(page.viewer("viewer.renderer.grid"), {"exact": True, "subpixels": 256})
        if PICTURE:
            page.browser.picture(PICTURE)
        page.click("#compare")
        eventually(lambda: page.viewer("viewer.picture.split?.right") == "none", "a comparison")
        eventually(lambda: sum(self.pixels(page)) > sum(here[1]), "a brighter picture where shadows are uncovered")

        inner = page.evaluate("({width: innerWidth, height: innerHeight})")
        other = self.page(VIEWS[0], **inner)
        self.assertEqual(other.evaluate("({width: innerWidth, height: innerHeight})"), inner)
        there = [self.pixels(other), self.looked_elsewhere(other)]
        self.assertNotEqual(there[0], there[1])
        for mine, others in zip(here, there):
            self.assertEqual(len(mine), len(others))
            apart = [max(abs(mine[i + c] - others[i + c]) for c in range(3)) for i in range(0, len(mine), 4)]
            same = sum(each <= CLOSE for each in apart) / len(apart)
            print(f"{100 * same:.3f}% of {len(apart)} pixels within {CLOSE} of 255 of Chromium's, the worst {max(apart)}")
            self.assertGreaterEqual(same, SAME)


if __name__ == "__main__":
    browser_or_skip(BUILD)
    if not firefox.find():
        skip("no Firefox here, or no Xvfb for it (deploy/install-packages browser)")
    unittest.main(verbosity=2)
