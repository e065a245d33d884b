"""gnomond and gnomon-load as this folder uses them."""
import contextlib
import json
import pathlib
import re
import signal
import subprocess
import tempfile
import time
import urllib.request

PATIENCE_S = 120  # only what hangs takes this long


class Daemon:
    """Serves on free ports until stop(). `tenants`: list of dicts of configuration keys. args.cache: a folder for light buffers,
    if any."""

    def __init__(self, args, policy, tenants, devices=(), **scheduler):
        self.folder = tempfile.TemporaryDirectory(prefix="gnomon-load-")
        self.args = args
        self.config = {
            "server": {"mode": "demo", "state_folder": "state", "control_port": 0, "data_port": 0},
            "admin": {"port": 0},
            "scenes": {"list": [{"name": args.scene, "file": f"{args.scene}.glb"}]},
            "scheduler": {"policy": policy, "admit_percent": 0, **scheduler},
            "tenants": tenants,
            "log": {"level": "error"},
        }
        self.config["render"] = {"wait_for_light_buffers": True}  # what is measured does not change meanwhile
        if devices:
            self.config["render"]["devices"] = list(devices)
        if getattr(args, "cache", None):
            self.config["render"]["cache_folder"] = str(pathlib.Path(args.cache).absolute())
        config = self.write_config()
        self.log = open(pathlib.Path(self.folder.name, "log"), "w+")
        self.process = subprocess.Popen([args.bin / "gnomond", "--config", config], stdout=self.log,
                                        stderr=subprocess.STDOUT)
        self.control, self.admin, self.pin = self.wait_until_ready()

    def wait_until_ready(self):
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline and self.process.poll() is None:
            ready = re.search(r"gnomond ready control=(\S+).* admin=(\S+) pin=(\S+)", pathlib.Path(self.log.name).read_text())
            if ready:
                return ready.groups()
            time.sleep(0.05)
        raise SystemExit("gnomond did not start:\n" + pathlib.Path(self.log.name).read_text())

    def write_config(self):
        file = pathlib.Path(self.folder.name, "gnomond.json")
        file.write_text(json.dumps(self.config))  # JSON is YAML
        return file

    def reload(self, **scheduler):
        self.config["scheduler"].update(scheduler)
        self.write_config()
        self.process.send_signal(signal.SIGHUP)
        time.sleep(0.5)

    def metric(self, name):
        """Values by tenant, summed over other labels."""
        with urllib.request.urlopen(self.admin + "/metrics") as page:
            text = page.read().decode()
        values = {}
        for tenant, value in re.findall(rf'^{name}{{[^}}]*tenant="([^"]+)"[^}}]*}} (\S+)$', text, re.M):
            values[tenant] = values.get(tenant, 0) + float(value)
        return values

    def status(self):
        with urllib.request.urlopen(self.admin + "/status") as page:
            return json.load(page)

    def load(self, clients, size, rate, seconds, deadline_ms=0):
        """Starts gnomon-load. `clients`: number by tenant."""
        file = pathlib.Path(tempfile.mkstemp(suffix=".json", dir=self.folder.name)[1])
        command = [self.args.bin / "gnomon-load", "--server", self.control, "--pin", self.pin, "--scene", self.args.scene, "--size", size,
                   "--rate", str(rate), "--seconds", str(seconds), "--deadline-ms", str(deadline_ms), "--json", file]
        for tenant, count in clients.items():
            command += ["--tenant", f"{tenant}::{count}"]
        return Load(subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL), file)

    def stop(self):
        self.process.terminate()
        self.process.wait(PATIENCE_S)
        self.log.close()
        self.folder.cleanup()


class Load:
    def __init__(self, process, file):
        self.process, self.file = process, file

    def rows(self):
        """Waits for its end. The rows by tenant."""
        self.process.wait(PATIENCE_S + 3600)
        rows = json.loads(self.file.read_text())["rows"]
        return {row["tenant"]: row for row in rows if row["scope"] == "tenant"}

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
        self.process.wait()


@contextlib.contextmanager
def serving(args, policy, tenants, devices=(), **scheduler):
    daemon = Daemon(args, policy, tenants, devices, **scheduler)
    try:
        yield daemon
    finally:
        daemon.stop()


def change(daemon, name, seconds, until=lambda: True):
    """How much a counter of each tenant grows in that time, and until that is true, by second."""
    before, begin = daemon.metric(name), time.monotonic()
    time.sleep(seconds)
    while not until():
        if time.monotonic() > begin + seconds + PATIENCE_S:
            raise SystemExit("the daemon answers too little to be measured")
        time.sleep(0.05)
    after, took = daemon.metric(name), time.monotonic() - begin
    return {tenant: (after[tenant] - before.get(tenant, 0)) / took for tenant in after}
