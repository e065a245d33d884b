"""The experiments. Each gives rows with the columns of report.COLUMNS."""
import signal
import time

from served import PATIENCE_S, change, serving

POLICIES = ["fair", "priority", "deadline", "round_robin"]
WARM_UP_S = 3  # until costs are learned
GPU = "gnomon_tenant_gpu_seconds_total"
BUFFERS = "gnomon_visibility_buffers_total"


def jain(values):
    return sum(values) ** 2 / (len(values) * sum(v * v for v in values)) if any(values) else 0


def flood_shares(args, experiment, policy, weights):
    """Every tenant floods with as many sessions as keep it busy."""
    tenants = [{"name": f"weight{w}-{i}", "weight": w, "priority": i} for i, w in enumerate(weights)]
    with serving(args, policy, tenants) as daemon:
        load = daemon.load({t["name"]: 4 for t in tenants}, args.size, 0, 36000, deadline_ms=1000)
        connected(daemon, 4 * len(tenants))
        change(daemon, GPU, args.warm_up, until=lambda: answered(daemon) >= args.least_frames / 4)
        warm = answered(daemon)
        busy = change(daemon, GPU, args.seconds, until=lambda: answered(daemon) >= warm + args.least_frames)
        load.process.send_signal(signal.SIGINT)
        clients = load.tenant_rows()
    fairness = jain([busy[t["name"]] / t["weight"] for t in tenants])
    return [{"experiment": experiment, "policy": policy, "tenant": t["name"], "weight": t["weight"],
             "share": busy[t["name"]] / sum(busy.values()), "expected_share": t["weight"] / sum(weights),
             "vbps": clients[t["name"]]["vbps"], "p50_ms": clients[t["name"]]["p50_ms"],
             "p99_ms": clients[t["name"]]["p99_ms"], "jain": fairness} for t in tenants]


def shares(args):
    policies = ["fair", "round_robin"] if args.quick else POLICIES
    return [row for policy in policies for row in flood_shares(args, "shares", policy, [1, 2, 3, 4])]


def equal(args):
    return flood_shares(args, "equal", "fair", [1, 1, 1, 1])


def answered(daemon):
    """Frames, of all tenants."""
    return sum(daemon.metric_by_tenant(BUFFERS).values())


def sessions(daemon):
    return {session["id"] for session in daemon.status()["sessions"]}


def connected(daemon, count, before=frozenset()):
    """Waits until there are so many sessions beside those before."""
    until = time.monotonic() + PATIENCE_S
    while len(sessions(daemon) - before) < count:
        if time.monotonic() > until:
            raise SystemExit(f"never: {count} more sessions")
        time.sleep(0.05)


def frame_seconds(args, daemon, tenant):
    """Device time of a steady client's frame."""
    before = daemon.metric_by_tenant(GPU)[tenant]
    frames = daemon.load({tenant: 1}, args.size, 0, WARM_UP_S).tenant_rows()[tenant]["frames"]
    return (daemon.metric_by_tenant(GPU)[tenant] - before) / max(frames, 1)


def beside_a_flood(args, experiment, policy, steady_priority):
    """A steady client alone, then beside a tenant that floods with large buffers, in one daemon.

    What is promised is promised to frames of one job, and to a tenant that stays within its share: on a slow device
    the slice is made three times the frame, and the rate lower than asked for.
    """
    tenants = [{"name": "steady", "priority": steady_priority}, {"name": "flood"}]
    with serving(args, policy, tenants) as daemon:
        cost = frame_seconds(args, daemon, "steady")
        rate = round(min(args.rate, 0.25 / cost), 2)
        slice_ms = max(4.0, 3300 * cost)
        daemon.reload(quantum_us=int(1000 * slice_ms))
        alone = daemon.load({"steady": 1}, args.size, rate, args.seconds).tenant_rows()["steady"]
        flood = daemon.load({"flood": args.sessions}, args.large, 0, args.seconds + 600)
        connected(daemon, args.sessions)
        time.sleep(2 * args.warm_up)
        busy_before = daemon.metric_by_tenant(GPU)
        beside = daemon.load({"steady": 1}, args.size, rate, args.seconds).tenant_rows()["steady"]
        busy = {t: v - busy_before[t] for t, v in daemon.metric_by_tenant(GPU).items()}
        flood.kill()
    row = {"experiment": experiment, "policy": policy, "tenant": "steady", "weight": 1,
           "share": busy["steady"] / sum(busy.values()), "vbps": beside["vbps"], "p50_ms": beside["p50_ms"],
           "p99_ms": beside["p99_ms"], "p50_alone_ms": alone["p50_ms"], "p99_alone_ms": alone["p99_ms"],
           "vbps_alone": alone["vbps"], "rate_hz": rate, "slice_ms": slice_ms,
           "p99_allowed_ms": 1.25 * alone["p99_ms"] + slice_ms}
    return [row]


def neighbour(args):
    policies = ["fair"] if args.quick else POLICIES
    return [row for policy in policies for row in beside_a_flood(args, "neighbour", policy, 0)]


def classes(args):
    return beside_a_flood(args, "classes", "priority", 1)


def vanishing(args):
    """Steady clients, and beside them one that falls silent, one that stops reading, one that is killed."""
    rows = []
    tenants = [{"name": "steady"}, {"name": "other"}]
    seconds = min(args.seconds, 10)
    with serving(args, "fair", tenants) as daemon:
        steady = daemon.load({"steady": 2}, args.size, args.rate / 4, 8 * seconds + 600)
        connected(daemon, 2)
        time.sleep(args.warm_up)
        for name, rate, sign in [("silent", 0.01, None), ("stops reading", args.rate / 8, signal.SIGSTOP),
                                 ("killed", args.rate / 8, signal.SIGKILL)]:
            before = change(daemon, BUFFERS, seconds)["steady"]
            known = sessions(daemon)  # those that vanished before may be among them
            other = daemon.load({"other": 1}, args.size, rate, 600)
            connected(daemon, 1, known)
            time.sleep(args.warm_up)
            if sign:
                other.process.send_signal(sign)
            after = change(daemon, BUFFERS, seconds)["steady"]
            other.kill()
            rows.append({"experiment": "vanishing", "policy": "fair", "tenant": f"steady, beside {name}", "weight": 1,
                         "vbps": after, "vbps_alone": before})
        steady.kill()
    return rows


def devices(args):
    """As many clients for each device, who ask for a new frame as soon as one is there: on the first device alone, on two ..."""
    rows = []
    for count in range(1, len(args.devices) + 1):
        with serving(args, "fair", [{"name": "clients"}], devices=args.devices[:count]) as daemon:
            # A program of clients is one thread: so many that it is not they who are measured.
            loads = [daemon.load({"clients": 4}, args.size, 0, args.seconds + 2 * WARM_UP_S) for _ in range(4 * count)]
            time.sleep(WARM_UP_S)
            vbps = change(daemon, BUFFERS, args.seconds)["clients"]
            clients = [load.tenant_rows()["clients"] for load in loads]
        rows.append({"experiment": "devices", "policy": "fair", "tenant": f"clients of {count}", "weight": 1, "vbps": vbps,
                     "vbps_alone": rows[0]["vbps"] if rows else vbps, "p50_ms": max(c["p50_ms"] for c in clients),
                     "p99_ms": max(c["p99_ms"] for c in clients), "jain": jain([c["vbps"] for c in clients])})
    return rows


ALL = {"shares": shares, "equal": equal, "neighbour": neighbour, "classes": classes, "vanishing": vanishing,
       "devices": devices}
