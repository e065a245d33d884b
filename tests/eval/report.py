"""One self-contained page of what the stages left: for each figure a plot, a table beside the dissertation's numbers, the
machine that it was measured on."""
import base64
import html

import dissertation
import findings
import plots
import policies
import spread
import tables

STYLE = """body{font:15px/1.5 sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}
table{border-collapse:collapse;margin:.8em 0}td,th{border-bottom:1px solid #ddd;padding:.15em .8em;text-align:right}
th{background:#f4f4f4}td:first-child,th:first-child{text-align:left}.machine,.says{color:#555}.here{border-left:3px solid #2a9d8f;padding-left:.8em}figure{display:inline-block;margin:.5em}
img{max-width:100%}figcaption{font-size:13px;color:#555}"""


def cell(value):
    if isinstance(value, float):
        return f"{value:.0f}" if value == int(value) and abs(value) < 1e6 else f"{value:.3g}" if abs(value) < 100 else f"{value:.0f}"
    return html.escape(str(value))


class Table(str):
    """HTML, and what it was made of."""

    def __new__(cls, columns, rows):
        head = "".join(f"<th>{html.escape(column)}</th>" for column in columns)
        body = "".join("<tr>" + "".join(f"<td>{cell(value)}</td>" for value in row) + "</tr>" for row in rows)
        made = super().__new__(cls, f"<table><tr>{head}</tr>{body}</table>")
        made.columns, made.rows = columns, rows
        return made


def picture(file, caption=""):
    kind = "svg+xml" if file.suffix == ".svg" else "png"
    data = base64.b64encode(file.read_bytes()).decode()
    return f'<figure><img src="data:image/{kind};base64,{data}"><figcaption>{html.escape(caption)}</figcaption></figure>'


class Here(str):
    """What is found here, beside what the dissertation says."""

    def __new__(cls, text):
        made = super().__new__(cls, f'<p class="here">Here: {html.escape(text)}</p>' if text else "")
        made.text = text
        return made


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
        parts.append(Table(["border", *(f"x = {x:.0f}" for x in some_x)], lines))
        parts.append(Here(findings.of_errors(by_border)))
    if not parts:
        return []
    file = out / "figure-10.svg"
    plots.side_by_side(file, "frames predicted ahead, x", "wrong bits per light, % of the picture", curves, key="left top", x_step=2)
    return [picture(file, "Wrong bits per light for each border"), *parts]


def automatic(out):
    parts = []
    for file in sorted(out.glob("auto-*.csv")):
        rows = tables.read(file)
        scene = rows[0]["scene"]
        compared = policies.compared(rows)
        kinds = grouped([r for r in rows if r["seed"] == 1], "policy")
        series = {policy: ([(r["response_ms"], 100 * r["error_share"]) for r in group], "points" if "switching" in policy else "linespoints")
                  for (policy,), group in kinds.items()}
        parts.append(plotted(out, f"auto-{scene}", f"{scene}: error against response time, round trips of 5 to 230 ms", "mean response time, ms",
                             "mean wrong bits, %", series))
        lines = [[c.name, c.response.text(1), c.error.text(2), c.ours.text(2) if c.ours else "-", c.verdict] for c in compared]
        parts.append(Here(policies.said(scene, compared)))
        parts.append(Table(["policy", "response, ms", "error, %", "auto's error at no later response, %", "auto's is"], lines))
    return parts


def videos(out):
    rows = tables.read(out / "videos.csv")
    parts = []
    for metric, label in (("ssim", "SSIM"), ("psnr", "PSNR, dB"), ("vif", "VIF"), ("vmaf", "VMAF")):
        if rows and metric in rows[0]:
            series = {scene: ([(r["x"], r[metric]) for r in group], "linespoints") for (scene,), group in grouped(rows, "scene").items()}
            parts.append(plotted(out, f"figure-12-{metric}", f"{label} of predicted against fresh video, 30 fps", "frames predicted ahead, x", label,
                                 series, size="520,360", key="below height 1", y_range="*:*", x_step=1))
    metrics = [m for m in ("ssim", "psnr", "vif", "vmaf") if rows and m in rows[0]]
    if not rows:
        return []
    seconds = "; ".join(f"{scene}: {group[0]['seconds']:.0f} s" for (scene,), group in grouped(rows, "scene").items())
    parts.append(f"<p>{rows[0]['size']}, 30 frames a second, from the beginning of each path ({seconds}), border 128x72.</p>")
    by_x = {x: {r["scene"]: r for r in group} for (x,), group in grouped(rows, "x").items()}
    scenes = list(dict.fromkeys(r["scene"] for r in rows))
    parts.append(Table(["x", *(f"{scene}: {m.upper()}" for scene in scenes for m in metrics)],
                       [[x, *(found[scene][m] if scene in found else "-" for scene in scenes for m in metrics)] for x, found in by_x.items()]))
    for metric in metrics:
        parts.append(Here(findings.of_videos({scene: {r["x"]: r[metric] for r in group} for (scene,), group in grouped(rows, "scene").items()},
                                             metric.upper())))
    return parts


def of_its_size(rows, numbers, column):
    """A column of the dissertation's numbers, if these rows are of its size; `numbers`: key -> its number."""
    if not rows or rows[0]["size"] != dissertation.SIZE:
        return [], lambda key: []
    return [f"{column}, {dissertation.CARD} (dissertation)"], lambda key: [numbers.get(key, "-")]


def rates(out):
    rows = tables.read(out / "rates.csv")
    if not rows:
        return []
    for row in rows:
        row["border"] = border_of(row)
    fps, vbps = (spread.by(rows, column, "scene", "border") for column in ("fps", "vbps"))
    fps_column, their_fps = of_its_size(rows, dissertation.FPS, "pictures a second")
    vbps_column, their_vbps = of_its_size(rows, dissertation.VBPS, "vbps")
    lines = [[*key, fps[key].text(), *their_fps(key), vbps[key].text(), *their_vbps(key)] for key in fps]
    series = {f"{scene} {what}": ([(int(border.split("x")[0]), figure.median) for (of, border), figure in figures.items() if of == scene], "linespoints")
              for scene in dict.fromkeys(key[0] for key in fps) for what, figures in (("fps", fps), ("vbps", vbps))}
    return [plotted(out, "figure-13-14", f"client fps and server vbps, {rows[0]['size']}", "border, pixels of width at 1920", "a second", series,
                    dashed=["vbps"]),
            Table(["scene", "border", "pictures a second", *fps_column, "vbps", *vbps_column], lines),
            Here(findings.of_rates(fps, vbps))]


def border_of(row):
    return str(row["border"]).removesuffix(".0")


def response(out):
    rows = tables.read(out / "response.csv")
    if not rows:
        return []
    plain = [r for r in rows if border_of(r) == "0"]
    figures = spread.by(plain, "response_ms", "latency_ms", "x")
    pings, every_x = (sorted({key[i] for key in figures}) for i in (0, 1))
    series = {f"{ping:.0f} ms": ([(x, figure.median) for (of, x), figure in figures.items() if of == ping], "linespoints") for ping in pings}
    parts = [plotted(out, "figure-15", f"response time, {rows[0]['rate_hz']:.0f} cameras a second", "frames predicted ahead, x", "ms", series, x_step=1)]
    bordered = spread.by([r for r in rows if r["latency_ms"] == 100], "response_ms", "border", "x")
    borders = {border_of({"border": border}): border for border, _ in bordered}
    if len(borders) > 1:
        parts.append(plotted(out, "figure-15-borders", "response time at 100 ms by border", "frames predicted ahead, x", "ms",
                             {name: ([(x, figure.median) for (of, x), figure in bordered.items() if of == border], "linespoints")
                              for name, border in borders.items()}, x_step=1))
    frame_ms = 1000 / rows[0]["rate_hz"]
    parts.append(f"<p>Median ms from a camera to its picture, drawing included; a frame takes {frame_ms:.1f} ms, and response times come in "
                 "steps of it: smaller differences do not show.</p>")
    parts.append(Table(["latency", *(f"x = {x:.0f}" for x in every_x)],
                       [[f"{ping:.0f} ms", *(figures[ping, x].text(1) if (ping, x) in figures else "-" for x in every_x)] for ping in pings]))
    repeats = {ping: {repeat: [(r["x"], r["response_ms"]) for r in group]
                      for (of, repeat), group in grouped(plain, "latency_ms", "repeat").items() if of == ping} for ping in pings}
    parts.append(Here(findings.of_response(repeats, frame_ms)))
    return parts


def clients(out):
    rows = tables.read(out / "clients.csv")
    if not rows:
        return []
    for row in rows:
        row["border"] = border_of(row)
    figures = {column: spread.by(rows, column, "scene", "border", "clients") for column in ("vbps", "p50_ms", "p99_ms")}
    plain = {scene: {count: figure for (of, border, count), figure in figures["vbps"].items() if of == scene and border == "0"}
             for scene in dict.fromkeys(r["scene"] for r in rows)}
    series = {scene: ([(count, figure.median) for count, figure in counts.items()], "linespoints") for scene, counts in plain.items()}
    said = {(*key, float(count)): value for count, numbers in ((1, dissertation.VBPS), (2, dissertation.VBPS_OF_TWO))
            for key, value in numbers.items()}
    column, theirs = of_its_size(rows, said, "vbps")
    lines = [[*key, figure.text(), *theirs(key), figures["p50_ms"][key].text(1), figures["p99_ms"][key].text(1)]
             for key, figure in figures["vbps"].items()]
    return [plotted(out, "figure-16", f"vbps of all clients together, {rows[0]['size']}", "clients", "vbps", series, log_x=True),
            Table(["scene", "border", "clients", "vbps", *column, "p50 ms", "p99 ms"], lines),
            Here(findings.of_clients(plain))]


def sharing(out):
    rows = tables.read(out / "sharing.csv")
    if not rows:
        return []
    series = {f"{kind}": ([(r["clients"], r["host_mb"] + r["device_mb"]) for r in group], "linespoints")
              for (kind,), group in grouped(rows, "kind").items()}
    lines = [[r["kind"], r["clients"], r["host_mb"], r["device_mb"], r["last_client_ready_s"]] for r in rows]
    return [plotted(out, "sharing", "memory of gnomond, host and device", "clients in one scene", "MB", series),
            Table(["scene is", "clients", "host MB", "device MB", "last client has its first frame after, s"], lines),
            "<p>The first client's time, and each one's with a daemon of its own, has the daemon's start in it, the reading of the scene and "
            "the building of its hierarchies. A further client of a shared scene waits for its session and one frame alone.</p>"]


REMOTE = {"response_ms": ("response, ms", 0), "late_share": ("late, % of the steps", 1), "ssim": ("SSIM", 3), "vmaf": ("VMAF", 1),
          "psnr": ("PSNR, dB", 1), "mbit_per_s": ("Mbit/s", 1), "fps": ("pictures a second", 1), "x": ("frames ahead", 0)}
LINK = ("loss_percent", "round_trip_ms", "link_mbit")


def remote_rows(out):
    rows = tables.read(out / "remote.csv")
    for row in rows:
        row["late_share"] *= 100
    return rows


def remote(out):
    rows = remote_rows(out)
    if not rows:
        return []
    figures = {column: spread.by(rows, column, "scene", *LINK, "mode") for column in REMOTE}
    columns = [column for column in REMOTE if figures[column]]
    lines = [[key[0], *(f"{part:.0f}" for part in key[1:4]), key[4],
              *(figures[c][key].text(REMOTE[c][1]) if key in figures[c] else "-" for c in columns)] for key in sorted(figures["response_ms"])]
    return [f"<p>{JUDGED.format(size=rows[0]['size'], rate=rows[0]['rate_hz'])}</p>",
            Table(["scene", "loss, %", "round trip, ms", "link, Mbit/s", "sent", *(REMOTE[c][0] for c in columns)], lines),
            Here(findings.of_remote(figures))]


JUDGED = ("Both fly the same seconds of the path at {size} and {rate:.0f} cameras a second over the same links; pacing, feedback, parity and "
          "rate are the same code. Video: H.264 by libx264 (veryfast, no delay). Visibility: mode auto, border 128x72. At each camera's end "
          "what is on the screen is judged by the picture that was meant: its own camera's; but where it is more than one camera older than "
          "this flight's pictures usually are, as a later one was lost or late, by that of the camera that should have been there. Such steps "
          "are the late ones. The first second is not judged. A client for video needs a decoder; one for visibility rasterises.")


def pictures(out):
    parts = []
    for file in sorted(out.glob("picture-*-fresh.png"), key=lambda f: [int(p) if p.isdigit() else p for p in f.stem.split("-")]):
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


def measured_on(where, stage):
    """Device, size, repeats, commit, command and date of a stage."""
    size = where["small"] if stage in ("response", "sharing") else where["size"]
    repeats = "the same bytes in every run" if stage in ("errors", "videos", "pictures") else f"{where.get('repeats', 1)} repeats: median (range)"
    jobs = f", {where['jobs']} parts at once" if where.get("jobs", 1) > 1 else ""
    return (f"{where['device']}; {where['cpu']}; {size}; {repeats}{jobs}; commit {where.get('commit', 'unknown')}; "
            f"{where.get('command', 'unknown')}; {where['date']}")


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
            parts.append(f'<p class="machine">{html.escape(measured_on(where, name))}</p>')
        parts.append(f'<p class="says">The dissertation: {html.escape(dissertation.SAYS[name])}</p>')
        parts += content
    (out / "report.html").write_text("\n".join(parts))
