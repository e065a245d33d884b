"""Three gnomonds and two doors, each on a machine of its own, and what clients of theirs need."""
import http.client
import json
import pathlib
import re
import shutil
import socket
import subprocess
import sys
import tempfile

from namespaces import Machine, open_bridge

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/ops"))
from node import PATIENCE_S, Node, eventually  # noqa: E402, F401

FLEET = "gnomon.test"
NODES = {"n1": 11, "n2": 12, "n3": 13}
DOORS = {"east": 2, "west": 3}
SCENES = 100
# A triangle and a point light: what a scene costs is none of this test's business.
TINY_SCENE = {
    "asset": {"version": "2.0"},
    "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64,"
                 "AACAvwAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [-1, 0, 0],
                   "max": [1, 1, 0]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "nodes": [{"mesh": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 0, 2]}],
    "scenes": [{"nodes": [0, 1]}], "scene": 0,
    "extensionsUsed": ["KHR_lights_punctual"], "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}},
}


class FleetNode(Node):
    """A gnomond on a machine of its own."""

    def __init__(self, build, name, certificates, scenes):
        self.name, self.machine = name, Machine(NODES[name])
        address = self.machine.address
        server = {"mode": "production", "listen": "0.0.0.0", "insecure_listen": True, "control_port": 7600,
                  "data_port": 7600, "public_address": address,
                  "drain_timeout_ms": 40_000, "proxies": [f"10.77.0.{number}" for number in DOORS.values()],
                  "tls": {"certificate": str(certificates / "server.pem"), "key": str(certificates / "server-key.pem")}}
        super().__init__(build, server=server, tenants=[{"name": "default", "open": True}],
                         fleet={"name": FLEET, "door_listen": address}, scheduler={"admit_percent": 0},
                         scenes={"list": [], "allow_files": [str(scenes)]}, encode={"threads": 1}, web={"listen": True})
        self.lights_file = self.folder / "lights.json"
        self.config["scenes"]["lights_file"] = str(self.lights_file)

    def start(self, **_):
        if self.process:
            self.log.close()
        return super().start(wrapper=self.machine.inside)

    def page(self, path):
        """Over the operators' socket, as its loopback is another one than ours."""
        connection = http.client.HTTPConnection("localhost", timeout=PATIENCE_S)
        connection.sock = socket.socket(socket.AF_UNIX)
        connection.sock.connect(self.socket)
        connection.request("GET", path)
        text = connection.getresponse().read().decode()
        connection.close()
        return text

    def sessions(self):
        """Those that it has told about, a second ago or less; none if it is not there."""
        return self.status()["sessions"] if self.process.poll() is None else []

    def kill(self):
        """As kill -9 does: its kernel resets its connections."""
        self.process.kill()
        self.process.wait()


class Door:
    """HAProxy by the configuration that gnomonctl has made."""

    def __init__(self, name, config, folder):
        self.machine = Machine(DOORS[name])
        self.where = self.machine.address, 7600
        self.file, self.socket = folder / f"{name}.cfg", folder / f"{name}.sock"
        # The test asks HAProxy by its socket what it makes of the nodes; both doors' are on one machine here.
        self.file.write_text(config.replace("/run/haproxy/admin.sock", str(self.socket)))
        self.log = open(folder / f"{name}.log", "w")
        self.process = None

    def start(self):
        self.process = subprocess.Popen([*self.machine.inside, "haproxy", "-db", "-f", str(self.file)], stdout=self.log,
                                        stderr=subprocess.STDOUT)

    def kill(self):
        self.process.kill()
        self.process.wait()

    def log_text(self):
        return pathlib.Path(self.log.name).read_text()

    def end(self):
        if self.process and self.process.poll() is None:
            self.kill()
        self.log.close()
        self.machine.end()


class World:
    fleet = FLEET

    def __init__(self, build):
        open_bridge()
        self.bin = pathlib.Path(build).resolve() / "bin"
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="gnomon-fleet-"))
        self.scenes, certificates = self.folder / "scenes", self.folder / "certificates"
        self.scenes.mkdir()
        for number in range(1, SCENES + 1):  # nodes list the folder once
            (self.scenes / f"scene{number}.gltf").write_text(json.dumps(TINY_SCENE))
        self.ctl("make-certs", "--out", certificates, "--host", "10.77.0.2", "--fleet", FLEET)
        self.pin = self.pin_of(certificates / "server.pem")
        self.authority = certificates / "ca.pem"
        self.nodes = {name: FleetNode(build, name, certificates, self.scenes) for name in NODES}
        for node in self.nodes.values():
            node.start()
        named = [f"--node={node.name}={node.machine.address}" for node in self.nodes.values()]
        config = self.ctl("fleet", "haproxy", *named, "--max-connections", "1000")
        self.doors = {name: Door(name, config, self.folder) for name in DOORS}
        for door in self.doors.values():
            door.start()

    def ctl(self, *arguments):
        return subprocess.check_output([self.bin / "gnomonctl", *map(str, arguments)], text=True)

    @staticmethod
    def pin_of(certificate):
        said = subprocess.check_output(["openssl", "x509", "-in", certificate, "-noout", "-fingerprint", "-sha256"],
                                       text=True)
        return "sha256:" + said.split("=")[1].strip().replace(":", "").lower()

    def states(self, door):
        """What the door thinks of each node: "UP", "DOWN", "DRAIN" ... and empty while it does not answer."""
        if door.process.poll() is not None:
            raise AssertionError("a door has ended:\n" + door.log_text())
        asked = socket.socket(socket.AF_UNIX)
        try:
            asked.connect(str(door.socket))
            asked.sendall(b"show stat\n")
            text = b"".join(iter(lambda: asked.recv(1 << 16), b"")).decode()
        except OSError:
            return {}
        finally:
            asked.close()
        rows = [row.split(",") for row in text.lstrip("# ").splitlines() if row]
        status, weight = rows[0].index("status"), rows[0].index("weight")
        self.weights = {row[1]: int(row[weight]) for row in rows[1:] if row[1] in NODES}
        return {row[1]: re.split(r"[ (]", row[status])[0] for row in rows[1:] if row[1] in NODES}

    def scene(self, number):
        """The name by which clients ask for it; from 1 to SCENES."""
        return str(self.scenes / f"scene{number}.gltf")

    def node_at(self, address):
        return next(node for node in self.nodes.values() if node.machine.address == address)

    def end(self):
        for door in self.doors.values():
            door.end()
        for node in self.nodes.values():
            node.kill()
            node.stop()
            node.__exit__()
            node.machine.end()
        shutil.rmtree(self.folder)
