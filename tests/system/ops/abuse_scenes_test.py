#!/usr/bin/env python3
"""Scene files as weapons: what one tenant asks for costs another one nothing that it could lose by.

    abuse_scenes_test.py BUILD
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import bombs
from node import Node, eventually, unsanitized

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
LIMIT_MB = 600


def ask(node, tenant, scene):
    """What a client of the tenant is told about the scene, or "served"."""
    load = node.load({tenant: 1}, size="64x64", rate=20, seconds=1, scene=scene)
    text = load.process.communicate()[0]
    refused = re.search(r"(refused|error|no answer)[^\n]*", text)
    return refused.group() if refused else "served"


# What costs little since it is bounded, and is a scene like others.
HARMLESS = {"alternating_alpha.glb", "heavy_vertices.glb"}


class Bombs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        scenes = {"list": [{"name": "living_room", "file": "living_room.glb"}], "allow_files": ["bombs"],
                  "worker_time_s": 20, "max_memory_mb": LIMIT_MB + 700}
        cls.node = Node(BUILD, scenes=scenes, render={"device": "cpu", "tracer": "bvh", "light_buffer_mb": 100})
        cls.addClassCleanup(cls.node.__exit__)
        folder = cls.node.folder / "bombs"
        folder.mkdir()
        cls.files = bombs.make(folder)
        cls.node.start()

    def frames(self):
        return self.node.metric("gnomon_visibility_buffers_total", tenant="studio")

    def test_every_bomb_is_refused_with_a_reason_while_another_tenant_flies(self):
        honest = self.node.load({"studio": 1}, size="64x64", rate=10, seconds=60)
        try:
            eventually(self.frames, "frames of the honest tenant")
            for file in self.files:
                before = self.frames()
                answer = ask(self.node, "arcade", file)
                if file not in HARMLESS:
                    self.assertRegex(answer, r"refused", file)
                self.assertNotIn(str(self.node.folder), answer, "a client is not told where files lie")
                self.assertIsNone(self.node.process.poll(), f"{file}: the daemon has ended")
                eventually(lambda: self.frames() > before, f"a frame of the honest tenant after {file}")
        finally:
            honest.kill()

    @unsanitized(BUILD, "takes memory of its own")
    def test_memory_stays_within_its_account(self):
        for file in self.files:
            ask(self.node, "arcade", file)
        memory = self.node.status()["scene_memory"]
        self.assertGreater(memory["limit_bytes"], 0)
        self.assertLessEqual(memory["bytes"], memory["limit_bytes"])
        peak = re.search(r"VmHWM:\s+(\d+)", pathlib.Path(f"/proc/{self.node.process.pid}/status").read_text())
        self.assertLess(int(peak.group(1)) << 10, memory["limit_bytes"])

    def test_a_refusal_is_remembered(self):
        file = self.files[-1]
        first = ask(self.node, "arcade", file)
        cpu = self.node.cpu_seconds()
        self.assertEqual(ask(self.node, "arcade", file), first)
        self.assertLess(self.node.cpu_seconds() - cpu, 5)

    @unsanitized(BUILD, "needs the worker unconfined")
    def test_a_link_leads_to_no_other_folder(self):
        with tempfile.TemporaryDirectory() as elsewhere:
            target = pathlib.Path(elsewhere, "scene.glb")
            target.write_bytes((self.node.build / "share/gnomon/scenes/living_room.glb").read_bytes())
            (self.node.folder / "bombs/linked.glb").symlink_to(target)
            scenes = dict(self.node.config["scenes"], allow_files=[str(self.node.folder / "bombs")])
            with Node(BUILD, scenes=scenes, render={"device": "cpu", "tracer": "bvh"}) as other:
                other.start()
                self.assertRegex(ask(other, "arcade", "linked.glb"), "refused")


class NothingShows(unittest.TestCase):
    def test_a_scene_without_an_area_beside_frames_of_others(self):
        """By light buffers, whose shaders read of it what the memory held of the scene before."""
        scenes = {"list": [{"name": "living_room", "file": "living_room.glb"}], "allow_files": ["bombs"]}
        with Node(BUILD, scenes=scenes,
                  render={"device": "cpu", "tracer": "light_buffer", "wait_for_light_buffers": True}) as node:
            (node.folder / "bombs").mkdir()
            bombs.make(node.folder / "bombs")
            node.start()

            def frames(tenant):
                return node.metric("gnomon_visibility_buffers_total", tenant=tenant)
            flying = [node.load({"studio": 1}, size="160x90", rate=30, seconds=600)]
            flying += [node.load({"arcade": 1}, size="64x64", rate=5, seconds=600, scene="alternating_alpha.glb")
                       for _ in range(3)]
            try:
                eventually(lambda: frames("arcade"), "frames of it")
                self.assertEqual(ask(node, "arcade", "heavy_vertices.glb"), "served")
                before = frames("studio")
                eventually(lambda: frames("studio") > before, "frames of the other tenant")
            finally:
                for load in flying:
                    load.kill()


@unsanitized(BUILD, "maps terabytes of addresses")
class LittleMemory(unittest.TestCase):
    def test_a_scene_that_finds_no_memory_is_refused_and_nothing_dies(self):
        scenes = {"list": [{"name": "living_room", "file": "living_room.glb"}], "allow_files": ["bombs"],
                  "worker_memory_mb": 1 << 20, "max_memory_mb": 1 << 20}
        with Node(BUILD, scenes=scenes, render={"device": "cpu", "tracer": "bvh"}) as node:
            (node.folder / "bombs").mkdir()
            bombs.make(node.folder / "bombs")
            node.start(wrapper=("prlimit", f"--as={3 << 30}"))
            self.assertRegex(ask(node, "arcade", "many_triangles.glb"), "refused")
            self.assertIsNone(node.process.poll())
            self.assertEqual(ask(node, "studio", "living_room"), "served")

    def test_too_little_address_space_is_said_at_the_start(self):
        with Node(BUILD) as node:
            done = subprocess.run(["prlimit", f"--as={700 << 20}", node.bin / "gnomond", "--config",
                                   node.write_config()], capture_output=True, text=True)
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn("address space", done.stderr)


if __name__ == "__main__":
    os.chdir(pathlib.Path(__file__).parent)
    unittest.main(verbosity=2)
