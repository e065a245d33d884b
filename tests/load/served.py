"""A gnomond whose sharing is measured: the node of tests/system/ops with a policy, tenants and one scene."""
import contextlib
import pathlib
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/ops"))
from node import PATIENCE_S, Node  # noqa: E402


class MeasuredNode(Node):
    """Serves from start() to stop(). `tenants`: list of dicts of configuration keys. args.cache: a folder for light
    buffers, if any."""

    def __init__(self, args, policy, tenants, devices=(), **scheduler):
        render = {"wait_for_light_buffers": True}  # what is measured does not change meanwhile
        if devices:
            render["devices"] = list(devices)
        if getattr(args, "cache", None):
            render["cache_folder"] = str(pathlib.Path(args.cache).absolute())
        super().__init__(args.bin.parent, scenes={"list": [{"name": args.scene, "file": f"{args.scene}.glb"}]},
                         render=render, scheduler={"policy": policy, "admit_percent": 0, **scheduler}, tenants=tenants,
                         log={"level": "error"})
        del self.config["render"]["device"]  # the best there is
        if "cache_folder" not in render:
            del self.config["render"]["cache_folder"]
        self.scene = args.scene

    def load(self, clients, size, rate, seconds, deadline_ms=0):
        return super().load(clients, size, rate, seconds, scene=self.scene, deadline_ms=deadline_ms)

    def reload(self, **scheduler):
        self.config["scheduler"].update(scheduler)
        self.write_config()
        self.signal(signal.SIGHUP)
        time.sleep(0.5)


@contextlib.contextmanager
def serving(args, policy, tenants, devices=(), **scheduler):
    with MeasuredNode(args, policy, tenants, devices, **scheduler) as node:
        node.start()
        yield node
        node.stop()


def change(node, name, seconds, until=lambda: True):
    """How much a counter of each tenant grows in that time, and until that is true, by second."""
    before, begin = node.metric_by_tenant(name), time.monotonic()
    time.sleep(seconds)
    while not until():
        if time.monotonic() > begin + seconds + PATIENCE_S:
            raise SystemExit("the daemon answers too little to be measured")
        time.sleep(0.05)
    after, took = node.metric_by_tenant(name), time.monotonic() - begin
    return {tenant: (after[tenant] - before.get(tenant, 0)) / took for tenant in after}
