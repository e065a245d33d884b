"""Headless Chromium over its debugging pipe: one page, what it logs, what scripts say, pictures."""
import base64
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import tempfile


# WebGL2 on Mesa's llvmpipe, whose grid of 1/256 of a pixel is the server's; SwiftShader's is coarser.
LLVMPIPE = ("--use-angle=gl-egl", "--ignore-gpu-blocklist")
SWIFTSHADER = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader")
NO_GPU = ("--disable-gpu",)


def trusting(key):
    """The argument by which a server's certificate is taken though nobody has signed it; of key_hash()."""
    return f"--ignore-certificate-errors-spki-list={key}"


def key_hash(host, port):
    """What trusting() wants, of the server that listens there."""
    got = subprocess.run(["openssl", "s_client", "-connect", f"{host}:{port}", "-alpn", "http/1.1"], input=b"",
                         capture_output=True, check=False).stdout
    key = subprocess.run(["openssl", "x509", "-pubkey", "-noout"], input=got, capture_output=True, check=True).stdout
    der = subprocess.run(["openssl", "pkey", "-pubin", "-outform", "der"], input=key, capture_output=True,
                         check=True).stdout
    return base64.b64encode(hashlib.sha256(der).digest()).decode()


def find():
    return shutil.which("chromium") or shutil.which("chromium-headless-shell") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Chromium:
    """`arguments`: beside those that every test needs, as LLVMPIPE."""

    def __init__(self, program, arguments=NO_GPU):
        self.folder = tempfile.TemporaryDirectory(prefix="gnomon-chromium-", ignore_cleanup_errors=True)
        to_browser, self.out = os.pipe()
        self.into, from_browser = os.pipe()
        command = (f'exec "$@" 3<&{to_browser} 4>&{from_browser}')
        self.process = subprocess.Popen(
            ["bash", "-c", command, "bash", program, "--headless=new", "--no-sandbox", *arguments,
             "--no-first-run", "--disable-background-networking", "--disable-component-update",
             f"--user-data-dir={self.folder.name}", "--remote-debugging-pipe", "about:blank"],
            pass_fds=(to_browser, from_browser), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.number, self.buffer, self.errors, self.requests = 0, b"", [], []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        # Workers are targets of their own; each waits until it is listened to.
        self.call("Target.setAutoAttach", autoAttach=True, waitForDebuggerOnStart=True, flatten=True)

    def receive(self):
        while b"\0" not in self.buffer:
            data = os.read(self.into, 1 << 20)
            if not data:
                raise AssertionError("the browser has gone")
            self.buffer += data
        message, self.buffer = self.buffer.split(b"\0", 1)
        message = json.loads(message)
        self.note(message.get("method"), message.get("params", {}))
        return message

    def tell(self, session, method):
        """Without waiting for an answer, which is not read."""
        os.write(self.out, json.dumps({"id": 0, "sessionId": session, "method": method}).encode() + b"\0")

    def note(self, method, params):
        if method == "Target.attachedToTarget" and getattr(self, "session", None):
            for told in ("Runtime.enable", "Log.enable", "Network.enable", "Runtime.runIfWaitingForDebugger"):
                self.tell(params["sessionId"], told)
        if method == "Page.loadEventFired":
            self.loaded = True
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        if method == "Network.webSocketCreated":
            self.requests.append(params["url"])
        if method == "Runtime.exceptionThrown":
            self.errors.append(json.dumps(params["exceptionDetails"])[:500])
        if method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.errors.append(json.dumps(params["args"])[:500])
        if method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.errors.append(json.dumps(params["entry"])[:500])

    def call(self, method, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if getattr(self, "session", None):
            message["sessionId"] = self.session
        os.write(self.out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise AssertionError(f"{method}: {answer['error']}")
                return answer["result"]

    def open(self, url, width=1280, height=900, mobile=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)
        if mobile:
            self.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)
        self.loaded = False
        self.call("Page.navigate", url=url)
        while not self.loaded:
            self.receive()

    def evaluate(self, script):
        """What the script says. If its page goes while it is asked, the next page is."""
        for attempt in range(10):
            try:
                result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
                break
            except AssertionError as error:
                if "navigated or closed" not in str(error) or attempt == 9:
                    raise
        if "exceptionDetails" in result:
            raise AssertionError(f"{script}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def picture(self, file):
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]
        pathlib.Path(file).write_bytes(base64.b64decode(data))

    def close(self):
        self.process.kill()
        self.process.wait()
        os.close(self.out)
        os.close(self.into)
        self.folder.cleanup()
