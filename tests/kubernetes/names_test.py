#!/usr/bin/python3
"""The names that pods of tests/kubernetes are told, as a resolver and as HAProxy ask for them.

    names_test.py
"""
import socket
import struct
import unittest

import names

NODE, OTHER = "10.77.0.11", "10.77.0.12"


class Cluster:
    """An API server with one service of two nodes, and one of none."""

    @staticmethod
    def items(kind):
        assert kind == "endpoints"
        subset = {"addresses": [{"ip": NODE}, {"ip": OTHER}],
                  "ports": [{"name": "control", "port": 7600, "protocol": "TCP"}]}
        return [{"metadata": {"name": "gnomon", "namespace": "default"}, "subsets": [subset]},
                {"metadata": {"name": "empty", "namespace": "default"}}]


class Questions(unittest.TestCase):
    def setUp(self):
        self.names = names.Names.__new__(names.Names)  # without its socket
        self.names.api = Cluster()
        self.names.records = self.names.known()

    def ask(self, name, kind):
        """The code of the answer, and the data of its records."""
        question = struct.pack("!HHHHHH", 7, 0x0100, 1, 0, 0, 0) + names.packed(name) + struct.pack("!HH", kind, names.IN)
        answer = self.names.answer(question)
        number, flags, questions, answers, _, more = struct.unpack_from("!HHHHHH", answer)
        self.assertEqual((number, questions, flags & names.ANSWERS), (7, 1, names.ANSWERS))
        self.assertEqual(answer[12:len(question)], question[12:])
        at, records = len(question), []
        for _ in range(answers + more):
            owner, at = names.read_name(answer, at)
            of_kind, _, _, length = struct.unpack_from("!HHIH", answer, at)
            records.append((owner, of_kind, answer[at + 10:at + 10 + length]))
            at += 10 + length
        self.assertEqual(at, len(answer))
        return flags & 0xF, records

    def test_a_service_has_the_addresses_of_all_its_pods(self):
        code, records = self.ask("gnomon.default.svc.cluster.local", names.A)
        self.assertEqual(code, names.NO_ERROR)
        self.assertEqual([socket.inet_ntoa(data) for _, _, data in records], [NODE, OTHER])

    def test_a_door_finds_ports_and_addresses_at_once(self):
        code, records = self.ask("_control._TCP.gnomon.default.svc.cluster.local", names.SRV)
        self.assertEqual(code, names.NO_ERROR)
        ports = [(struct.unpack_from("!HHH", data)[2], names.read_name(data, 6)[0]) for _, kind, data in records
                 if kind == names.SRV]
        self.assertEqual(ports, [(7600, "10-77-0-11.gnomon.default.svc.cluster.local"),
                                 (7600, "10-77-0-12.gnomon.default.svc.cluster.local")])
        addresses = {owner: socket.inet_ntoa(data) for owner, kind, data in records if kind == names.A}
        self.assertEqual(addresses, dict(zip((host for _, host in ports), (NODE, OTHER))))

    def test_who_has_no_pods_is_known_all_the_same(self):
        self.assertEqual(self.ask("empty.default.svc.cluster.local", names.A), (names.NO_ERROR, []))
        self.assertEqual(self.ask("gnomon.default.svc.cluster.local", 28), (names.NO_ERROR, []))
        self.assertEqual(self.ask("gnomon.svc.cluster.local", names.A), (names.NO_SUCH_NAME, []))
        self.assertEqual(self.ask("gnomon", names.A), (names.NO_SUCH_NAME, []))


if __name__ == "__main__":
    unittest.main(verbosity=2)
