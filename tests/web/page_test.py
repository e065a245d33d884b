#!/usr/bin/env python3
"""The viewer in headless Chromium beside a real daemon: what a person does, and what the page does then.

    page_test.py BUILD [PICTURE.png]     with a picture: of the page, for the documentation
"""
import hashlib
import http.server
import re
import signal
import sys
import threading
import unittest

from browsing import Page, browser_or_skip, eventually, web_node

BUILD = sys.argv.pop(1)
PICTURE = sys.argv.pop(1) if len(sys.argv) > 1 and sys.argv[1].endswith(".png") else None


class Viewer(unittest.TestCase):
    def setUp(self):
        self.node = web_node(BUILD)
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def page(self, *arguments, **options):
        page = Page(self.node, *arguments, **options)
        self.addCleanup(page.close)
        return page

    def test_a_person_looks_moves_and_compares(self):
        page = self.page()
        page.wait_fresh()
        self.assertEqual(page.text("h1"), "Gnomon")
        self.assertTrue(page.evaluate("document.getElementById('poster').hidden"))
        eventually(lambda: page.text("[data-figure=response]").strip("–"), "a response time")
        self.assertEqual(page.text("[data-figure=transport]"), "WebSocket")
        self.assertEqual(page.text("[data-figure=lights]"), str(page.viewer("viewer.welcome.scene.lights.length")))

        before = page.gaze()
        page.drag((240, 160), (300, 170))
        eventually(lambda: page.gaze()["yaw"] != before["yaw"], "a turn by dragging")
        page.wait_fresh()
        before = page.gaze()
        page.press("KeyW", "w")
        page.evaluate("gnomon.controls.keys.add('KeyW')")
        eventually(lambda: page.gaze()["position"] != before["position"], "a step forward")
        page.evaluate("gnomon.controls.keys.clear()")
        page.wait_fresh()
        if PICTURE:
            page.browser.picture(PICTURE)

        page.click("#more-button")
        eventually(lambda: page.evaluate("document.getElementById('qr').naturalWidth") > 0, "a code for phones")
        page.click("#lights-button")
        boxes = page.evaluate("document.querySelectorAll('#light-list input').length")
        self.assertEqual(boxes, page.viewer("viewer.welcome.scene.lights.length"))
        lit = self.brightness(page)
        page.click("#all-off")
        eventually(lambda: self.brightness(page) < 0.8 * lit, "darkness without lights")
        page.click("#all-on")
        eventually(lambda: abs(self.brightness(page) - lit) < 1, "light again")

        page.click("#compare")
        eventually(lambda: page.viewer("viewer.picture.split?.right") == "none", "a comparison")
        eventually(lambda: self.brightness(page) > lit + 0.5, "a brighter picture where shadows are uncovered")
        page.evaluate("document.getElementById('divider').focus()")
        page.press("Home", "Home")
        eventually(lambda: page.viewer("viewer.picture.split.at") == 0, "the divider at the left")
        unshadowed = self.brightness(page)
        page.press("End", "End")
        eventually(lambda: abs(self.brightness(page) - lit) < 1 < unshadowed - lit, "exact shadows everywhere")
        self.assertEqual(page.browser.errors, [])

    def brightness(self, page):
        """Mean of the picture's pixels, 0 to 255."""
        return page.evaluate("""(() => {
          const { renderer } = gnomon.viewer
          const pixels = renderer.readPixels()
          let sum = 0
          for (let i = 0; i < pixels.length; i += 4) sum += pixels[i] + pixels[i + 1] + pixels[i + 2]
          return sum / (pixels.length / 4 * 3)
        })()""")

    def test_a_link_leads_to_the_same_view(self):
        page = self.page()
        page.wait_fresh()
        page.drag((240, 160), (180, 150))
        page.wait_fresh()
        page.click("#link")
        fragment = eventually(lambda: page.evaluate("location.hash.includes('cam=') && location.hash.slice(1)"), "a link")
        there = page.gaze()
        page.open(fragment)
        page.wait_fresh()
        for before, now in zip([*there["position"], there["yaw"]], [*page.gaze()["position"], page.gaze()["yaw"]]):
            self.assertAlmostEqual(before, now, delta=1e-3)

    def test_a_link_asks_for_soft_shadows_and_the_settings_change_that(self):
        however_slow = {"tenants": [{"name": "studio", "least_samples": 4}], "scheduler": {"admit_percent": 0}}
        node = web_node(BUILD, **however_slow)
        self.addCleanup(node.__exit__)
        node.start()
        page = Page(node)
        self.addCleanup(page.close)
        page.wait_fresh()
        lights = page.viewer("viewer.welcome.scene.lights.length")
        self.assertEqual(page.viewer("viewer.masks.planes.total"), lights)
        hard = self.brightness(page)
        page.evaluate("document.getElementById('more-button').click()")
        page.evaluate("""(() => {
          const choice = document.getElementById('samples')
          choice.value = '4'
          choice.dispatchEvent(new Event('change'))
        })()""")
        page.wait("viewer.welcome?.samples === 4 && viewer.masks?.planes.samples.includes(4)", "counts of four points")
        areas = page.viewer("viewer.welcome.areas").count(True)
        self.assertGreater(areas, 0, "a scene with area lights")
        self.assertEqual(page.viewer("viewer.masks.planes.total"), lights + 2 * areas)
        page.wait_fresh()
        self.assertAlmostEqual(self.brightness(page), hard, delta=0.2 * hard)
        page.evaluate("""(() => {
          const choice = document.getElementById('occlusion')
          choice.value = 'half'
          choice.dispatchEvent(new Event('change'))
        })()""")
        page.wait("viewer.welcome?.samples === 4 + 64 && viewer.masks?.planes.samples.includes(4)", "counts at half size")
        page.click("#filter")
        page.click("#accumulate")
        eventually(lambda: not page.viewer("viewer.changed"), "a picture of averages")
        averages = "viewer.renderer.wish.filter && viewer.renderer.wish.accumulate"
        self.assertTrue(page.viewer(averages))
        page.click("#link")
        fragment = eventually(lambda: page.evaluate("location.hash.includes('soft=4') && location.hash.slice(1)"), "a link")
        page.open(fragment)
        page.wait_fresh()
        self.assertTrue(page.viewer(averages))
        for switch in ("filter", "accumulate"):
            self.assertTrue(page.evaluate(f"document.getElementById('{switch}').checked"), switch)
        page.drag((240, 160), (200, 155))  # a session's masks, of several cameras
        page.wait_fresh()
        self.assertGreater(page.viewer("viewer.renderer.stage.accumulationOf().earlier.length"), 0)
        self.assertEqual(page.viewer("viewer.welcome.samples"), 4 + 64)
        self.assertEqual(page.viewer("viewer.masks.planes.first.length"), lights)
        self.assertEqual(page.browser.errors, [])

    def test_hard_soft_and_a_reference_stand_side_by_side(self):
        node = web_node(BUILD, scheduler={"admit_percent": 0}, tenants=[{"name": "studio", "least_samples": 16}])
        self.addCleanup(node.__exit__)
        node.start()
        page = Page(node, width=240, height=160)
        self.addCleanup(page.close)
        page.wait_fresh()
        page.click("#sides-button")
        captions = "[...document.querySelectorAll('#sides figcaption')].map((caption) => caption.textContent)"
        said = lambda: page.text("#sides-text")
        eventually(lambda: len(page.evaluate(captions)) == 4 or (said() and "is traced" not in said()), "four pictures", patience=400)
        found = page.evaluate(captions)
        self.assertEqual(len(found), 4, said())
        points = [re.search(r"(\w+) points? of each lamp", caption).group(1) for caption in found]
        self.assertEqual(points, ["one", "16", "16", "256"])
        self.assertEqual(["ambient occlusion" in caption.split(":", 1)[1] for caption in found], [False, False, True, True])
        eventually(lambda: "from the reference" in page.evaluate(captions)[0], "differences")
        apart = [float(re.search(r"([\d.]+) of 255", caption).group(1)) for caption in page.evaluate(captions)[:3]]
        self.assertGreater(apart[0], apart[2], "one point is farther from all points than 16 are")
        self.assertGreater(apart[1], apart[2], "without ambient occlusion it is farther from a picture that has it")
        self.assertGreater(apart[2], 0, "16 points leave some grain")
        if PICTURE:
            page.browser.picture(PICTURE.replace(".png", "_sides.png"))
        page.click("#sides-close")
        page.drag((120, 80), (100, 80))
        page.wait_fresh()
        self.assertEqual(page.viewer("viewer.masks.planes.total"), page.viewer("viewer.welcome.scene.lights.length"))
        self.assertEqual(page.browser.errors, [])

    def test_the_daemon_comes_back_and_so_does_the_picture(self):
        page = self.page()
        page.wait_fresh()
        packs = [url for url in page.browser.requests if url.endswith(".pack")]
        self.assertEqual(len(packs), 1)
        self.node.keep_ports()
        self.node.signal(signal.SIGKILL)
        self.node.wait()
        eventually(lambda: "trying again" in page.text("#news"), "news of the loss")
        self.assertTrue(page.viewer("Boolean(viewer.drawn)"), "the last picture stays")
        before = page.viewer("viewer.masks.index")
        self.node.start()
        page.drag((240, 160), (250, 160))
        page.wait(f"viewer.masks && viewer.masks.index > {before}", "masks again")
        page.wait_fresh()
        eventually(lambda: page.text("#news") == "", "no more news")
        self.assertEqual([url for url in page.browser.requests if url.endswith(".pack")], packs)

    def test_what_the_network_took_away_is_asked_for_again(self):
        """The browser ends requests as it does where its machine goes to another network."""
        page = self.page("")
        page.browser.call("Network.setCacheDisabled", cacheDisabled=True)
        said = lambda: page.text("#poster-text")
        for part in ("render/chunks.js", "scene/living_room", ".pack"):
            with self.subTest(part=part):
                page.browser.call("Network.setBlockedURLs", urls=["*" + part])
                page.open("scene=living_room&tenant=studio")
                eventually(lambda: "trying again" in said(), f"what the page says without {part}")
                page.browser.call("Network.setBlockedURLs", urls=[])
                page.wait_fresh()
        page.browser.call("Network.setBlockedURLs", urls=["*render/chunks.js"])
        page.evaluate("sessionStorage.setItem('gnomon-failed-starts', 8)")
        page.open("scene=living_room&tenant=studio")
        eventually(lambda: not page.evaluate("document.getElementById('again').hidden"), "a button, at last")
        self.assertIn("did not come", said())
        page.browser.call("Network.setBlockedURLs", urls=[])
        page.click("#again")
        page.wait_fresh()

    def test_a_worker_that_does_not_come_is_asked_for_again(self):
        """No request of a worker can be ended from here: the first one is sent where nothing is."""
        page = self.page(before="""
          const Real = Worker
          window.workers = []
          window.Worker = class extends Real {
            constructor(url, options) {
              const name = window.workers.length > 0 ? url : new URL('no_such_worker.js', url)
              super(name, options)
              window.workers.push(String(name))
            }
          }""")
        page.wait_fresh()
        names = [name.rsplit("/", 1)[1] for name in page.evaluate("window.workers")]
        self.assertEqual(names[:2], ["no_such_worker.js", "worker.js"])

    def test_a_phone_held_upright(self):
        page = self.page(width=390, height=700, mobile=True)
        page.wait_fresh()
        self.assertLessEqual(page.evaluate("document.documentElement.scrollWidth"), 390)
        for name in ("#bar", "#hud", "#stick"):
            box = page.evaluate(f"""(() => {{ const box = document.querySelector('{name}').getBoundingClientRect()
                                    return [box.left, box.right, box.top, box.bottom] }})()""")
            self.assertTrue(0 <= box[0] < box[1] <= 390 and 0 <= box[2] < box[3] <= 700, f"{name}: {box}")
        before = page.gaze()
        page.touch_drag([(200, 300)], [(240, 310)])
        eventually(lambda: page.gaze()["yaw"] != before["yaw"], "a turn by one finger")
        before = page.gaze()
        page.touch_drag([(150, 300), (250, 300)], [(100, 300), (300, 300)])
        eventually(lambda: page.gaze()["position"] != before["position"], "a way by two fingers")
        page.wait_fresh()

    def test_several_workers_decode_the_context_code(self):
        page = self.page()
        page.wait_fresh()
        page.browser.call("Emulation.setHardwareConcurrencyOverride", hardwareConcurrency=5)
        page.open("scene=living_room&tenant=studio")
        page.wait_fresh()
        self.assertEqual(page.viewer("viewer.masks.lanes"), 0)  # of the code that is fast to decode
        yaw = page.gaze()["yaw"]

        def look(way):
            page.wait_fresh()
            before = page.viewer("viewer.order.newest.index")
            page.evaluate(f"gnomon.gaze.yaw = {way}")
            page.wait(f"viewer.order.newest.index > {before}", "a camera there")
            page.wait_fresh()
            return self.brightness(page)

        fast = [look(yaw + turn) for turn in (0.1, 0.2, 0.3)]
        page.evaluate("gnomon.viewer.set({codec: 'tiles_context'})")
        page.wait("viewer.welcome.codec === 3", "a session by the other code")
        for turn, brightness in zip((0.1, 0.2, 0.3), fast):  # the later ones refer to the first
            self.assertAlmostEqual(look(yaw + turn), brightness, delta=2)  # without shadows it is brighter by 8
        self.assertEqual(page.viewer("[viewer.masks.codec, viewer.masks.lanes]"), ["tiles_context", 3])
        self.assertEqual(page.browser.errors, [])

    def test_what_cannot_be_had_is_said(self):
        page = self.page("scene=no_such_scene&tenant=studio")
        eventually(lambda: "no_such_scene" in page.text("#poster-text"), "the name of what is missing")
        page.open("tenant=studio")
        eventually(lambda: not page.evaluate("document.getElementById('choose').hidden"), "a choice of scenes")
        eventually(lambda: "living_room" in page.text("#poster-text"), "the scenes that there are")


def serve_page(test, html):
    """The origin, on loopback, of somebody else's page."""
    class Page(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><link rel=icon href=data:,>" + html.encode())

        def log_message(self, *_):
            pass
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Page)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    test.addCleanup(server.server_close)
    test.addCleanup(server.shutdown)
    return f"http://127.0.0.1:{server.server_port}/"


class Framing(unittest.TestCase):
    def test_no_other_page_may_frame_the_viewer(self):
        node = web_node(BUILD)
        self.addCleanup(node.__exit__)
        node.start()
        page = Page(node, "")
        self.addCleanup(page.close)
        page.browser.requests.clear()
        harmless = serve_page(self, "<img src=seen>")
        viewer = page.url + "#scene=living_room&tenant=studio"
        frames = f"<iframe id=harmless src='{harmless}'></iframe><iframe id=viewer src='{viewer}'></iframe>"
        page.browser.open(serve_page(self, frames))
        said = lambda: [error for error in page.browser.errors if "frame-ancestors" in error]
        eventually(lambda: page.evaluate("1") and said(), "the browser refuses the frame")
        eventually(lambda: page.evaluate("1") and harmless + "seen" in page.browser.requests, "another frame loads")
        self.assertIn(page.url, page.browser.requests)
        own = [url for url in page.browser.requests if url.endswith(("/app.js", "/session", "/scene/living_room"))]
        self.assertEqual(own, [], "nothing of the page runs in a frame")


SECRET = "5e" * 32
HASH = hashlib.sha256(SECRET.encode()).hexdigest()


class Tokens(unittest.TestCase):
    def test_a_token_is_in_no_request_and_no_log(self):
        secret = SECRET
        node = web_node(BUILD, tenants=[{"name": "studio", "token_sha256": [HASH]}])
        self.addCleanup(node.__exit__)
        node.start()
        page = Page(node, f"scene=living_room&tenant=studio&token={secret}")
        self.addCleanup(page.close)
        page.wait_fresh()
        self.assertNotIn(secret, page.evaluate("location.href"))
        self.assertTrue(any(url.startswith("wss:") for url in page.browser.requests))
        self.assertEqual([url for url in page.browser.requests if secret in url.split("#")[0]], [])
        self.assertNotIn(secret, node.log_text())
        page.open("scene=living_room&tenant=studio")  # the tab remembers it
        page.wait_fresh()

    def test_without_a_token_the_page_asks(self):
        node = web_node(BUILD, tenants=[{"name": "studio", "token_sha256": [HASH]}])
        self.addCleanup(node.__exit__)
        node.start()
        page = Page(node, "scene=living_room&tenant=studio")
        self.addCleanup(page.close)
        eventually(lambda: not page.evaluate("document.getElementById('choose').hidden"), "a form for the token")


if __name__ == "__main__":
    browser_or_skip(BUILD)
    unittest.main(verbosity=2)
