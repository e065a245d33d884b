"""What needs no network: gnomon-eval renders the paths, this machine's device traces them."""
import concurrent.futures
import functools
import os
import re
import subprocess

import tables

FPS = {"living_room": 60, "temple": 58}  # dissertation 4.1.1
VIDEO_SECONDS = {"living_room": 14, "temple": 20}  # 4.1.3
VIDEO_FPS = 30


QUICK_SIZE = "480x270"  # where bits are counted: on few pixels most of them lie at edges of shadows


def eval_program(args, what, scene, out, *more):
    size = QUICK_SIZE if args.quick and what in ("errors", "auto") else args.size
    command = [args.bin / "gnomon-eval", what, "--scene", scene, "--size", size, "--cache", args.cache, "--out", out,
               "--device", args.device, *more]
    subprocess.run([str(part) for part in command], check=True)


def by_scene(measure):
    """A stage that has a part for each scene."""
    return lambda args: ((scene, functools.partial(measure, args, scene)) for scene in args.scene)


def errors(args, scene):
    """Figure 10. The living room's path is flown twice there; the second time is the same frames."""
    quick = ["--seconds", 1, "--from", 2] if args.quick else []
    eval_program(args, "errors", scene, args.out / f"errors-{scene}.csv", "--fps", FPS.get(scene, 60), "--stride",
                 6 if args.quick else args.stride, *quick)


def automatic(args, scene):
    """Policies for x over the frames' errors, in virtual time."""
    frames = args.out / f"errors-{scene}.csv.frames"
    if not frames.exists():
        raise SystemExit("stage auto needs what stage errors leaves")
    quick = ["--from", 2] if args.quick else []
    rows = []
    for seed in range(1, args.repeats + 1):  # of the link
        file = args.out / f"auto-{scene}.csv.{seed}"
        eval_program(args, "auto", scene, file, "--errors", frames, "--fps", FPS.get(scene, 60), "--seed", seed, *quick)
        rows += [{**row, "seed": seed} for row in tables.read(file)]
        file.unlink()
    tables.write(args.out / f"auto-{scene}.csv", rows)


def pictures(args, scene):
    for x in (4, 19):
        eval_program(args, "pictures", scene, args.out / f"picture-{scene}-{x}", "--x", x, "--from", 3, "--seconds", 0.1)


@functools.cache
def has_filter(name):
    return f" {name} " in subprocess.run(["ffmpeg", "-hide_banner", "-filters"], capture_output=True, text=True).stdout


def quality(args, reference, distorted):
    """Figures of ffmpeg's filters for two raw videos."""
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", args.size, "-r", str(VIDEO_FPS)]
    filters = {"ssim": r"All:([\d.]+)", "psnr": r"PSNR .*?average:(inf|[\d.]+)", "vif": r"VIF scale=0 average:([\d.]+)"}
    filters = {name: pattern for name, pattern in filters.items() if has_filter(name)}
    graph = ";".join(f"[0:v]format=yuv420p,split={len(filters)}" + "".join(f"[d{i}]" for i in range(len(filters)))
                     if part == "d" else f"[1:v]format=yuv420p,split={len(filters)}" + "".join(f"[r{i}]" for i in range(len(filters)))
                     for part in "dr")
    graph += "".join(f";[d{i}][r{i}]{name}[o{i}]" for i, name in enumerate(filters))
    command = ["nice", "ffmpeg", "-hide_banner", "-nostats", *raw, "-i", distorted, *raw, "-i", reference, "-filter_complex", graph]
    for i in range(len(filters)):
        command += ["-map", f"[o{i}]", "-f", "null", "-"]
    log = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    found = {name: re.search(pattern, log) for name, pattern in filters.items()}
    return {name: float(match.group(1)) for name, match in found.items() if match} | vmaf(args.vmaf_every, raw, reference, distorted)


def vmaf(every, raw, reference, distorted):
    """Where this ffmpeg has it. GNOMON_VMAF_MODEL: the file vmaf_v0.6.1.pkl, for an ffmpeg before 5.0, which has none in it."""
    if not every or not has_filter("libvmaf"):
        return {}
    model = os.environ.get("GNOMON_VMAF_MODEL")
    options = f"libvmaf=n_threads=4:n_subsample={every}" + (f":model_path={model}" if model else "")
    both = f"[0:v]format=yuv420p[d];[1:v]format=yuv420p[r];[d][r]{options}"
    command = ["nice", "ffmpeg", "-hide_banner", "-nostats", *raw, "-i", distorted, *raw, "-i", reference, "-lavfi", both, "-f", "null", "-"]
    log = subprocess.run(command, capture_output=True, text=True, check=True).stderr
    return {"vmaf": float(re.search(r"VMAF score[:=] *([\d.]+)", log).group(1))}


def videos(args, scene):
    """Figure 12: video of each x against the video of x = 0, 30 frames a second. The same bytes in every run."""
    every_x = [0, 1, 4, 10] if args.quick else [0, *args.ahead]
    seconds = 0.7 if args.quick else args.video_seconds or VIDEO_SECONDS.get(scene, 14)
    prefix = args.out / f"video-{scene}"
    files = {x: f"{prefix}-{x}.rgb" for x in every_x}
    try:
        eval_program(args, "video", scene, prefix, "--fps", VIDEO_FPS, "--seconds", seconds, "--from", 2 if args.quick else 0,
                     *[part for x in every_x for part in ("--x", x)])
        predicted = [x for x in every_x if x > 0]
        with concurrent.futures.ThreadPoolExecutor(max(1, (os.cpu_count() or 1) // 2)) as pool:
            figures = pool.map(lambda x: quality(args, files[0], files[x]), predicted)
        return [{"scene": scene, "size": args.size, "seconds": seconds, "x": x, **row} for x, row in zip(predicted, figures)]
    finally:
        for file in files.values():
            if os.path.exists(file):
                os.remove(file)


STAGES = {"errors": by_scene(errors), "auto": by_scene(automatic), "videos": by_scene(videos), "pictures": by_scene(pictures)}
