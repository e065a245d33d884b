"""What needs the daemon: frame rates, response times, many clients, shared scenes."""
import argparse
import concurrent.futures
import functools
import json
import re
import statistics
import subprocess
import sys
import tempfile
import time

from served import MeasuredNode, serving

BORDERS = {"0": (0, 0), "64x36": (64, 36), "128x72": (128, 72)}
TENANTS = [{"name": "eval"}]


def of_scene(args, scene):
    return argparse.Namespace(**{**vars(args), "scene": scene})


def scaled(border, size):
    """A border of the dissertation's in proportion to the picture."""
    width, height = (int(side) for side in size.split("x"))
    x, y = BORDERS[border]
    return f"{round(x * width / 1920)}x{round(y * height / 1080)}"


def client(args, daemon, size, frames, server=None, **options):
    """One flight of gnomon-client: its row of figures."""
    with tempfile.NamedTemporaryFile(suffix=".json") as file:
        command = [args.bin / "gnomon-client", "--server", server or daemon.control, "--pin", daemon.pin, "--tenant", "eval",
                   "--scene", args.scene, "--size", size, "--frames", frames, "--device", args.device, "--json", file.name]
        for key, value in options.items():
            command += ["--" + key.replace("_", "-"), value]
        done = subprocess.run([str(part) for part in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if done.returncode != 0:
            print(re.split(r"[\r\n]", done.stderr.strip())[-1], file=sys.stderr, flush=True)
            done.check_returncode()
        return json.load(open(file.name))["rows"][0]


def frames_for(args, daemon, size, **options):
    """How many frames a flight of args.seconds takes: from a short one, and from one that is as long as a rate takes to be found."""
    frames = 30
    for seconds in (min(2, args.seconds), args.seconds):
        row = client(args, daemon, size, frames, **options)
        frames = max(30, int(seconds * row["fps"]))
    return frames


def repeated(args, parts):
    """Each part as many times as --repeats says, one round after the other, so that what drifts is in the spread."""
    for repeat in range(1, args.repeats + 1):
        for name, part in parts:
            yield f"{name}-{repeat}", functools.partial(one_repeat, part, repeat)


def one_repeat(part, repeat):
    return [{**row, "repeat": repeat} for row in part()]


def rates(args):
    """Figures 13 and 14: one client that predicts, as fast as it can."""
    return repeated(args, [(f"{scene}-{border}", functools.partial(rate, of_scene(args, scene), border))
                           for scene in args.scene for border in args.borders])


def rate(args, border):
    with serving(args, "fair", TENANTS) as daemon:
        options = {"mode": "predicted", "ahead": 4, "border": scaled(border, args.size)}
        row = client(args, daemon, args.size, frames_for(args, daemon, args.size, **options), **options)
    print(f"    {row['fps']:.1f} fps, {row['vbps']:.1f} vbps", flush=True)
    return [{"scene": args.scene, "size": args.size, "border": border, "fps": row["fps"], "vbps": row["vbps"]}]


class Link:
    """netsim before a daemon: that round trip more."""

    def __init__(self, args, daemon, round_trip_ms, *more):
        data = re.search(r" data=(\S+)", daemon.log_text()).group(1).split(",")
        control = daemon.control.rsplit(":", 1)[1]
        self.server = f"127.0.0.2:{control}"
        self.process = subprocess.Popen([args.bin / "netsim", "--tcp", control, "--udp", *data, "--delay",
                                         f"{round_trip_ms / 2}ms", *more], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        time.sleep(0.5)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        self.process.wait()


def response(args):
    """Figure 15: for several round trips, and at 100 ms for each border."""
    parts = []
    for ping in [20, 100] if args.quick else args.pings:
        for border in BORDERS if ping == 100 and not args.quick else ["0"]:
            parts.append((f"{args.scene[0]}-{ping}ms-{border}", functools.partial(responses, of_scene(args, args.scene[0]), ping, border)))
    return repeated(args, parts)


def responses(args, ping, border):
    frames = max(20, int(args.rate * min(args.seconds, 3)))
    rows = []
    with serving(args, "fair", TENANTS) as daemon, Link(args, daemon, ping) as link:
        client(args, daemon, args.small, 12, mode="predicted")
        for x in [0, 1, 2] if args.quick else [0, *args.ahead]:
            row = client(args, daemon, args.small, frames, link.server, mode="predicted", ahead=x, rate=args.rate,
                         border=scaled(border, args.small))
            drawing_ms = 1000 * row["draw_seconds"] / max(1, row["shown"])
            rows.append({"scene": args.scene, "size": args.small, "rate_hz": args.rate, "latency_ms": ping, "border": border, "x": x,
                         "response_ms": row["response_p50_ms"] + drawing_ms, "drawing_ms": drawing_ms, "vbps": row["vbps"]})
    return rows


def clients(args):
    """Figure 16: what the server sends in a second to one client and to more."""
    return repeated(args, [(f"{scene}-{border}", functools.partial(clients_together, of_scene(args, scene), border))
                           for scene in args.scene for border in (["0"] if args.quick else args.borders)])


def clients_together(args, border):
    rows = []
    width, height = (int(side) for side in args.size.split("x"))
    extra = scaled(border, args.size).split("x")
    size = f"{width + int(extra[0])}x{height + int(extra[1])}"
    with serving(args, "fair", TENANTS) as daemon:
        for count in [1, 2, 4] if args.quick else args.clients if border == "0" else [1, 2]:
            # A program of clients is one thread: so many that it is not they who are measured.
            loads = [daemon.load({"eval": min(4, count)}, size, 0, args.seconds) for _ in range((count + 3) // 4)]
            each = [load.tenant_rows()["eval"] for load in loads]
            rows.append({"scene": args.scene, "size": args.size, "border": border, "clients": count,
                         "vbps": sum(row["vbps"] for row in each), "p50_ms": statistics.median(row["p50_ms"] for row in each),
                         "p99_ms": max(row["p99_ms"] for row in each)})
            print(f"    {count} clients: {rows[-1]['vbps']:.1f} vbps", flush=True)
    return rows


def resident_mb(daemon):
    status = open(f"/proc/{daemon.process.pid}/status").read()
    return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024


def device_mb(daemon):
    """Of the scenes on the device; 0 where that is the host's memory."""
    if "llvmpipe" in json.dumps(daemon.status()):
        return 0
    return sum(scene.get("device_memory_bytes", 0) for scene in daemon.status()["scenes"]) / 2**20


def sharing(args):
    """What a further client costs: one more in the same scene, or a daemon with a scene of its own."""
    for kind in ("shared", "separate"):
        yield f"{args.scene[0]}-{kind}", functools.partial(memory_and_time, of_scene(args, args.scene[0]), kind)


def memory_and_time(args, kind):
    if not args.quick:
        args.cache = None  # the time that it takes to build what is shared counts
    rows, daemons = [], []
    try:
        for count in range(1, (2 if args.quick else 4) + 1):
            began = time.monotonic()
            if kind == "separate" or not daemons:
                daemons.append(MeasuredNode(args, "fair", TENANTS).start())
            client(args, daemons[-1], args.small, 1)
            took = time.monotonic() - began
            loads = [daemon.load({"eval": count if kind == "shared" else 1}, args.small, 2, 2) for daemon in daemons]
            with concurrent.futures.ThreadPoolExecutor() as pool:
                list(pool.map(lambda load: load.tenant_rows(), loads))
            rows.append({"kind": kind, "clients": count, "host_mb": sum(map(resident_mb, daemons)),
                         "device_mb": sum(map(device_mb, daemons)), "last_client_ready_s": took})
            print(f"    {count} clients: {rows[-1]['host_mb']:.0f} MB, {took:.1f} s", flush=True)
    finally:
        for daemon in daemons:
            daemon.stop()
    return rows


STAGES = {"rates": rates, "response": response, "clients": clients, "sharing": sharing}
