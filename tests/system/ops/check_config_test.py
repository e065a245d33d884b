#!/usr/bin/python3
"""gnomond --check-config and the start are one check: what is wrong is found by both, in the same words, all of it at
once, each with file, line, column and the system's reason; and what is accepted starts.

    check_config_test.py BUILD
"""
import datetime
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from node import eventually

BUILD = pathlib.Path(sys.argv.pop(1)).resolve()
SEED = int(os.environ.get("GNOMON_SEED", random.randrange(1 << 32)))
ROUNDS = int(os.environ.get("GNOMON_ROUNDS", 12))
SCENE = "scenes: {list: [{name: living_room, file: living_room.glb}]}\n"
FREE = "server: {mode: demo, state_folder: state, control_port: 0, data_port: 0}\nadmin: {port: 0, socket: ''}\n"
CPU = "render: {device: cpu, tracer: bvh}\n"
GOOD = FREE + CPU + SCENE
PRODUCTION = ("server: {mode: production, control_port: 0, data_port: 0, tls: {certificate: %s, key: %s}}\n"
              "admin: {port: 0, socket: ''}\ntenants: [{name: lab, open: true}]\n" + CPU + SCENE)
HASH = "a" * 64

# What is wrong: the file's text, and what the one check says of it.
BROKEN = {
    # The keys and their values.
    "unknown section": (GOOD + "sevrer: {}\n", r":5:1: sevrer: unknown key; did you mean server\?"),
    "unknown key": (GOOD + "log: {levle: info}\n", r":5:7: log\.levle: unknown key; did you mean level\?"),
    "wrong type": (GOOD + "encode:\n  threads: many\n", r":6:3: encode\.threads: \"many\" is not allowed"),
    "quoted number": (GOOD + "encode: {threads: '2'}\n", r":5:10: encode\.threads"),
    "fraction": (GOOD + "encode: {threads: 1.5}\n", r":5:10: encode\.threads"),
    "beyond its range": (GOOD + "scheduler: {priority_floor_percent: 100}\n", r":5:13: scheduler\.priority_floor"),
    "no choice": (GOOD + "scheduler: {policy: fairest}\n", r":5:13: scheduler\.policy.*fair, priority"),
    "given twice": (GOOD + "log: {}\nlog: {}\n", r":6:1: log: given twice"),
    "a list for a value": (GOOD + "log: {level: [info]}\n", r":5:7: log\.level: a list"),
    "a value for a section": (GOOD + "log: info\n", r":5:1: log: \"info\""),
    "no tenants": (GOOD + "tenants: []\n", r":5:1: tenants: an empty list"),
    "second tenant": (GOOD + "tenants: [{name: a}, {name: a}]\n", r":5:\d+: tenants: a second tenant named a"),
    "no hash": (GOOD + "tenants: [{name: a, token_sha256: [12]}]\n", r":5:\d+: tenants\.token_sha256"),
    "tab": (GOOD + "log:\n\tlevel: info\n", r":6:\d+: not YAML: .*begins with a tab"),
    "not closed": (GOOD + "log: [\n", r":\d+:\d+: not YAML"),
    "not a map": ("- a\n", r":1:1: a list"),
    "two documents": (GOOD + "---\ntenants: []\n", r":6:\d+: a second YAML document"),
    "nearly an effect": (GOOD.replace("tracer: bvh", "tracer: bvh, passes: [soft_shadow]"),
                         r":3:\d+: render\.passes: 'soft_shadow'; did you mean soft_shadows\?"),
    # Keys that do not go together.
    "the door's port twice": (GOOD.replace("control_port: 0", "control_port: 7731") +
                              "fleet: {door_listen: 127.0.0.1, door_port: 7731}\n",
                              r":5:\d+: fleet\.door_port: 7731 is server\.control_port too"),
    "a socket's path": (GOOD.replace("socket: ''", "socket: /tmp/" + 103 * "a"), r"admin\.socket: the path has 108 bytes; allowed: 107"),
    "no folder for lights": (GOOD.replace("scenes: {", "scenes: {lights_file: none/lights.json, "),
                             r"scenes\.lights_file: .*none: No such file or directory"),
    "one port twice": (GOOD.replace("control_port: 0", "control_port: 7731").replace("port: 0, socket", "port: 7731, socket"),
                       r":2:\d+: admin\.port: 7731 is server\.control_port too"),
    "ports run out": (GOOD.replace("data_port: 0", "data_port: 65535, net_threads: 2"), r":1:\d+: server\.data_port"),
    "everybody from elsewhere": (GOOD.replace("mode: demo", "mode: demo, listen: 0.0.0.0"), r":1:\d+: server\.listen"),
    "public admin": (GOOD.replace("admin: {port", "admin: {listen: 0.0.0.0, port"), r":2:\d+: admin\.listen"),
    "lists without an authority": (GOOD.replace("mode: demo", "mode: demo, tls: {client_crl: crl.pem}"),
                                   r":1:\d+: server\.tls\.client_crl"),
    # Certificates, keys, tokens.
    "no certificate": (GOOD.replace("mode: demo, ", "") + "tenants: [{name: a, open: true}]\n",
                       r"server\.tls\.certificate: none is set"),
    "key without certificate": (GOOD.replace("mode: demo", "tls: {key: server-key.pem}"), r":1:\d+: .*needed together"),
    "missing certificate": (PRODUCTION % ("gone.pem", "server-key.pem"),
                            r":1:\d+: server\.tls\.certificate: .*gone\.pem: No such file or directory"),
    "folder for a certificate": (PRODUCTION % ("folder", "server-key.pem"),
                                 r":1:\d+: server\.tls\.certificate: .*folder: Is a directory"),
    "empty certificate": (PRODUCTION % ("empty", "server-key.pem"),
                          r":1:\d+: server\.tls\.certificate: .*empty: the file is empty"),
    "no PEM": (PRODUCTION % ("text", "server-key.pem"), r":1:\d+: server\.tls\.certificate: .*text: no start line"),
    "key of another certificate": (PRODUCTION % ("server.pem", "other-key.pem"),
                                   r":1:\d+: server\.tls\.key: .*other-key\.pem: key values mismatch"),
    "key that others read": (PRODUCTION % ("server.pem", "open-key.pem"),
                             r":1:\d+: server\.tls\.key: .*open-key\.pem may be read by others"),
    "admin token that others read": (GOOD.replace("socket: ''", "socket: '', token_file: open-token"),
                                     r":2:\d+: admin\.token_file: .*open-token may be read by others"),
    "missing admin token": (GOOD.replace("socket: ''", "socket: '', token_file: gone"),
                            r":2:\d+: admin\.token_file: .*gone: No such file or directory"),
    "short admin token": (GOOD.replace("socket: ''", "socket: '', token_file: short-token"),
                          r":2:\d+: admin\.token_file: .*shorter than 16"),
    "unknown group": (GOOD.replace("socket: ''", "socket: '', group: nobodys-group"), r":2:\d+: admin\.group: .*nobodys-group"),
    "socket in no folder": (GOOD.replace("socket: ''", "socket: gone/admin.sock"),
                            r":2:\d+: admin\.socket: .*gone: No such file or directory"),
    "missing hashes": (GOOD + "tenants: [{name: lab, token_sha256_file: gone}]\n",
                       r":5:\d+: tenants\.lab\.token_sha256_file: .*gone: No such file or directory"),
    "no hashes": (GOOD + "tenants: [{name: lab, token_sha256_file: text}]\n",
                  r":5:\d+: tenants\.lab\.token_sha256_file: .*text:1: allowed"),
    "nobody could connect": (PRODUCTION.replace(", open: true", "") % ("server.pem", "server-key.pem"),
                             r":3:\d+: tenants\.lab: nobody could connect as lab|tenants\.lab: nobody could"),
    # Scenes and folders.
    "missing scene": (GOOD.replace("living_room.glb", "gone.glb"), r":4:\d+: scenes\.list: file gone\.glb .* does not exist"),
    "folder for a scene": (GOOD.replace("living_room.glb", "folder"), r":4:\d+: scenes\.list: .*folder: Is a directory"),
    "empty scene": (GOOD.replace("living_room.glb", "empty"), r":4:\d+: scenes\.list: .*empty: the file is empty"),
    "no scene": (GOOD.replace("living_room.glb", "/etc/passwd"), r":4:\d+: scenes\.list: scene living_room: "),
    "unknown node": (GOOD.replace("file: living_room.glb", "file: living_room.glb, moving: [{node: nowhere, spin: [0, 1, 0]}]"),
                     r":4:\d+: scenes\.list: scene living_room: .*nowhere"),
    "missing folder of files": (GOOD.replace("scenes: {", "scenes: {allow_files: [gone], "),
                                r":4:\d+: scenes\.allow_files: .*gone: No such file or directory"),
    "file for a cache": (GOOD.replace("device: cpu", "device: cpu, cache_folder: text"),
                         r":3:\d+: render\.cache_folder: .*text: Not a directory"),
    "cache where nothing can be made": (GOOD.replace("device: cpu", "device: cpu, cache_folder: /proc/x"),
                                        r":3:\d+: render\.cache_folder: /proc: no file can be made there"),
    "audit log in no folder": (GOOD + "log: {audit_file: gone/audit.log}\n",
                               r":5:\d+: log\.audit_file: .*gone: No such file or directory"),
    "folder for an audit log": (GOOD + "log: {audit_file: folder}\n", r":5:\d+: log\.audit_file: .*Is a directory"),
    # The machine.
    "address of another machine": (GOOD.replace("mode: demo", "mode: demo, insecure_listen: true, listen: 192.0.2.1"),
                                   r":1:\d+: server\.listen: 192\.0\.2\.1: Cannot assign requested address"),
    "unknown device": (GOOD.replace("device: cpu", "device: abacus"), r":3:\d+: render\.device: .*abacus"),
    "unknown one of several": (GOOD.replace("device: cpu", "devices: [cpu, abacus]"), r":3:\d+: render\.devices: .*abacus"),
    "unknown tracer": (GOOD.replace("tracer: bvh", "tracer: magic"),
                       r":3:\d+: render\.tracer: no tracer is called 'magic'; there are auto, bvh"),
    "unknown pass": (GOOD.replace("tracer: bvh", "passes: [gbuffer, sharpen]"),
                     r":3:\d+: render\.passes: no pass for masks is called 'sharpen'; there are gbuffer"),
    "passes in the wrong order": (GOOD.replace("tracer: bvh", "passes: [trace, gbuffer, pack, readback]"),
                                  r":3:\d+: render\.passes: pass 'trace' reads 'triangle_id'"),
    "passes without an end": (GOOD.replace("tracer: bvh", "passes: [gbuffer, trace, pack]"),
                              r":3:\d+: render\.passes: .*no 'readback'"),
}


class CheckConfig(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="gnomon-check-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = folder = pathlib.Path(cls.temporary.name)
        for name in ("server", "other"):
            subprocess.run([BUILD / "bin/gnomonctl", "make-certs", "--out", folder / f"{name}.d", "--host", "localhost"],
                           check=True, stdout=subprocess.DEVNULL)
            for suffix in (".pem", "-key.pem"):
                shutil.copy(folder / f"{name}.d" / f"server{suffix}", folder / f"{name}{suffix}")
        shutil.copy(folder / "server-key.pem", folder / "open-key.pem")
        (folder / "folder").mkdir()
        for name, text, mode in (("empty", "", 0o600), ("text", "just words\n", 0o600), ("token", "t" * 32, 0o600),
                                 ("open-token", "t" * 32, 0o644), ("short-token", "t", 0o600), ("hashes", HASH, 0o600)):
            (folder / name).write_text(text)
            (folder / name).chmod(mode)
        (folder / "open-key.pem").chmod(0o644)

    def write(self, text, name="gnomond.yaml"):
        file = self.folder / name
        file.write_text(text)
        return file

    def gnomond(self, file, *more):
        done = subprocess.run([BUILD / "bin/gnomond", "--config", file, *more], text=True, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=120)
        return done.returncode, done.stdout

    def check(self, text, *more):
        return self.gnomond(self.write(text), "--check-config", *more)

    def test_the_good_one_of_the_table_is_good(self):
        code, said = self.check(GOOD)
        self.assertEqual((code, said), (0, f"{self.folder}/gnomond.yaml: ok\n"))
        self.assertEqual(self.check(PRODUCTION % ("server.pem", "server-key.pem"))[0], 0)

    def test_what_is_broken_is_found_by_both_in_the_same_words(self):
        for name, (text, said) in BROKEN.items():
            with self.subTest(name):
                code, output = self.check(text)
                self.assertEqual(code, 1, output)
                self.assertRegex(output, said)
                if "scene living_room: " in said:
                    continue  # the start reads scenes once, where it loads them; see below
                start_code, start_output = self.gnomond(self.folder / "gnomond.yaml")
                self.assertEqual((start_code, start_output), (1, output))

    def test_scenes_that_cannot_be_read_stop_the_start_too(self):
        for name in ("no scene", "unknown node"):
            text, said = BROKEN[name]
            checked = self.check(text)[1].strip()
            code, output = self.gnomond(self.folder / "gnomond.yaml")
            self.assertEqual(code, 1)
            self.assertIn(checked, output)

    def test_the_configuration_itself(self):
        for file, said in ((self.folder / "nope.yaml", "nope.yaml: No such file or directory"),
                           (self.folder / "folder", "folder: Is a directory"),
                           (self.folder / "empty", "empty: the file is empty")):
            self.assertEqual(self.gnomond(file, "--check-config"), (1, f"gnomond: {self.folder}/{said}\n"))
            self.assertEqual(self.gnomond(file), (1, f"gnomond: {self.folder}/{said}\n"))
        if os.getuid() != 0:
            file = self.write(GOOD, "unreadable.yaml")
            file.chmod(0)
            self.assertIn("unreadable.yaml: Permission denied", self.gnomond(file, "--check-config")[1])

    def test_all_of_it_at_once(self):
        code, output = self.check("""server:
  mode: demmo
  control_prot: 1
  net_threads: 0
admin: {token_file: gone, listen: 10.0.0.256}
scenes:
  list:
    - {name: a, file: gone.glb}
    - {name: b, file: /etc/passwd}
render: {tracer: magic, passes: [sharpen], device: abacus, cache_folder: text}
log: {level: loud}
""")
        self.assertEqual(code, 1)
        for said in (":2:3: server.mode", ":3:3: server.control_prot", ":4:3: server.net_threads", ":5:27: admin.listen",
                     ":8:7: scenes.list: file gone.glb", ":9:7: scenes.list: scene b", ":10:10: render.tracer",
                     ": render.passes: ", ": render.device: ", ": render.cache_folder: ", ":11:7: log.level"):
            self.assertIn(said, output)
        self.assertNotIn("tls.certificate", output, "nothing is concluded from a mode that nobody understands")

    def test_that_nobody_could_be_served_is_a_warning(self):
        code, output = self.check(FREE + CPU + "scenes: {list: [], allow_files: []}\n")
        self.assertEqual(code, 0, output)
        self.assertRegex(output, r"warning: .*scenes\.list: an empty list, and scenes\.allow_files too")
        self.assertNotIn("warning", self.check(GOOD)[1])

    def test_the_shipped_one_says_what_it_lacks(self):
        shipped = pathlib.Path(__file__).resolve().parents[3] / "config/gnomond.yaml"
        code, output = self.gnomond(shipped, "--check-config")
        self.assertEqual(code, 1)
        self.assertIn("server.tls.certificate: none is set, and without one", output)

    def certificate(self, name, days_from):
        """Files of a certificate that is valid for a day, from so many days after now: NAME.pem and NAME-key.pem. Returns
        when it begins."""
        key, begins = ec.generate_private_key(ec.SECP256R1()), datetime.datetime.utcnow() + datetime.timedelta(days_from)
        edge = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "edge")])
        made = x509.CertificateBuilder(edge, edge, key.public_key(), x509.random_serial_number(), begins,
                                       begins + datetime.timedelta(days=1)).sign(key, hashes.SHA256())
        (self.folder / f"{name}.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
        (self.folder / f"{name}-key.pem").touch(0o600)
        (self.folder / f"{name}-key.pem").write_bytes(key.private_bytes(
            serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8, serialization.NoEncryption()))
        return begins

    def test_a_certificate_that_is_not_valid_yet(self):
        """An error of the check. The start says it and serves: the clock of a machine that was just turned on may be wrong."""
        tomorrow = self.certificate("early", 1)
        why = (rf"server\.tls\.certificate: {self.folder}/early\.pem is not valid before {tomorrow:%Y-%m-%dT%H:%M:%S}Z: "
               "clients refuse it until then")
        code, said = self.check(PRODUCTION % ("early.pem", "early-key.pem"))
        self.assertEqual(code, 1, said)
        self.assertRegex(said, rf"gnomond: {self.folder}/gnomond\.yaml:1:\d+: {why}\n")
        code, said = self.check(PRODUCTION % ("early.pem", "early-key.pem"), "--for-reload")
        self.assertEqual(code, 0, "a reload applies the rest")
        self.assertRegex(said, why)
        serves, log = self.starts(self.folder / "gnomond.yaml")
        self.assertTrue(serves, log)
        self.assertRegex(log, f'error no client will connect why="{why}"')

    def test_a_certificate_that_has_expired(self):
        """Likewise: the daemon may be started to be mended by a reload."""
        self.certificate("late", -2)
        why = r"server\.tls\.certificate: a certificate has expired: it is of no use to clients"
        code, said = self.check(PRODUCTION % ("late.pem", "late-key.pem"))
        self.assertEqual(code, 1, said)
        self.assertRegex(said, rf"gnomond: {self.folder}/gnomond\.yaml:1:\d+: {why}\n")
        serves, log = self.starts(self.folder / "gnomond.yaml")
        self.assertTrue(serves, log)

    def test_passes_by_the_names_of_before_are_deprecated(self):
        code, said = self.check(GOOD.replace("tracer: bvh", "passes: [gbuffer, trace, pack, readback]"))
        self.assertEqual(code, 0, said)
        self.assertRegex(said, r":3:\d+: render\.passes: 'gbuffer' is a name of before \(deprecated\)")
        code, said = self.check(GOOD.replace("tracer: bvh", "passes: [hard_shadows, soft_shadows]"))
        self.assertEqual((code, "deprecated" in said), (0, False), said)

    # ---- what is accepted starts

    def some(self, random):
        """A configuration of random parts, some of them wrong."""
        pick = random.choice
        server = {"mode": pick(["demo", "demo", "production"]), "state_folder": pick(["state", "new/state", "text"]),
                  "control_port": 0, "data_port": 0, "net_threads": pick([1, 2, 3]),
                  "listen": pick(["127.0.0.1", "::1", "127.0.0.1", "192.0.2.7"])}
        if random.random() < 0.5:
            server["tls"] = (f"{{certificate: {pick(['server.pem', 'server.pem', 'other.pem', 'gone.pem'])}, "
                             f"key: {pick(['server-key.pem', 'server-key.pem', 'open-key.pem'])}}}")
        admin = {"port": 0, "socket": pick(["''", "admin.sock", "gone/admin.sock"]),
                 "token_file": pick(["token", "token", "short-token", "''"])}
        render = {"device": pick(["cpu", "auto", "0", "llvmpipe", "9"]), "tracer": pick(["bvh", "light_buffer", "auto", "no"]),
                  "raster": pick(["auto", "hardware", "compute"]), "queues": pick([0, 1, 4]), "frames_in_flight": pick([1, 6]),
                  "cache_folder": pick(["''", "cache", "text", "deep/er/cache"]),
                  "passes": pick(["[]", "[hard_shadows]", "[hard_shadows, soft_shadows]", "[gbuffer, trace, pack, readback]", "[gbuffer_all, trace, pack, readback]",
                                  "[gbuffer, pack, readback]", "[hard_shadows, fog]"])}
        scene = pick(["living_room.glb", "living_room.glb", "living_room.glb", "text"])
        tenant = pick(["{name: lab, open: true}", "{name: lab}", f"{{name: lab, token_sha256: ['{HASH}']}}",
                       "{name: lab, token_sha256_file: hashes}", "{name: lab, token_sha256_file: gone}"])
        inline = lambda keys: "{" + ", ".join(f"{key}: {value}" for key, value in keys.items()) + "}"
        # Most of a random configuration is to be good, so that some are accepted.
        if random.random() < 0.6:
            server |= {"state_folder": "state", "listen": "127.0.0.1", "mode": "demo"}
            server.pop("tls", None)
            render |= {"device": "cpu", "cache_folder": "''", "tracer": pick(["bvh", "auto"])}
            admin |= {"socket": "''", "token_file": "token"}
            scene, tenant = "living_room.glb", "{name: lab, open: true}"
        return (f"server: {inline(server)}\nadmin: {inline(admin)}\nrender: {inline(render)}\n"
                f"scenes: {{list: [{{name: s, file: {scene}}}]}}\ntenants: [{tenant}]\n"
                f"log: {{level: {pick(['info', 'warning'])}, format: {pick(['json', 'key_value'])}}}\n")

    def starts(self, file):
        """Whether it serves, and what it said."""
        log = self.folder / "log"
        with open(log, "w") as out:
            process = subprocess.Popen([BUILD / "bin/gnomond", "--config", file], stdout=out, stderr=subprocess.STDOUT)
        try:
            ready = eventually(lambda: process.poll() is not None or "gnomond ready" in log.read_text(), "ready or gone")
            serves = bool(ready) and "gnomond ready" in log.read_text()
            if serves:
                process.send_signal(signal.SIGTERM)
                self.assertEqual(process.wait(60), 0, log.read_text())
            return serves, log.read_text()
        finally:
            process.kill()
            process.wait()

    def test_what_it_accepts_starts_and_what_it_refuses_does_not(self):
        print(f"GNOMON_SEED={SEED} GNOMON_ROUNDS={ROUNDS}", flush=True)
        dice, accepted = random.Random(SEED), 0
        for number in range(ROUNDS):
            text = self.some(dice)
            code, said = self.check(text)
            serves, log = self.starts(self.folder / "gnomond.yaml")
            self.assertEqual(serves, code == 0, f"round {number}:\n{text}\ncheck: {said}\nstart: {log}")
            accepted += serves
            if not serves:
                # Scenes are read by who loads them, after all else was found right.
                complaints = [line for line in said.splitlines() if line.startswith("gnomond: ")]
                self.assertTrue(any(line in log for line in complaints), f"{text}\ncheck: {said}\nstart: {log}")
        print(f"{accepted} of {ROUNDS} were accepted, and started")
        self.assertGreater(accepted, 0)
        self.assertLess(accepted, ROUNDS)


if __name__ == "__main__":
    unittest.main(verbosity=2)
