"""Firefox by its own remote protocol (Marionette): one page, what scripts say, pictures. Without a screen it has no WebGL,
so that it gets one of Xvfb's; what it draws with is Mesa's llvmpipe."""
import base64
import json
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile

from node import eventually

PREFERENCES = {
    "marionette.port": 0,  # one that is free, which it writes into its profile
    "webgl.force-enabled": True,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
    "toolkit.telemetry.enabled": False,
    "app.update.enabled": False,
    "network.captive-portal-service.enabled": False,
    "network.connectivity-service.enabled": False,
    "extensions.update.enabled": False,
    "services.settings.server": "",
}


def find():
    """Firefox, if it and a screen for it are there."""
    return shutil.which("Xvfb") and (shutil.which("firefox-esr") or shutil.which("firefox"))


class Firefox:
    def __init__(self, program):
        self.folder = tempfile.TemporaryDirectory(prefix="gnomon-firefox-", ignore_cleanup_errors=True)
        home = pathlib.Path(self.folder.name)
        profile = home / "profile"
        profile.mkdir()
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items()]
        (profile / "user.js").write_text("\n".join(lines) + "\n")
        self.log = open(home / "log", "w+")
        told, tell = os.pipe()
        self.screen = subprocess.Popen(["Xvfb", "-displayfd", str(tell), "-screen", "0", "1280x1024x24", "-nolisten", "tcp"],
                                       pass_fds=(tell,), stdout=self.log, stderr=subprocess.STDOUT)
        os.close(tell)
        with open(told) as numbers:
            display = numbers.readline().strip()
        environment = {**os.environ, "HOME": str(home), "DISPLAY": f":{display}", "LIBGL_ALWAYS_SOFTWARE": "1"}
        self.process = subprocess.Popen([program, "--marionette", "--no-remote", "--profile", str(profile)],
                                        stdout=self.log, stderr=subprocess.STDOUT, env=environment)
        port = eventually(lambda: self.port_in(profile / "MarionetteActivePort"), "Firefox listens")
        self.number, self.buffer = 0, b""
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.receive()  # its greeting
        self.call("WebDriver:NewSession", acceptInsecureCerts=True)

    def port_in(self, file):
        if self.process.poll() is not None:
            self.log.seek(0)
            raise AssertionError("Firefox has ended:\n" + self.log.read())
        text = file.read_text() if file.exists() else ""
        return int(text) if text.strip() else None

    def receive(self):
        """A message is its length, a colon, and JSON."""
        while True:
            length, colon, rest = self.buffer.partition(b":")
            if colon and len(rest) >= int(length):
                self.buffer = rest[int(length):]
                return json.loads(rest[:int(length)])
            data = self.socket.recv(1 << 20)
            if not data:
                raise AssertionError("the browser has gone")
            self.buffer += data

    def call(self, method, **params):
        self.number += 1
        message = json.dumps([0, self.number, method, params]).encode()
        self.socket.sendall(str(len(message)).encode() + b":" + message)
        _, number, error, result = self.receive()
        assert number == self.number
        if error:
            raise AssertionError(f"{method}: {error['error']}: {error['message']}")
        return result

    def open(self, url, width=1280, height=900):
        self.call("WebDriver:SetWindowRect", width=width, height=height)
        self.call("WebDriver:Navigate", url=url)

    def evaluate(self, script):
        return self.call("WebDriver:ExecuteScript", script=f"return {script}", args=[], sandbox=None)["value"]

    def picture(self, file):
        png = self.call("WebDriver:TakeScreenshot", full=False)["value"]
        pathlib.Path(file).write_bytes(base64.b64decode(png))

    def close(self):
        self.socket.close()
        for process in (self.process, self.screen):
            process.terminate()
            process.wait()
        self.log.close()
        self.folder.cleanup()
