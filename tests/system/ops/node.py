"""A gnomond of this build as operators have it: its configuration, its admin server, gnomonctl, load and faults."""
import http.client
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.error
import urllib.request

ROOT = pathlib.Path(__file__).resolve().parents[3]
PATIENCE_S = 120  # only what hangs takes this long


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def eventually(condition, what, patience=PATIENCE_S):
    """Asks until it is true; its value."""
    deadline = time.monotonic() + patience
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > deadline:
            raise AssertionError("never: " + what)
        time.sleep(0.02)


def is_sanitized(build):
    cache = pathlib.Path(build, "CMakeCache.txt").read_text()
    return re.search(r"^GNOMON_SANITIZE:\w+=.+$", cache, re.M) is not None


def unsanitized(build, why):
    """Skips a test, or a class of them, in builds with a sanitizer."""
    return unittest.skipIf(is_sanitized(build), "a sanitizer " + why)


class Node:
    """Serves from start() to stop(). `build`: a build folder, as build/release."""

    def __init__(self, build, faults=False, **config):
        self.build = pathlib.Path(build).resolve()
        self.bin = self.build / "bin"
        self.temporary = tempfile.TemporaryDirectory(prefix="gnomon-ops-")
        self.folder = pathlib.Path(self.temporary.name)
        self.cache = self.folder / "cache"
        self.faults = self.folder / "faults"
        self.faults.mkdir()
        self.environment = dict(os.environ)
        if faults:
            self.environment.update(
                VK_ADD_LAYER_PATH=str(self.build / "faults"), VK_INSTANCE_LAYERS="VK_LAYER_GNOMON_faults",
                GNOMON_FAULTS=str(self.faults), GNOMON_FULL_FOLDER=str(self.cache))
        self.config = {
            "server": {"mode": "demo", "state_folder": "state", "control_port": 0, "data_port": 0},
            "admin": {"port": 0, "socket": str(self.folder / "admin.sock")},
            "scenes": {"list": [{"name": "living_room", "file": "living_room.glb"}]},
            "render": {"device": "cpu", "cache_folder": str(self.cache)},
            "tenants": [{"name": "studio"}, {"name": "arcade"}],
        }
        for section, keys in config.items():
            if isinstance(keys, dict):
                self.config.setdefault(section, {}).update(keys)
            else:
                self.config[section] = keys
        self.log_file = self.folder / "log"
        self.process = None
        self.control = self.admin = self.pin = None

    def write_config(self):
        file = self.folder / "gnomond.json"
        file.write_text(json.dumps(self.config))  # JSON is YAML
        return file

    def start(self, wait=True, wrapper=(), pass_fds=(), preload=None):
        environment = dict(self.environment)
        if preload:
            environment["LD_PRELOAD"] = str(preload)
            # A build with that sanitizer otherwise refuses to start behind another library, whose `new` is our malloc.
            environment["ASAN_OPTIONS"] = ":".join([environment.get("ASAN_OPTIONS", ""), "verify_asan_link_order=0",
                                                    "alloc_dealloc_mismatch=0"])
        self.log = open(self.log_file, "w")
        command = [*wrapper, self.bin / "gnomond", "--config", self.write_config()]
        self.process = subprocess.Popen([str(part) for part in command], stdout=self.log, stderr=subprocess.STDOUT,
                                        env=environment, pass_fds=pass_fds)
        if wait:
            self.wait_until_ready()
        return self

    def wait_until_ready(self):
        def ready():
            if self.process.poll() is not None:
                raise AssertionError("gnomond did not start:\n" + self.log_text())
            return self.ready_line()
        line = eventually(ready, "gnomond ready")
        self.control, self.admin, self.pin = line["control"], line["admin"], line["pin"]

    def ready_line(self):
        """What it says of itself when it serves, in either format of the log; None before."""
        whole = [line for line in self.log_text().splitlines(keepends=True) if line.endswith("\n")]
        for line in whole:
            if line.startswith("gnomond ready "):
                return dict(re.findall(r"(\w+)=(\S+)", line))
            if line.startswith("{") and json.loads(line)["event"] == "gnomond ready":
                return json.loads(line)
        return None

    def keep_ports(self):
        """The next start is on the ports of this one."""
        self.config["server"]["control_port"] = int(self.control.rsplit(":", 1)[1])
        self.config["server"]["data_port"] = int(re.search(r" data=(\d+)", self.log_text()).group(1))
        self.config["admin"]["port"] = int(self.admin.rsplit(":", 1)[1])

    def log_text(self):
        return self.log_file.read_text(errors="replace")

    def page(self, path):
        with urllib.request.urlopen(self.admin + path, timeout=10) as page:
            return page.read().decode()

    def code(self, path):
        try:
            with urllib.request.urlopen(self.admin + path, timeout=10) as page:
                return page.status
        except urllib.error.HTTPError as error:
            return error.code
        except OSError:
            return 0

    def status(self):
        return json.loads(self.page("/status"))

    def metric(self, name, **labels):
        """Sum of the series that have these labels."""
        total = 0.0
        for series, value in re.findall(rf"^{name}(\{{[^}}]*\}})? (\S+)$", self.page("/metrics"), re.M):
            if all(f'{key}="{wanted}"' in series for key, wanted in labels.items()):
                total += float(value)
        return total

    def metric_by_tenant(self, name):
        """Values by tenant, each summed over the other labels."""
        values = {}
        for tenant, value in re.findall(rf'^{name}{{[^}}]*tenant="([^"]+)"[^}}]*}} (\S+)$', self.page("/metrics"), re.M):
            values[tenant] = values.get(tenant, 0) + float(value)
        return values

    @property
    def socket(self):
        return self.config["admin"]["socket"]

    def ctl(self, *arguments, admin=None):
        """gnomonctl through the operators' socket, or over another address: exit status, output."""
        done = subprocess.run([self.bin / "gnomonctl", "--admin", admin or f"unix:{self.socket}", *arguments],
                              text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE_S)
        return done.returncode, done.stdout

    def post(self, path, **body):
        """Through the operators' socket: status, text."""
        connection = http.client.HTTPConnection("localhost", timeout=PATIENCE_S)
        connection.sock = socket.socket(socket.AF_UNIX)
        connection.sock.connect(self.socket)
        connection.request("POST", path, json.dumps(body), {"Content-Type": "application/json"})
        answer = connection.getresponse()
        text = answer.read().decode()
        connection.close()
        return answer.status, text

    def cpu_seconds(self):
        """Processor time of the process until now."""
        user, system = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def load(self, clients, size="160x90", rate=0, seconds=5, scene="living_room", server=None, still=False,
             deadline_ms=None):
        """Starts gnomon-load. `clients`: number by tenant, who stand `still` or ask at `rate`; `server`: of a relay(),
        if not directly."""
        pace = ["--still"] if still else ["--rate", str(rate)]
        if deadline_ms is not None:
            pace += ["--deadline-ms", str(deadline_ms)]
        return Load(self, clients, size, pace, seconds, scene, server or self.control)

    def relay(self, *link):
        """Starts netsim before this node, as `--loss 2%`; its process, and where clients find the node through it."""
        port, listen = self.control.rsplit(":", 1)[1], "127.0.0.2"
        data = re.search(r" data=(\d+)", self.log_text()).group(1)
        process = subprocess.Popen([self.bin / "netsim", "--listen", listen, "--tcp", port, "--udp", data, *link],
                                   stdout=subprocess.PIPE, text=True)
        if "relaying" not in process.stdout.readline():
            raise AssertionError("netsim does not relay")
        return process, f"{listen}:{port}"

    def order(self, fault, text=""):
        (self.faults / fault).write_text(text)

    def withdraw(self, fault):
        (self.faults / fault).unlink(missing_ok=True)

    def signal(self, number):
        self.process.send_signal(number)

    def wait(self, patience=PATIENCE_S):
        return self.process.wait(patience)

    def stop(self):
        """Exit status of a drain."""
        if self.process and self.process.poll() is None:
            self.signal(signal.SIGTERM)
            self.wait()
        self.log.close()
        return self.process.returncode

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        if self.process:
            self.log.close()
        self.temporary.cleanup()


class Load:
    def __init__(self, node, clients, size, pace, seconds, scene, server):
        self.file = pathlib.Path(tempfile.mkstemp(suffix=".json", dir=node.folder)[1])
        # Here daemons are killed, drained and overloaded: cameras without an answer are no failure of the load.
        command = [node.bin / "gnomon-load", "--server", server, "--pin", node.pin, "--scene", scene, "--size", size,
                   *pace, "--seconds", str(seconds), "--may-miss", "100", "--json", self.file]
        for tenant, count in clients.items():
            command += ["--tenant", f"{tenant}::{count}"]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)

    def rows(self):
        """Waits for its end; all rows."""
        self.output = self.process.communicate(timeout=3600)[0]
        return json.loads(self.file.read_text())["rows"]

    def tenant_rows(self):
        """Waits for its end; the tenants' rows by name."""
        return {row["tenant"]: row for row in self.rows() if row["scope"] == "tenant"}

    def kill(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()
