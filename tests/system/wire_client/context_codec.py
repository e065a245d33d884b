"""Codec 2, tiles_context: every decision coded with the probability that its surroundings give it. Slow and plain."""
import pathlib
import re
from collections import defaultdict
from functools import lru_cache

import xxhash

from fields import Malformed, require

DARK, LIT, MIXED, OUTSIDE = range(4)
MOST = 2047  # of stretched numbers
SEGMENT = 32  # tiles
BLOCK = 8
WEIGHTS = pathlib.Path(__file__).resolve().parents[3] / "protocol/context/net_weights.inc"


class NoReference(Malformed):
    """A slice that is as good as lost."""


def squash_table():
    table, e = [0] * (2 * MOST + 1), 1 << 40
    for n in range(MOST + 1):
        q = (1 << 56) // ((1 << 40) + e)
        table[MOST + n], table[MOST - n] = min(q, 65535), max(65536 - q, 1)
        high, low = e >> 20, e & 0xFFFFF
        e = high * 1_044_487 + (low * 1_044_487 >> 20) + (high * 1_037_664 >> 20)
    return table


def stretch_table(squashed):
    table, at = [], 0
    for p in range(4096):
        while at < 2 * MOST and squashed[at] < p * 16 + 8:
            at += 1
        table.append(at - MOST)
    return table


SQUASHED = squash_table()
STRETCHED = stretch_table(SQUASHED)


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

    def says(self):
        return STRETCHED[self.one >> 4] * min(self.seen, 8) >> 3

    def take(self, bits):
        bit = bits.take(within(self.one, 32, 65503))
        self.learn(bit)
        return bit


class Net:
    """`inputs`: for each byte, the widths of its one-of fields; None: a byte of pixels."""

    def __init__(self, name, hidden, inputs, outputs):
        numbers = re.search(rf"{name}\[\d+\] = {{(.*?)}}", WEIGHTS.read_text(), re.S)[1]
        self.numbers, self.hidden, self.inputs = list(map(int, re.findall(r"-?\d+", numbers))), hidden, inputs
        self.first_row = []
        row = 0
        for fields in inputs:
            self.first_row.append(row)
            row += sum(1 << bits for bits in fields) if fields else 8
        self.biases = self._hidden_numbers(row)
        rest = self.numbers[(row + 1) * hidden:]
        assert len(rest) == outputs * (hidden + 1)
        self.outputs = [(rest[o * (hidden + 1):][:hidden], rest[o * (hidden + 1) + hidden]) for o in range(outputs)]
        self.part = lru_cache(None)(self._part)
        self.units = lru_cache(1 << 16)(self._units)

    def _hidden_numbers(self, row):
        return self.numbers[row * self.hidden:(row + 1) * self.hidden]

    def _part(self, number, byte):
        """What one input byte adds to the units."""
        fields, row, rows = self.inputs[number], self.first_row[number], []
        if not fields:
            rows = [row + bit for bit in range(8) if byte >> bit & 1]
        for bits in fields or ():
            rows.append(row + (byte & (1 << bits) - 1))
            row, byte = row + (1 << bits), byte >> bits
        return [sum(column) for column in zip(*map(self._hidden_numbers, rows))] if rows else [0] * self.hidden

    def _units(self, inputs):
        parts = [self.part(number, byte) for number, byte in enumerate(inputs)]
        sums = map(sum, zip(self.biases, *parts))
        return [max(0, (s + 32768 & 65535) - 32768) for s in sums]

    def output(self, inputs, number=0):
        weights, bias = self.outputs[number]
        return (sum(u * w for u, w in zip(self.units(inputs), weights)) >> 6) + bias


PLACE, CLASSES, PIXELS = (3, 3, 2), (2, 2, 2, 2), None


@lru_cache(None)
def nets(referenced):
    """Of pixels and of classes."""
    if referenced:
        return (Net("kReferencePixelWeights", 32, [PLACE] + 9 * [PIXELS], 1),
                Net("kReferenceClassWeights", 16, 2 * [CLASSES] + 11 * [PIXELS], 2))
    return (Net("kPixelWeights", 32, [PLACE] + 7 * [PIXELS], 1),
            Net("kClassWeights", 16, 2 * [CLASSES] + 4 * [PIXELS], 2))


class Blend:
    def __init__(self):
        self.weights = defaultdict(lambda: [65536, 9830, 9830])
        self.counts = defaultdict(Count), defaultdict(Count)

    def take(self, bits, output, set_, contexts):
        counts = [table[context] for table, context in zip(self.counts, contexts)]
        weights = self.weights[set_]
        numbers = within(output, -MOST, MOST), *(count.says() for count in counts)
        p = squash(sum(w * n for w, n in zip(weights, numbers)) >> 16)
        bit = bits.take(p)
        error = (65535 if bit else 0) - p
        weights[:] = (within(w + (error * n >> 15), -262_144, 262_144) for w, n in zip(weights, numbers))
        for count in counts:
            count.learn(bit)
        return bit


class Plane:
    """Pixels and classes of one light's tiles, by whole rows: bit x of `rows[y]`."""

    def __init__(self, tiles_x, tiles_y):
        self.tiles_x, self.tiles_y = tiles_x, tiles_y
        self.rows, self.classes = [0] * (8 * tiles_y), {}

    def span(self, x, y, first, last):
        """Pixels x + first to x + last of row y, the leftmost in the lowest bit; 0 outside."""
        if y < 0:
            return 0
        row, start = self.rows[y], x + first
        return (row >> start if start >= 0 else row << -start) & (1 << last - first + 1) - 1

    def class_at(self, x, y):
        if not (0 <= x < self.tiles_x and y >= 0):
            return OUTSIDE
        return self.classes.get((x, y), OUTSIDE)

    def word(self, tile):
        x, y = tile % self.tiles_x, tile // self.tiles_x
        return sum((self.rows[8 * y + r] >> 8 * x & 255) << 8 * r for r in range(8))


class Reference:
    """One light of the frame that a slice refers to; beyond its edges as the nearest at the edge."""

    def __init__(self, words, tiles_x, tiles_y):
        self.width, self.height = 8 * tiles_x, 8 * tiles_y
        self.rows = []
        for y in range(self.height):
            row = 0
            for t in range(tiles_x):
                row |= (words[y // 8 * tiles_x + t] >> 8 * (y % 8) & 255) << 8 * t
            self.rows.append(row)

    def pixel(self, x, y):
        return self.rows[within(y, 0, self.height - 1)] >> within(x, 0, self.width - 1) & 1

    def span(self, x, y, first, last):
        return sum(self.pixel(x + first + i, y) << i for i in range(last - first + 1))

    def column(self, x, y):
        return sum(self.pixel(x, y + i) << i for i in range(8))

    def window(self, x, y):
        """The twelve rows of a tile and the two pixels around it."""
        return [self.span(x, y + r, -2, 9) for r in range(-2, 10)]


class Slice:
    """`references`: words by light of the frame referred to, or None."""

    def __init__(self, slice_, tiles_x, tiles_y, coded, references):
        self.slice, self.tiles_x, self.tiles_y = slice_, tiles_x, tiles_y
        self.bits, self.references = Bits(coded), references
        self.pixel_net, self.class_net = nets(references is not None)
        self.pixel_blend, self.class_blends = Blend(), (Blend(), Blend())
        self.even_pixels = {}
        self.even_classes = [(Count(600, 30), Count(65436 if v else 100, 30)) for v in (0, 1)]
        self.foreseen = Count(50_000, 4)
        self.lengths = defaultdict(lambda: Count(32768, 2))

    def decode(self):
        lights = [self._light(light) for light in range(self.slice.light_count)]
        require(self.bits.at >= len(self.bits.coded), "coded bytes that nothing needs")
        return lights

    def _light(self, light):
        self.plane = Plane(self.tiles_x, self.tiles_y)
        self.motions = {}
        if self.references:
            words = self.references[self.slice.first_light + light]
            self.reference = Reference(words, self.tiles_x, self.tiles_y)
        first, end = self.slice.first_tile, self.slice.first_tile + self.slice.tile_count
        at = first
        while at < end:
            x, y = at % self.tiles_x, at // self.tiles_x
            count = min(SEGMENT - x % SEGMENT, self.tiles_x - x, end - at)
            self._segment(range(x, x + count), y)
            at += count
        return [self.plane.word(tile) for tile in range(first, end)]

    def _segment(self, xs, y):
        if self.references:
            for block in range(xs[0] // BLOCK, xs[-1] // BLOCK + 1):
                if (block, y // BLOCK) not in self.motions:
                    self.motions[block, y // BLOCK] = self._motion(block, y // BLOCK)
        for x in xs:
            class_ = self.plane.classes[x, y] = self._class(x, y)
            if class_ == LIT:
                for r in range(8):
                    self.plane.rows[8 * y + r] |= 255 << 8 * x
        mixed = [x for x in xs if self.plane.classes[x, y] == MIXED]
        for r in range(8):
            for x in mixed:
                for c in range(8):
                    self.plane.rows[8 * y + r] |= self._pixel(x, y, c, r) << 8 * x + c

    # ---- motions

    def _motion(self, x, y):
        left, above, right = (self.motions.get(b) for b in ((x - 1, y), (x, y - 1), (x + 1, y - 1)))
        if left and above and right:
            guess = tuple(sorted(axis)[1] for axis in zip(left, above, right))
        else:
            guess = left or above or (0, 0)
        if self.foreseen.take(self.bits):
            return guess
        return tuple(within(guess[axis] + self._difference(axis), -511, 511) for axis in (0, 1))

    def _difference(self, axis):
        length = 0
        while length < 10 and self.lengths[axis, length].take(self.bits):
            length += 1
        if not length:
            return 0
        value = 1
        for _ in range(length - 1):
            value = value << 1 | self.bits.take(32768)
        return -value if self.bits.take(32768) else value

    def _moved(self, x, y):
        """Where a tile's first pixel is in the reference."""
        dx, dy = self.motions[x // BLOCK, y // BLOCK]
        return (within(8 * x + dx, -24, 8 * self.tiles_x + 8), within(8 * y + dy, -24, 8 * self.tiles_y + 8))

    # ---- classes

    def _class(self, x, y):
        at, plane = self.plane.class_at, self.plane
        near = at(x - 1, y), at(x, y - 1), at(x + 1, y - 1), at(x - 1, y - 1)
        far = at(x - 2, y), at(x, y - 2), at(x + 2, y - 1), at(x - 2, y - 1)
        window = self.reference.window(*self._moved(x, y)) if self.references else None
        v = near[0]
        if v in (DARK, LIT) and len(set(near)) == 1 and (window is None or set(window) == {4095 * v}):
            mixed, lit = self.even_classes[v]
            return MIXED if mixed.take(self.bits) else lit.take(self.bits)
        above = plane.span(8 * x, 8 * y - 1, 0, 7)
        inputs = [sum(c << 2 * i for i, c in enumerate(near)), sum(c << 2 * i for i, c in enumerate(far)),
                  plane.span(8 * x, 8 * y - 1, -8, -1), above, plane.span(8 * x, 8 * y - 1, 8, 15),
                  plane.span(8 * x, 8 * y - 2, 0, 7)]
        contexts = [inputs[0] | (0 if above == 0 else 1 if above == 255 else 2) << 8, above | near[0] << 8]
        if window:
            mx, my = self._moved(x, y)
            tile = [row >> 2 & 255 for row in window[2:10]]
            flags = 0
            for number, (rows, full) in enumerate(((tile, 255), (window, 4095), (tile[:4], 255), (tile[4:], 255))):
                flags |= int(any(rows)) << 2 * number | int(all(r == full for r in rows)) << 2 * number + 1
            inputs += [flags, tile[0], tile[7], window[0] >> 2 & 255, window[11] >> 2 & 255,
                       self.reference.column(mx - 2, my), self.reference.column(mx + 9, my)]
            contexts[1] = flags | near[0] << 8 | near[1] << 10
        inputs, set_ = tuple(inputs), near[0] | near[1] << 2
        mixed, lit = self.class_blends
        if mixed.take(self.bits, self.class_net.output(inputs, 0), set_, contexts):
            return MIXED
        return lit.take(self.bits, self.class_net.output(inputs, 1), set_, contexts)

    # ---- pixels

    def _pixel(self, tile_x, tile_y, c, r):
        span, x, y = self.plane.span, 8 * tile_x + c, 8 * tile_y + r
        place = c | r << 3 | self.plane.class_at(tile_x + 1, tile_y) << 6
        west = span(x, y, -8, -1)
        if self.references:
            mx, my = self._moved(tile_x, tile_y)
            of = lambda dy, first, last: self.reference.span(mx + c, my + r + dy, first, last)
            pixels = (west, span(x, y - 1, -3, 4), span(x, y - 2, -3, 4), span(x, y - 3, -3, 4),
                      *(of(dy, -3, 4) for dy in range(-2, 3)))
        else:
            pixels = (west, span(x, y - 1, -7, 0), span(x, y - 1, 1, 8), span(x, y - 2, -7, 0), span(x, y - 2, 1, 8),
                      span(x, y - 3, -3, 4), span(x, y - 4, -3, 4))
        output = self.pixel_net.output((place, *pixels))
        if set(pixels) in ({0}, {255}):
            key = pixels[0] & 1, place
            if key not in self.even_pixels:
                self.even_pixels[key] = Count(squash(output), 24)
            return self.even_pixels[key].take(self.bits)
        near = west >> 7 | span(x, y - 1, -1, 1) << 1 | (west >> 6 & 1) << 4
        first = west >> 4 | span(x, y - 1, -3, 3) << 4 | span(x, y - 2, -1, 1) << 11
        if self.references:
            second = near | of(-1, -1, 1) << 5 | of(0, -1, 1) << 8 | of(1, -1, 1) << 11
        else:
            second = place | near << 8 | span(x, y - 2, 0, 0) << 13
        return self.pixel_blend.take(self.bits, output, near, (first, second))


def tiles_context(slice_, tiles_x, tiles_y, kept):
    """`kept`: words by light of the frames that may be referred to, by frame number."""
    payload = slice_.payload
    require(payload and payload[0] <= 1, "a payload of another form")
    if payload[0] == 0:
        return Slice(slice_, tiles_x, tiles_y, payload[1:], None).decode()
    require(len(payload) >= 9, "a reference that is cut")
    frame, checksum = (int.from_bytes(payload[at:at + 4], "little") for at in (1, 5))
    if frame not in kept:
        raise NoReference(f"frame {frame} is not here")
    plain = b"".join(word.to_bytes(8, "little") for light in kept[frame] for word in light)
    if xxhash.xxh3_64_intdigest(plain) & 0xFFFFFFFF != checksum:
        raise NoReference(f"frame {frame} has another mask here")
    return Slice(slice_, tiles_x, tiles_y, payload[9:], kept[frame]).decode()
