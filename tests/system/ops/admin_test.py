#!/usr/bin/env python3
"""Who may do what over the admin server: gnomonctl over TCP with the token of admin.token_file, with another one and
with none, and without an address.

    admin_test.py BUILD
"""
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from node import Node, eventually

BUILD = sys.argv.pop(1)
TOKEN = "the operators' token"
NEXT_TOKEN = "the operators' next token"
TRIANGLE = "data:application/octet-stream;base64,AACAvwAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"


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
        for command in (("reload",), ("scene", "unload", "living_room"), ("device", "drain", "0"), ("drain",),
                        ("undrain",), ("stop",)):
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
        self.assertEqual(self.over_tcp("stop", "--token-file", right)[0], 0)
        self.assertEqual(node.wait(), 0)
        self.assertNotIn(TOKEN, node.log_text())

    def test_what_is_written_wrong_is_said_and_asks_nobody(self):
        for words, said in ((("sessoins",), "no command 'sessoins'; did you mean sessions?"),
                            (("scene", "lod", "temple"), "no command 'lod'; did you mean load?"),
                            (("frobnicate",), "there are: "),
                            (("quit",), "there are: "),
                            (("kick", "abc"), "'abc' is no number"),
                            (("kick", "1", "--for", "soon"), "--for"),
                            ((), "subcommand is required")):
            code, output = self.node.ctl(*words)
            self.assertEqual(code, 2, (words, output))
            self.assertIn(said, output, words)

    def test_who_does_not_answer(self):
        code, said = self.node.ctl("status", admin="http://127.0.0.1:9")
        self.assertEqual((code, said), (1, "gnomonctl: http://127.0.0.1:9 does not answer: Connection refused\n"))
        code, said = self.node.ctl("status", admin=f"unix:{self.node.folder}/nothing")
        self.assertEqual(code, 1)
        self.assertIn("/nothing does not answer: No such file or directory", said)

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
            self.assertEqual(self.bare_ctl("reload", **environment), (0, "reloaded; no key has changed\n"))
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


class JsonLog(unittest.TestCase):
    def test_every_line_of_a_start_is_json_the_ready_line_too(self):
        node = Node(BUILD, log={"format": "json"}, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        node.start()
        lines = [json.loads(line) for line in node.log_text().splitlines()]
        ready, = (line for line in lines if line["event"] == "gnomond ready")
        self.assertEqual(list(ready), ["time", "level", "event", "control", "data", "admin", "pin", "socket"])
        self.assertRegex(ready["control"], r"^127\.0\.0\.1:\d+$")
        self.assertEqual(ready["socket"], node.socket)
        self.assertEqual(node.code("/readyz"), 200)


class NotReady(unittest.TestCase):
    def test_status_says_why(self):
        node = Node(BUILD, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        node.start()
        self.assertEqual(node.status()["why_not_ready"], "")
        self.assertNotIn("not ready", node.ctl("status")[1])
        self.assertEqual(node.ctl("drain")[0], 0)
        why = "draining: nobody is admitted (gnomonctl undrain takes it back)"
        self.assertEqual(node.status()["why_not_ready"], why)
        self.assertIn(f"\nnot ready: {why}\n", node.ctl("status")[1])
        self.assertEqual(node.stop(), 0)
        node.start(wait=False)
        asked = lambda: node.ctl("status")[1]
        eventually(lambda: re.search(r"^not ready: (.*; )?scenes are being loaded: living_room", asked(), re.M),
                   "what it waits for at the start")
        node.wait_until_ready()


class AuditOnAFullDisk(unittest.TestCase):
    def test_what_its_file_does_not_take_is_told_and_stands_in_the_log(self):
        node = Node(BUILD, log={"audit_file": "/dev/full"}, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        node.start()
        lines = "gnomon_audit_lines_unwritten_total"
        self.assertTrue(f"\n{lines} 0\n" in node.page("/metrics"), "a series from the start, so that the first line counts")
        self.assertNotIn("audit log", node.ctl("status")[1])
        self.assertEqual(node.ctl("undrain")[0], 0)
        self.assertEqual(node.metric(lines), 1)
        self.assertRegex(node.log_text(), r" audit action operator=\S+ address=socket action=undrain ")
        self.assertRegex(node.log_text(), r' error audit log not written file=/dev/full why="No space left on device"')
        told = "1 line not in the file, but in the daemon's log"
        self.assertEqual(node.status()["audit"], {"unwritten": 1, "why": "No space left on device"})
        self.assertIn(f"audit log NOT WRITTEN: No space left on device; {told}\n", node.ctl("status")[1])
        node.config["log"]["audit_file"] = "audit.log"
        node.write_config()
        self.assertEqual(node.ctl("reload")[0], 0)
        self.assertEqual(node.status()["audit"], {"unwritten": 1, "why": ""})
        self.assertIn(f"audit log: {told}\n", node.ctl("status")[1])


class LightsThatAreNotKept(unittest.TestCase):
    def test_who_changes_one_is_told(self):
        kept = pathlib.Path(tempfile.mkdtemp(prefix="gnomon-lights-"))
        self.addCleanup(shutil.rmtree, kept, ignore_errors=True)
        node = Node(BUILD, render={"tracer": "bvh"})
        self.addCleanup(node.__exit__)
        node.config["scenes"]["lights_file"] = str(kept / "lights.json")
        node.start()
        self.assertEqual(node.ctl("scene", "light", "living_room", "0", "--off"), (0, "accepted\n"))
        self.assertIn("living_room", (kept / "lights.json").read_text())
        shutil.rmtree(kept)
        status, said = node.ctl("scene", "light", "living_room", "1", "--off")
        self.assertEqual(status, 0, said)
        self.assertIn("accepted; not kept for the next start", said)
        self.assertIn("No such file or directory", said)
        checked = subprocess.run([node.bin / "gnomond", "--config", node.folder / "gnomond.json", "--check-config"], text=True,
                                 stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        said = checked.stdout
        self.assertEqual(checked.returncode, 1, said)
        self.assertIn(f"scenes.lights_file: {kept}: No such file or directory", said)


class Reload(unittest.TestCase):
    """Of what is made beside the daemon: what workers log, and what may be kept of light buffers."""

    SCENE = {"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": TRIANGLE}],
             "bufferViews": [{"buffer": 0, "byteLength": 36}],
             "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
             "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "skins": [{"joints": [0]}],
             "nodes": [{"mesh": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [0, 0, 2]}],
             "scenes": [{"nodes": [0, 1]}], "scene": 0, "extensionsUsed": ["KHR_lights_punctual"],
             "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point"}]}}}

    def setUp(self):
        self.node = Node(BUILD, scenes={"list": []}, render={"tracer": "light_buffer"})
        self.addCleanup(self.node.__exit__)
        self.node.start()

    def reload(self):
        self.node.write_config()
        code, said = self.node.ctl("reload")
        self.assertEqual((code, said.splitlines()[0]), (0, "reloaded"))
        return said.splitlines()[1:]

    def events(self, start):
        return [json.loads(line)["event"] for line in self.node.log_text().splitlines()[start:]]

    def test_it_changes_how_the_log_is_written_and_what_the_cache_may_hold(self):
        node = self.node
        (node.folder / "doll.gltf").write_text(json.dumps(self.SCENE))  # of its skin the worker that reads it warns
        node.config["log"] = {"format": "json"}
        node.config["render"]["cache_mb"] = 1  # less than the scene's one light takes
        node.config["scenes"]["list"].append({"name": "doll", "file": "doll.gltf"})
        start = len(node.log_text().splitlines())
        self.assertEqual(self.reload(), ["log.format: (default) -> json", "render.cache_mb: (default) -> 1",
                                         "scenes.list: [] -> (default)", "scenes.list.doll: added",
                                         "scenes.list.doll.file: (default) -> doll.gltf"])
        eventually(lambda: "light buffers ready" in node.log_text(), "the light buffers")
        for event in ("configuration", "configuration reloaded", "skins are left out: their meshes stay as stored",
                      "light buffer not cached"):
            self.assertIn(event, self.events(start))
        self.assertEqual(list(node.cache.glob("*.lightbuffer")), [])
        node.config["render"]["cache_mb"] = 0
        self.reload()
        for what in ("unload", "load"):
            self.assertEqual(node.ctl("scene", what, "doll")[0], 0)
        eventually(lambda: list(node.cache.glob("*.lightbuffer")), "a light buffer that is kept")


if __name__ == "__main__":
    unittest.main(verbosity=2)
