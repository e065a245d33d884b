"""What must hold at every size and on every machine, of what the stages left."""
import sys

import tables


def check(out, stages):
    """`stages`: those that were run."""
    wrong = []

    def promise(holds, text):
        if not holds:
            wrong.append(text)

    for file in out.glob("errors-*.csv"):
        rows = {(str(r["border"]).removesuffix(".0"), int(r["x"])): r for r in tables.read(file)}
        share = {key: row["error_share_of_picture"] for key, row in rows.items()}
        promise(share["128x72", 19] > share["128x72", 4] > share["128x72", 1], f"{file.name}: the error does not grow with x")
        promise(share["0", 4] >= share["64x36", 4] >= share["128x72", 4] >= share["640x360", 4],
                f"{file.name}: a border does not lower the error")
        promise(share["128x72", 4] <= 0.02, f"{file.name}: {share['128x72', 4]:.4f} of the bits wrong at x = 4")
    for file in out.glob("auto-*.csv"):
        rows = tables.read(file)
        ours = [r for r in rows if r["policy"] == "auto"]
        waiting = [r for r in rows if r["policy"] == "fixed" and r["response_ms"] > 1 and r["error_share"] > 0]
        beaten = sum(any(r["response_ms"] <= other["response_ms"] and r["error_share"] <= other["error_share"] for r in ours)
                     for other in waiting)
        promise(beaten >= 0.75 * len(waiting), f"{file.name}: auto is as good as {beaten} of {len(waiting)} fixed x alone")
    if "videos" in stages:
        videos = tables.read(out / "videos.csv")
        promise(videos[0]["ssim"] > videos[-1]["ssim"], "videos predicted farther ahead are not less alike")
    if "response" in stages:
        response = tables.read(out / "response.csv")
        at_100 = {int(r["x"]): r["response_ms"] for r in response if r["latency_ms"] == 100}
        promise(at_100[2] < at_100[0], "prediction does not shorten the response time")
    for name in stages & {"rates", "clients", "sharing", "remote"}:
        promise(tables.read(out / f"{name}.csv"), f"{name}.csv is empty")
    promise((out / "report.html").stat().st_size > 10_000, "the report is empty")
    if wrong:
        sys.exit("does not hold:\n  " + "\n  ".join(wrong))
