"""Visibility against video over the same links: gnomon-remote flies Gnomon's thin client, and a client of its own server,
which shades and sends H.264. Both are judged by what was on the screen at each camera (remote/screen.h), so that
pictures that never came or came late count."""
import functools
import json
import subprocess
import tempfile
from pathlib import Path

import offline
import online
from served import serving

KEPT = ("fps", "response_ms", "response_p99_ms", "mbit_per_s", "late_share", "x", "vbps", "render_ms", "encode_ms", "decode_ms", "ssim", "psnr", "vif", "vmaf")


def flown(args, *more):
    """One flight of gnomon-remote, judged by ffmpeg's filters."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        seconds = 2 if args.quick else args.seconds
        command = [args.bin / "gnomon-remote", "--scene", args.scene, "--size", args.size, "--frames", round(seconds * args.rate), "--rate",
                   args.rate, "--from", 2, "--device", args.device, "--cache", args.cache, "--out", folder, "--json", folder / "remote.json", *more]
        subprocess.run([str(part) for part in command], check=True, stdout=subprocess.DEVNULL)
        row = json.load(open(folder / "remote.json"))["rows"][0]
        return row | offline.quality(args, folder / "ideal.rgb", folder / "shown.rgb")


def video_row(args, link, seed):
    profile = f"delay={link['round_trip_ms'] / 2}ms,rate={link['link_mbit']}mbit,loss={link['loss_percent']}%"
    return flown(args, "--link", profile, "--seed", seed)


def visibility_row(args, link, seed):
    with serving(args, "fair", online.TENANTS) as daemon:
        loss = f"{link['loss_percent']}%"
        with online.Link(args, daemon, link["round_trip_ms"], "--loss", loss, "--down", f"rate={link['link_mbit']}mbit", "--seed", str(seed)) as netsim:
            return flown(args, "--server", netsim.server, "--pin", daemon.pin, "--tenant", "eval", "--border", online.scaled("128x72", args.size))


def remote(args):
    links = [{"link_mbit": mbit, "round_trip_ms": ms, "loss_percent": loss} for loss in ([0] if args.quick else args.losses)
             for ms in ([50] if args.quick else args.round_trips) for mbit in ([10] if args.quick else args.links)]
    parts = []
    for scene in args.scene:
        for link in links:
            name = f"{scene}-{link['link_mbit']}-{link['round_trip_ms']}ms-{link['loss_percent']}"
            parts.append((name, functools.partial(compared, online.of_scene(args, scene), link)))
    for repeat in range(1, args.repeats + 1):
        for name, part in parts:
            yield f"{name}-{repeat}", functools.partial(part, repeat)


def compared(args, link, repeat):
    rows = []
    for mode, measure in (("visibility", visibility_row), ("video", video_row)):
        row = measure(args, link, repeat)
        print(f"    {mode}: {row['response_ms']:.0f} ms, {row['mbit_per_s']:.2f} Mbit/s, SSIM {row.get('ssim')}, late {row['late_share']:.3f}", flush=True)
        rows.append({"scene": args.scene, "size": args.size, "rate_hz": args.rate, **link, "mode": mode, "repeat": repeat,
                     **{key: row[key] for key in KEPT if key in row}})
    return rows


STAGES = {"remote": remote}
