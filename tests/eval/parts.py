"""A stage in parts. Each leaves its rows in DIR/parts/, so that a run that was stopped goes on where it was (--resume)."""
import concurrent.futures
import json
import time

import tables

SETTINGS = ("size", "stride", "video_seconds", "small", "rate", "seconds", "device", "quick", "ahead", "jobs")  # what rows depend on


def settings(args):
    return {key: getattr(args, key) for key in SETTINGS}


def kept(file, args):
    """What an earlier run with the same settings left of the part, if it did."""
    if not args.resume or not file.exists():
        return None
    part = json.loads(file.read_text())
    return part if part["settings"] == settings(args) else None


def measure(file, args, part):
    began = time.monotonic()
    rows = part() or []
    done = {"settings": settings(args), "rows": rows, "took_s": time.monotonic() - began}
    unfinished = file.with_suffix(".new")
    unfinished.write_text(json.dumps(done, indent=1))
    unfinished.replace(file)
    return done


def run(args, stage, parts):
    """`parts`: (name, function) pairs; what the functions return are rows of DIR/STAGE.csv. Seconds that all of them took."""
    folder = args.out / "parts"
    folder.mkdir(exist_ok=True)
    parts = list(parts)
    measured = []

    def done(i):
        name, part = parts[i]
        jobs = max(1, args.jobs)
        left = f", about {sum(measured) / len(measured) * (len(parts) - i) / jobs / 60:.0f} min left" if measured else ""
        file = folder / f"{stage}-{name}.json"
        known = kept(file, args)
        print(f"  {name} ({i + 1} of {len(parts)}{left}){', kept' if known else ''}", flush=True)
        if not known:
            known = measure(file, args, part)
            measured.append(known["took_s"])
        return known

    rows, took = [], 0
    with concurrent.futures.ThreadPoolExecutor(max(1, args.jobs)) as pool:
        for part in pool.map(done, range(len(parts))):
            rows += part["rows"]
            took += part["took_s"]
            if rows:
                tables.write(args.out / f"{stage}.csv", rows)
    return took
