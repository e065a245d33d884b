"""The cluster's names, which CoreDNS has elsewhere: services without an address of their own, by what the API server says
of their endpoints. As much of DNS as HAProxy and getaddrinfo ask for, over UDP."""
import re
import socket
import struct
import threading
import time

A, SRV, IN = 1, 33, 1
NO_ERROR, NO_SUCH_NAME = 0, 3
ANSWERS, AUTHORITATIVE = 0x8000, 0x0400
DOMAIN = "svc.cluster.local"
TTL_S, OFTEN_S = 1, 0.5


def packed(name):
    return b"".join(bytes([len(label)]) + label.encode() for label in name.split(".")) + b"\0"


def record(name, kind, data):
    return packed(name) + struct.pack("!HHIH", kind, IN, TTL_S, len(data)) + data


def read_name(data, at):
    labels = []
    while data[at]:
        labels.append(data[at + 1:at + 1 + data[at]].decode("ascii"))
        at += 1 + data[at]
    return ".".join(labels), at + 1


class Names:
    """`records`: what there is, by name in small letters and by kind."""

    def __init__(self, api, address, namespace):
        self.api, self.namespace = api, namespace
        self.records = {}
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((address, 53))
        for work in (self.learn, self.serve):
            threading.Thread(target=work, daemon=True).start()

    def learn(self):
        while True:
            try:
                self.records = self.known()
            except OSError:
                pass  # of a server that is slow or not there; what was known stays
            time.sleep(OFTEN_S)

    def known(self):
        """Who is not ready is among the addresses, where the service publishes such."""
        records = {}
        for endpoints in self.api.items("endpoints"):
            service = f"{endpoints['metadata']['name']}.{endpoints['metadata']['namespace']}.{DOMAIN}"
            records[service] = {A: []}
            for subset in endpoints.get("subsets", []):
                self.add(records, service, subset)
        return records

    @staticmethod
    def add(records, service, subset):
        for address in subset.get("addresses", []):
            data, host = socket.inet_aton(address["ip"]), f"{address['ip'].replace('.', '-')}.{service}"
            records[service][A].append((data, []))
            records[host] = {A: [(data, [])]}
            for port in subset["ports"]:
                name = f"_{port.get('name', '')}._{port['protocol'].lower()}.{service}"
                target = struct.pack("!HHH", 0, 100, port["port"]) + packed(host)
                records.setdefault(name, {}).setdefault(SRV, []).append((target, [record(host, A, data)]))

    def serve(self):
        while True:
            question, whence = self.socket.recvfrom(1 << 12)
            try:
                self.socket.sendto(self.answer(question), whence)
            except (IndexError, struct.error, UnicodeDecodeError, OSError):
                pass  # no question that anybody here asks

    def answer(self, data):
        number, flags = struct.unpack_from("!HH", data)
        name, end = read_name(data, 12)
        kind, = struct.unpack_from("!H", data, end)
        found = self.records.get(name.lower())
        answers = (found or {}).get(kind, [])
        more = [each for _, additional in answers for each in additional]
        known = found is not None or any(re.search(rf"(^|\.){re.escape(name.lower())}$", other) for other in self.records)
        flags = ANSWERS | AUTHORITATIVE | (flags & 0x0100) | (NO_ERROR if known else NO_SUCH_NAME)
        head = struct.pack("!HHHHHH", number, flags, 1, len(answers), 0, len(more))
        return head + data[12:end + 4] + b"".join(record(name, kind, each) for each, _ in answers) + b"".join(more)
