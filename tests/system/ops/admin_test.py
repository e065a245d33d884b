#!/usr/bin/env python3
"""Who may do what over the admin server: gnomonctl over TCP with the token of admin.token_file, with another one and
with none, and without an address.

    admin_test.py BUILD
"""
import os
import signal
import subprocess
import sys
import unittest

from node import Node, eventually

BUILD = sys.argv.pop(1)
TOKEN = "the operators' token"
NEXT_TOKEN = "the operators' next token"


class Admin(unittest.TestCase):
    def setUp(self):
        self.node = Node(BUILD)
        self.addCleanup(self.node.__exit__)
        self.node.config["admin"]["token_file"] = self.write("token", TOKEN)
        self.node.start()

    def write(self, name, text):
        file = self.node.folder / name
        file.touch(0o600)
        file.write_text(text + "\n")
        return str(file)

    def over_tcp(self, *arguments):
        return self.node.ctl(*arguments, admin=self.node.admin)

    def test_the_token_is_for_those_who_change_something(self):
        node, wrong, right = self.node, self.write("wrong", TOKEN + "?"), self.node.config["admin"]["token_file"]
        for command in (("reload",), ("scene", "unload", "living_room"), ("device", "drain", "0"), ("drain",)):
            code, said = self.over_tcp(*command)
            self.assertEqual(code, 1, command)
            self.assertIn("admin.token_file", said)
            self.assertIn(node.socket, said)
        code, said = self.over_tcp("drain", "--token-file", wrong)
        self.assertEqual(code, 1)
        self.assertIn("admin.token_file", said)
        self.assertEqual(self.over_tcp("reload", "--token-file", str(node.folder / "nothing"))[0], 1)
        self.assertFalse(node.status()["draining"])
        self.assertEqual(self.over_tcp("status")[0], 0, "looking needs none")
        self.assertEqual(node.metric("gnomon_config_reloads_total"), 0)
        self.assertEqual(self.over_tcp("reload", "--token-file", right)[0], 0)
        self.assertEqual(node.metric("gnomon_config_reloads_total", result="done"), 1)
        self.rotate(right)
        self.assertEqual(self.over_tcp("drain", "--token-file", right)[0], 0)
        self.assertEqual(node.wait(), 0)
        self.assertNotIn(TOKEN, node.log_text())

    def bare_ctl(self, *arguments, **environment):
        """gnomonctl as people call it: exit status, output."""
        kept = {"PATH": os.environ["PATH"], **environment}
        done = subprocess.run([self.node.bin / "gnomonctl", *arguments], text=True, env=kept, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT)
        return done.returncode, done.stdout

    def test_without_an_address_it_finds_the_socket_of_its_environment(self):
        node = self.node
        node.stop()
        node.config["admin"]["socket"] = "auto"
        runtime = node.folder / "runtime"
        runtime.mkdir(0o700)
        for environment in ({"RUNTIME_DIRECTORY": str(node.folder)}, {"XDG_RUNTIME_DIR": str(runtime)}):
            node.environment = {**os.environ, **environment}
            node.start()
            self.assertEqual(self.bare_ctl("reload", **environment), (0, "reloaded\n"))
            self.assertEqual(node.stop(), 0)
        self.assertFalse(any(node.folder.rglob("admin.sock")), "removed at the end")
        code, said = self.bare_ctl("status", **environment)
        if code == 1:  # nobody answers at the usual port of this machine either
            self.assertIn(str(runtime / "gnomon" / "admin.sock"), said)
            self.assertIn("--admin", said)

    def rotate(self, file):
        """The token is another one from a SIGHUP on; a file that is none leaves things as they are."""
        node, old = self.node, self.write("old", TOKEN)
        self.write("token", NEXT_TOKEN)
        node.signal(signal.SIGHUP)
        eventually(lambda: node.metric("gnomon_config_reloads_total", result="done") == 2, "the reload")
        self.assertEqual(self.over_tcp("reload", "--token-file", old)[0], 1)
        self.write("token", "short")
        node.signal(signal.SIGHUP)
        eventually(lambda: node.metric("gnomon_config_reloads_total", result="failed") == 1, "the mistake")
        self.assertIn("admin.token_file", node.log_text())
        self.write("token", NEXT_TOKEN)
        self.assertEqual(self.over_tcp("reload", "--token-file", file)[0], 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
