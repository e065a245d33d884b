#!/usr/bin/env python3
"""Grafana's dashboards as files: what Grafana's own types say of it, where npm reaches them, and what no type says:
a unit that suits what is shown, panels that do not lie on each other. prometheus_test runs every query.

    dashboard_test.py SOURCE BUILD
"""
import copy
import itertools
import json
import pathlib
import re
import sys
import unittest

import dashboard_types

SOURCE, BUILD = pathlib.Path(sys.argv.pop(1)), pathlib.Path(sys.argv.pop(1)).resolve()
DASHBOARDS = [json.loads(file.read_text()) for file in sorted((SOURCE / "deploy/grafana").glob("*.json"))]
COLUMNS = 24
# Grafana's name for the unit of a metric that is named by Prometheus' rules.
UNITS = [(r"_seconds(:mean|:p\d+|_sum|\{|$)", "s"), (r"_bytes:rate", "Bps"), (r"_bytes(\{|$)", "bytes"),
         (r"_ratio(:avg)?(\{|$)|:ratio\d+m", "percentunit"), (r"", "short")]


def unit(expression):
    return next(unit for pattern, unit in UNITS if re.search(pattern, expression))


class Structure(unittest.TestCase):
    def each(self):
        """Every dashboard as a part of the test: itself and its panels."""
        for dashboard in DASHBOARDS:
            with self.subTest(dashboard["title"]):
                yield dashboard, dashboard["panels"]

    def test_each_is_another_one(self):
        self.assertGreater(len(DASHBOARDS), 1)
        for key in ("title", "uid"):
            self.assertEqual(len({dashboard[key] for dashboard in DASHBOARDS}), len(DASHBOARDS), key)

    def test_every_panel_says_what_it_shows(self):
        source = {"type": "prometheus", "uid": "${datasource}"}
        for panel in [panel for _, panels in self.each() for panel in panels]:
            with self.subTest(panel["title"]):
                self.assertGreater(len(panel["description"]), len(panel["title"]), "the title alone explains little")
                self.assertEqual(panel["datasource"], source)
                self.assertGreater(len(panel["targets"]), 0)
                self.assertEqual(len({target["refId"] for target in panel["targets"]}), len(panel["targets"]))
                for target in panel["targets"]:
                    self.assertEqual(target["datasource"], source)
                    self.assertIn('instance=~"$instance"', target["expr"])
                    self.assertEqual(panel["fieldConfig"]["defaults"]["unit"], unit(target["expr"]), target["expr"])

    def test_names_are_unique(self):
        for _, panels in self.each():
            for key in ("id", "title"):
                self.assertEqual(len({panel[key] for panel in panels}), len(panels), key)

    def test_variables_that_are_used_exist(self):
        for dashboard, panels in self.each():
            known = {variable["name"] for variable in dashboard["templating"]["list"]}
            used = set(re.findall(r"\$\{?(\w+)", json.dumps([panels, dashboard["templating"]])))
            self.assertEqual(used - {"__rate_interval", "__range", "__interval"}, known)

    def test_panels_do_not_overlap(self):
        for _, panels in self.each():
            places = {panel["title"]: panel["gridPos"] for panel in panels}
            for title, at in places.items():
                inside = at["w"] > 0 and at["h"] > 0 and 0 <= at["x"] <= COLUMNS - at["w"] and at["y"] >= 0
                self.assertTrue(inside, title)
            for (one, a), (other, b) in itertools.combinations(places.items(), 2):
                apart = (a["x"] + a["w"] <= b["x"] or b["x"] + b["w"] <= a["x"]
                         or a["y"] + a["h"] <= b["y"] or b["y"] + b["h"] <= a["y"])
                self.assertTrue(apart, f"{one} lies on {other}")


class Types(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = BUILD / "ops/grafana"
        why = dashboard_types.install(cls.folder)
        if why:
            raise unittest.SkipTest(why)

    def test_grafana_knows_all_of_it(self):
        for dashboard in DASHBOARDS:
            self.assertEqual(dashboard_types.errors(self.folder, dashboard), [], dashboard["title"])

    def test_mistakes_are_noticed(self):
        spoiled = copy.deepcopy(next(one for one in DASHBOARDS if one["uid"] == "gnomon-node"))
        stat, series = ({panel["type"]: panel for panel in spoiled["panels"]}[kind] for kind in ("stat", "timeseries"))
        spoiled["refesh"] = spoiled.pop("refresh")
        stat["gridPos"]["width"] = 4
        stat["options"]["colorMode"] = "values"
        stat["fieldConfig"]["defaults"]["units"] = "s"
        series["options"]["tooltip"]["mode"] = "many"
        series["fieldConfig"]["defaults"]["custom"]["lineWith"] = 1
        series["targets"][0]["exp"] = series["targets"][0].pop("expr")
        found = "\n".join(dashboard_types.errors(self.folder, spoiled))
        for mistake in ("refesh", "width", "colorMode", "units", "mode", "lineWith", "exp"):
            self.assertRegex(found, rf'"{mistake}"')


if __name__ == "__main__":
    unittest.main(verbosity=2)
