"""What the figures say, in words and from the numbers themselves: whether the shape is the dissertation's, and if not, why."""


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
    said.append(f"That is most of the error at x = {most:.0f}, {100 * share[most]:.0f}% of it.")
    if most > 1:
        said.append("Before that less of the error lies outside of what was seen: it is at the edges of shadows and of what hides them, where "
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
    """`by_latency`: ping -> [(x, ms)]. Slopes where there is still something to take off."""
    slopes = {}
    for ping, points in by_latency.items():
        falling = [(x, y) for x, y in sorted(points) if y > frame_ms / 2]
        if len(falling) > 1:
            slopes[ping] = -line_through(falling)[0]
    if not slopes:
        return "Every answer comes within half a frame: there is nothing to take off."
    low, high = min(slopes.values()), max(slopes.values())
    by = f"{low:.0f}" if round(low) == round(high) else f"{low:.0f} to {high:.0f}"
    floor = min(y for points in by_latency.values() for _, y in points)
    return (f"Each frame predicted ahead takes {by} ms off the response time (a frame takes {frame_ms:.0f} ms), at every latency, until the "
            f"newest camera is what is shown: {floor:.1f} ms are left then, and a larger x changes nothing, as no client can show a camera that it "
            "has not had.")


def of_clients(by_scene):
    """`by_scene`: scene -> clients -> vbps."""
    said = []
    for scene, vbps in by_scene.items():
        most = max(vbps, key=vbps.get)
        idle = vbps[2] > 1.1 * vbps[1]
        why = ("a client alone waits for its own answers and leaves the device idle meanwhile" if idle
               else "a client alone keeps the device busy already, as it did in Sun Temple")
        said.append(f"{scene}: two clients get {vbps[2] / vbps[1]:.2f} times what one gets ({why}), {most:.0f} the most, "
                    f"{vbps[most] / vbps[1]:.2f} times.")
    return " ".join(said)


def of_rates(rows):
    """One client that predicts: does the server keep up with it?"""
    behind = [r for r in rows if r["vbps"] < 0.95 * r["fps"]]
    said = ("The client shows a picture for each mask that comes: fps and vbps are the same."
            if not behind else "The server is behind the client with " + ", ".join(f"{r['scene']} {str(r['border']).removesuffix('.0')}" for r in behind) + ".")
    return said


def of_remote(by_link):
    """`by_link`: (scene, Mbit/s) -> mode -> row."""
    pairs = {key: modes for key, modes in by_link.items() if {"visibility", "video"} <= modes.keys()}
    if not pairs:
        return ""
    sooner = [key for key, m in pairs.items() if m["visibility"]["response_ms"] < m["video"]["response_ms"]]
    better = [key for key, m in pairs.items() if number(m["visibility"].get("ssim")) > number(m["video"].get("ssim"))]
    ratio = sorted(m["visibility"]["mbit_per_s"] / m["video"]["mbit_per_s"] for m in pairs.values())
    return (f"Of {len(pairs)} scenes and links visibility answers sooner in {len(sooner)} and is more like the ideal picture in "
            f"{len(better)}; it receives {ratio[0]:.2f} to {ratio[-1]:.2f} times video's bits.")


def number(value):
    return value if isinstance(value, float) else -1.0
