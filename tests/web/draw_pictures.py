"""A browser that runs the renderer's checks: the page's files and those of draw_inputs.cpp over HTTP on loopback."""
import base64
import functools
import http.server
import json
import pathlib
import struct
import sys
import threading
import zlib

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests" / "system" / "ops"))
import chromium  # noqa: E402


LIMIT_S = 200


class Files(http.server.SimpleHTTPRequestHandler):
    """/inputs/ is the folder of inputs, /checks/ this folder, all else web/."""
    inputs = None
    extensions_map = {".js": "text/javascript", ".mjs": "text/javascript", ".html": "text/html", ".css": "text/css",
                      ".json": "application/json", "": "application/octet-stream"}

    def translate_path(self, path):
        path = path.split("?")[0].lstrip("/")
        for prefix, folder in (("inputs/", self.inputs), ("checks/", HERE)):
            if path.startswith(prefix):
                return str(folder / path[len(prefix):])
        return str(ROOT / "web" / path)

    def do_GET(self):
        if self.path == "/blank":
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<!doctype html><meta charset=utf-8><link rel=icon href=data:,><title>checks</title>")
        else:
            super().do_GET()

    def log_message(self, *_):
        pass


class Browser:
    def __init__(self, inputs, arguments=chromium.LLVMPIPE):
        handler = type("Handler", (Files,), {"inputs": pathlib.Path(inputs).resolve()})
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.page = chromium.Chromium(chromium.find(), arguments)
        self.page.open(f"http://127.0.0.1:{self.server.server_port}/blank")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.page.close()
        self.server.shutdown()
        self.server.server_close()

    def has_webgl2(self):
        return self.page.evaluate("Boolean(document.createElement('canvas').getContext('webgl2'))")

    def start(self):
        """Loads the scene; `checks` in later scripts is draw_checks.mjs' object. Returns its facts."""
        return self.run("globalThis.checks = await (await import('/checks/draw_checks.mjs')).Checks.open('/inputs');"
                        "return checks.facts")

    def run(self, body):
        """The result of the body of an asynchronous function; one that never ends is an error."""
        late = f"new Promise((_, no) => setTimeout(() => no(new Error('not done in {LIMIT_S} s')), {1000 * LIMIT_S}))"
        return json.loads(self.page.evaluate(
            "(async () => JSON.stringify(await Promise.race([" + late + ", (async () => {" + body + "})()])))()"))


def write_png(file, width, height, rgba):
    rows = b"".join(b"\0" + rgba[4 * width * y:4 * width * (y + 1)] for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    pathlib.Path(file).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0))
                                   + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b""))


def keep(result, file, width, height):
    """Writes the picture of a result of Checks.picture(..., true)."""
    write_png(file, width, height, base64.b64decode(result.pop("rgba")))
