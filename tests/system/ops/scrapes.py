"""Scrapes of a daemon as Prometheus has them, and what the shipped rules make of them when what they show goes on."""
import json
import re
import subprocess
import time
import urllib.request

from node import ROOT

FILES = ROOT / "deploy/prometheus"
RULES, ALERTS = FILES / "gnomon.rules.yml", FILES / "gnomon.alerts.yml"
JOB = re.search(r"job_name: (\S+)", (FILES / "prometheus.yml").read_text())[1]
CALM_S, CALM_END_S, CALM_END = 360, 300, "5m"  # before anything happens; longer than the rules look back, but for the hour of GnomonMemoryGrows
SAMPLE = re.compile(r"^(\w+)(?:\{(.*)\})? (\S+)$", re.M)
LABEL = re.compile(r'(\w+)="((?:[^"\\]|\\.)*)"')


def promtool(*arguments, folder=FILES, **more):
    done = subprocess.run(["promtool", *map(str, arguments)], text=True, stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, cwd=folder, **more)
    return done.returncode, done.stdout


def family_of(name):
    return re.sub(r"_(bucket|sum|count)$", "", name)


class Scrape:
    """`samples`: values by series, ("name", (("label", "value"), ...)), with the target's labels; `types`: of families.
    Of a daemon that does not answer there is `up` alone."""
    everything = []  # all scrapes of this process

    def __init__(self, node):
        self.at = time.monotonic()
        target = {"instance": node.admin.split("://")[1], "job": JOB}
        try:
            with urllib.request.urlopen(node.admin + "/metrics", timeout=10) as page:
                text = page.read().decode()
        except OSError:
            text = ""
        self.types = dict(re.findall(r"^# TYPE (\w+) (\w+)$", text, re.M))
        self.samples = {("up", tuple(sorted(target.items()))): float(bool(text))}
        for name, labels, value in SAMPLE.findall(text):
            own = {**target, **dict(LABEL.findall(labels))}
            self.samples[name, tuple(sorted(own.items()))] = float(value)
        # promtool's tests begin in 1970, and this scrape is where the calm ends.
        shift = time.time() - CALM_S
        for series in [one for one in self.samples if one[0].endswith(("_timestamp_seconds", "_start_time_seconds"))]:
            self.samples[series] -= shift
        Scrape.everything.append(self)

    def value(self, name, **labels):
        """Sum of the series that have these labels."""
        return sum(value for (own, of), value in self.samples.items() if own == name and labels.items() <= dict(of).items())

    def counts(self, name):
        """Whether it only ever goes up."""
        return self.types.get(name, self.types.get(family_of(name))) in ("counter", "histogram")


def shown(series):
    name, labels = series
    return name + "{" + ", ".join(f'{label}="{value}"' for label, value in labels) + "}"


def line(begin, rate, count):
    """So many values of a series, in promtool's words."""
    return f"{begin!r}{rate:+.9g}x{count - 1}"


def values(scrapes, series, steps, once, trending):
    """As the series went between the first two scrapes for `steps[0]` scrapes, then as between the last two for
    `steps[1]`; or, if that was to happen `once`, with its difference, and then as before. Gauges stay as they are, but for
    those `trending`."""
    moves = scrapes[-1].counts(series[0]) or series[0] in trending
    _, before, after = (scrape.samples.get(series) for scrape in scrapes)

    def rate(begin, end):
        if not moves or scrapes[begin].samples.get(series) is None:
            return 0
        difference = scrapes[end].samples[series] - scrapes[begin].samples[series]
        return difference / (scrapes[end].at - scrapes[begin].at) * steps.interval_s

    calm = rate(0, 1) if before is not None else 0
    known = line(before, calm, steps[0]) if before is not None else f"_x{steps[0]}"
    if after is None:
        return f"{known} stale"
    if not moves:
        return f"{known} {line(after, 0, steps[1])}"
    level = (before or 0) + calm * steps[0]
    if once:
        return f"{known} {line(level + after - (before or 0), calm, steps[1])}"
    rise = rate(1, 2) if before is not None else after / (scrapes[2].at - scrapes[1].at) * steps.interval_s
    return f"{known} {line(level + rise, rise, steps[1])}"


class Steps(tuple):
    """Scrapes in the calm, and those afterwards."""
    def __new__(cls, for_s, interval_s):
        steps = super().__new__(cls, (CALM_S // interval_s, for_s // interval_s))
        steps.interval_s = interval_s
        return steps


def alert_names():
    return re.findall(r"- alert: (\w+)", ALERTS.read_text())


def what_fires(folder, scrapes, for_s=900, interval_s=5, once=False, trending=(), calm=True):
    """Alerts that fire when what happened between the last two of three scrapes goes on for so long: a dictionary with
    the labels of each, the alert's own left out. An error if one fires in the `calm` before, which is as between the
    first two."""
    steps = Steps(for_s, interval_s)
    every = sorted({series for scrape in scrapes[1:] for series in scrape.samples})
    series = [{"series": shown(one), "values": values(scrapes, one, steps, once, trending)} for one in every]
    # Nothing is expected, so that promtool says what there is.
    firing = {"expr": 'ALERTS{alertstate="firing"}', "exp_samples": []}
    test = {"interval": f"{interval_s}s", "input_series": series,
            "promql_expr_test": [{**firing, "eval_time": f"{CALM_END_S}s"}, {**firing, "eval_time": f"{CALM_S + for_s}s"}]}
    file = folder / "alerts.test.json"
    file.write_text(json.dumps({"rule_files": [str(RULES), str(ALERTS)], "evaluation_interval": f"{interval_s}s",
                                "tests": [test]}))
    status, output = promtool("test", "rules", file, folder=folder)
    if status == 0:
        return {}
    found = dict(re.findall(r"time: (\S+),\s+exp:.*\s+got: (.*)", output))
    if not found or (calm and CALM_END in found):
        raise AssertionError(f"an alert fired before anything happened, or promtool failed:\n{output}")
    fired = {}
    for labels in re.findall(r"\{(.*?)\}", "".join(found.values())):
        own = dict(LABEL.findall(labels))
        fired.setdefault(own.pop("alertname"), []).append(
            {label: value for label, value in own.items() if label not in ("__name__", "alertstate", "severity")})
    return fired
