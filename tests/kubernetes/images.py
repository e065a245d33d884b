"""The images that the cluster's pods are made of, as archives that containerd imports: gnomond's own by the shipped
Containerfile, a door of Debian's HAProxy, and the program that holds a pod's namespaces. Kept in BUILD/ops/kubernetes."""
import pathlib
import shutil
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/ops"))
from containers import IMAGE, Podman  # noqa: E402
from debian_root import kept_root  # noqa: E402
from booted_root import run  # noqa: E402

DOOR, PAUSE = "localhost/haproxy:2.6", "localhost/pause:1"
CATATONIT = "/usr/bin/catatonit"  # Debian's podman holds pods with it; it is linked statically
# As the image that the manifest names: the program, and where it looks for its configuration.
DOOR_FILE = """FROM {base}
CMD ["haproxy", "-W", "-db", "-f", "/usr/local/etc/haproxy/haproxy.cfg"]
"""
PAUSE_FILE = """FROM scratch
COPY catatonit /pause
ENTRYPOINT ["/pause", "-P"]
"""


def archives(build):
    """Those of this build, by their names; anew only where something of them has changed."""
    podman = Podman(build)
    folder = pathlib.Path(build).resolve() / "ops/kubernetes"
    folder.mkdir(parents=True, exist_ok=True)
    podman.build_image()
    small(podman, DOOR, DOOR_FILE.format(base=podman.base(kept_root(podman.build, "haproxy"))), folder)
    shutil.copy(CATATONIT, folder / "catatonit")
    small(podman, PAUSE, PAUSE_FILE, folder)
    return {image: saved(podman, image, folder) for image in (IMAGE, DOOR, PAUSE)}


def small(podman, image, text, folder):
    if podman.has(image):
        return
    file = folder / "Containerfile"
    file.write_text(text)
    run("podman", "build", "--format", "docker", "-f", file, "-t", image, folder, env=podman.environment)


def saved(podman, image, folder):
    """Under the number of what is in it, so that an image of an earlier build is no answer."""
    number = podman.inspect(image)["Id"].removeprefix("sha256:")[:12]
    name = image.split("/")[1].split(":")[0]
    file = folder / f"{name}-{number}.tar"
    if not file.is_file():
        for old in folder.glob(f"{name}-*.tar"):
            old.unlink()
        part = folder / f"{name}.part"
        part.unlink(missing_ok=True)
        podman("save", "--format", "docker-archive", "-o", part, image, timeout=600)
        part.rename(file)
    return file
