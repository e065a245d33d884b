"""What the fleet is asked to do on the cluster. Each check returns rows of the report: what, the figure, and the target of
the acceptance that it is of, if there is one, with whether it was met."""
import collections
import subprocess
import time

from cluster import LONG_S, patiently
from fleet import NEXT_IMAGE, SCENES
from under_load import Load

SETTLE_S = 5
TARGET_GAP_MS = 50  # more than the interval between two frames
# Of its devices' time, on average: where the autoscaler has nothing to do, and has when there is three times as much.
CALM_LOAD = 0.25
TRIPLED_S = 60

Row = collections.namedtuple("Row", "what figure target met", defaults=("", None))


class Loads:
    """Several, each of a scene of its own, through the doors in turn."""

    def __init__(self, fleet, sessions, rate, *more, doors=None, scenes=SCENES):
        self.fleet, self.rate = fleet, rate
        doors = doors or list(fleet.doors().values())
        share = [sessions // len(scenes) + (number < sessions % len(scenes)) for number in range(len(scenes))]
        self.all = [Load(fleet, scene, clients, rate, "--scene-dir", fleet.scenes, *more,
                         where=doors[number % len(doors)], tenant=f"lab:{fleet.token}")
                    for number, (scene, clients) in enumerate(zip(scenes, share)) if clients]
        self.sessions = sum(load.clients for load in self.all)

    def fly(self):
        return all(load.must_fly() for load in self.all) and self.fleet.cluster.lives()

    def served_by(self, names):
        """All of them are at these nodes, and nobody waits."""
        patiently(lambda: self.fly() and sum(len(self.fleet.sessions(name)) for name in names) == self.sessions,
                   f"{self.sessions} sessions at {', '.join(names)}; there are {self.fleet.served()}")

    def land(self):
        rows = [load.land() for load in self.all]
        wrong = [row["error"] for row in rows if row.get("error")]
        if wrong or any(row["invalid_slices"] for row in rows):
            raise AssertionError(f"sessions were refused or lost, or frames are wrong: {rows}")
        total = {key: sum(row[key] for row in rows) for key in ("frames", "moves", "reopened", "dropped",
                                                                "incomplete_frames")}
        total["gap_ms"] = max(row["max_gap_ms"] for row in rows)
        if self.rate:
            total["late_ms"] = total["gap_ms"] - 1000 / self.rate
        return total

    def end(self):
        for load in self.all:
            load.end()


def with_loads(fleet, sessions, rate, work, *more, **options):
    loads = Loads(fleet, sessions, rate, *more, **options)
    try:
        return work(loads)
    finally:
        loads.end()


def serves(fleet):
    """The client program comes through a door, and gets pictures of every scene."""
    rows, used = [], set()
    for number, scene in enumerate(SCENES):
        host, port = list(fleet.doors().values())[number % 2]
        pictures = fleet.folder / "pictures" / scene
        done = subprocess.run([fleet.bin / "gnomon-client", "--server", f"{host}:{port}", "--fleet", fleet.fleet, "--ca",
                               fleet.authority, "--tenant", "lab", "--token-file", fleet.token, "--scene", scene, "--scene-dir",
                               fleet.scenes, "--size", "64x36", "--frames", "8", "--out", pictures], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=LONG_S)
        if done.returncode or not list(pictures.iterdir()):
            raise AssertionError(f"gnomon-client, {scene}: {done.stdout}")
        used.add(scene)
    rows.append(Row("gnomon-client through a door: scenes with pictures", f"{len(used)} of {len(SCENES)}", "all", True))
    return rows


def rolling_update(fleet, sessions):
    """A new image, one node after the other, under sessions that are to notice nothing."""
    def work(loads):
        loads.served_by(fleet.nodes)
        before = fleet.served()
        time.sleep(SETTLE_S)
        since = time.monotonic()
        fleet.cluster.kubectl("set", "image", "deployment/gnomon", f"lights={NEXT_IMAGE}", f"gnomond={NEXT_IMAGE}")
        fleet.cluster.kubectl("rollout", "status", "deployment/gnomon", "--timeout=10m")
        took = time.monotonic() - since
        loads.served_by(fleet.nodes)
        time.sleep(SETTLE_S)
        images = {pod["spec"]["containers"][0]["image"] for pod in fleet.api.pods("gnomon")}
        if images != {NEXT_IMAGE}:
            raise AssertionError(f"pods are of {images}")
        return took, before, loads.land()
    took, before, figures = with_loads(fleet, sessions, 1, work)
    if figures["moves"] < sum(before.values()):
        raise AssertionError(f"both nodes were replaced under {before}, and only {figures['moves']} sessions moved")
    what = f"rolling update of both nodes under {sessions} sessions at 1 Hz"
    return [Row(f"{what}: duration", f"{took:.0f} s"),
            Row(f"{what}: moves, frames", f"{figures['moves']}, {figures['frames']}"),
            Row(f"{what}: refused or lost at the application", figures["reopened"], "0", figures["reopened"] == 0),
            Row(f"{what}: cameras without an answer, frames incomplete",
                f"{figures['dropped']}, {figures['incomplete_frames']}"),
            Row(f"{what}: longest gap beyond a second", f"{figures['late_ms']:.0f} ms", f"{TARGET_GAP_MS} ms",
                figures["late_ms"] <= TARGET_GAP_MS)]


def node_loss(fleet, sessions):
    """The cable of a machine is pulled: no packet says that it is gone. Its door is gone as well, so that clients come
    through the other machine's."""
    def work(loads):
        loads.served_by(fleet.nodes)
        had = fleet.served()[gone]
        time.sleep(SETTLE_S)
        machine, took, since = fleet.nodes[gone].machine, {}, time.monotonic()
        machine.pull_cable()

        def until(what, condition):
            patiently(lambda: loads.fly() and condition(), f"{what} after {gone}'s cable was pulled")
            took[what] = time.monotonic() - since
        until("served", lambda: len(fleet.sessions(left)) == loads.sessions)
        until("noticed", lambda: not fleet.is_ready(gone))
        until("evicted", lambda: any(pod["spec"].get("nodeName") == gone and "deletionTimestamp" in pod["metadata"]
                                     for pod in fleet.api.pods("gnomon")))
        machine.plug_cable()
        since = time.monotonic()
        until("back", lambda: fleet.is_ready(gone) and fleet.available("gnomon") == 2 and replaced())
        time.sleep(SETTLE_S)
        return had, took, loads.land()

    def replaced():
        return all("deletionTimestamp" not in pod["metadata"] for pod in fleet.api.pods("gnomon"))
    doors = fleet.doors()
    gone, left = victim(fleet, doors)
    had, took, figures = with_loads(fleet, sessions, 5, work, "--reopen", doors=[doors[left]])
    what = f"a node's cable is pulled, {had} of {sessions} sessions at 5 Hz on it"
    return [Row(f"{what}: opened again elsewhere", figures["reopened"], f"{had}", figures["reopened"] == had),
            Row(f"{what}: longest time without a frame", f"{figures['gap_ms']:.0f} ms", "3,500 ms",
                figures["gap_ms"] <= 3500),
            Row(f"{what}: Kubernetes says NotReady after", f"{took['noticed']:.0f} s"),
            Row(f"{what}: and gives its pod up after", f"{took['evicted']:.0f} s"),
            Row(f"{what}: cable plugged in, two nodes available after", f"{took['back']:.0f} s")]


def victim(fleet, doors):
    """A node that has scenes' places, while the other one has a door."""
    def with_some(loads):
        loads.served_by(fleet.nodes)
        return max(fleet.served().items(), key=lambda item: item[1] if set(doors) - {item[0]} else -1)[0]
    gone = with_loads(fleet, len(SCENES), 1, with_some)
    left, = set(fleet.nodes) - {gone}
    patiently(lambda: not any(fleet.served().values()), "nobody is left of before")
    if left not in doors:
        raise AssertionError(f"both doors are on one machine: {doors}")
    return gone, left


def autoscaler(fleet):
    """Sessions that name no rate are booked at 60 Hz, and cost nothing while they stand still. Nodes learn what a frame
    costs from those that they render, so that some are rendered before."""
    adapter = fleet.start_metrics()
    with_loads(fleet, len(SCENES), 5, lambda loads: (loads.served_by(fleet.nodes), time.sleep(2 * SETTLE_S)))
    patiently(lambda: not any(fleet.served().values()), "nobody is left of before")
    still = []

    def asked():
        return fleet.api.deployment("gnomon")["spec"]["replicas"]

    def mean():
        return sum(adapter.loads("app.kubernetes.io/name=gnomon").values()) / len(fleet.nodes)

    def more(sessions):
        for _ in range(sessions):
            still.append(Loads(fleet, 1, 0, scenes=[SCENES[len(still) % len(SCENES)]]))
        patiently(lambda: all(loads.fly() for loads in still) and sum(fleet.served().values()) == len(still),
                  f"{len(still)} sessions that stand still; there are {fleet.served()}")
        time.sleep(1)  # until nodes have counted them
    try:
        while mean() < CALM_LOAD:
            more(1)
        patiently(lambda: adapter.asked > 1, "the autoscaler asks")
        time.sleep(3 * SETTLE_S)
        calm, load, before = len(still), mean(), asked()
        if before != 2 or load > 0.6:
            raise AssertionError(f"{before} replicas at a load of {load:.2f}")
        since = time.monotonic()
        more(2 * calm)
        while mean() < 3 * load:
            more(1)
        patiently(lambda: asked() * 0.66 >= mean() * len(fleet.nodes), "the autoscaler asks for more")
        took, replicas, tripled = time.monotonic() - since, asked(), mean()
        pods = patiently_some(lambda: [pod for pod in fleet.api.pods("gnomon") if pod["status"]["phase"] == "Pending"])
    finally:
        for loads in still:
            loads.end()
    what = f"autoscaler, gnomon_load_ratio {load:.2f} to {tripled:.2f} a node ({calm} to {len(still)} sessions)"
    return [Row(f"{what}: replicas asked for", f"2 to {replicas}"),
            Row(f"{what}: asked for after", f"{took:.0f} s", f"{TRIPLED_S} s", took <= TRIPLED_S),
            Row(f"{what}: pods that wait for a machine", len(pods))]


def patiently_some(found):
    """What is found, once it is something."""
    patiently(found, "pods that wait")
    return found()
