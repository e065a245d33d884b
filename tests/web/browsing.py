"""A daemon that serves browsers, and a real Chromium with its page open."""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system" / "ops"))

import chromium  # noqa: E402
from node import Node, eventually, skip  # noqa: E402,F401

SIZE = dict(width=480, height=320)  # small, as a CPU draws it


def browser_or_skip(build):
    """Ends the test with a line if the page cannot be shown here."""
    if not chromium.find():
        skip("no Chromium here (deploy/install-packages browser)")
    if not shutil.which("openssl"):
        skip("no openssl here")
    configuration = pathlib.Path(__file__).resolve().parents[2] / "config" / "gnomond.yaml"
    if "\nweb:" not in configuration.read_text():
        skip("gnomond does not serve browsers")
    if not list(pathlib.Path(build).glob("**/decoder.wasm")):
        skip("gnomond was built without the decoder for browsers (deploy/install-packages browser)")


def web_node(build, **config):
    config.setdefault("web", {"listen": True})
    config.setdefault("render", {"tracer": "bvh"})  # nothing to build
    return Node(build, **config)


class Page:
    """The page in a browser of its own. `fragment`: behind the #; `before`: a script that runs before those of the page;
    `host`: of a relay, if not the node itself; `browser`: another one than Chromium."""

    def __init__(self, node, fragment="scene=living_room&tenant=studio", program=None, arguments=chromium.LLVMPIPE, before="",
                 host=None, browser=None, **size):
        own, port = node.control.rsplit(":", 1)
        host = host or own
        self.url = f"https://{host}:{port}/"
        self.browser = browser or chromium.Chromium(
            program or chromium.find(), (*arguments, chromium.trusting(chromium.key_hash(host, port))))
        if before:
            self.browser.call("Page.addScriptToEvaluateOnNewDocument", source=before)
        self.open(fragment, **size)

    def open(self, fragment, **size):
        self.browser.open("about:blank")
        self.browser.open(self.url + ("#" + fragment if fragment else ""), **(size or SIZE))

    def evaluate(self, script):
        return self.browser.evaluate(script)

    def viewer(self, expression):
        """Of the viewer, as JavaScript."""
        return self.evaluate(f"(() => {{ const viewer = window.gnomon?.viewer; return viewer ? {expression} : null }})()")

    def text(self, selector):
        return self.evaluate(f"document.querySelector('{selector}')?.textContent ?? ''")

    def wait(self, expression, what):
        """Waits for something of the viewer. Says what the page shows if it never comes."""
        try:
            return eventually(lambda: self.viewer(expression), what)
        except AssertionError as error:
            raise AssertionError(f"{error}; the page says: {self.text('#poster-text')!r} {self.text('#news')!r}; "
                                 f"it logged {self.browser.errors}") from None

    def wait_fresh(self):
        """Waits until the picture shows masks of the camera that it was asked for last, at a size that stays."""
        self.wait("viewer.quality && (viewer.quality.automatic = false, true)", "a viewer")
        self.wait("viewer.masks && viewer.drawn && viewer.drawn.camera.index === viewer.order.newest.index && "
                  "viewer.masks.index === viewer.order.newest.index && viewer.taken === viewer.masks",
                  "a picture with its own masks")

    def press(self, code, key):
        for kind in ("keyDown", "keyUp"):
            self.browser.call("Input.dispatchKeyEvent", type=kind, code=code, key=key)

    def drag(self, start, end, steps=4):
        mouse = lambda kind, x, y, **more: self.browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)
        mouse("mousePressed", *start, button="left", buttons=1, clickCount=1)
        for i in range(1, steps + 1):
            mouse("mouseMoved", *(a + (b - a) * i / steps for a, b in zip(start, end)), button="left", buttons=1)
        mouse("mouseReleased", *end, button="left", clickCount=1)

    def touch_drag(self, starts, ends, steps=4):
        """Fingers that move together. Each of `starts` and `ends`: (x, y)."""
        fingers = lambda share: [{"x": a[0] + (b[0] - a[0]) * share, "y": a[1] + (b[1] - a[1]) * share, "id": i}
                                 for i, (a, b) in enumerate(zip(starts, ends))]
        touch = lambda kind, points: self.browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)
        touch("touchStart", fingers(0))
        for i in range(1, steps + 1):
            touch("touchMove", fingers(i / steps))
        touch("touchEnd", [])

    def click(self, selector):
        self.evaluate(f"document.querySelector('{selector}').click()")

    def gaze(self):
        return self.evaluate("({position: gnomon.gaze.position, yaw: gnomon.gaze.yaw, pitch: gnomon.gaze.pitch})")

    def close(self):
        self.browser.close()
