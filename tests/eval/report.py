"""One self-contained page of what the stages left: for each figure a plot, a table beside the dissertation's numbers, the
machine that it was measured on."""
import base64
import html

import dissertation
import findings
import plots
import tables

STYLE = """body{font:15px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.8em 0}td,th{border-bottom:1px solid #ddd;padding:.15em .8em;text-align:right}
th{background:#f4f4f4}td:first-child,th:first-child{text-align:left}.machine,.says{color:#555}.here{border-left:3px solid #2a9d8f;padding-left:.8em}figure{display:inline-block;margin:.5em}
img{max-width:100%}figcaption{font-size:13px;color:#555}"""


def cell(value):
    if isinstance(value, float):
        return f"{value:.0f}" if value == int(value) and abs(value) < 1e6 else f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"
    return html.escape(str(value))


def table(columns, rows):
    head = "".join(f"<th>{html.escape(column)}</th>" for column in columns)
    body = "".join("<tr>" + "".join(f"<td>{cell(value)}</td>" for value in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def picture(file, caption=""):
    kind = "svg+xml" if file.suffix == ".svg" else "png"
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<figure><img src="data:image/{kind};base64,{data}"><figcaption>{html.escape(caption)}</figcaption></figure>'


def here(text):
    """What is found here, beside what the dissertation says."""
    return f'<p class="here">Here: {html.escape(text)}</p>' if text else ""


def grouped(rows, *keys):
    groups = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def plotted(out, name, *args, **kwargs):
    file = out / f"{name}.svg"
    plots.lines(file, *args, **kwargs)
    return picture(file)


def shares(rows):
    """Border -> x -> % of the picture's bits."""
    return {border_of({"border": border}): {r["x"]: 100 * r["error_share_of_picture"] for r in group}
            for (border,), group in grouped(rows, "border").items()}


def errors(out):
    parts, curves = [], {}
    for file in sorted(out.glob("errors-*.csv")):
        rows = tables.read(file)
        scene = rows[0]["scene"]
        by_border = shares(rows)
        curves[f"{scene}, {rows[0]['size']}"] = {"no border" if border == "0" else border: (list(points.items()), "linespoints") for border, points in by_border.items()}
        parts.append(f"<p>{scene}: wrong bits per light as % of the picture, and in brackets of the bits that matter (where a light may "
                     f"shine); {rows[0]['frames']:.0f} frames of the path, {rows[0]['size']}, {html.escape(rows[0]['device'])}.</p>")
        that_matter = grouped(rows, "border", "x")
        some_x = [x for x in next(iter(by_border.values())) if x in (1, 2, 4, 8, 12, 19)]
        lines = []
        for (border,), _ in grouped(rows, "border").items():
            picked = [that_matter[border, x][0] for x in some_x]
            lines.append([border_of({"border": border}),
                          *(f"{100 * r['error_share_of_picture']:.2f} ({100 * r['error_share']:.2f})" for r in picked)])
        parts.append(table(["border", *(f"x = {x:.0f}" for x in some_x)], lines))
        parts.append(here(findings.of_errors(by_border)))
    if not parts:
        return []
    file = out / "figure-10.svg"
    plots.side_by_side(file, "frames predicted ahead, x", "wrong bits per light, % of the picture", curves, key="left top")
    return [picture(file, "Wrong bits per light for each border"), *parts]


def better(automatic, other):
    """Of our settings that answer no later, the one of least error."""
    return min((row for row in automatic if row["response_ms"] <= other["response_ms"] + 1e-9), key=lambda r: r["error_share"],
               default=None)


def automatic(out):
    parts = []
    for file in sorted(out.glob("auto-*.csv")):
        rows = tables.read(file)
        scene = rows[0]["scene"]
        kinds = grouped(rows, "policy")
        ours = kinds[("auto",)]
        series = {policy: ([(r["response_ms"], 100 * r["error_share"]) for r in group], "points" if "switching" in policy else "linespoints")
                  for (policy,), group in kinds.items()}
        parts.append(plotted(out, f"auto-{scene}", f"{scene}: error against response time, round trips of 5 to 230 ms", "mean response time, ms",
                             "mean wrong bits, %", series))
        lines = []
        for (policy,), group in kinds.items():
            if policy == "auto":
                continue
            for row in group:
                best = better(ours, row)
                lines.append([f"x = {row['parameter']:.0f}" if policy == "fixed" else f"{policy}, high {row['parameter']:g}", row["response_ms"],
                              100 * row["error_share"], best["response_ms"] if best else "-", 100 * best["error_share"] if best else "-",
                              verdict(row, best)])
        counts = {word: sum(line[-1] == word for line in lines) for word in ("lower", "equal", "higher")}
        parts.append("<p>At the same or lower response time, auto's error is lower than that of {lower} others, equal to that of {equal} "
                     "(where nothing or everything is predicted they are the same) and higher than that of {higher}.</p>".format(**counts))
        parts.append(table(["policy", "response, ms", "error, %", "auto: response, ms", "auto: error, %", "auto's error is"], lines))
    return parts


def verdict(row, best):
    if best is None:
        return "not comparable: never so early"
    if best["error_share"] < row["error_share"]:
        return "lower"
    return "equal" if best["error_share"] == row["error_share"] else "higher"


def videos(out):
    rows = tables.read(out / "videos.csv")
    parts = []
    for metric, label in (("ssim", "SSIM"), ("psnr", "PSNR, dB"), ("vif", "VIF"), ("vmaf", "VMAF")):
        if rows and metric in rows[0]:
            series = {scene: ([(r["x"], r[metric]) for r in group], "linespoints") for (scene,), group in grouped(rows, "scene").items()}
            parts.append(plotted(out, f"figure-12-{metric}", f"{label} of predicted against fresh video, 30 fps", "frames predicted ahead, x", label,
                                 series, size="520,360", key="below height 1", y_range="*:*"))
    metrics = [m for m in ("ssim", "psnr", "vif", "vmaf") if rows and m in rows[0]]
    if not rows:
        return []
    seconds = "; ".join(f"{scene}: {group[0]['seconds']:.0f} s" for (scene,), group in grouped(rows, "scene").items())
    parts.append(f"<p>{rows[0]['size']}, 30 frames a second, from the beginning of each path ({seconds}), border 128x72.</p>")
    by_x = {x: {r["scene"]: r for r in group} for (x,), group in grouped(rows, "x").items()}
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    parts.append(table(["x", *(f"{scene}: {m.upper()}" for scene in scenes for m in metrics)],
                       [[x, *(found[scene][m] if scene in found else "-" for scene in scenes for m in metrics)] for x, found in by_x.items()]))
    for metric in metrics:
        parts.append(here(findings.of_videos({scene: {r["x"]: r[metric] for r in group} for (scene,), group in grouped(rows, "scene").items()},
                                             metric.upper())))
    return parts


def rates(out):
    rows = tables.read(out / "rates.csv")
    lines = [[r["scene"], border_of(r), r["fps"], 1000 / r["fps"], dissertation.FPS.get((r["scene"], border_of(r)), "-"), r["vbps"],
              dissertation.VBPS.get((r["scene"], border_of(r)), "-")] for r in rows]
    series = {f"{scene} {what}": ([(int(border_of(r).split("x")[0]), r[what]) for r in group], "linespoints")
              for (scene,), group in grouped(rows, "scene").items() for what in ("fps", "vbps")}
    if not rows:
        return []
    return [plotted(out, "figure-13-14", f"client fps and server vbps, {rows[0]['size']}", "border, pixels of width at 1920", "a second", series,
                    dashed=["vbps"]),
            table(["scene", "border", "fps", "ms a frame", "dissertation fps", "vbps", "dissertation vbps"], lines),
            here(findings.of_rates(rows))]


def border_of(row):
    return str(row["border"]).removesuffix(".0")


def response(out):
    rows = tables.read(out / "response.csv")
    if not rows:
        return []
    plain = [r for r in rows if border_of(r) == "0"]
    series = {f"{ping:.0f} ms": ([(r["x"], r["response_ms"]) for r in group], "linespoints")
              for (ping,), group in grouped(plain, "latency_ms").items()}
    parts = [plotted(out, "figure-15", f"response time, {rows[0]['rate_hz']:.0f} cameras a second", "frames predicted ahead, x", "ms", series)]
    bordered = {border_of(g[0]): ([(r["x"], r["response_ms"]) for r in g], "linespoints")
                for g in grouped([r for r in rows if r["latency_ms"] == 100], "border").values()}
    if len(bordered) > 1:
        parts.append(plotted(out, "figure-15-borders", "response time at 100 ms by border", "frames predicted ahead, x", "ms", bordered))
    every_x = sorted({r["x"] for r in plain})
    parts.append(f"<p>Median ms from a camera to its picture; a frame takes {1000 / rows[0]['rate_hz']:.0f} ms.</p>")
    parts.append(table(["latency", *(f"x = {x:.0f}" for x in every_x)],
                       [[name, *(y for _, y in sorted(points))] for name, (points, _) in series.items()]))
    parts.append(here(findings.of_response({name: points for name, (points, _) in series.items()}, 1000 / rows[0]["rate_hz"])))
    return parts


def clients(out):
    rows = tables.read(out / "clients.csv")
    if not rows:
        return []
    plain = [r for r in rows if border_of(r) == "0"]
    series = {scene: ([(r["clients"], r["vbps"]) for r in group], "linespoints") for (scene,), group in grouped(plain, "scene").items()}
    lines = [[r["scene"], border_of(r), r["clients"], r["vbps"], said_of(r), r["p50_ms"], r["p99_ms"]] for r in rows]
    return [plotted(out, "figure-16", f"vbps of all clients together, {rows[0]['size']}", "clients", "vbps", series, log_x=True),
            table(["scene", "border", "clients", "vbps", "dissertation vbps", "p50 ms", "p99 ms"], lines),
            here(findings.of_clients({scene: {r["clients"]: r["vbps"] for r in group} for (scene,), group in grouped(plain, "scene").items()}))]


def said_of(row):
    said = {1: dissertation.VBPS, 2: dissertation.VBPS_OF_TWO}.get(int(row["clients"]), {})
    return said.get((row["scene"], border_of(row)), "-")


def sharing(out):
    rows = tables.read(out / "sharing.csv")
    if not rows:
        return []
    series = {f"{kind}": ([(r["clients"], r["host_mb"] + r["device_mb"]) for r in group], "linespoints")
              for (kind,), group in grouped(rows, "kind").items()}
    lines = [[r["kind"], r["clients"], r["host_mb"], r["device_mb"], r["last_client_ready_s"]] for r in rows]
    return [plotted(out, "sharing", "memory of gnomond, host and device", "clients in one scene", "MB", series),
            table(["scene is", "clients", "host MB", "device MB", "last client has its first frame after, s"], lines)]


def remote(out):
    rows = tables.read(out / "remote.csv")
    if not rows:
        return []
    modes = grouped(rows, "scene", "mode")
    parts = []
    for metric, label in (("response_ms", "median response time, ms"), ("mbit_per_s", "received, Mbit/s"), ("ssim", "SSIM")):
        series = {f"{scene} {mode}": ([(r["link_mbit"], r[metric]) for r in group], "linespoints")
                  for (scene, mode), group in modes.items() if all(metric in r and r[metric] != "" for r in group)}
        if series and len(rows) > 2:
            parts.append(plotted(out, f"remote-{metric}", f"{label}, {rows[0]['size']}", "link, Mbit/s", label, series, log_x=True,
                                 size="520,380", key="below height 1", dashed=["video"], y_range="*:*" if metric == "ssim" else "0:*"))
    parts.append(f"<p>The same links (50 ms of round trip), scenes, device, sizes and {rows[0]['rate_hz']:.0f} cameras a second; pacing, "
                 "feedback and rate are the same code. Video: H.264 by libx264 without delay, its quality measured on what came. "
                 "Visibility: mode auto; its quality is Figure 12's at as many milliseconds ahead as it chose in the mean, as its pictures "
                 "are the client's own but for predicted bits. A client for video needs a decoder; one for visibility rasterises.</p>")
    columns = ["fps", "response_ms", "bytes_per_frame", "mbit_per_s", "ssim", "psnr", "vif"]
    parts.append(table(["scene", "link, Mbit/s", "sent", "pictures a second", "response, ms", "bytes a picture", "Mbit/s", "SSIM", "PSNR", "VIF"],
                       [[r["scene"], r["link_mbit"], r["mode"], *(r.get(c, "-") for c in columns)] for r in rows]))
    parts.append(here(findings.of_remote({key: {r["mode"]: r for r in group} for key, group in grouped(rows, "scene", "link_mbit").items()})))
    return parts


def pictures(out):
    parts = []
    for file in sorted(out.glob("picture-*-fresh.png")):
        stem = file.name.removesuffix("-fresh.png")
        scene, x = stem.removeprefix("picture-").rsplit("-", 1)
        for part in ("predicted", "fresh", "difference"):
            parts.append(picture(out / f"{stem}-{part}.png", f"{scene}, x = {x}: {part}"))
    return parts


CHAPTERS = [("errors", "Figure 10: prediction error", errors), ("pictures", "What prediction looks like", pictures),
            ("auto", "Choosing x while the link changes", automatic), ("videos", "Figure 12: video quality", videos),
            ("rates", "Figures 13 and 14: frame rates", rates), ("response", "Figure 15: response time", response),
            ("clients", "Figure 16: several clients", clients), ("sharing", "Sharing scenes", sharing),
            ("remote", "Visibility against video", remote)]


def write(out, machine):
    parts = ["<!doctype html><meta charset=utf-8><title>Gnomon: the evaluation</title>", f"<style>{STYLE}</style>",
             "<h1>The dissertation's evaluation, measured with Gnomon</h1>",
             "<p>Scenes: " + "; ".join(f"<b>{ours}</b> stands for its {theirs}" for ours, theirs in dissertation.SCENES.items()) +
             ". Borders are named as at 1920x1080 and are in proportion at other sizes.</p>"]
    for name, title, chapter in CHAPTERS:
        content = chapter(out)
        if not content:
            continue
        parts.append(f"<h2>{html.escape(title)}</h2>")
        where = machine.get(name)
        if where:
            parts.append(f'<p class="machine">{html.escape(where["device"])}; {html.escape(where["cpu"])}; {where["date"]}, {where["took_s"]:.0f} s</p>')
        parts.append(f'<p class="says">The dissertation: {html.escape(dissertation.SAYS[name])}</p>')
        parts += content
    (out / "report.html").write_text("\n".join(parts))
