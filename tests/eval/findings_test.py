"""No finding is told of noise, and what really differs is told; docs/evaluation.md is made of tests/eval/measured."""
import json
import pathlib
import random
import shutil
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import findings  # noqa: E402
import page  # noqa: E402
import policies  # noqa: E402
from spread import Spread, differ  # noqa: E402


def noise(random_numbers, mean=200, deviation=15, repeats=3):
    return Spread([random_numbers.gauss(mean, deviation) for _ in range(repeats)])


class OfNoise(unittest.TestCase):
    """Twenty sets of three repeats that are of one distribution each."""

    def setUp(self):
        self.random = random.Random(19)

    def test_rates(self):
        for _ in range(20):
            keys = [(scene, border) for scene in ("living_room", "temple") for border in ("0", "64x36", "128x72")]
            same = [{key: noise(self.random) for key in keys} for _ in range(2)]
            self.assertEqual(findings.of_rates(*same), findings.NO_DIFFERENCE)

    def test_clients(self):
        for _ in range(20):
            self.assertEqual(findings.of_clients({"temple": {count: noise(self.random) for count in (1, 2, 64)}}), findings.NO_DIFFERENCE)

    def test_remote(self):
        for _ in range(20):
            figures = {column: {("temple", link, mode): noise(self.random) for link in range(3) for mode in ("visibility", "video")}
                       for column in ("response_ms", "late_share", "ssim", "vmaf", "mbit_per_s")}
            self.assertEqual(findings.of_remote(figures), findings.NO_DIFFERENCE)

    def test_response(self):
        for _ in range(20):
            repeats = {ping: {repeat: [(x, self.random.gauss(100, 10)) for x in range(5)] for repeat in range(3)} for ping in (20, 100)}
            self.assertIn("cannot be told from the spread", findings.of_response(repeats, 16.7))

    def test_three_in_a_thousand(self):
        found = sum(differ(noise(self.random), noise(self.random)) for _ in range(10_000))
        self.assertLess(found, 60)

    def test_fewer_than_three_repeats_tell_nothing(self):
        self.assertFalse(differ(Spread([1, 1.01]), Spread([9, 9.01])))

    def test_policies(self):
        self.assertEqual(policies.verdict([0.1, -0.1, 0.2]), "within the spread")


class OfDifferences(unittest.TestCase):
    def test_rates(self):
        fps = {("temple", "0"): Spread([200, 204, 207]), ("temple", "128x72"): Spread([150, 152, 155])}
        said = findings.of_rates(fps, {key: Spread([80, 81, 82]) for key in fps})
        self.assertIn("with 128x72 fewer pictures a second, 152 (150 to 155) for 204 (200 to 207)", said)
        self.assertIn("the server is behind the client, 81 (80 to 82) vbps", said)

    def test_clients(self):
        said = findings.of_clients({"temple": {1: Spread([60, 62, 65]), 2: Spread([170, 174, 175])}})
        self.assertIn("two clients get 2.81 times", said)

    def test_remote(self):
        figures = {"response_ms": {("temple", 1, "visibility"): Spread([1, 2, 3]), ("temple", 1, "video"): Spread([80, 81, 82])}}
        self.assertIn("answers sooner in 1 of 1 links, video in 0", findings.of_remote(figures))

    def test_response(self):
        repeats = {100: {repeat: [(x, 116.7 - 16.7 * x) for x in range(6)] for repeat in range(3)}}
        self.assertIn("takes 16.7 ms off", findings.of_response(repeats, 16.7))

    def test_policies(self):
        self.assertEqual(policies.verdict([0.1, 0.3, 0.2]), "lower")


class OfThePage(unittest.TestCase):
    def test_docs_evaluation_is_what_measured_holds(self):
        text = (HERE.parents[1] / "docs/evaluation.md").read_text()
        machine = json.loads((HERE / "measured/machine.json").read_text())
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(shutil.copytree(HERE / "measured", folder, dirs_exist_ok=True))
            self.assertEqual(page.filled(text, out, machine), text)


if __name__ == "__main__":
    unittest.main()
