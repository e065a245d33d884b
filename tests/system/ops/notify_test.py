#!/usr/bin/env python3
"""What gnomond tells its service manager, against a socket of the test: ready, reloading, stopping, signs of life.

    notify_test.py BUILD
"""
import fcntl
import os
import pathlib
import re
import signal
import socket
import sys
import threading
import time
import unittest

from node import Node, eventually

WATCHDOG_S = 3.0
BUILD = sys.argv.pop(1)


class Manager:
    """The service manager's end."""

    def __init__(self, node):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        path = str(node.folder / "notify")
        self.socket.bind(path)
        self.messages, self.lock = [], threading.Lock()
        self.kept = {}  # descriptors by name
        node.environment.update(NOTIFY_SOCKET=path, WATCHDOG_USEC=str(int(WATCHDOG_S * 1e6)))
        threading.Thread(target=self.listen, daemon=True).start()

    def listen(self):
        while True:
            data, descriptors, _, _ = socket.recv_fds(self.socket, 4096, 1)
            lines = data.decode().splitlines()
            name = next((line.removeprefix("FDNAME=") for line in lines if line.startswith("FDNAME=")), None)
            with self.lock:
                if "FDSTOREREMOVE=1" in lines:
                    self.kept.pop(name, None)
                if "FDSTORE=1" in lines:
                    self.kept[name] = descriptors[0]
                self.messages.append((time.monotonic(), lines))

    def lines(self, since=0):
        with self.lock:
            return [line for _, message in self.messages[since:] for line in message]

    def count(self):
        with self.lock:
            return len(self.messages)

    def pings(self):
        return self.lines().count("WATCHDOG=1")

    def silence(self):
        """Seconds since the last sign of life."""
        with self.lock:
            last = max((at for at, message in self.messages if "WATCHDOG=1" in message), default=0)
        return time.monotonic() - last


class Notify(unittest.TestCase):
    def setUp(self):
        self.node = Node(BUILD, faults=True, render={"tracer": "bvh"})  # nothing to build
        self.addCleanup(self.node.__exit__)
        self.manager = Manager(self.node)

    def test_ready_reloading_stopping(self):
        node, manager = self.node, self.manager
        node.start()
        eventually(lambda: "READY=1" in manager.lines(), "READY=1")
        self.assertTrue(any(line.startswith("STATUS=serving 1 scenes") for line in manager.lines()))

        seen = manager.count()
        node.signal(signal.SIGHUP)
        eventually(lambda: "READY=1" in manager.lines(seen), "READY=1 after a reload")
        lines = manager.lines(seen)
        self.assertLess(lines.index("RELOADING=1"), lines.index("READY=1"))
        self.assertTrue(any(line.startswith("MONOTONIC_USEC=") for line in lines))

        seen = manager.count()
        node.config["scheduler"] = {"policy": "whoever"}
        node.write_config()
        node.signal(signal.SIGHUP)
        told = eventually(lambda: [line for line in manager.lines(seen) if "not reloaded" in line], "the bad file")
        self.assertIn("gnomond.json:1", told[0])
        self.assertIn("policy", told[0])
        self.assertEqual(node.metric("gnomon_config_reloads_total", result="failed"), 1)

        seen = manager.count()
        self.assertEqual(node.stop(), 0)
        eventually(lambda: "STOPPING=1" in manager.lines(seen), "STOPPING=1")

    def begin(self):
        """Returns when gnomond takes signals itself, long before it serves."""
        self.node.start(wait=False)
        status = pathlib.Path(f"/proc/{self.node.process.pid}/status")

        def taken():
            mask = int(re.search(r"SigCgt:\s*(\w+)", status.read_text()).group(1), 16)
            return all(mask >> (number - 1) & 1 for number in (signal.SIGHUP, signal.SIGTERM))
        eventually(taken, "handlers of signals")
        self.assertIsNone(self.node.ready_line())

    def test_a_reload_that_is_asked_for_while_it_starts_is_done_then(self):
        self.begin()
        self.node.signal(signal.SIGHUP)
        self.node.wait_until_ready()
        eventually(lambda: self.node.metric("gnomon_config_reloads_total", result="unchanged") == 1 or
                   self.node.metric("gnomon_config_reloads_total", result="done") == 1, "a reload")
        self.assertEqual(self.node.stop(), 0)

    def test_a_stop_ends_a_start(self):
        """Also of the first process of a container, which no signal ends that it does not take."""
        self.begin()
        self.node.signal(signal.SIGTERM)
        self.assertEqual(self.node.process.wait(60), 0)
        self.assertIsNone(self.node.ready_line())

    def test_signs_of_life_end_with_the_device(self):
        node, manager = self.node, self.manager
        node.start()
        idle = manager.pings()
        eventually(lambda: manager.pings() >= idle + 3, "signs of life of an idle daemon")
        load = node.load({"studio": 2}, seconds=600)
        self.addCleanup(load.kill)
        eventually(lambda: node.metric("gnomon_visibility_buffers_total") > 10, "frames")
        busy = manager.pings()
        eventually(lambda: manager.pings() >= busy + 3, "signs of life under load")
        node.order("hang")
        eventually(lambda: manager.silence() > WATCHDOG_S, "the silence that a supervisor acts on")
        # The rest of it goes on, and tells those that no watchdog tells: a container's health check.
        eventually(lambda: node.code("/healthz") == 503, "a health check that fails")
        self.assertIn("gnomon_ready", node.page("/metrics"))

    def test_ports_outlive_the_daemon(self):
        node = self.node
        control, data = socket.create_server(("127.0.0.1", 0)), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        data.bind(("127.0.0.1", 0))
        node.config["server"].update(control_port=control.getsockname()[1], data_port=data.getsockname()[1])
        given = ["bash", "-c", f'export LISTEN_PID=$$ LISTEN_FDS=2; exec "$@" 3<&{control.fileno()} 4<&{data.fileno()}',
                 "bash"]
        descriptors = (control.fileno(), data.fileno())
        node.start(wrapper=given, pass_fds=descriptors)
        node.process.kill()
        node.wait()
        load = node.load({"studio": 1}, seconds=0.5)  # connects while nobody serves
        self.addCleanup(load.kill)
        time.sleep(0.5)
        node.start(wrapper=given, pass_fds=descriptors)
        rows = load.rows()
        self.assertGreater(rows[-1]["frames"], 0, rows)
        self.assertEqual(node.stop(), 0)

    def test_sessions_outlive_the_daemon(self):
        """Killed three times under its clients, with its ports and the sessions' memory kept for it."""
        node = self.node
        control, data = socket.create_server(("127.0.0.1", 0)), socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        data.bind(("127.0.0.1", 0))
        node.config["server"].update(control_port=control.getsockname()[1], data_port=data.getsockname()[1],
                                     silence_timeout_ms=60_000)

        def start():
            kept = self.manager.kept
            given = [fcntl.fcntl(fd, fcntl.F_DUPFD, 64)  # beyond the numbers that they are moved to
                     for fd in (control.fileno(), data.fileno(), *kept.values())]
            names = ":".join(["control", "data", *kept])
            moved = " ".join(f"{3 + i}<&{fd}" for i, fd in enumerate(given))
            script = f'export LISTEN_PID=$$ LISTEN_FDS={len(given)} LISTEN_FDNAMES={names}; exec "$@" {moved}'
            node.start(wrapper=["bash", "-c", script, "bash"], pass_fds=given)
            for fd in given:
                os.close(fd)

        def sessions():
            return sorted(session["id"] for session in node.status()["sessions"])

        def frames():
            return node.metric("gnomon_visibility_buffers_total")

        kills, clients = 3, 4
        start()
        load = node.load({"studio": 2, "arcade": 2}, rate=20, seconds=600)
        self.addCleanup(load.kill)
        eventually(lambda: len(sessions()) == clients and frames() > 20, "frames")
        ids = sessions()
        for _ in range(kills):
            node.process.kill()
            node.wait()
            start()
            eventually(lambda: sessions() == ids, "the same sessions")
            had = frames()
            eventually(lambda: frames() > had + 20, "frames of the same sessions")
            self.assertEqual(node.metric("gnomon_refusals_total"), 0)
        self.assertIsNone(load.process.poll(), "they are all still there")
        load.process.send_signal(signal.SIGINT)
        rows = load.rows()
        self.assertEqual(load.process.returncode, 0, load.output)
        self.assertEqual((rows[-1]["resumed"], rows[-1]["invalid_slices"]), (kills * clients, 0), rows[-1])
        self.assertEqual(node.stop(), 0)

        start()  # after an orderly end there is nothing to go on with
        self.assertNotIn("sessions may be resumed", node.log_text())

    def test_a_port_open_at_another_address_is_an_error(self):
        node = self.node
        control = socket.create_server(("127.0.0.2", 0))
        node.config["server"]["control_port"] = control.getsockname()[1]
        given = ["bash", "-c", f'export LISTEN_PID=$$ LISTEN_FDS=1; exec "$@" 3<&{control.fileno()}', "bash"]
        node.start(wait=False, wrapper=given, pass_fds=(control.fileno(),))
        self.assertEqual(node.wait(), 1)
        self.assertIn("server.control_port", node.log_text())


if __name__ == "__main__":
    os.environ.pop("NOTIFY_SOCKET", None)
    unittest.main(verbosity=2)
