"""Choosing x: `auto` beside every fixed x and the dissertation's switching, over links of several chances (seeds)."""
import collections

from spread import Spread

Compared = collections.namedtuple("Compared", "name kind response error ours verdict line_verdict")


def least_error(front, response_ms):
    """Of settings of auto that answer no later, the least error; nullopt: none answers so early."""
    return min((row["error_share"] for row in front if row["response_ms"] <= response_ms + 1e-9), default=None)


def on_the_line(front, response_ms):
    """The error at exactly that response, on the line between the settings of auto that answer just sooner and just later: auto's
    settings leave gaps (a cost of time decides alike for whole stretches of a path), and a client could change over in a flight."""
    best = {}
    for row in sorted(front, key=lambda r: (r["response_ms"], r["error_share"])):
        if not best or row["error_share"] < min(best.values()):
            best[row["response_ms"]] = row["error_share"]
    sooner, later = ([ms for ms in best if (ms <= response_ms) == low] for low in (True, False))
    if not sooner:
        return None
    if not later:
        return best[max(sooner)]
    a, b = max(sooner), min(later)
    return best[a] + (best[b] - best[a]) * (response_ms - a) / (b - a)


def verdict(differences):
    """`differences`: of each seed, the other's error less auto's."""
    if any(d is None for d in differences):
        return "not comparable: never so early"
    if all(d == 0 for d in differences):
        return "equal"
    if all(d >= 0 for d in differences):
        return "lower"
    return "higher" if all(d <= 0 for d in differences) else "within the spread"


def settings(rows):
    groups = {}
    for row in rows:
        if row["policy"] != "auto":
            groups.setdefault((row["policy"], row["parameter"]), {})[row["seed"]] = row
    return groups


def best_switching(groups):
    """Its settings that none of its others beats in both error and response, in the mean over the seeds."""
    mean = {key: tuple(sum(row[c] for row in of.values()) / len(of) for c in ("response_ms", "error_share"))
            for key, of in groups.items() if key[0] != "fixed"}
    return [key for key, (late, wrong) in mean.items()
            if not any(l <= late and w <= wrong and (l, w) != (late, wrong) for l, w in mean.values())]


def compared(rows):
    """Of one scene: every fixed x that waits at all and is wrong at all, and the best settings of switching."""
    groups = settings(rows)
    front = {seed: [r for r in rows if r["policy"] == "auto" and r["seed"] == seed] for seed in {r["seed"] for r in rows}}
    found, seen = [], set()
    for key in [key for key in groups if key[0] == "fixed"] + best_switching(groups):
        of = groups[key]
        outcome = tuple((row["response_ms"], row["error_share"]) for row in of.values())
        if outcome in seen or min(late for late, _ in outcome) < 1 or max(wrong for _, wrong in outcome) == 0:
            continue
        seen.add(outcome)
        ours = {seed: least_error(front[seed], row["response_ms"]) for seed, row in of.items()}
        none = any(value is None for value in ours.values())
        differences = [None if ours[seed] is None else row["error_share"] - ours[seed] for seed, row in of.items()]
        lines = {seed: on_the_line(front[seed], row["response_ms"]) for seed, row in of.items()}
        line_differences = [None if lines[seed] is None else row["error_share"] - lines[seed] for seed, row in of.items()]
        name = f"x = {key[1]:.0f}" if key[0] == "fixed" else f"{key[0]}, high {key[1]:g}"
        found.append(Compared(name, "fixed" if key[0] == "fixed" else "switching", Spread([r["response_ms"] for r in of.values()]),
                              Spread([100 * r["error_share"] for r in of.values()]),
                              None if none else Spread([100 * value for value in ours.values()]), verdict(differences), verdict(line_differences)))
    return found


def counted(of, verdicts):
    counts = collections.Counter(verdicts)
    parts = [f"lower than {counts['lower']}", *(f"{name} {counts[word]}" for word, name in (("equal", "equal to"), ("within the spread", "within the spread of"),
             ("higher", "higher than"), ("not comparable: never so early", "never as early as")) if counts[word])]
    return f"{', '.join(parts)} of {len(of)}"


def said(scene, found):
    parts = []
    for kind, name in (("fixed", "fixed x that wait at all"), ("switching", "best settings of switching")):
        of = [c for c in found if c.kind == kind]
        worst = max((c.ours.median - c.error.median for c in of if c.verdict == "higher"), default=0)
        by = f" (by {worst:.2f} points at most)" if worst else ""
        parts.append(f"auto's error at no later response is {counted(of, [c.verdict for c in of])} {name}{by}; between its own settings, on the "
                     f"line, {counted(of, [c.line_verdict for c in of])}")
    return f"{scene}: " + ". Further, ".join(parts) + "."
