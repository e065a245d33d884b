"""The numbers of tiles_context: the range coder's decoder, counts, nets and predictors."""
import pathlib
import re
from functools import lru_cache

MOST = 2047  # of stretched numbers
WEIGHTS = pathlib.Path(__file__).resolve().parents[3] / "protocol/context/net_weights.inc"


def squash_table():
    table, e = [0] * (2 * MOST + 1), 1 << 40
    for n in range(MOST + 1):
        q = (1 << 56) // ((1 << 40) + e)
        table[MOST + n], table[MOST - n] = min(q, 65535), max(65536 - q, 1)
        high, low = e >> 20, e & 0xFFFFF
        e = high * 1_044_487 + (low * 1_044_487 >> 20) + (high * 1_037_664 >> 20)
    return table


SQUASHED = squash_table()


def within(value, least, most):
    return least if value < least else most if value > most else value


def squash(s):
    return SQUASHED[within(s, -MOST, MOST) + MOST]


class Bits:
    """The range coder's decoder."""

    def __init__(self, coded):
        self.coded, self.at = coded, 0
        self.range, self.value = (1 << 32) - 1, 0
        for _ in range(4):
            self.value = self.value << 8 | self._byte()

    def _byte(self):
        self.at += 1
        return self.coded[self.at - 1] if self.at <= len(self.coded) else 0

    def take(self, p):
        bound = (self.range >> 16) * p
        bit = self.value < bound
        if bit:
            self.range = bound
        else:
            self.value -= bound
            self.range -= bound
        while self.range < 1 << 24:
            self.range <<= 8
            self.value = self.value << 8 | self._byte()
        return int(bit)


class Count:
    __slots__ = "one", "seen"

    def __init__(self, one=32768, seen=0):
        self.one, self.seen = one, seen

    def learn(self, bit):
        rate = 655_360 // (10 * self.seen + 16)
        self.one += (65535 - self.one if bit else -self.one) * (rate >> 1) >> 15
        self.seen = min(self.seen + 1, 60)

    def take(self, bits):
        bit = bits.take(within(self.one, 32, 65503))
        self.learn(bit)
        return bit


def joined(*numbers):
    """Numbers of some bits, (bits, number), one after the other, the first in the lowest bits."""
    value = shift = 0
    for bits, number in numbers:
        value, shift = value | number << shift, shift + bits
    return value


class Net:
    """`inputs`: of each part."""

    HIDDEN = 32

    def __init__(self, name, inputs, outputs):
        numbers = re.search(rf"{name}\[\d+\] = {{(.*?)}}", WEIGHTS.read_text(), re.S)[1]
        numbers = list(map(int, re.findall(r"-?\d+", numbers)))
        self.parts = []
        for count in inputs:
            rows = [numbers[self.HIDDEN * row:][:self.HIDDEN] for row in range(count + 1)]
            numbers = numbers[self.HIDDEN * (count + 1):]
            of_outputs = [numbers[(self.HIDDEN + 1) * output:][:self.HIDDEN + 1] for output in range(outputs)]
            numbers = numbers[(self.HIDDEN + 1) * outputs:]
            self.parts.append((rows[:-1], rows[-1], of_outputs))
        assert not numbers
        self.says = lru_cache(None)(self._says)

    def _says(self, part, inputs, output):
        rows, biases, of_outputs = self.parts[part]
        sums = map(sum, zip(biases, *(row for bit, row in enumerate(rows) if inputs >> bit & 1)))
        units = [max(0, (s + 32768 & 65535) - 32768) for s in sums]
        *weights, bias = of_outputs[output]
        return within((sum(u * w for u, w in zip(units, weights)) >> 6) + bias, -8191, 8191)

    def output(self, inputs, output=0):
        return sum(self.says(part, of_part, output) for part, of_part in enumerate(inputs))


@lru_cache(None)
def nets(referenced):
    """Of pixels, of runs and of classes."""
    if referenced:
        return (Net("kReferencePixelWeights", (16, 16, 16, 16), 1), Net("kReferenceRunWeights", (16, 13), 1),
                Net("kReferenceClassWeights", (16, 16, 16, 12, 14), 2))
    return (Net("kPixelWeights", (16, 16, 16), 1), Net("kRunWeights", (16, 12), 1),
            Net("kClassWeights", (16, 16, 14), 2))


class Predictor:
    def __init__(self):
        self.fine, self.coarse = {}, {}

    def take(self, bits, output, fine, coarse):
        k = within(output, -MOST, MOST) + 2048 >> 7
        first = self.fine.setdefault((k, fine), Count(squash(128 * k - 1984), 20))
        second = self.coarse.setdefault((k >> 1, coarse), Count(squash(256 * (k >> 1) - 1920), 20))
        bit = bits.take(within(first.one + second.one >> 1, 32, 65503))
        first.learn(bit)
        second.learn(bit)
        return bit
