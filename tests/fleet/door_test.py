#!/usr/bin/python3
"""HAProxy in front of three gnomonds: the clients of a scene share a node, and when a node or a door ends, its clients go
on elsewhere. Nothing here is timed; what was measured is printed.

    door_test.py BUILD
"""
import pathlib
import subprocess
import sys
import time
import unittest

from namespaces import enter_own_network, skip

enter_own_network()

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "system/wire_client"))
try:
    from control import Closed
    from messages import MOMENTS, RESUME, Hello, LightsChanged
    from session import RefusedBy, Session
except ModuleNotFoundError as error:
    skip(f"Debian's python3-{error.name.lower()} is missing")
from world import FLEET, NODES, PATIENCE_S, World, eventually

BUILD = sys.argv.pop(1)
PLACED_SCENES, CLIENTS_OF_EACH = 60, 2
TRIES = 3


class Doors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.world = World(BUILD)
        cls.addClassCleanup(cls.world.end)
        cls.scenes_made = 0

    def setUp(self):
        """Every test finds a fleet in which all is well."""
        for node in self.world.nodes.values():
            if node.process.poll() is not None:
                node.start()
        for door in self.world.doors.values():
            if door.process.poll() is not None:
                door.start()
            eventually(lambda door=door: set(self.world.states(door).values()) == {"UP"} and
                       set(self.world.weights.values()) == {100}, f"{door.file.name}: all nodes are up")

    def new_scene(self):
        type(self).scenes_made += 1
        return self.world.scene(self.scenes_made)

    def session(self, scene, door="east", **hello):
        hello = {"width": 64, "height": 32, **hello}
        session = Session(*self.world.doors[door].where, self.world.pin, Hello(scene=scene, **hello), fleet=FLEET)
        self.addCleanup(session.abandon)
        return session

    def session_soon(self, scene, **options):
        """As a client gets one that asks again and again."""
        def opened():
            try:
                return self.session(scene, **options)
            except (Closed, OSError, RefusedBy):
                return None
        return eventually(opened, "a session")

    def node_of(self, session):
        return self.world.node_at(session.welcome.home_host)

    def answered(self, session):
        frame = session.picture(session.welcome.scene.default_camera)
        self.assertGreater(session.counts["frame_slice"], 0, "by datagrams, which go past the door")
        return frame

    def own_node(self, scene):
        session = self.session(scene)
        node = self.node_of(session)
        session.close()
        return node

    @staticmethod
    def while_alive(session, condition, what):
        """As eventually(), with a session that gives signs of life meanwhile."""
        def asked():
            session.poll(0.02)
            return condition()
        eventually(asked, what)

    # ---- where clients come to

    def test_the_clients_of_a_scene_share_a_node(self):
        nodes_of_scenes = []
        for _ in range(PLACED_SCENES):
            scene = self.new_scene()
            doors = [list(self.world.doors)[i % 2] for i in range(CLIENTS_OF_EACH)]
            sessions = [self.session(scene, door) for door in doors]
            nodes_of_scenes.append({self.node_of(session).name for session in sessions})
            for session in sessions:
                session.close()
        split = sum(len(nodes) > 1 for nodes in nodes_of_scenes)
        share = {name: sum(name in nodes for nodes in nodes_of_scenes) for name in NODES}
        print(f"{PLACED_SCENES} scenes, {CLIENTS_OF_EACH} clients each by two doors: {split} on more than one node; {share}")
        self.assertEqual(split, 0)
        self.assertEqual(min(share.values()) > 0, True, share)

    def test_a_client_that_names_no_scene_is_served(self):
        door = self.world.doors["east"].where
        session = Session(*door, self.world.pin, Hello(scene=self.new_scene(), width=64, height=32))
        self.addCleanup(session.abandon)
        self.assertFalse(session.welcome.home_host, "it has not asked for the feature")

    def test_the_native_client_comes_through_the_door(self):
        scene, door = self.new_scene(), self.world.doors["east"].where
        done = subprocess.run([self.world.bin / "gnomon-load", "--server", f"{door[0]}:{door[1]}", "--fleet", FLEET,
                               "--ca", self.world.authority, "--scene", scene, "--size", "64x32", "--clients", "2",
                               "--rate", "10", "--seconds", "2", "--transport", "udp", "--may-miss", "50"], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        print(done.stdout)
        self.assertEqual(done.returncode, 0, done.stdout)  # or answers are missing, late or wrong
        resident = [name for name, node in self.world.nodes.items() if pathlib.Path(scene).name in node.ctl("scene", "list")[1]]
        self.assertEqual(resident, [self.own_node(scene).name])

    def until_cut(self, session):
        """Takes what comes until the control connection ends."""
        deadline = time.monotonic() + PATIENCE_S
        with self.assertRaises(Closed):
            while time.monotonic() < deadline:
                session.poll(1)

    # ---- a node ends

    def moves(self, session, end, mend):
        """Ends the session's node; a new session is elsewhere, until the node is back."""
        scene, node = session.hello.scene, self.node_of(session)
        self.answered(session)
        began = time.monotonic()
        end(node)
        self.until_cut(session)
        cut = time.monotonic()
        other = self.session_soon(scene)
        opened = time.monotonic()
        self.assertNotEqual(self.node_of(other).name, node.name)
        self.answered(other)
        print(f"{self.id().split('.')[-1]}: cut after {cut - began:.2f} s, a session elsewhere after "
              f"{opened - began:.2f} s, its frame after {time.monotonic() - began:.2f} s")
        other.close()
        mend(node)
        eventually(lambda: self.own_node(scene) is node, "the scene is at its own node again")

    def test_a_node_is_killed(self):
        for _ in range(TRIES):
            self.moves(self.session(self.new_scene()), lambda node: node.kill(), lambda node: node.start())

    def test_a_cable_is_pulled(self):
        for _ in range(TRIES):
            self.moves(self.session(self.new_scene()), lambda node: node.machine.pull_cable(),
                       lambda node: node.machine.plug_cable())

    def test_a_node_hangs(self):
        self.moves(self.session(self.new_scene()), lambda node: node.signal(19), lambda node: node.signal(18))

    # ---- a node takes nobody

    def test_a_node_drains(self):
        scene = self.new_scene()
        staying = self.session(scene)
        node = self.node_of(staying)
        self.answered(staying)
        self.assertEqual(node.ctl("drain")[0], 0)
        door = self.world.doors["east"]
        self.while_alive(staying, lambda: self.world.states(door)[node.name] == "DRAIN", "the door knows")
        coming = self.session(scene)
        self.assertNotEqual(self.node_of(coming).name, node.name)
        staying.listen(2)  # as long as the door needs to take a node for broken
        self.answered(staying)
        self.assertEqual(node.ctl("undrain")[0], 0)
        self.while_alive(staying, lambda: self.own_node(scene) is node, "the scene is at its own node again")
        self.answered(staying)

    def test_a_full_node_is_passed_over(self):
        scene = self.new_scene()
        greedy = self.session(scene, rate_hz=1000, width=640, height=360)  # of these a second, more than a node renders
        node = self.node_of(greedy)
        self.answered(greedy)
        self.while_alive(greedy, lambda: self.own_node(scene) is not node, "newcomers go elsewhere")
        greedy.close()
        eventually(lambda: self.own_node(scene) is node, "the scene is at its own node again")

    # ---- operators

    def operate(self, *arguments):
        """gnomonctl for all nodes: exit status, output."""
        nodes = ",".join(f"{node.name}=unix:{node.socket}" for node in self.world.nodes.values())
        done = subprocess.run([self.world.bin / "gnomonctl", "--fleet", nodes, *arguments], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=PATIENCE_S)
        return done.returncode, done.stdout

    def test_operators_see_and_tell_nodes_by_name(self):
        session = self.session(self.new_scene(), features=MOMENTS)
        node, scene = self.node_of(session), pathlib.Path(session.hello.scene).name
        status, shown = self.operate("status")
        self.assertEqual(status, 0, shown)
        for name in NODES:
            self.assertRegex(shown, rf"(?m)^{name} +ready ")
        self.assertEqual(self.operate("drain")[0], 2, "one has to be named")
        self.assertEqual(self.operate("drain", "--node", node.name)[0], 0)
        self.assertRegex(self.operate("status")[1], rf"(?m)^{node.name} +draining")
        self.assertEqual(self.operate("undrain", "--node", node.name)[0], 0)
        status, said = self.operate("scene", "light", scene, "0", "--off")
        self.assertEqual((status, said), (0, "".join(
            f"{name}: accepted{'' if name == node.name else ', for when the scene is loaded'}\n" for name in NODES)))
        dark = lambda: any(isinstance(news, LightsChanged) and news.lights[0].intensity == 0 for news in session.news)
        self.while_alive(session, dark, "its clients hear of it")
        self.assertEqual(self.operate("scene", "light", "attic", "0", "--on")[0], 1)
        self.assertEqual(self.operate("reload")[0], 2, "what changes one node alone needs --admin")
        node.kill()
        status, shown = self.operate("status")
        self.assertEqual(status, 1)
        self.assertRegex(shown, rf"(?m)^{node.name} +does not answer")

    def light_of(self, session):
        """Its intensity, as the session's server says it now."""
        changed = [news for news in session.news if isinstance(news, LightsChanged)]
        return (changed[-1].lights if changed else session.welcome.scene.lights)[0].intensity

    def test_a_node_that_comes_late_knows_the_changed_lights(self):
        scene = self.new_scene()
        name, node = pathlib.Path(scene).name, self.own_node(scene)
        node.kill()
        status, said = self.operate("scene", "light", name, "0", "--off")
        self.assertEqual(status, 1, "one does not know it yet")
        self.assertIn(f"{node.name}: ", said)
        elsewhere = self.session_soon(scene, features=MOMENTS)
        self.assertIsNot(self.node_of(elsewhere), node)
        self.assertEqual(self.light_of(elsewhere), 0, "also where the scene was not loaded then")
        self.answered(elsewhere)
        elsewhere.close()
        status, said = self.operate("scene", "lights", "--file", str(node.lights_file))
        self.assertEqual(status, 0, said)
        self.assertIn(f"{node.name}: ", said)
        node.start()
        late = eventually(lambda: (lambda session: session if self.node_of(session) is node else session.close())(
            self.session_soon(scene, features=MOMENTS)), "the scene is at its own node again")
        self.assertEqual(self.light_of(late), 0)
        self.answered(late)
        late.close()

    def test_nodes_tell_each_other_changed_lights_by_their_operator(self):
        scene = self.new_scene()
        name, node = pathlib.Path(scene).name, self.own_node(scene)
        session = self.session(scene, features=MOMENTS)
        self.assertGreater(self.light_of(session), 0)
        other = next(each for each in self.world.nodes.values() if each is not node)
        self.assertEqual(other.ctl("scene", "light", name, "0", "--off")[0], 0)
        status, said = self.operate("scene", "lights")
        self.assertEqual(status, 0, said)
        self.assertIn(f'{name}      0  {{"on":false}}', said)
        self.while_alive(session, lambda: self.light_of(session) == 0, "its clients hear of it")
        self.assertEqual(self.operate("scene", "light", name, "0", "--as-in-file")[0], 0)
        self.while_alive(session, lambda: self.light_of(session) > 0, "its clients hear of it")
        known = {each.ctl("scene", "lights", "--json")[1] for each in self.world.nodes.values()}
        self.assertEqual(len(known), 1, known)

    # ---- a door ends

    def test_a_door_is_killed(self):
        scene = self.new_scene()
        session = self.session(scene, features=RESUME)
        id_, node = session.welcome.session, self.node_of(session)
        self.answered(session)
        began = time.monotonic()
        self.world.doors["east"].kill()
        self.until_cut(session)
        session.resume()
        print(f"a door was killed: the control connection was back after {time.monotonic() - began:.2f} s")
        self.assertEqual(session.welcome.session, id_)
        self.answered(session)
        self.assertIs(self.node_of(self.session(scene, "west")), node, "both doors know the same nodes by scene")


if __name__ == "__main__":
    unittest.main(verbosity=2)
