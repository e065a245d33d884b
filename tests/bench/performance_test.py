#!/usr/bin/env python3
"""docs/performance.md and the script that writes its tables: each knows the other's, and a run is shown as it was.

    performance_test.py ROOT BIN
"""
import importlib.machinery
import importlib.util
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT, BIN = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
SCRIPT, PAGE = ROOT / "tests/bench/performance", ROOT / "docs/performance.md"
sys.dont_write_bytecode = True
loader = importlib.machinery.SourceFileLoader("performance", str(SCRIPT))
performance = importlib.util.module_from_spec(importlib.util.spec_from_loader("performance", loader))
loader.exec_module(performance)


def blocks(text):
    return {match.group(2): match.group(3) for match in performance.BLOCK.finditer(text)}


class Performance(unittest.TestCase):
    def run_script(self, *arguments):
        return subprocess.run([SCRIPT, *map(str, arguments)], capture_output=True, text=True)

    def test_page_and_script_know_each_others_tables(self):
        text = PAGE.read_text()
        performance.check_markers(text)
        for broken in (text.replace("table: scheduler", "table: schedular"), text.replace("<!-- /table -->", "", 1),
                       text + "<!-- table: scheduler -->\n<!-- /table -->\n"):
            with self.assertRaises(performance.Wrong):
                performance.check_markers(broken)

    def test_every_column_is_a_key_that_its_suite_writes(self):
        for name, (suite, _, columns) in performance.TABLES.items():
            sources = "".join(file.read_text() for file in (ROOT / "tests/bench").glob(f"{suite}*.cpp"))
            for _, key, _ in columns:
                self.assertIn(f'"{key}"', sources, f"table {name}")

    def test_a_run_is_shown_as_it_was(self):
        with tempfile.TemporaryDirectory() as folder:
            folder = pathlib.Path(folder)
            page = folder / "page.md"
            page.write_text(PAGE.read_text())
            ran = self.run_script("--bin", BIN, "--out", folder, "--page", page, "--sessions", 10, 20, "--",
                                  "scheduler")
            self.assertEqual(ran.returncode, 0, ran.stderr)
            report = json.loads((folder / "scheduler.json").read_text())
            shown = blocks(page.read_text())
            lines = [line for line in shown["scheduler"].splitlines() if line.startswith("|")][2:]
            self.assertEqual(len(lines), len(report["rows"]))
            for line, row in zip(lines, report["rows"]):
                cells = [text.strip() for text in line.strip("|").split("|")]
                self.assertEqual((cells[0], cells[1]), (row["policy"], str(row["sessions"])))
                self.assertAlmostEqual(float(cells[2].replace(",", "")) / row["pick_ns"], 1, delta=0.02)
            for part in (report["host"], report["date"], report["commit"], "`gnomon-bench scheduler --sessions 10 20`"):
                self.assertIn(part, shown["scheduler"])
            before = blocks(PAGE.read_text())
            self.assertEqual({name for name in shown if shown[name] != before[name]}, {"scheduler"})

            again = folder / "again.md"
            again.write_text(PAGE.read_text())
            rendered = self.run_script("--from", folder, "--page", again)
            self.assertEqual((rendered.returncode, again.read_text()), (0, page.read_text()), rendered.stderr)

            for row in report["rows"]:
                row["pick_nanoseconds"] = row.pop("pick_ns")
            (folder / "scheduler.json").write_text(json.dumps(report))
            renamed = self.run_script("--from", folder, "--page", again)
            self.assertNotEqual(renamed.returncode, 0)
            self.assertRegex(renamed.stderr, re.escape("no row has 'pick_ns'"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1], verbosity=2)
