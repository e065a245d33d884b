"""The seal of the data channel: epochs of keys, nonces, and the window of sequence numbers that may still come."""
import struct

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM, ChaCha20Poly1305
from cryptography.hazmat.primitives.hashes import SHA256
from cryptography.hazmat.primitives.kdf.hkdf import HKDFExpand

from messages import VERSION

HEADER = struct.Struct("<BBHQQ")  # version, kind, flags, session, sequence
TAG_BYTES = 16
EPOCH_DATAGRAMS = 1 << 22
WINDOW = 1024

AES_128_GCM, CHACHA20_POLY1305 = 1, 2
CIPHERS = {AES_128_GCM: (AESGCM, 16), CHACHA20_POLY1305: (ChaCha20Poly1305, 32)}

CLIENT_LABEL = b"EXPERIMENTAL gnomon 2 client"
SERVER_LABEL = b"EXPERIMENTAL gnomon 2 server"
RESUMPTION_LABEL = b"EXPERIMENTAL gnomon 2 resumption"
CHALLENGE_LABEL = b"EXPERIMENTAL gnomon 2 challenge"


def exporter_context(session, cipher):
    return struct.pack("<QB", session, cipher)


def expand(secret, info, length):
    return HKDFExpand(SHA256(), length, info).derive(secret)


class Keys:
    """Of one direction, by epoch. A secret is forgotten when the next is made, a key when it is two epochs old."""

    def __init__(self, secret, cipher, epoch_datagrams=EPOCH_DATAGRAMS):
        self.make, self.key_bytes = CIPHERS[cipher]
        self.epoch_datagrams = epoch_datagrams
        self.secret, self.next_epoch = secret, 0
        self.by_epoch = {}

    def epoch(self, sequence):
        return sequence // self.epoch_datagrams

    def material(self):
        """Key and iv of the newest secret's epoch."""
        return expand(self.secret, b"gnomon 2 key", self.key_bytes), expand(self.secret, b"gnomon 2 iv", 12)

    def of(self, sequence):
        """AEAD and nonce."""
        epoch = self.epoch(sequence)
        while self.next_epoch <= epoch:
            key, iv = self.material()
            self.by_epoch[self.next_epoch] = self.make(key), iv
            self.secret = expand(self.secret, b"gnomon 2 next", 32)
            self.next_epoch += 1
            self.by_epoch.pop(self.next_epoch - 4, None)
        aead, iv = self.by_epoch[epoch]
        tail = int.from_bytes(iv[4:], "little") ^ sequence
        return aead, iv[:4] + tail.to_bytes(8, "little")


class Sealer:
    def __init__(self, keys, session):
        self.keys, self.session, self.sequence = keys, session, 0

    def seal(self, kind, body):
        self.sequence += 1
        header = HEADER.pack(VERSION, kind, 0, self.session, self.sequence)
        aead, nonce = self.keys.of(self.sequence)
        return header + aead.encrypt(nonce, bytes(body), header)


class Opener:
    """Opens each datagram of the peer once."""

    def __init__(self, keys, session, kinds, longest=1200):
        self.keys, self.session, self.kinds, self.longest = keys, session, kinds, longest
        self.highest, self.taken = 0, set()

    def open(self, datagram):
        """Kind, sequence number and body; None for what has no effect."""
        if not HEADER.size + TAG_BYTES <= len(datagram) <= self.longest:
            return None
        header = datagram[:HEADER.size]
        version, kind, _, session, sequence = HEADER.unpack(header)
        if version != VERSION or kind not in self.kinds or session != self.session or not self._may_come(sequence):
            return None
        aead, nonce = self.keys.of(sequence)
        try:
            body = aead.decrypt(nonce, datagram[HEADER.size:], header)
        except InvalidTag:
            return None
        self._remember(sequence)
        return kind, sequence, body

    def _may_come(self, sequence):
        if sequence == 0 or sequence in self.taken or sequence <= self.highest - WINDOW:
            return False
        return abs(self.keys.epoch(sequence) - self.keys.epoch(self.highest)) <= 1

    def _remember(self, sequence):
        self.taken.add(sequence)
        self.highest = max(self.highest, sequence)
        if len(self.taken) > 2 * WINDOW:
            self.taken = {s for s in self.taken if s > self.highest - WINDOW}
