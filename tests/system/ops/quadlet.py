"""Debian 13's Quadlet: Debian 12's podman has none. Only its program and what it loads is kept, in BUILD/ops/quadlet."""
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

from debian_root import bootstrap

PARTS = ("/usr/libexec/podman/quadlet", "/usr/lib64/ld-linux-x86-64.so.2", "/usr/lib/x86_64-linux-gnu/libc.so.6")


def fetch(build):
    """The folder with it."""
    kept = build / "ops/quadlet"
    if not kept.is_dir():
        with tempfile.TemporaryDirectory(prefix="gnomon-trixie-") as folder:
            root = pathlib.Path(folder, "root")
            bootstrap(root, "trixie", "--variant=extract", "--include=podman")  # unpacked alone: nothing of it is set up
            part = kept.with_suffix(".part")
            shutil.rmtree(part, ignore_errors=True)
            part.mkdir(parents=True)
            for name in PARTS:
                shutil.copy(root / name.lstrip("/"), part)
            os.replace(part, kept)
    return kept


def generate(program, folder):
    """What Quadlet makes of the files there: exit status, complaints, units by name."""
    loader = program / pathlib.Path(PARTS[1]).name
    done = subprocess.run([loader, "--library-path", program, program / "quadlet", "-dryrun"], text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          env={**os.environ, "QUADLET_UNIT_DIRS": str(folder)})
    parts = re.split(r"^---(\S+\.service)---\n", done.stdout, flags=re.M)
    complaints = [line for line in done.stderr.splitlines() if "Loading source unit file" not in line]
    return done.returncode, complaints, dict(zip(parts[1::2], parts[2::2]))
