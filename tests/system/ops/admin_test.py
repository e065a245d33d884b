#!/usr/bin/env python3
"""Who may do what over the admin server: gnomonctl with the token of admin.token_file, with another one and with none.

    admin_test.py BUILD
"""
import signal
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

    def test_the_token_is_for_those_who_change_something(self):
        node, wrong, right = self.node, self.write("wrong", TOKEN + "?"), self.node.config["admin"]["token_file"]
        for command in (("reload",), ("scene", "unload", "living_room"), ("device", "drain", "0"), ("drain",)):
            for shown in ((), ("--token-file", wrong)):
                code, said = node.ctl(*command, *shown)
                self.assertEqual(code, 1, command)
                self.assertIn("admin.token_file", said)
        self.assertEqual(node.ctl("reload", "--token-file", str(node.folder / "nothing"))[0], 1)
        self.assertFalse(node.status()["draining"])
        self.assertEqual(node.ctl("status")[0], 0, "looking needs none")
        self.assertEqual(node.metric("gnomon_config_reloads_total"), 0)
        self.assertEqual(node.ctl("reload", "--token-file", right)[0], 0)
        self.assertEqual(node.metric("gnomon_config_reloads_total", result="done"), 1)
        self.rotate(right)
        self.assertEqual(node.ctl("drain", "--token-file", right)[0], 0)
        self.assertEqual(node.wait(), 0)
        self.assertNotIn(TOKEN, node.log_text())

    def rotate(self, file):
        """The token is another one from a SIGHUP on; a file that is none leaves things as they are."""
        node, old = self.node, self.write("old", TOKEN)
        self.write("token", NEXT_TOKEN)
        node.signal(signal.SIGHUP)
        eventually(lambda: node.metric("gnomon_config_reloads_total", result="done") == 2, "the reload")
        self.assertEqual(node.ctl("reload", "--token-file", old)[0], 1)
        self.write("token", "short")
        node.signal(signal.SIGHUP)
        eventually(lambda: node.metric("gnomon_config_reloads_total", result="failed") == 1, "the mistake")
        self.assertIn("admin.token_file", node.log_text())
        self.write("token", NEXT_TOKEN)
        self.assertEqual(node.ctl("reload", "--token-file", file)[0], 0)


if __name__ == "__main__":
    unittest.main(verbosity=2)
