"""A relay before a daemon: its TCP port as it is, its UDP ports as long as they are open. In threads of this process."""
import random
import selectors
import socket
import threading

MOST = 65536


class Relay:
    """Listens at `host` on the same ports as the daemon at `server`. `loss`: share of UDP payloads, each way."""

    def __init__(self, host, server, tcp, udp):
        self.host, self.server = host, server
        self.is_open, self.loss = True, 0.0
        self.random = random.Random(7)
        self.selector = selectors.DefaultSelector()
        self.ways = {}  # UDP: by a client's address, the socket that stands for it
        self.udp = [self.udp_at(port) for port in udp]
        self.tcp = socket.create_server((host, tcp))
        self.tcp_port = tcp
        self.stopping = False
        self.threads = [threading.Thread(target=self.serve_udp, daemon=True),
                        threading.Thread(target=self.serve_tcp, daemon=True)]
        for thread in self.threads:
            thread.start()

    def udp_at(self, port):
        listening = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        listening.bind((self.host, port))
        self.selector.register(listening, selectors.EVENT_READ, ("client", port))
        return listening

    def passes(self):
        return self.is_open and self.random.random() >= self.loss

    def serve_udp(self):
        while not self.stopping:
            for key, _ in self.selector.select(0.2):
                try:
                    payload, peer = key.fileobj.recvfrom(MOST)
                    if not self.passes():
                        continue
                    if key.data[0] == "client":
                        self.way_of(key.fileobj, peer, key.data[1]).send(payload)
                    else:
                        _, listening, client = key.data
                        listening.sendto(payload, client)
                except OSError:
                    pass  # lost, or the daemon has gone

    def way_of(self, listening, client, port):
        way = self.ways.get((client, port))
        if way is None:
            way = self.ways[client, port] = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            way.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
            way.connect((self.server, port))
            self.selector.register(way, selectors.EVENT_READ, ("server", listening, client))
        return way

    def serve_tcp(self):
        while not self.stopping:
            try:
                client, _ = self.tcp.accept()
                server = socket.create_connection((self.server, self.tcp_port))
                for one in (client, server):
                    one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            except OSError:
                continue  # the browser has thought better of it
            for one, other in ((client, server), (server, client)):
                threading.Thread(target=self.pump, args=(one, other), daemon=True).start()

    @staticmethod
    def pump(source, sink):
        try:
            while data := source.recv(MOST):
                sink.sendall(data)
        except OSError:
            pass
        for end in (source, sink):
            try:
                end.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass
        source.close()  # the other one is that of the other direction

    def close(self):
        self.stopping = True
        self.tcp.shutdown(socket.SHUT_RDWR)
        self.tcp.close()
        self.threads[0].join()
        for way in (*self.udp, *self.ways.values()):
            way.close()
