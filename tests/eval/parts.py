"""A stage in parts. Each leaves its rows in DIR/parts/, so that a run that was stopped goes on where it was (--resume)."""
import json
import time

import tables

SETTINGS = ("size", "stride", "video_seconds", "small", "rate", "seconds", "device", "quick")  # what rows depend on


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
    rows, took, measured = [], 0, []
    for i, (name, part) in enumerate(parts):
        left = f", about {sum(measured) / len(measured) * (len(parts) - i) / 60:.0f} min left" if measured else ""
        file = folder / f"{stage}-{name}.json"
        done = kept(file, args)
        print(f"  {name} ({i + 1} of {len(parts)}{left}){', kept' if done else ''}", flush=True)
        if not done:
            done = measure(file, args, part)
            measured.append(done["took_s"])
        rows += done["rows"]
        took += done["took_s"]
        if rows:
            tables.write(args.out / f"{stage}.csv", rows)
    return took
