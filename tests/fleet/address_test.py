#!/usr/bin/python3
"""One address for two doors, by deploy/fleet/keepalived.conf as it stands: real keepalived and HAProxy on two machines, of
which one loses its HAProxy, or its cable.

    address_test.py SOURCE
"""
import pathlib
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import unittest

sys.dont_write_bytecode = True
import namespaces  # noqa: E402

if not shutil.which("keepalived", path="/usr/sbin:/sbin"):
    namespaces.skip("keepalived is not installed (deploy/install-packages tests)")
namespaces.enter_own_network()
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/ops"))
from node import eventually  # noqa: E402

DEPLOY = pathlib.Path(sys.argv.pop(1)) / "deploy/fleet"
ADDRESS, NUMBERS = "10.77.0.9", {"east": 2, "west": 3}


class Door:
    def __init__(self, name, folder):
        self.name, self.machine = name, namespaces.Machine(NUMBERS[name])
        self.pids = [f"--{which}={folder}/{name}.{which}" for which in ("pid", "vrrp_pid", "checkers_pid")]
        self.log = open(folder / f"{name}.log", "w")
        text = (DEPLOY / "keepalived.conf").read_text()
        self.file = folder / f"{name}.conf"
        self.file.write_text(text.replace("10.0.0.2/24", f"{ADDRESS}/24"))
        self.door = folder / f"{name}.cfg"
        # This machine may not allow 20,000 connections' descriptors, and both doors are on it.
        text = (DEPLOY / "haproxy.cfg").read_text().replace("maxconn 20000", "maxconn 100")
        self.door.write_text(text.replace("/run/haproxy/admin.sock", f"{folder}/{name}.sock"))
        self.haproxy = self.keepalived = None

    def start_haproxy(self):
        self.haproxy = self.start("haproxy", "-db", "-f", self.door)

    def start_keepalived(self):
        self.keepalived = self.start("keepalived", "--dont-fork", "--log-console", "--vrrp", f"--use-file={self.file}",
                                     *self.pids)

    def start(self, *command):
        return subprocess.Popen([*self.machine.inside, *map(str, command)], stdout=self.log, stderr=subprocess.STDOUT)

    def has_address(self):
        shown = subprocess.check_output([*self.machine.inside, "ip", "-brief", "addr", "show", "dev", "eth0"], text=True)
        return f" {ADDRESS}/" in shown

    def end(self):
        for process in (self.keepalived, self.haproxy):
            if process:
                process.terminate()
                process.wait()
        self.log.close()
        self.machine.end()


def answers():
    """Somebody takes a connection at the address."""
    try:
        socket.create_connection((ADDRESS, 7600), timeout=0.3).close()
        return True
    except OSError:
        return False


class OneAddress(unittest.TestCase):
    def setUp(self):
        namespaces.open_bridge()
        folder = pathlib.Path(tempfile.mkdtemp(prefix="gnomon-address-"))
        self.addCleanup(shutil.rmtree, folder)
        self.doors = [Door(name, folder) for name in NUMBERS]
        for door in self.doors:
            self.addCleanup(door.end)
            door.start_haproxy()
            door.start_keepalived()

    def holder(self):
        """The door that has the address, and the other one."""
        having = [door for door in self.doors if door.has_address()]
        self.assertEqual(len(having), 1)
        return having[0], next(door for door in self.doors if door is not having[0])

    def moved(self, other, why):
        since = time.monotonic()
        eventually(lambda: other.has_address() and answers(), f"the address at {other.name} after {why}")
        print(f"{why}: the address answers at the other door after {time.monotonic() - since:.1f} s")

    def test_it_is_at_a_door_that_answers(self):
        eventually(answers, "a door at the address")
        holder, other = self.holder()
        holder.haproxy.kill()
        holder.haproxy.wait()
        self.moved(other, "HAProxy killed")

        holder.start_haproxy()
        eventually(lambda: "Script `haproxy_answers` now returning 0" in pathlib.Path(holder.log.name).read_text(),
                   "keepalived that sees it again")
        time.sleep(1)  # three times as often as doors tell each other where the address is
        self.assertEqual(self.holder(), (other, holder), "an address that went back would cut connections for nothing")

        other.machine.pull_cable()
        since = time.monotonic()
        eventually(lambda: holder.has_address() and answers(), "the address at the door that is left")
        print(f"cable pulled: the address answers at the other door after {time.monotonic() - since:.1f} s")


if __name__ == "__main__":
    unittest.main(verbosity=2)
