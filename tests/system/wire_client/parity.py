"""Cauchy Reed-Solomon over GF(2^8), polynomial 0x11d: slices of a group are rebuilt from parity shards."""
import struct


def _powers():
    value, powers = 1, []
    for _ in range(255):
        powers.append(value)
        value = value << 1 ^ (0x11D if value & 0x80 else 0)
    return powers


EXP = _powers() * 2
LOG = {value: power for power, value in enumerate(EXP[:255])}


def times(a, b):
    return EXP[LOG[a] + LOG[b]] if a and b else 0


def inverse(a):
    return EXP[255 - LOG[a]]


def scaled(shard, factor):
    return bytes(times(byte, factor) for byte in shard)


def added(a, b):
    return bytes(x ^ y for x, y in zip(a, b))


def coefficient(k, p, j):
    return inverse((k + p) ^ j)


def shard_of(body, length):
    """Of a slice, in a group whose shards have `length` bytes."""
    return (struct.pack("<H", len(body)) + body).ljust(length, b"\0")


def body_of(shard):
    """None if the shard cannot be one of a slice."""
    length = struct.unpack_from("<H", shard)[0]
    return shard[2:2 + length] if length <= len(shard) - 2 else None


def parity_shard(shards, p):
    total = bytes(len(shards[0]))
    for j, shard in enumerate(shards):
        total = added(total, scaled(shard, coefficient(len(shards), p, j)))
    return total


def rebuild(k, shards, parity):
    """The shards of the group that are missing, by number. `shards` and `parity`: what is there, by number, all of one
    length. Empty if too few are there."""
    missing = [j for j in range(k) if j not in shards]
    if len(parity) < len(missing):
        return {}
    rows = []  # [coefficients of the missing, what they sum up to]
    for p in sorted(parity)[:len(missing)]:
        right = parity[p]
        for j, shard in shards.items():
            right = added(right, scaled(shard, coefficient(k, p, j)))
        rows.append([[coefficient(k, p, j) for j in missing], right])
    for i in range(len(rows)):  # Gauss-Jordan; every square part of a Cauchy matrix is regular, so no pivot is 0
        factor = inverse(rows[i][0][i])
        rows[i] = [[times(c, factor) for c in rows[i][0]], scaled(rows[i][1], factor)]
        for other in range(len(rows)):
            factor = rows[other][0][i]
            if other != i and factor:
                rows[other] = [[a ^ times(b, factor) for a, b in zip(rows[other][0], rows[i][0])],
                               added(rows[other][1], scaled(rows[i][1], factor))]
    return {j: row[1] for j, row in zip(missing, rows)}
