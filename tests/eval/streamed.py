"""Visibility against video over the same links: Gnomon's thin client, and gnomon-remote, whose server shades and sends
H.264."""
import functools
import json
import subprocess
import tempfile
from pathlib import Path

import offline
import online
import tables
from served import serving

PATH_SECONDS = {"living_room": 14, "temple": 50}
ROUND_TRIP_MS = 50


def frames_of(args):
    """As many as fly the path at its own speed."""
    seconds = 2 if args.quick else PATH_SECONDS.get(args.scene, 14)
    return round(seconds * args.rate)


def video_row(args, mbit):
    """Quality by ffmpeg's filters, of what came against what was rendered."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        command = [args.bin / "gnomon-remote", "--scene", args.scene, "--size", args.size, "--frames", frames_of(args), "--rate", args.rate,
                   "--link", f"delay={ROUND_TRIP_MS / 2}ms,rate={mbit}mbit", "--device", args.device, "--cache", args.cache,
                   "--out", folder, "--json", folder / "remote.json"]
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
        for name in ("shown", "ideal"):
            subprocess.run(["ffmpeg", "-loglevel", "error", "-i", folder / f"{name}.mp4", "-f", "rawvideo", "-pix_fmt", "rgb24",
                            folder / f"{name}.rgb"], check=True)
        row = json.load(open(folder / "remote.json"))["rows"][0]
        row.pop("psnr")  # of RGB; the filter's is of what video keeps
        return row | offline.quality(args.size, folder / "ideal.rgb", folder / "shown.rgb")


def visibility_row(args, mbit):
    """Quality as Figure 12 has it for as many milliseconds ahead as `auto` chose in the mean."""
    border = online.scaled("128x72", args.size)
    with serving(args, "fair", online.TENANTS) as daemon, online.Link(args, daemon, ROUND_TRIP_MS, "--rate", f"{mbit}mbit") as link:
        row = online.client(args, daemon, args.size, frames_of(args), link.server, mode="auto", rate=args.rate, border=border)
    x = round(row["mean_x"] * offline.VIDEO_FPS / args.rate)
    row |= {"mbit_per_s": 8e-6 * row["bytes_per_frame"] * row["vbps"], "response_ms": row["response_p50_ms"], "frames_ahead_at_30": x}
    seen = [v for v in tables.read(args.out / "videos.csv") if v["scene"] == args.scene and v["x"] <= x]
    return row | {m: seen[-1][m] for m in ("ssim", "psnr", "vif") if seen}


def remote(args):
    for scene in args.scene:
        for mbit in [10] if args.quick else args.links:
            for mode, measure in (("visibility", visibility_row), ("video", video_row)):
                yield f"{scene}-{mbit}-{mode}", functools.partial(compared, online.of_scene(args, scene), mbit, mode, measure)


def compared(args, mbit, mode, measure):
    row = measure(args, mbit)
    print(f"    {row['response_ms']:.0f} ms, {row['mbit_per_s']:.2f} Mbit/s", flush=True)
    keep = ("fps", "response_ms", "bytes_per_frame", "mbit_per_s", "ssim", "psnr", "vif", "frames_ahead_at_30")
    return [{"scene": args.scene, "size": args.size, "rate_hz": args.rate, "link_mbit": mbit, "mode": mode,
             **{key: row[key] for key in keep if key in row}}]


STAGES = {"remote": remote}
