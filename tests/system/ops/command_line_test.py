#!/usr/bin/env python3
"""The programs' command lines: what their help, manual pages and completion say of each other, exit statuses, and what is
said to somebody who is wrong.

    command_line_test.py SOURCE BUILD
"""
import csv
import json
import os
import pathlib
import pty
import re
import select
import subprocess
import sys
import tempfile
import time
import unittest

from node import Node, eventually

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)).resolve(), pathlib.Path(sys.argv.pop(1)).resolve()
PAGES = {"gnomond": "gnomond.8", "gnomonctl": "gnomonctl.8", "gnomon-client": "gnomon-client.1",
         "gnomon-load": "gnomon-load.1"}
OPTION = re.compile(r"--[a-z][a-z-]*")
# Those whose default a help must name: (program, commands before it, option).
WITH_DEFAULT = [("gnomon-client", (), "--mode"), ("gnomon-client", (), "--frames"), ("gnomon-client", (), "--ahead"),
                ("gnomon-load", (), "--seconds"), ("gnomon-load", (), "--rate"), ("gnomon-load", (), "--transport"),
                ("gnomonctl", ("top",), "--interval"), ("gnomonctl", ("init",), "--port"),
                ("gnomonctl", ("make-certs",), "--days")]


def run(program, *arguments, **more):
    done = subprocess.run([BUILD / "bin" / program, *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, timeout=120, **more)
    return done.returncode, done.stdout


def helps(program, commands=()):
    """The help of the program and of every command below it, by the commands that lead there."""
    status, text = run(program, *commands, "--help")
    assert status == 0, text
    found = {commands: text}
    below = text.split("Subcommands:")
    for name in re.findall(r"^  ([a-z][a-z-]*)", below[1], re.M) if len(below) > 1 else []:
        found.update(helps(program, (*commands, name)))
    return found


def options(program):
    """Declared ones, each at the beginning of its line."""
    return {option for text in helps(program).values()
            for line in re.findall(r"^  (?:-\w,)?(--.*)", text, re.M) for option in OPTION.findall(line.split()[0])}


def page(program):
    return (SOURCE / "deploy/man" / PAGES[program]).read_text().replace("\\-", "-")


class Documents(unittest.TestCase):
    def test_manual_pages_name_every_option_and_no_other(self):
        for program in PAGES:
            body = page(program)
            named = set(OPTION.findall(body.split(".SH EXAMPLES")[0]))
            self.assertEqual(options(program) - named, set(), f"{PAGES[program]} lacks options of {program}")
            self.assertEqual(named - options(program), set(), f"{PAGES[program]} has options that {program} has not")
            for section in ("SYNOPSIS", "EXIT STATUS", "EXAMPLES", "SEE ALSO"):
                self.assertIn(f".SH {section}\n", body, PAGES[program])

    def test_manual_pages_name_every_command(self):
        for commands in helps("gnomonctl"):
            if commands:
                self.assertRegex(page("gnomonctl"), rf"(?m)^\.B[RI]* .*\b{' '.join(commands)}", commands)

    def test_completion_offers_every_option(self):
        for program in PAGES:
            file = SOURCE / "deploy/completion" / program
            offered = set(OPTION.findall(file.read_text()))
            self.assertEqual(options(program) - offered, set(), file.name)
            function = "_" + program.replace("-", "_")
            script = f"source {file}; COMP_WORDS=({program} --); COMP_CWORD=1; {function}; echo ${{COMPREPLY[*]}}"
            done = subprocess.run(["bash", "-c", script], text=True, capture_output=True, check=True)
            self.assertIn("--help", done.stdout, program)
            self.assertEqual(done.stderr, "")

    def test_help_shows_defaults_and_what_kind_of_value(self):
        for program, commands, option in WITH_DEFAULT:
            text = helps(program, commands)[commands]
            entry = re.search(rf"{option}\b.*?(?=\n  -|\n\n|\Z)", text, re.S).group(0)
            self.assertRegex(entry, r"=\S+", f"{program}: no default")
        for program in PAGES:
            for commands, text in helps(program).items():
                self.assertNotRegex(text, r"--(?!why|for)\S+ (TEXT|UINT|INT|FLOAT)\b", f"{program} {commands}")

    def test_what_the_examples_run_is_understood(self):
        """But for what is not there: no line of them is a wrong usage."""
        for program in PAGES:
            text = re.sub(r"\\e\n", " ", page(program).split(".SH EXAMPLES")[1].split(".SH SEE ALSO")[0])
            lines = [line.split("&")[0].split() for line in text.splitlines() if line.startswith(program + " ")]
            self.assertTrue(lines, f"{program} has no example")
            for _, *arguments in lines:
                checked = [option for option in arguments if option.startswith("--")]
                self.assertEqual([option for option in checked if option not in options(program)], [])


class ExitStatuses(unittest.TestCase):
    def test_versions_and_help(self):
        for program in PAGES:
            status, text = run(program, "--version")
            self.assertEqual(status, 0, text)
            self.assertRegex(text, rf"^{program} \d+\.\d+\.\d+\n$")
            self.assertEqual(run(program, "--help")[0], 0)

    def test_wrong_usage_is_2(self):
        for program in PAGES:
            for arguments in (["--no-such-option"], []):
                status, text = run(program, *arguments)
                self.assertEqual(status, 2, f"{program} {arguments}: {text}")
                self.assertNotEqual(text, "")
        for arguments in (("top", "--interval", "0"), ("scene",), ("kick",)):
            self.assertEqual(run("gnomonctl", *arguments)[0], 2, arguments)
        self.assertEqual(run("gnomon-load", "--server", "h:1", "--scene", "s", "--size", "8x8", "--rate", "-1")[0], 2)

    def test_wrong_usage_that_shows_in_a_value_is_2_too(self):
        client = ("--server", "h:1", "--scene", "s", "--size", "8x8")
        wrong = {"gnomon-client": (("--size", "abc"), ("--mode", "nonsense"), ("--server", "h"), ("--border", "1"),
                                   ("--codec", "zip"), ("--transport", "post"), ("--antialias", "3x"), ("--view", "all"),
                                   ("--view", "mask"), ("--record-view", "none"), ("--record-view", "side-by-side"),
                                   ("--soft-filter",), ("--soft-accumulate",)),
                 "gnomon-load": (("--size", "abc"), ("--server", "h"), ("--codec", "zip"), ("--transport", "post"),
                                 ("--clients", "few"), ("--tenant", "a:b"), ("--tenant", "a::2", "--clients", "3"), ())}
        for program, cases in wrong.items():
            for case in cases:
                said = [word for option, value in zip(client[::2], client[1::2]) if option not in case
                        for word in (option, value)]
                more = ("--clients", "1") if program == "gnomon-load" and case and case[0] not in ("--clients", "--tenant") else ()
                status, text = run(program, *said, *case, *more)
                self.assertEqual(status, 2, f"{program} {case}: {text}")
                self.assertTrue(text.startswith(program + ": "), text)
        for arguments in (("--admin", "nowhere", "status"), ("--fleet", "n1", "sessions"), ("--fleet", "=x", "status"),
                          ("--fleet", "n1=http://127.0.0.1:1", "drain", "--node", "n2"), ("scene", "light", "a", "0"),
                          ("scene", "lights", "--file", "x"), ("fleet", "haproxy", "--node", "n1"), ("init",),
                          ("init", "--host", "edge", "--tenant", "a/b"), ("init", "--host", "edge", "--scene", "nowhere"),
                          ("init", "--host", "edge", "--listen", "everywhere")):
            status, text = run("gnomonctl", *arguments)
            self.assertEqual(status, 2, f"{arguments}: {text}")
        for program in ("gnomon-client", "gnomon-load"):
            token = ("--token-file", "/none") if program == "gnomon-client" else ("--tenant", "a:/none:1")
            self.assertEqual(run(program, *client, *token)[0], 1, "a file that cannot be read is no wrong usage")

    def test_a_second_init_keeps_whether_browsers_are_served(self):
        with tempfile.TemporaryDirectory() as folder:
            init = ("init", "--out", folder, "--host", "edge.example", "--tenant", "lab", "--scene", "temple")
            served = lambda: re.search(r"web:\s+listen: (\w+)", pathlib.Path(folder, "gnomond.yaml").read_text())
            for more, expected in ((("--browsers",), "true"), ((), "true"), (("--no-browsers",), "false"), ((), "false")):
                status, text = run("gnomonctl", *init, *more)
                self.assertEqual(status, 0, text)
                self.assertEqual(served().group(1), expected, more)

    def test_an_address_that_is_said_is_asked_and_not_the_fleet_of_the_environment(self):
        fleet = {**os.environ, "GNOMON_FLEET": "n1=http://127.0.0.1:2"}
        for arguments in (("--admin", "http://127.0.0.1:1", "status"), ("sessions", "--admin", "http://127.0.0.1:1")):
            text = run("gnomonctl", *arguments, env=fleet)[1]
            self.assertTrue(text.startswith("gnomonctl: http://127.0.0.1:1 does not answer"), text)
        for more, environment in ((("--fleet", "n1=http://127.0.0.1:2"), os.environ), ((), fleet),
                                  ((), {**fleet, "GNOMON_ADMIN": "http://127.0.0.1:1"})):
            text = run("gnomonctl", "status", *more, env=environment)[1]
            self.assertIn("n1: http://127.0.0.1:2 does not answer", text)

    def test_what_fails_is_1(self):
        for program, arguments in (("gnomonctl", ("--admin", "http://127.0.0.1:1", "status")),
                                   ("gnomond", ("--config", "/no/such/file")),
                                   ("gnomon-load", ("--server", "127.0.0.1:1", "--scene", "s", "--size", "8x8",
                                                    "--clients", 1))):
            status, text = run(program, *arguments)
            self.assertEqual(status, 1, text)
            self.assertTrue(text.startswith(program + ": "), text)


class BesideADaemon(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        # One of them asks for far more than there is, which admission would refuse.
        cls.node = Node(BUILD, tenants=[{"name": "studio"}, {"name": "default"}], scheduler={"admit_percent": 0})
        cls.addClassCleanup(cls.node.__exit__)
        cls.node.start()

    def load(self, *more, server=None, pin=True, scene="living_room"):
        known = ["--pin", self.node.pin] if pin else []
        return run("gnomon-load", "--server", server or self.node.control, *known, "--scene", scene, "--size", "160x90",
                   "--tenant", "studio::2", "--seconds", 1, *more)

    def test_without_a_pin_the_one_that_is_shown_is_named(self):
        status, text = self.load(pin=False)
        self.assertEqual(status, 1)
        self.assertIn("self-signed certificate", text)
        self.assertIn(f"--pin {self.node.pin}", text)

    def test_a_wrong_pin_is_set_beside_the_one_that_is_shown(self):
        status, text = self.load("--pin", "sha256:" + 32 * "0f", pin=False)
        self.assertEqual(status, 1)
        self.assertIn(f"the server shows {self.node.pin}", text)

    def test_the_admin_port_is_told_from_that_of_clients(self):
        status, text = self.load(server=self.node.admin.removeprefix("http://"))
        self.assertEqual(status, 1)
        self.assertIn("not the port for clients", text)

    def test_nobody_there(self):
        self.assertIn("no gnomond listens there", self.load(server="127.0.0.1:1")[1])

    def test_an_unknown_scene_lists_those_there(self):
        status, text = self.load(scene="bunny")
        self.assertEqual(status, 1)
        self.assertIn("there are: living_room", text)

    def test_every_camera_is_answered_coalesced_or_dropped(self):
        """More are offered than two cores can answer: the exit status and the words say so."""
        file = self.node.folder / "load.json"
        overload = ("--rate", 1000, "--json", file)
        status, text = self.load(*overload)
        report = json.loads(file.read_text())
        self.assertEqual(report["server"], self.node.control)
        self.assertEqual(report["device"], self.node.status()["devices"][0]["name"])
        row = report["rows"][-1]
        self.assertEqual(row["offered"], row["answered"] + row["coalesced"] + row["dropped"])
        self.assertGreater(row["coalesced"], 0)
        self.assertEqual(status, 3, text)
        without = row["coalesced"] + row["dropped"]
        self.assertIn(f"{without} of {row['offered']} cameras stayed without an answer", text)
        self.assertEqual(self.load("--may-miss", 100, *overload)[0], 0)
        stages = sum(row[f"mean_{stage}_ms"] for stage in ("queue", "device", "encode", "network"))
        self.assertAlmostEqual(stages, row["mean_ms"], delta=0.05 * row["mean_ms"] + 1)
        self.assertLessEqual(row["p50_ms"], row["p90_ms"])
        self.assertLessEqual(row["p99_ms"], row["p999_ms"])

    def test_the_table_says_what_was_run(self):
        status, text = self.load("--warm-up", 1)
        self.assertEqual(status, 0, text)
        for part in (self.node.control, "tracer ", "scene living_room, 160x90", "after 1.0 s of warm-up",
                     "offered answered coalesced dropped", "p99.9 ms", "total, 2 clients", "the mean answer took"):
            self.assertIn(part, text)

    def test_a_sweep(self):
        file = self.node.folder / "sweep.csv"
        status, text = run("gnomon-load", "--server", self.node.control, "--pin", self.node.pin, "--scene", "living_room",
                           "--size", "64x36", "--clients", "1..4", "--seconds", 2, "--csv", file)
        self.assertEqual(status, 0, text)
        self.assertEqual(re.findall(r"^total, (\d+) clients", text, re.M), ["1", "2", "4"])
        with open(file) as opened:
            rows = list(csv.DictReader(opened))
        totals = [row for row in rows if row["scope"] == "total"]
        self.assertEqual([row["clients"] for row in totals], ["1", "2", "4"])
        self.assertTrue(all(float(row["vbps"]) > 0 for row in totals))

    def test_scene_load_names_what_it_is_at(self):
        self.assertEqual(self.node.status()["scenes_under_way"], [])
        status, told = self.node.ctl("scene", "load", "living_room")
        self.assertEqual(status, 0, told)
        self.assertTrue(told.endswith("loaded\n"), told)  # after lines of progress, if it took long

    def test_top_on_a_terminal(self):
        pid, terminal = pty.fork()
        if pid == 0:
            os.environ["TERM"] = "xterm"
            os.execv(BUILD / "bin/gnomonctl", ["gnomonctl", "--admin", f"unix:{self.node.socket}", "top"])
        shown = bytearray()

        def shows(text):
            if select.select([terminal], [], [], 0.05)[0]:
                shown.extend(os.read(terminal, 65536))
            return text in shown

        eventually(lambda: shows(b"TENANT"), "the tenants")
        os.write(terminal, b"?")
        eventually(lambda: shows(b"scroll the sessions"), "the help")
        os.write(terminal, b"x/stu")
        eventually(lambda: shows(b"contain"), "the filter")
        os.write(terminal, b"\r")
        time.sleep(0.2)
        os.write(terminal, b"q")
        self.assertEqual(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]), 0)

    def test_top_without_a_terminal(self):
        status, text = self.node.ctl("top", "--count", "2", "--interval", "0.2")
        self.assertEqual(status, 0)
        self.assertEqual(text.count("TENANT"), 4, "of tenants and of sessions, twice")
        self.assertNotIn("\x1b", text)


if __name__ == "__main__":
    unittest.main(verbosity=2)
