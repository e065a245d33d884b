#!/usr/bin/python3
"""A gnomond that Agones runs tells its sidecar, which is the test's here, that it lives, is ready, and goes.

    agones_test.py BUILD
"""
import http.server
import signal
import sys
import threading
import unittest

from node import Node, eventually

BUILD = sys.argv.pop(1)


class Sidecar(http.server.ThreadingHTTPServer):
    """Answers as Agones' own does, and notes what it was told."""

    def __init__(self):
        told = self.told = []

        class Answer(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                body = self.rfile.read(int(self.headers["Content-Length"]))
                told.append((self.path, body, self.headers["Content-Type"]))
                self.send_response(200)
                self.send_header("Content-Type", "application/json")
                self.send_header("Content-Length", "2")
                self.end_headers()
                self.wfile.write(b"{}")

            def log_message(self, *_):
                pass

        super().__init__(("127.0.0.1", 0), Answer)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    def paths(self):
        return [path for path, _, _ in self.told]


class Agones(unittest.TestCase):
    def setUp(self):
        self.sidecar = Sidecar()
        self.addCleanup(self.sidecar.server_close)
        self.addCleanup(self.sidecar.shutdown)

    def node(self, agones):
        node = Node(BUILD, fleet={"agones": agones}, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        self.addCleanup(lambda: node.log.close())
        node.environment["AGONES_SDK_HTTP_PORT"] = str(self.sidecar.server_address[1])
        return node

    def test_a_nodes_life(self):
        node = self.node(True)
        node.start(wait=False)
        eventually(self.sidecar.paths, "a sign of life")
        self.assertEqual(self.sidecar.paths()[0], "/health", "from the start, as scenes may take long")
        node.wait_until_ready()
        eventually(lambda: "/ready" in self.sidecar.paths(), "it says that it is ready")
        self.assertEqual(node.ctl("drain")[0], 0)
        before = len(self.sidecar.told)
        eventually(lambda: len(self.sidecar.told) > before, "it lives on")
        self.assertNotIn("/shutdown", self.sidecar.paths(), "a drain may be taken back")
        node.process.send_signal(signal.SIGTERM)
        self.assertEqual(node.process.wait(60), 0)
        paths = self.sidecar.paths()
        self.assertEqual((paths.count("/ready"), paths.count("/shutdown"), paths[-1]), (1, 1, "/shutdown"))
        self.assertEqual({(body, kind) for _, body, kind in self.sidecar.told}, {(b"{}", "application/json")})

    def test_without_the_key_nothing_is_said(self):
        node = self.node(False)
        node.start()
        node.process.send_signal(signal.SIGTERM)
        node.process.wait(60)
        self.assertEqual(self.sidecar.paths(), [])


if __name__ == "__main__":
    unittest.main(verbosity=2)
