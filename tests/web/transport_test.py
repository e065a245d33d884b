#!/usr/bin/python3
"""WebTransport in headless Chromium beside a real daemon: the page uses it, gets the same masks as over its WebSocket and
as a native client, goes back to the WebSocket where UDP is cut, and comes again.

    transport_test.py BUILD
"""
import pathlib
import re
import subprocess
import sys
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system" / "wire_client"))

from browsing import Page, browser_or_skip, eventually, skip, web_node

try:
    from mask_codecs import TILES
    from messages import MOMENTS, REFERENCES, SIZES, Hello
    from session import Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")
from relay import Relay

BUILD = sys.argv.pop(1)
RELAY = "127.0.0.4"

# A session of the page's own making, and the way to its datagrams.
OFFER = """
(async () => {
  const { decode, encodeHello } = await import('/wire/messages.js')
  const socket = new WebSocket(location.href.replace('https', 'wss').replace(/\\/(#.*)?$/, '/session'), 'gnomon')
  socket.binaryType = 'arraybuffer'
  socket.onopen = () => socket.send(encodeHello({ client: 'test', tenant: 'studio', token: '', scene: 'living_room',
    width: 64, height: 32, borderX: 0, borderY: 0, rateHz: 0, codecs: [1], webTransport: true }))
  window.kept = socket
  return new Promise((resolve) => {
    socket.onmessage = ({ data }) => {
      const message = decode(new Uint8Array(data))
      if (message?.is !== 'webTransport') return
      const { port, ticket, hashes } = message
      resolve({ port, ticket, hashes: JSON.stringify(hashes.map((hash) => [...hash])) })
      socket.onmessage = null
    }
  })
})()
"""
MASKS = """
(async () => {
  const worker = new Worker('/worker.js', { type: 'module' })
  let transport = 'WebSocket', camera = null
  const url = location.href.replace('https', 'wss').replace(/\\/(#.*)?$/, '/session')
  const hello = { client: 'test', tenant: 'studio', token: '', scene: 'living_room', width: 256, height: 128,
    borderX: 0, borderY: 0, rateHz: 0, codecs: [1] }
  return new Promise((resolve, reject) => {
    const look = () => {
      if (camera && transport === '%(transport)s') worker.postMessage({ do: 'look', index: 0, camera })
    }
    worker.onmessage = ({ data }) => {
      if (data.is === 'failed' || data.is === 'closed') reject(new Error(data.why))
      if (data.is === 'open') camera = data.scene.defaultCamera
      if (data.is === 'transport') transport = data.name
      if (data.is === 'open' || data.is === 'transport') look()
      if (data.is === 'frame') resolve({ camera, words: Array.from(data.words) })
    }
    worker.postMessage({ do: 'open', url, hello })
  }).finally(() => worker.terminate())
})()
"""
# Cameras that turn, one after the other; what is seen of their masks lies in `flight`.
FLIGHT = """
(() => {
  const worker = new Worker('/worker.js', { type: 'module' })
  window.flight = { transport: 'WebSocket', frames: { WebSocket: 0, WebTransport: 0 }, sessions: 0, why: '' }
  const url = location.href.replace('https', 'wss').replace(/\\/(#.*)?$/, '/session')
  const hello = { client: 'test', tenant: 'studio', token: '', scene: 'living_room', width: 256, height: 128,
    borderX: 0, borderY: 0, rateHz: 0, codecs: [1] }
  let camera = null, index = 0
  worker.onmessage = ({ data }) => {
    if (data.is === 'failed' || data.is === 'closed') flight.why = data.why
    if (data.is === 'open') [camera, flight.sessions] = [data.scene.defaultCamera, flight.sessions + 1]
    if (data.is === 'transport') flight.transport = data.name
    if (data.is === 'frame') flight.frames[flight.transport] += 1
  }
  setInterval(() => {
    const turn = Math.sin(++index / 50) / 8
    const orientation = [0, Math.sin(turn), 0, Math.cos(turn)]
    if (camera) worker.postMessage({ do: 'look', index, camera: { ...camera, orientation } })
  }, 40)
  worker.postMessage({ do: 'open', url, hello })
})()
"""
# A client that may resume its session goes over to WebTransport, and then loses its WebSocket.
HALF_GONE = """
(async () => {
  const { cameraDatagram, decode, encodeHello } = await import('/wire/messages.js')
  const { Datagrams } = await import('/link/datagrams.js')
  const hello = encodeHello({ client: 'test', tenant: 'studio', token: '', scene: 'living_room', width: 64, height: 32,
    borderX: 0, borderY: 0, rateHz: 0, codecs: [1], webTransport: true })
  hello[10] |= 16 // the feature resume, which the viewer does not ask for
  const socket = new WebSocket(location.href.replace('https', 'wss').replace(/\\/(#.*)?$/, '/session'), 'gnomon')
  socket.binaryType = 'arraybuffer'
  socket.onopen = () => socket.send(hello)
  let camera = null
  return new Promise((resolve, reject) => {
    socket.onmessage = ({ data }) => {
      const message = decode(new Uint8Array(data))
      if (message?.is === 'welcome') camera = message.scene.defaultCamera
      if (message?.is !== 'webTransport') return
      const onOpen = () => datagrams.send(
        cameraDatagram({ frame: 1, camera, timeUs: 0, deadlineUs: 0, have: 0 }))
      const onDatagram = () => { socket.close(); resolve('served') }
      const onEnd = (served) => reject(new Error(`ended, served: ${served}`))
      const datagrams = new Datagrams({ dial: (url, options) => new WebTransport(url, options),
        host: location.hostname, offer: message, onOpen, onDatagram, onEnd })
      window.kept = datagrams
      socket.onmessage = null
    }
  })
})()
"""
CONNECT = """
(async () => {
  const hashes = %(hashes)s.map((value) => ({ algorithm: 'sha-256', value: new Uint8Array(value) }))
  const transport = new WebTransport('https://%(host)s:%(port)s/session?ticket=%(ticket)s', { serverCertificateHashes: hashes })
  transport.closed.catch(() => {})
  try { await transport.ready; return 'open' } catch (error) { return 'refused' }
})()
"""


def is_built(build):
    cache = (pathlib.Path(build) / "CMakeCache.txt").read_text()
    return re.search(r"^GNOMON_HAS_WEBTRANSPORT:INTERNAL=ON", cache, re.M)


class Transport(unittest.TestCase):
    def setUp(self):
        self.node = web_node(BUILD, web={"listen": True, "webtransport": True, "hosts": [RELAY]},
                             server={"net_threads": 2}, scheduler={"admit_percent": 0})
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def page(self, host=None, fragment="scene=living_room&tenant=studio"):
        page = Page(self.node, fragment, host=host)
        self.addCleanup(page.close)
        return page

    def relay(self):
        tcp = int(self.node.control.rsplit(":", 1)[1])
        first = int(re.search(r" data=(\d+)", self.node.log_text()).group(1))
        found = subprocess.check_output(["ss", "-Hlunp"], text=True)
        ports = {int(port) for port in re.findall(rf":(\d+) .*pid={self.node.process.pid}\b", found)}
        relay = Relay(RELAY, "127.0.0.1", tcp, ports | {first})
        self.addCleanup(relay.close)
        return relay

    def test_the_viewer_says_by_which_way_masks_come(self):
        page = self.page()
        eventually(lambda: page.text("[data-figure=transport]") == "WebTransport", "WebTransport in the display")
        self.counted(lambda: self.node.metric("gnomon_transport_sessions", transport="webtransport") == 1, "its count")
        self.assertEqual(page.browser.errors, [])

    def counted(self, condition, what):
        """Metrics are counted once a second."""
        eventually(lambda: condition() or time.sleep(0.5), what)

    def masks(self, page, transport):
        """Of the scene's camera, by the page's worker alone: what draws changes the size as it finds time."""
        return page.evaluate(MASKS % dict(transport=transport))

    def test_masks_are_the_same_whichever_way_they_come(self):
        relay = self.relay()
        by_datagrams = self.masks(self.page(fragment=""), "WebTransport")
        self.assertGreater(self.node.metric("gnomon_transport_bytes_sent_total", transport="webtransport"), 0)
        relay.is_open = False
        by_socket = self.masks(self.page(RELAY, ""), "WebSocket")
        self.assertEqual(by_datagrams["words"], by_socket["words"])
        self.assertGreater(len(set(by_datagrams["words"])), 2, "there are shadows")
        self.assertEqual(self.native_words(by_datagrams["camera"], (256, 128)), by_datagrams["words"])

    def native_words(self, camera, size):
        from messages import Camera
        hello = Hello("living_room", *size, codecs=(TILES,), tenant="studio", features=MOMENTS | REFERENCES | SIZES)
        host, port = self.node.control.rsplit(":", 1)
        session = Session(host, int(port), self.node.pin, hello)
        self.addCleanup(session.close)
        frame = session.picture(Camera(tuple(camera["position"]), tuple(camera["orientation"]), camera["tanLeft"],
                                       camera["tanRight"], camera["tanUp"], camera["tanDown"], camera["near"]))
        return [half for light in frame.words for word in light for half in (word & 0xffffffff, word >> 32)]

    def test_udp_is_cut_in_mid_flight_and_comes_back(self):
        relay = self.relay()
        page = self.page(RELAY, "")
        page.evaluate(FLIGHT)
        seen = lambda: page.evaluate("flight")
        more = lambda transport, than: eventually(
            lambda: seen()["transport"] == transport and seen()["frames"][transport] > than, f"masks by {transport}")
        more("WebTransport", 5)
        relay.is_open = False
        more("WebSocket", seen()["frames"]["WebSocket"] + 5)
        before = seen()["frames"]["WebTransport"]
        relay.is_open = True
        more("WebTransport", before + 5)
        self.assertEqual(seen()["sessions"], 1, "the session stayed")
        self.assertEqual(seen()["why"], "")

    def test_a_session_without_its_websocket_is_reported_like_others(self):
        page = self.page(fragment="")
        self.assertEqual(page.evaluate(HALF_GONE), "served")
        eventually(lambda: "control connection lost" in self.node.log_text(), "the loss of the WebSocket")
        time.sleep(2)  # sessions are reported once a second
        self.assertIsNone(self.node.process.poll(), self.node.log_text())
        self.counted(lambda: not self.node.status()["sessions"], "the end of a session that did not come back")

    def test_what_is_lost_is_sent_again(self):
        relay = self.relay()
        page = self.page(RELAY, "")
        page.evaluate(FLIGHT)
        eventually(lambda: page.evaluate("flight.frames.WebTransport") > 5, "masks by datagrams")
        relay.loss = 0.01
        self.counted(lambda: self.node.metric("gnomon_datagrams_retransmitted_total") > 0, "slices that were sent again")
        self.assertEqual(page.evaluate("flight.why"), "")

    def test_a_ticket_opens_one_connection_for_a_page_of_the_same_origin(self):
        self.relay()
        page, foreign = self.page(fragment=""), self.page(RELAY, "")
        offer = page.evaluate(OFFER)
        refused = lambda: self.node.metric("gnomon_refusals_total", reason="webtransport_ticket")
        self.assertEqual(foreign.evaluate(CONNECT % dict(offer, host=RELAY)), "refused")
        self.assertEqual(page.evaluate(CONNECT % dict(offer, host="127.0.0.1", ticket="0" * 32)), "refused")
        self.assertEqual(refused(), 2)
        self.assertEqual(page.evaluate(CONNECT % dict(offer, host="127.0.0.1")), "open")
        self.assertEqual(page.evaluate(CONNECT % dict(offer, host="127.0.0.1")), "refused")
        self.assertEqual(refused(), 3)


if __name__ == "__main__":
    browser_or_skip(BUILD)
    if not is_built(BUILD):
        skip("gnomond was built without WebTransport (deploy/install-packages webtransport)")
    unittest.main(verbosity=2)
