#!/usr/bin/env python3
"""Attacks on the admin server: pages of others (DNS rebinding, cross-site requests), accounts without rights, guessed
tokens, tokens in clear, text that is a command to a terminal; and what the audit log keeps of it all.

    abuse_admin_test.py BUILD
"""
import grp
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import ssl
import subprocess
import sys
import unittest

from node import PATIENCE_S, Node, eventually

BUILD = sys.argv.pop(1)
TOKEN = "0123456789abcdef, the operators' token"
NOBODY = 65534
LIGHT = "/scenes/living_room/lights/0"
EVIL = "a\u009b31m\u202eb\x1b[2J.glb"  # a file's name, which is a command to a terminal
RAW_CONTROLS = re.compile(rb"[\x00-\x09\x0b-\x1f\x7f]|\xc2[\x80-\x9f]|\xe2\x80[\x8e\x8f\xa8-\xae]")


def converse(connection, data):
    """What comes back until the server closes."""
    answer = b""
    with connection:
        connection.settimeout(PATIENCE_S)
        try:
            connection.sendall(data)
            while part := connection.recv(65536):
                answer += part
        except ConnectionError:
            pass  # closed without an answer, or within one
    return answer


def request(method, path, headers, body=b""):
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers.items()),
             f"Content-Length: {len(body)}"]
    return ("\r\n".join(lines) + "\r\n\r\n").encode() + body


def status_of(answer):
    return int(answer[9:12]) if answer.startswith(b"HTTP/1.1 ") else None


def as_account(uid, groups, act):
    """What `act` returns, as JSON, in a child of that account."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            os.setgroups(groups)
            os.setgid(uid)
            os.setuid(uid)
            os.write(writer, json.dumps(act()).encode())
        finally:
            os._exit(0)
    os.close(writer)
    with os.fdopen(reader) as told:
        text = told.read()
    os.waitpid(child, 0)
    return json.loads(text)


class Abuse(unittest.TestCase):
    def node(self, **config):
        node = Node(BUILD, render={"tracer": "bvh"}, **config)
        self.addCleanup(node.__exit__)
        return node

    def write(self, node, name, text):
        file = node.folder / name
        file.touch(0o600)
        file.write_text(text + "\n")
        return str(file)

    def with_token(self, **config):
        node = self.node(**config)
        node.config["admin"]["token_file"] = self.write(node, "token", TOKEN)
        return node.start()

    @staticmethod
    def over_tcp(node, method, path, body=b"", **headers):
        host, port = re.fullmatch(r"https?://(.*):(\d+)", node.admin).groups()
        known = {"Host": f"{host}:{port}", "Content-Type": "application/json"}
        known.update({name.replace("_", "-"): value for name, value in headers.items()})
        return converse(socket.create_connection((host, int(port))), request(method, path, known, body))

    @staticmethod
    def through_socket(path, method, page):
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(path)
        return converse(connection, request(method, page, {"Content-Type": "application/json"}, b"{}"))

    @staticmethod
    def lights_version(node):
        return node.status()["scenes"][0]["lights_version"]

    def audit(self, node, event, **fields):
        """Lines of the audit log that have these fields."""
        wanted = [f" {key}={value}" for key, value in fields.items()]
        lines = (line for line in node.log_text().splitlines() if re.match(rf"\S+ audit {event}\b", line))
        return [line for line in lines if all(field in line + " " for field in wanted)]


class PagesOfOthers(Abuse):
    """In an operator's browser, on the node itself."""

    def setUp(self):
        self.victim = self.with_token()
        self.right = {"Authorization": f"Bearer {TOKEN}"}

    def test_a_name_that_is_bound_to_our_address_shows_nothing(self):
        port = self.victim.admin.rsplit(":", 1)[1]
        for page in ("/", "/status", "/metrics", "/healthz"):
            for host in ("attacker.example", f"attacker.example:{port}", f"127.0.0.1.attacker.example:{port}"):
                self.assertEqual(status_of(self.over_tcp(self.victim, "GET", page, Host=host)), 403, (page, host))
            self.assertEqual(status_of(self.over_tcp(self.victim, "GET", page, Host=f"localhost:{port}")), 200, page)
        nameless = converse(socket.create_connection(("127.0.0.1", int(port))), b"GET /status HTTP/1.0\r\n\r\n")
        self.assertEqual(status_of(nameless), 403)
        self.assertTrue(self.audit(self.victim, "admin request", action="GET", target="/status", reason="host"))

    def test_they_change_nothing(self):
        before = self.lights_version(self.victim)
        port = self.victim.admin.rsplit(":", 1)[1]
        for headers in ({"Host": f"attacker.example:{port}", "Origin": f"http://attacker.example:{port}"},
                        {"Origin": "http://attacker.example"}, {"Origin": "null"},
                        {"Origin": "http://127.0.0.1:3000"}):
            answer = self.over_tcp(self.victim, "POST", LIGHT, b'{"on": false}', **headers, **self.right)
            self.assertEqual(status_of(answer), 403, headers)
        for kind in ("text/plain", "application/x-www-form-urlencoded", "application/jsonp", "application/json-but-not",
                     "text/plain; application/json", ""):
            answer = self.over_tcp(self.victim, "POST", LIGHT, b'{"on": false}', Content_Type=kind, **self.right)
            self.assertEqual(status_of(answer), 415, kind)
        preflight = self.over_tcp(self.victim, "OPTIONS", LIGHT, Origin="http://attacker.example",
                                  Access_Control_Request_Method="POST")
        self.assertNotIn(b"access-control", preflight.lower())
        self.assertEqual(self.lights_version(self.victim), before)

        answer = self.over_tcp(self.victim, "POST", LIGHT, b'{"on": false}', Origin=self.victim.admin,
                               Content_Type="Application/JSON; charset=utf-8", **self.right)
        self.assertEqual(status_of(answer), 202, "a page of ours with the token")
        eventually(lambda: self.lights_version(self.victim) > before, "the change")


class Neighbours(Abuse):
    """Other accounts of the machine."""

    def setUp(self):
        if os.geteuid() != 0:
            self.skipTest("only root becomes somebody else")
        self.operators = grp.getgrgid(os.getgid() + 1)
        self.victim = self.node(admin={"group": self.operators.gr_name}).start()
        for folder in (self.victim.folder, self.victim.folder.parent):
            folder.chmod(folder.stat().st_mode | 0o011)  # so that nothing but the socket itself is in their way

    def ask(self, method, page, groups=()):
        return as_account(NOBODY, list(groups),
                          lambda: status_of(self.through_socket(self.victim.socket, method, page)))

    def test_the_socket_does_not_open_to_them(self):
        def connect():
            try:
                socket.socket(socket.AF_UNIX).connect(self.victim.socket)
            except PermissionError:
                return "refused"
            return "connected"
        self.assertEqual(as_account(NOBODY, [], connect), "refused")

    def test_where_it_opens_they_look_and_change_nothing(self):
        os.chmod(self.victim.socket, 0o666)
        self.assertEqual(self.ask("GET", "/status"), 200)
        for page in ("/drain", "/reload", "/sessions/1/kick", LIGHT, "/scenes/living_room/unload", "/devices/0/drain"):
            self.assertEqual(self.ask("POST", page), 403, page)
        self.assertFalse(self.victim.status()["draining"])
        self.assertEqual(self.victim.metric("gnomon_config_reloads_total"), 0)
        self.assertEqual(len(self.audit(self.victim, "admin request", operator=f"nobody({NOBODY})", reason="no_operator")), 6)

    def test_members_of_the_group_are_operators(self):
        self.assertEqual(self.ask("POST", "/reload", [self.operators.gr_gid]), 200)
        self.assertEqual(len(self.audit(self.victim, "action", operator=f"nobody({NOBODY})", action="reload",
                                        result="done")), 1)

    def test_over_tcp_they_change_nothing(self):
        for headers in ({}, {"Authorization": f"Bearer {TOKEN}"}):
            answer = self.over_tcp(self.victim, "POST", "/drain", b"{}", **headers)
            self.assertEqual(status_of(answer), 403)
            self.assertIn(self.victim.socket.encode(), answer)
            self.assertIn(b"admin.token_file", answer)
        code, said = self.victim.ctl("drain", admin=self.victim.admin)
        self.assertEqual(code, 1)
        self.assertIn(self.victim.socket, said)
        self.assertFalse(self.victim.status()["draining"])

    def test_a_second_daemon_does_not_take_the_socket_and_a_killed_ones_is_taken(self):
        second = self.node(admin={"socket": self.victim.socket})
        second.start(wait=False)
        self.assertEqual(second.wait(), 1)
        self.assertIn("another process listens there", second.log_text())
        self.victim.signal(signal.SIGKILL)
        self.victim.wait()
        self.assertTrue(pathlib.Path(self.victim.socket).exists())
        second.start()
        self.assertEqual(second.ctl("reload")[0], 0)


class Guesses(Abuse):
    def test_three_hundred_wrong_tokens(self):
        victim = self.with_token()
        answers = [self.over_tcp(victim, "POST", "/drain", b"{}", Authorization=f"Bearer guess{i}") for i in range(300)]
        statuses = [status_of(answer) for answer in answers]
        looked_at = statuses.count(401)
        print(f"of 300 guesses {looked_at} were looked at")
        self.assertLess(looked_at, 30)
        self.assertEqual(statuses.count(429), 300 - looked_at)
        for answer in answers:
            self.assertEqual(b"Retry-After: " in answer, status_of(answer) == 429)
        self.assertEqual(victim.metric("gnomon_admin_refusals_total", reason="wrong_token"), looked_at)
        self.assertEqual(victim.metric("gnomon_admin_refusals_total", reason="backoff"), 300 - looked_at)
        self.assertEqual(len(self.audit(victim, "admin request", target="/drain", reason="wrong_token")), looked_at)
        self.assertNotIn("guess", victim.log_text(), "what was guessed may be nearly right")

        def long_wait():
            again = self.over_tcp(victim, "POST", "/drain", b"{}", Authorization="Bearer another")
            return int((re.findall(rb"Retry-After: (\d+)", again) or [0])[0]) >= 4
        eventually(long_wait, "a wait in which one more request surely falls")
        right = self.over_tcp(victim, "POST", "/drain", b"{}", Authorization=f"Bearer {TOKEN}")
        self.assertEqual(status_of(right), 429, "nor does a guess that is right get through")
        self.assertFalse(victim.status()["draining"])
        self.assertEqual(victim.ctl("reload")[0], 0, "the socket is not concerned")

    def test_an_endless_guesser_does_not_fill_the_log(self):
        victim = self.with_token()
        for _ in range(2000):
            self.over_tcp(victim, "POST", "/drain", b"{}")
        self.assertGreater(victim.metric("gnomon_admin_refusals_total", reason="no_token"), 1999)
        lines = len(self.audit(victim, "admin request"))
        print(f"2000 requests without a token left {lines} lines")
        self.assertLess(lines, 2000)


class InClear(Abuse):
    def setUp(self):
        self.victim = self.node(admin={"listen": "0.0.0.0"})
        self.certificates = self.victim.folder / "certificates"
        subprocess.run([self.victim.bin / "gnomonctl", "make-certs", "--out", self.certificates, "--host", "127.0.0.1"],
                       check=True, stdout=subprocess.DEVNULL)

    def give_certificate(self):
        self.victim.config["admin"]["tls"] = {"certificate": str(self.certificates / "server.pem"),
                                              "key": str(self.certificates / "server-key.pem")}

    def give_token(self):
        self.victim.config["admin"]["token_file"] = self.write(self.victim, "token", TOKEN)

    def complaint(self):
        checked = subprocess.run([self.victim.bin / "gnomond", "--config", self.victim.write_config(), "--check-config"],
                                 text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.victim.start(wait=False)
        self.assertEqual((checked.returncode, self.victim.wait()), (1, 1), checked.stdout + self.victim.log_text())
        self.assertIn(checked.stdout.strip(), self.victim.log_text())
        return checked.stdout

    def test_off_loopback_it_does_not_start_without_token_and_tls(self):
        self.assertIn("admin.token_file", self.complaint())
        self.give_token()
        self.assertIn("admin.tls.certificate", self.complaint())
        self.victim.config["admin"].pop("token_file")
        self.give_certificate()
        self.assertIn("admin.token_file", self.complaint())

    def test_off_loopback_nothing_is_said_in_clear_and_the_status_needs_the_token(self):
        self.give_token()
        self.give_certificate()
        self.victim.start()
        port = int(self.victim.admin.rsplit(":", 1)[1])
        ours = subprocess.run(["hostname", "-I"], text=True, stdout=subprocess.PIPE).stdout.split()
        elsewhere = next((address for address in ours if ":" not in address), None)
        if not elsewhere:
            self.skipTest("this machine has no address but loopback")

        def ask(method, page, **headers):
            trust = ssl.create_default_context(cafile=self.certificates / "ca.pem")
            connection = trust.wrap_socket(socket.create_connection((elsewhere, port)), server_hostname="127.0.0.1")
            return converse(connection, request(method, page, {"Host": f"{elsewhere}:{port}", **headers,
                                                               "Content-Type": "application/json"}, b"{}"))
        right = {"Authorization": f"Bearer {TOKEN}"}
        self.assertEqual(status_of(ask("GET", "/metrics")), 200)
        self.assertEqual(status_of(ask("GET", "/status")), 401)
        self.assertEqual(status_of(ask("GET", "/status", **right)), 200)
        self.assertEqual(status_of(ask("POST", "/devices/0/resume")), 401)
        self.assertEqual(status_of(ask("POST", "/devices/0/resume", **right)), 200)

        in_clear = converse(socket.create_connection((elsewhere, port)),
                            request("POST", "/drain", {"Host": f"{elsewhere}:{port}", **right}, b"{}"))
        self.assertNotIn(b"HTTP", in_clear)
        token = self.victim.config["admin"]["token_file"]
        code, said = self.victim.ctl("--token-file", token, "status", admin=f"http://{elsewhere}:{port}")
        self.assertEqual(code, 1)
        self.assertIn("in clear", said)
        authority = str(self.certificates / "ca.pem")
        code, said = self.victim.ctl("--token-file", token, "--ca", authority, "reload",
                                     admin=f"https://127.0.0.1:{port}")
        self.assertEqual((code, said), (0, "reloaded; no key has changed\n"))


class Audit(Abuse):
    def test_commands_to_a_terminal_reach_neither_log_nor_terminal(self):
        victim = self.node(scenes={"allow_files": ["files"]})
        (victim.folder / "files").mkdir()
        shutil.copy(victim.build / "share/gnomon/scenes/living_room.glb", victim.folder / "files" / EVIL)
        victim.start()
        status, told = victim.ctl("scene", "load", EVIL)
        self.assertEqual(status, 0, told)
        self.assertTrue(told.endswith("loaded\n"), told)  # after lines of progress, if it took long
        victim.ctl("kick", "1", "--why", EVIL)
        victim.ctl("scene", "load", EVIL + "?")
        self.over_tcp(victim, "GET", "/status", Host="a\u009b31m")
        self.assertTrue(self.audit(victim, "action", action='"load scene"', result="done"))
        raw = victim.log_file.read_bytes()
        self.assertIsNone(RAW_CONTROLS.search(raw), raw)
        for command in (("scene", "list"), ("status",), ("scene", "list", "--json"), ("top", "--count", "1")):
            shown = subprocess.run([victim.bin / "gnomonctl", "--admin", f"unix:{victim.socket}", *command],
                                   stdout=subprocess.PIPE, stderr=subprocess.STDOUT).stdout
            self.assertIsNone(RAW_CONTROLS.search(shown), (command, shown))
        self.assertIn("u009b31m", victim.ctl("scene", "list")[1])

    def test_every_action_has_its_line(self):
        victim = self.with_token()
        token = victim.config["admin"]["token_file"]
        me = f"root({os.getuid()})" if os.getuid() == 0 else rf"\w+({os.getuid()})"
        victim.ctl("kick", "77", "--why", "too loud")
        self.assertEqual(victim.ctl("device", "resume", "0")[0], 0)
        self.assertEqual(victim.ctl("--token-file", token, "scene", "unload", "living_room", admin=victim.admin)[0], 0)
        kick, = self.audit(victim, "action", action="kick", target="77", result="refused")
        self.assertIn(f"operator={me} address=socket", kick)
        self.assertIn('reason="no such session"', kick)
        self.assertIn("too loud", kick)
        self.assertEqual(len(self.audit(victim, "action", action='"resume device"', target="0", result="done")), 1)
        unload, = self.audit(victim, "action", action='"unload scene"', target="living_room", result="done")
        self.assertRegex(unload, r"operator=token address=127\.0\.0\.1:\d+ ")
        self.assertNotIn(TOKEN, victim.log_text())

    def test_reloads_say_what_they_changed_in_a_file_that_is_rotated(self):
        victim = self.node(log={"audit_file": "audit.log", "level": "error"}, tenants=[{"name": "studio", "weight": 1}])
        file, rotated = victim.folder / "audit.log", victim.folder / "audit.log.1"
        victim.start()
        victim.config["tenants"] = [{"name": "studio", "weight": 3, "token_sha256": ["ab" * 32]}, {"name": "museum"}]
        victim.write_config()
        self.assertEqual(victim.ctl("reload")[0], 0)
        self.assertIn('audit configuration asked_by=operator result=done changes="tenants.museum: added, '
                      'tenants.studio.token_sha256: 1 added, 0 removed, tenants.studio.weight: 1 -> 3"', file.read_text())
        self.assertNotIn("ab" * 6, file.read_text() + victim.log_text())  # a random pin may have a shorter run
        self.assertNotIn(" audit ", victim.log_text())

        file.rename(rotated)
        victim.signal(signal.SIGHUP)
        eventually(file.exists, "a new file")
        eventually(lambda: "asked_by=SIGHUP" in file.read_text(), "its line")
        self.assertNotIn("SIGHUP", rotated.read_text())
        victim.config["tenants"][0]["weight"] = -1
        victim.write_config()
        self.assertEqual(victim.ctl("reload")[0], 1)
        refused = [line for line in file.read_text().splitlines() if "audit configuration" in line][-1]
        self.assertIn("result=refused", refused)
        self.assertIn("weight", refused)

    def test_clients_that_fail_to_prove_who_they_are(self):
        victim = self.node(server={"mode": "production", "tls": {}}, tenants=[{"name": "studio"}])
        folder = victim.folder / "certificates"
        subprocess.run([victim.bin / "gnomonctl", "make-certs", "--out", folder, "--host", "127.0.0.1"], check=True,
                       stdout=subprocess.DEVNULL)
        made = subprocess.run([victim.bin / "gnomonctl", "make-token"], text=True, stdout=subprocess.PIPE).stdout
        token, token_hash = re.search(r"token +(\w+)\ntoken_sha256 +(\w+)", made).groups()
        victim.config["server"]["tls"] = {"certificate": str(folder / "server.pem"), "key": str(folder / "server-key.pem")}
        victim.config["tenants"][0]["token_sha256"] = [token_hash]
        victim.start()
        wrong = self.write(victim, "wrong", token[:-1])
        subprocess.run([victim.bin / "gnomon-client", "--server", victim.control, "--ca", folder / "ca.pem", "--tenant",
                        "studio", "--token-file", wrong, "--scene", "living_room", "--size", "64x64", "--frames", "1"],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        refused, = self.audit(victim, '"?client refused"?', reason="bad_token")
        self.assertRegex(refused, r"address=127\.0\.0\.1")
        self.assertNotIn(token[:-1], victim.log_text())


if __name__ == "__main__":
    unittest.main(verbosity=2)
