"""What the figures say, in words and from the numbers themselves: whether the shape is the dissertation's, and if not, why.
What is measured in time differs only where `spread.differ` says so."""
import statistics

from spread import Spread, differ

NO_DIFFERENCE = "No difference is larger than the spread of the repeats."


def line_through(points):
    """Slope, value at 0 and how much of the spread a straight line explains (R squared)."""
    n = len(points)
    mean_x, mean_y = (sum(p[i] for p in points) / n for i in (0, 1))
    spread_x = sum((x - mean_x) ** 2 for x, _ in points)
    spread_y = sum((y - mean_y) ** 2 for _, y in points)
    both = sum((x - mean_x) * (y - mean_y) for x, y in points)
    slope = both / spread_x
    return slope, mean_y - slope * mean_x, both * both / (spread_x * spread_y) if spread_y else 1


def of_errors(by_border):
    """`by_border`: name -> x -> % of wrong bits, of one scene."""
    none, widest = by_border["0"], by_border["128x72"]
    last = max(none)
    _, _, straight = line_through(list(none.items()))
    off = {x: none[x] - widest[x] for x in none if x in (1, 4, last)}
    said = [f"Without a border the error grows from {none[1]:.2f}% at x = 1 to {none[last]:.2f}% at x = {last:.0f}; a straight line explains "
            f"{100 * straight:.0f}% of the curve."]
    said.append("128x72 takes off " + ", ".join(f"{points:.2f} points at x = {x:.0f}" for x, points in off.items()) + ".")
    share = {x: 1 - widest[x] / none[x] for x in none}
    most = max(share, key=share.get)
    said.append(f"In proportion it takes off most at x = {most:.0f}: {100 * share[most]:.0f}% of the error there.")
    if most > 1:
        said.append("At smaller x less of the error lies outside of what was seen: it is at the edges of shadows and of what hides them, where "
                    "no border helps; after that the border is left behind. The dissertation's curves differ by a constant from x = 1 on.")
    return " ".join(said)


def of_videos(by_scene, label):
    """`by_scene`: scene -> x -> value."""
    said = []
    for scene, values in by_scene.items():
        xs = sorted(values)
        rises = [x for before, x in zip(xs, xs[1:]) if values[x] > values[before]]
        anomalies = f", but rises at x = {', '.join(f'{x:.0f}' for x in rises)}" if rises else " at every step"
        said.append(f"{label} falls from {values[xs[0]]:.4g} at x = {xs[0]:.0f} to {values[xs[-1]]:.4g} at x = {xs[-1]:.0f}{anomalies} ({scene}).")
    return " ".join(said)


def of_response(by_latency, frame_ms):
    """`by_latency`: ping -> repeat -> [(x, ms)]. Slopes where there is still something to take off."""
    slopes = {}
    for ping, repeats in by_latency.items():
        found = []
        for points in repeats.values():
            falling = [(x, y) for x, y in sorted(points) if y > frame_ms / 2]
            if len(falling) > 1:
                found.append(-line_through(falling)[0])
        if len(found) > 2 and min(found) > 0 and max(found) - min(found) < statistics.median(found) / 5:
            slopes[ping] = Spread(found)
    if not slopes:
        return "What a frame predicted takes off the response time cannot be told from the spread."
    low, high = min(s.low for s in slopes.values()), max(s.high for s in slopes.values())
    by = f"{low:.1f}" if f"{low:.1f}" == f"{high:.1f}" else f"{low:.1f} to {high:.1f}"
    floor = min(y for repeats in by_latency.values() for points in repeats.values() for _, y in points)
    return (f"Each frame predicted ahead takes {by} ms off the response time (a frame takes {frame_ms:.1f} ms), until the newest camera is "
            f"what is shown: {floor:.1f} ms are left then, for drawing, and a larger x changes nothing, as no client can show a camera that "
            "it has not had.")


def of_clients(by_scene):
    """`by_scene`: scene -> clients -> Spread of vbps."""
    said = []
    for scene, vbps in by_scene.items():
        most = max(vbps, key=lambda count: vbps[count].median)
        if 2 in vbps and differ(vbps[1], vbps[2]):
            more = vbps[2].median > vbps[1].median
            why = ("a client alone waits for its own answers and leaves the device idle meanwhile" if more
                   else "a client alone keeps the device busy already")
            said.append(f"{scene}: two clients get {vbps[2].median / vbps[1].median:.2f} times what one gets: {why}.")
        if most > 2 and differ(vbps[1], vbps[most]):
            said.append(f"{scene}: {most:.0f} clients get {vbps[most].median / vbps[1].median:.1f} times what one gets.")
    return " ".join(said) or NO_DIFFERENCE


def of_rates(fps, vbps):
    """Spreads by (scene, border), of one client that predicts: what does a border cost, does the server keep up?"""
    said = []
    for (scene, border), spread in fps.items():
        none = fps.get((scene, "0"))
        if border != "0" and none and differ(spread, none):
            word = "fewer" if spread.median < none.median else "more"
            said.append(f"{scene}: with {border} {word} pictures a second, {spread.text()} for {none.text()}.")
    said += [f"{scene}, {border}: the server is behind the client, {vbps[scene, border].text()} vbps for {spread.text()} pictures a second."
             for (scene, border), spread in fps.items() if vbps[scene, border].median < spread.median and differ(vbps[scene, border], spread)]
    return " ".join(said) or NO_DIFFERENCE


def of_remote(figures):
    """`figures`: column -> (scene, link, mode) -> Spread. In how many of the links that were measured three times
    which of the two is ahead by more than both spread."""
    words = {"response_ms": "answers sooner", "late_share": "has fewer late pictures", "ssim": "has the higher SSIM",
             "vmaf": "has the higher VMAF", "mbit_per_s": "takes fewer bits"}
    said = []
    for column, word in words.items():
        spreads = figures.get(column, {})
        links = [key[:-1] for key in spreads if key[-1] == "video" and (*key[:-1], "visibility") in spreads]
        pairs = [(spreads[(*link, "visibility")], spreads[(*link, "video")]) for link in links]
        pairs = [pair for pair in pairs if min(len(of.values) for of in pair) >= 3]
        if not pairs:
            continue
        apart = [(ours, theirs) for ours, theirs in pairs if differ(ours, theirs)]
        more_is_better = column in ("ssim", "vmaf")
        ours_ahead = sum((ours.median > theirs.median) == more_is_better for ours, theirs in apart)
        if apart:
            said.append(f"Visibility {word} in {ours_ahead} of {len(pairs)} links, video in {len(apart) - ours_ahead}; "
                        f"in {len(pairs) - len(apart)} the spread hides it.")
    return " ".join(said) or NO_DIFFERENCE
