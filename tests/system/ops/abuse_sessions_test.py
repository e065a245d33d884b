#!/usr/bin/python3
"""Attacks on places and on the life of credentials, against a real daemon with clients that follow the document alone:
strangers who fill the lobby, clients that leave while they wait, tokens that are revoked, certificates that expire.

    abuse_sessions_test.py BUILD
"""
import dataclasses
import datetime
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "wire_client"))

from node import Node, eventually, skip, unsanitized

try:
    import messages
    from control import Closed, Control
    from datagrams import Kind, camera_update
    from mask_codecs import CONTEXT
    from cryptography import x509
    from cryptography.hazmat.primitives import hashes, serialization
    from cryptography.hazmat.primitives.asymmetric import ec
    from session import RefusedBy, Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")

BUILD = sys.argv.pop(1)
SLOW, QUICK = "slow.glb", "living_room"
LOBBY = 64


def hello(scene=QUICK, tenant="studio", token="", features=messages.PATHS):
    return messages.Hello(scene=scene, width=64, height=64, tenant=tenant, token=token, features=features)


class Sessions:
    """Of a node's clients."""

    def __init__(self, node):
        self.node = node
        host, port = node.control.rsplit(":", 1)
        self.server = host, int(port)

    def open(self, **asks):
        return Session(*self.server, self.node.pin, hello(**asks))

    def ask(self, **asks):
        """A connection whose Hello was sent, and is not waited for."""
        control = Control(*self.server, self.node.pin)
        control.send(hello(**asks).message())
        return control


class Places(unittest.TestCase):
    """On a node whose reader of scenes waits as long as a file exists."""

    def setUp(self):
        node = self.node = Node(BUILD, server={"max_half_open": LOBBY, "max_sessions": LOBBY,
                                               "max_sessions_per_address": LOBBY, "connections_per_s": 1000,
                                               "handshake_timeout_ms": 600_000},
                                render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        self.hold = node.folder / "hold"
        self.install_reader(node)
        files = node.folder / "files"
        files.mkdir()
        shutil.copy(node.build / "share/gnomon/scenes/living_room.glb", files / SLOW)
        node.config["scenes"]["allow_files"] = [str(files)]
        node.start()
        self.hold.touch()
        self.sessions = Sessions(node)

    def install_reader(self, node):
        """The program finds its reader beside itself: here one that waits first."""
        tree = node.folder / "tree"
        reader = tree / "libexec/gnomon/gnomon-scene-worker"
        reader.parent.mkdir(parents=True)
        reader.write_text(f"#!/bin/sh\nwhile [ -e {self.hold} ]; do sleep 0.05; done\n"
                          f"exec {node.build}/libexec/gnomon/gnomon-scene-worker\n")
        reader.chmod(0o755)
        (tree / "bin").mkdir()
        shutil.copy(node.bin / "gnomond", tree / "bin")
        (tree / "share").symlink_to(node.build / "share")
        for program in ("gnomonctl", "gnomon-load"):
            (tree / "bin" / program).symlink_to(node.bin / program)
        node.bin = tree / "bin"

    def refused(self, reason):
        return self.node.metric("gnomon_refusals_total", reason=reason)

    def test_one_address_pushes_out_nobody_who_was_let_in(self):
        """And no other stranger either."""
        outcome = []
        waiting = threading.Thread(target=lambda: outcome.append(self.sessions.open(scene=SLOW)))
        waiting.start()
        eventually(self.reader_runs, "a reader of the slow scene")
        other = socket.create_connection(self.sessions.server)
        self.addCleanup(other.close)
        strangers = []
        while self.refused("half_open_replaced") < 4 * LOBBY:
            stranger = socket.socket()
            self.addCleanup(stranger.close)
            stranger.bind(("127.0.0.5", 0))
            stranger.connect(self.sessions.server)
            strangers.append(stranger)
            if self.refused("connection_rate"):
                time.sleep(0.01)
        other.setblocking(False)
        with self.assertRaises(BlockingIOError, msg="an older stranger of another address keeps its place"):
            other.recv(1)
        self.hold.unlink()
        waiting.join()
        print(f"{len(strangers)} silent connections of one address, {self.refused('half_open_replaced'):.0f} of them "
              "pushed out by their own, beside a client that waits for its scene")
        self.assertEqual(len(outcome), 1, "the client that waited was let in")
        outcome[0].close()

    def reader_runs(self):
        children = subprocess.run(["ps", "--ppid", str(self.node.process.pid), "-o", "args="], text=True,
                                  stdout=subprocess.PIPE).stdout
        return "gnomon-scene-worker" in children

    def test_places_are_free_as_soon_as_their_clients_have_gone(self):
        self.node.config["tenants"] = [{"name": "studio"}, {"name": "arcade", "max_sessions": 0}]
        self.node.write_config()
        self.assertEqual(self.node.ctl("reload")[0], 0)
        for _ in range(LOBBY):
            self.sessions.ask(scene=SLOW, tenant="arcade").socket.close()
        patient = self.sessions.ask(scene=SLOW, tenant="studio")
        eventually(self.reader_runs, "a reader of the slow scene")
        waiting = []
        while not self.refused("too_many_sessions"):
            waiting.append(self.sessions.ask(scene=SLOW, tenant="arcade"))
        self.assertTrue(self.is_full())
        for control in waiting:
            control.socket.close()
        eventually(lambda: not self.is_full(), "places are free")
        self.assertTrue(self.reader_runs(), "while the scene is still being read, for who waits")
        patient.socket.close()
        eventually(lambda: not self.reader_runs(), "nothing is read for whom nobody waits")
        session = self.sessions.open(tenant="studio")
        session.picture(session.welcome.scene.default_camera)
        session.close()

    def is_full(self):
        try:
            self.sessions.open(tenant="studio").close()
        except RefusedBy as refusal:
            self.assertEqual(refusal.refused.code, messages.Refusal.TOO_MANY_SESSIONS)
            return True
        return False

    def test_a_tenant_finds_its_places_whatever_another_takes(self):
        greedy = []
        with self.assertRaises(RefusedBy) as refusal:
            while len(greedy) <= LOBBY:
                greedy.append(self.sessions.open(tenant="arcade"))
        self.assertIn("what is left is for others", str(refusal.exception))
        print(f"one of two tenants got {len(greedy)} of {LOBBY} places")
        self.assertLess(len(greedy), LOBBY)
        for session in greedy[LOBBY // 2:]:  # of the address's
            session.close()
        self.sessions.open(tenant="studio").close()


class Memory(unittest.TestCase):
    """What sessions make the host keep is predicted, shared among tenants, and never more than was predicted."""

    LIMIT_MB = 96
    SIZE = 1280, 720

    def setUp(self):
        self.node = Node(BUILD, server={"max_session_memory_mb": self.LIMIT_MB}, render={"tracer": "bvh"})
        self.addCleanup(self.node.__exit__)
        self.node.start()
        self.sessions = Sessions(self.node)

    def open(self, tenant):
        host, port = self.sessions.server
        session = Session(host, port, self.node.pin, messages.Hello(
            scene=QUICK, width=self.SIZE[0], height=self.SIZE[1], tenant=tenant, codecs=(CONTEXT,),
            features=messages.PATHS | messages.REFERENCES))
        self.addCleanup(session.abandon)
        return session

    def account(self):
        return self.node.status()["session_memory"]

    def test_a_tenant_has_its_part_whatever_another_hoards(self):
        before = self.account()
        self.assertEqual(before["bytes"], 0)
        self.assertEqual(before["limit_bytes"], self.LIMIT_MB << 20)
        greedy = []
        with self.assertRaises(RefusedBy) as refusal:
            while len(greedy) < 1000:
                greedy.append(self.open("arcade"))
        refused = refusal.exception.refused
        self.assertEqual(refused.code, messages.Refusal.OVER_CAPACITY)
        self.assertIn("host memory", refused.text)
        taken = self.account()["bytes"]
        self.assertLessEqual(taken, before["limit_bytes"] * 3 / 4, "a quarter of all is reserved for the other tenant")
        self.assertEqual(self.node.metric("gnomon_account_bytes", account="sessions"), taken)
        other = [self.open("studio")]
        self.assertEqual(sum(t["session_memory_bytes"] for t in self.node.status()["tenants"]), self.account()["bytes"])
        print(f"{len(greedy)} sessions of one tenant in {taken >> 20} of {self.LIMIT_MB} MiB, then those of another")
        for session in greedy + other:
            session.close()
        eventually(lambda: self.account()["bytes"] == 0, "all given back")

    @unsanitized(BUILD, "takes memory of its own")
    def test_hoarders_take_no_more_than_was_predicted(self):
        """They keep every reference alive, and say of no slice that it has arrived."""
        first = self.open("arcade")
        first.picture(first.welcome.scene.default_camera)  # what the first frame makes for all
        first.close()
        eventually(lambda: self.account()["bytes"] == 0, "the first one given back")
        hoarders = [self.open("arcade") for _ in range(4)]
        before, predicted = self.node.metric("process_resident_memory_bytes"), self.account()["bytes"]
        until = time.monotonic() + 8
        while time.monotonic() < until:
            for session in hoarders:
                camera = session.welcome.scene.default_camera
                x, y, z = camera.position
                session.number += 1
                moved = dataclasses.replace(camera, position=(x + 0.02 * session.number, y, z))
                session._send(Kind.CAMERA_UPDATE, camera_update(session.number, moved, 0, 0, [], session.number - 1))
                session.poll(0.02)  # answers challenges
        grown = self.node.metric("process_resident_memory_bytes") - before
        print(f"{len(hoarders)} sessions took {grown / 1e6:.1f} MB; {predicted / 1e6:.1f} MB were predicted")
        self.assertLessEqual(grown, predicted)


def certificate(folder, name, days=30.0):
    """Writes a server's certificate that lasts so long, negative: that has expired, and its key."""
    key = ec.generate_private_key(ec.SECP256R1())
    subject = x509.Name([x509.NameAttribute(x509.NameOID.COMMON_NAME, name)])
    now = datetime.datetime.utcnow()
    made = (x509.CertificateBuilder().subject_name(subject).issuer_name(subject).public_key(key.public_key())
            .serial_number(x509.random_serial_number()).not_valid_before(now - datetime.timedelta(days=60))
            .not_valid_after(now + datetime.timedelta(days=days)).sign(key, hashes.SHA256()))
    (folder / f"{name}.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    file = folder / f"{name}-key.pem"
    file.touch(0o600)
    file.write_bytes(key.private_bytes(serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8,
                                       serialization.NoEncryption()))


class Credentials(unittest.TestCase):
    def setUp(self):
        node = self.node = Node(BUILD, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        self.tokens = {}
        for tenant in ("studio", "arcade"):
            made = subprocess.run([node.bin / "gnomonctl", "make-token"], text=True, stdout=subprocess.PIPE).stdout
            self.tokens[tenant], token_hash = re.findall(r"\b(?:gnomon_)?[0-9a-f]{64}\b", made)
            for entry in node.config["tenants"]:
                if entry["name"] == tenant:
                    entry["token_sha256"] = [token_hash]
        certificate(node.folder, "server")
        node.config["server"].update(mode="production",
                                     tls={"certificate": "server.pem", "key": "server-key.pem"})
        node.start()
        self.sessions = Sessions(node)

    def open(self, tenant, features=messages.RESUME):
        return self.sessions.open(tenant=tenant, token=self.tokens[tenant], features=features)

    def revoke(self, tenant):
        for entry in self.node.config["tenants"]:
            if entry["name"] == tenant:
                entry["token_sha256"] = ["0" * 64]
        self.node.write_config()

    def farewell(self, session):
        """What the server says at the end."""
        with self.assertRaises(Closed) as closed:
            session.listen(60)
        return str(closed.exception)

    def test_a_revoked_token_ends_its_sessions_and_is_not_resumed(self):
        revoked, kept = self.open("studio"), self.open("arcade")
        revoked.picture(revoked.welcome.scene.default_camera)
        self.revoke("studio")
        code, said = self.node.ctl("reload")
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r"^reloaded\ntenants\.studio\.token_sha256: \d added, 1 removed\n")
        self.assertIn("its token was revoked", self.farewell(revoked))
        with self.assertRaises(RefusedBy):
            revoked.resume()
        with self.assertRaises(RefusedBy):
            self.open("studio")
        kept.picture(kept.welcome.scene.default_camera)
        kept.resume()
        kept.picture(kept.welcome.scene.default_camera)
        kept.close()

    def test_what_expired_or_is_missing_keeps_no_reload_from_the_rest(self):
        node, session = self.node, self.open("studio")
        certificate(node.folder, "server", days=-1)
        node.config["scenes"]["list"].append({"name": "gone", "file": "gone.glb"})
        self.revoke("studio")
        status, said = node.ctl("reload")
        self.assertEqual(status, 1)
        for part in ("server.tls.certificate", "has expired", "gone.glb"):
            self.assertIn(part, said)
        self.assertIn("its token was revoked", self.farewell(session))
        self.assertIn("configuration reloaded in part", node.log_text())
        self.assertEqual(node.metric("gnomon_config_reloads_total", result="failed"), 1)
        kept = self.open("arcade")  # by the certificate that the daemon has had all the time
        kept.picture(kept.welcome.scene.default_camera)
        kept.close()
        check = [node.bin / "gnomond", "--config", node.folder / "gnomond.json", "--check-config"]
        self.assertEqual(subprocess.run(check, stderr=subprocess.DEVNULL).returncode, 1)
        self.assertEqual(subprocess.run([*check, "--for-reload"], stderr=subprocess.DEVNULL).returncode, 0)

    def test_operators_see_the_date_and_a_daemon_with_an_expired_certificate_can_be_mended(self):
        node = self.node
        date = node.metric("gnomon_certificate_expiry_timestamp_seconds")
        self.assertIn(round((date - time.time()) / 86400), (29, 30, 31))
        self.assertRegex(node.ctl("status")[1], r"server\.tls\.certificate expires in (29|30) days")
        self.assertIn("a certificate expires soon", node.log_text())
        node.stop()
        certificate(node.folder, "server", days=-1)
        node.start()
        self.assertIn("has expired: clients refuse it", node.log_text())
        self.assertIn("server.tls.certificate has EXPIRED", node.ctl("status")[1])
        certificate(node.folder, "server", days=200)
        self.assertEqual(node.ctl("reload")[0], 0)
        self.assertRegex(node.ctl("status")[1], r"server\.tls\.certificate expires in (199|200) days")


if __name__ == "__main__":
    unittest.main(verbosity=2)
