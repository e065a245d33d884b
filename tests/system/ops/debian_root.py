"""Debian roots, made by mmdebstrap from the mirror that this machine itself uses; kept in BUILD/ops for the next time."""
import hashlib
import os
import pathlib
import re
import shutil

from booted_root import run
from node import skip


# What mmdebstrap mounts in a root is not mounted here, and both end with the test, however that ends: whoever removes a
# root that was left must not meet this machine's /dev in it.
CONFINED = ("setpriv", "--pdeathsig", "KILL", "unshare", "--mount", "--pid", "--fork", "--kill-child", "--mount-proc")


def archive():
    """The package mirror that this machine itself uses."""
    for file in pathlib.Path("/etc/apt/sources.list.d").glob("*.sources"):
        for stanza in file.read_text().split("\n\n"):
            keys = dict(re.findall(r"^(\w[\w-]*): *(.*)$", stanza, re.M))
            if "bookworm" in keys.get("Suites", "").split():
                return keys["URIs"].split()[0]
    for file in [pathlib.Path("/etc/apt/sources.list"), *pathlib.Path("/etc/apt/sources.list.d").glob("*.list")]:
        found = file.is_file() and re.search(r"^deb +(?:\[.*\] +)?(\S+) +bookworm ", file.read_text(), re.M)
        if found:
            return found.group(1)
    return None


def is_bookworms_own(suite):
    return re.fullmatch("bookworm(-updates|-security)?", suite) is not None


def sources_of_bookworm(folder):
    """This machine's own sources of bookworm, its updates and its security (of nothing else, so without backports): files
    in `folder` as mmdebstrap takes them."""
    stanzas, lines = [], []
    for file in sorted(pathlib.Path("/etc/apt/sources.list.d").glob("*.sources")):
        for stanza in re.split(r"\n\s*\n", re.sub(r"^#.*\n", "", file.read_text(), flags=re.M)):
            suites = re.search(r"^Suites:(.*(?:\n[ \t].*)*)", stanza, re.M | re.I)
            own = [suite for suite in suites.group(1).split() if is_bookworms_own(suite)] if suites else []
            if own:
                stanzas.append(stanza.replace(suites.group(0), "Suites: " + " ".join(own)).strip())
    for file in [pathlib.Path("/etc/apt/sources.list"), *sorted(pathlib.Path("/etc/apt/sources.list.d").glob("*.list"))]:
        for line in file.read_text().splitlines() if file.is_file() else []:
            found = re.match(r"deb\s+(?:\[.*\]\s+)?\S+\s+(\S+)\s", line)
            if found and is_bookworms_own(found.group(1)):
                lines.append(line)
    files = []
    for name, text in (("debian.sources", "\n\n".join(stanzas)), ("debian.list", "\n".join(lines))):
        if text:
            files.append(folder / name)
            files[-1].write_text(text + "\n")
    return files


def bootstrap(target, suite, *options, sources=None):
    """Runs mmdebstrap, with this machine's mirror or the files `sources`; skips where it cannot."""
    if os.geteuid() != 0 or not shutil.which("mmdebstrap"):
        skip("a Debian root needs root and mmdebstrap")
    mirror = archive()
    if not mirror:
        skip("no bookworm mirror among this machine's package sources")
    if mirror.startswith("https:"):
        options = ("--include=ca-certificates", *options)
    done = run(*CONFINED, "mmdebstrap", "--quiet", *options, suite, target, *(sources or [mirror]), check=False)
    if done.returncode != 0:
        skip(f"no root of {suite} can be made here: " + done.stdout.strip()[-300:].replace("\n", " "))


def packed(build):
    """A digest of all that the packages may be made of, by names, sizes and times: what is built, and the tree but its
    tests."""
    cache = (build / "CMakeCache.txt").read_text()
    source = pathlib.Path(re.search(r"^CMAKE_HOME_DIRECTORY:\w+=(.*)$", cache, re.M)[1])
    made = [build / name for name in ("bin", "lib", "libexec", "share", "deploy", "client", "CPackConfig.cmake")]
    own = [path for path in source.iterdir() if path.name not in (".git", "build", "out", "tests")]
    files = [file for top in made + own for file in (top, *top.rglob("*"))] + list(build.rglob("cmake_install.cmake"))
    states = ((file, file.stat()) for file in sorted(files) if file.is_file())
    text = "".join(f"{file} {state.st_size} {state.st_mtime_ns} {state.st_mode}\n" for file, state in states)
    return hashlib.sha256(text.encode()).hexdigest()


def build_packages(build):
    """This build's packages, by name; anew, if anything has changed since another test made them."""
    folder = build / "ops/package"
    digest, made_of = packed(build), folder / "made_of"
    if not made_of.is_file() or made_of.read_text() != digest:
        shutil.rmtree(folder, ignore_errors=True)
        run("cpack", "-B", folder, cwd=build)
        made_of.write_text(digest)
    return {file.name.split("_")[0]: file for file in folder.glob("*.deb")}


def build_package(build):
    """That of the daemon and the programs."""
    return build_packages(build)["gnomon"]


def root_with_dependencies(build, package, *more):
    """The tar of a minimal bookworm with apt, what the package depends on and `more`, and nothing else."""
    depends = run("dpkg-deb", "-f", package, "Depends").stdout
    names = sorted(set(more) | {re.match(r"[^ (]+", part.split("|")[0].strip()).group(0) for part in depends.split(",")})
    return kept_root(build, ",".join(names))


def kept_root(build, packages=""):
    digest = hashlib.sha256(packages.encode()).hexdigest()[:12]
    kept = build / "ops" / f"bookworm-apt-{digest}.tar"
    if not kept.is_file():
        kept.parent.mkdir(exist_ok=True)
        include = ["--include=" + packages] if packages else []
        bootstrap(str(kept) + ".part", "bookworm", "--variant=apt", "--format=tar", *include)
        os.replace(str(kept) + ".part", kept)
    return kept
