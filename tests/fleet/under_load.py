"""gnomon-load through a fleet's door, for as long as a test wants."""
import json
import pathlib
import signal
import subprocess

SIZE = "32x32"
LONG_S, WARM_UP_S = 3600, 2


class Load:
    """gnomon-load until land(). `world`: where its programs are, where it may write, who has signed the fleet's
    certificates and what its name is; `where`: a door. Clients are of the tenant `default`, or of what `tenant` says."""

    made = 0

    def __init__(self, world, scene, clients, rate, *more, where=None, tenant=None):
        Load.made += 1
        self.scene, self.clients = pathlib.Path(scene).name, clients
        self.name = pathlib.Path(scene).stem
        self.file = world.folder / f"load-{Load.made}-{self.name}.json"
        host, port = where or world.doors["east"].where
        who = ("--tenant", f"{tenant}:{clients}") if tenant else ("--clients", clients)
        pace = ("--rate", rate) if rate else ("--still",)
        self.log = open(self.file.with_suffix(".log"), "w+")
        self.process = subprocess.Popen(
            [str(part) for part in (world.bin / "gnomon-load", "--server", f"{host}:{port}", "--fleet", world.fleet, "--ca",
             world.authority, "--scene", scene, "--size", SIZE, *who, *pace, "--seconds", LONG_S,
             "--warm-up", WARM_UP_S, "--transport", "udp", "--may-miss", "100", "--json", self.file, *more)],
            stdout=self.log, stderr=subprocess.STDOUT)

    def must_fly(self):
        if self.process.poll() is not None:
            raise AssertionError(f"gnomon-load has ended: {self.land()}")
        return True

    def land(self):
        """What was measured, in all."""
        self.process.send_signal(signal.SIGINT)
        self.process.wait(120)
        self.log.seek(0)
        if self.process.returncode:
            raise AssertionError(f"gnomon-load, {self.name}: {self.log.read()}")
        return next(row for row in json.loads(self.file.read_text())["rows"] if row["scope"] == "total")

    def end(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        self.log.close()
