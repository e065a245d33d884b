#!/usr/bin/env python3
"""What the soak says of a node that leaks, grows, is stuck or unfair, and of one that is well."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
FILE = pathlib.Path(__file__).resolve().parent / "run"
LOADER = importlib.machinery.SourceFileLoader("soak_run", str(FILE))
run = importlib.util.module_from_spec(importlib.util.spec_from_loader("soak_run", LOADER))
LOADER.exec_module(run)


def minutes_of(count, **changing):
    """Rows of a node that is well, but for columns that are a function of the row's number."""
    rows = []
    for i in range(count * 30):
        row = {"seconds": 2 * i, "bytes": 300e6, "descriptors": 60 + i % 5, "threads": 14, "sessions": 10 + i % 5,
               "frames": 100 * i, "jain": 0.99}
        row.update({column: value(i) for column, value in changing.items()})
        rows.append(row)
    return rows


def findings(sanitized=False, losses=0, **changing):
    watch = run.Watch(None)
    watch.rows = minutes_of(5, **changing)
    return watch.findings(100, losses, sanitized)


class FakeNode:
    def __init__(self):
        self.frames = {"quick": 0, "stuck": 7}

    def status(self):
        self.frames["quick"] += 1
        return {"sessions": [{"id": id, "frames": frames} for id, frames in self.frames.items()], "jain": 1}

    def metric(self, _):
        return 0


class Findings(unittest.TestCase):
    def test_nothing_of_a_node_that_is_well(self):
        self.assertEqual(findings(), [])

    def test_growth(self):
        self.assertEqual(findings(bytes=lambda i: 300e6 + 2e5 * i), ["memory grows"])
        self.assertEqual(findings(bytes=lambda i: 300e6 + 2e5 * i, losses=1), [], "a device was made anew")
        self.assertEqual(findings(bytes=lambda i: 300e6 + 2e6 * i, sanitized=True), ["memory grows"])

    def test_leaks(self):
        self.assertEqual(findings(descriptors=lambda i: 60 + i), ["descriptors leak"])
        self.assertEqual(findings(threads=lambda i: 14 + i // 40), ["threads leak"])

    def test_unfairness(self):
        self.assertEqual(findings(jain=lambda i: 0.85), ["unfair"])

    def test_a_node_that_stands_still(self):
        self.assertEqual(findings(frames=lambda i: 5000), ["no frames"])

    def test_one_session_that_is_stuck(self):
        watch = run.Watch(FakeNode())
        for now in range(0, 60, 2):
            watch.step(now)
        self.assertEqual(watch.stuck, {"stuck"})


if __name__ == "__main__":
    unittest.main()
