"""Codec 3, tiles_context: every decision coded with the probability that its surroundings give it. Slow and plain."""
from collections import defaultdict

import xxhash

from context_numbers import Bits, Count, Predictor, joined, nets, within
from fields import Malformed, require

DARK, LIT, MIXED, OUTSIDE = range(4)
SEGMENT = 32  # tiles
BLOCK = 8


class NoReference(Malformed):
    """A slice that is as good as lost."""


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
        self.pixel_net, self.run_net, self.class_net = nets(references is not None)
        self.pixels, self.runs, self.mixed, self.lit = (Predictor() for _ in range(4))
        self.breaks = {(v, n, i): Count(65535 // (n - i), 12) for v in (0, 1) for n in range(1, 9) for i in range(n)}
        self.quiet_breaks = {(v, size + 1): Count(one, 30) for v in (0, 1)
                             for size, one in enumerate((700, 1700, 3600, 7500, 15000, 19000))}
        self.odd = [Count(56_000, 30) for _ in (0, 1)]
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
        x = xs[0]
        while x <= xs[-1]:
            run = self._quiet(x, y, xs[-1] + 1)
            x += self._quiet_run(x, y, run) if run else self._set_class(x, y, self._class(x, y))
        mixed = [x for x in xs if self.plane.classes[x, y] == MIXED]
        for r in range(8):
            for x in mixed:
                self._pixel_row(x, y, r)

    def _set_class(self, x, y, class_):
        self.plane.classes[x, y] = class_
        if class_ == LIT:
            for r in range(8):
                self.plane.rows[8 * y + r] |= 255 << 8 * x
        return 1

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

    def _quiet(self, x, y, end):
        """The tiles of a run from x on; 0: none."""
        at, start = self.plane.class_at, x
        v = at(x - 1, y)
        if v not in (DARK, LIT) or at(x - 1, y - 1) != v or at(x, y - 1) != v:
            return 0
        while x < end and at(x + 1, y - 1) == v and (
                not self.references or set(self.reference.window(*self._moved(x, y))) == {4095 * v}):
            x += 1
        return x - start

    def _quiet_run(self, x, y, n):
        v, i = self.plane.class_at(x - 1, y), n
        if self.quiet_breaks[v, n.bit_length()].take(self.bits):
            i = 0
            while i < n - 1 and not self.bits.take(65536 // (n - i)):
                i += 1
        for kept in range(i):
            self._set_class(x + kept, y, v)
        if i == n:
            return n
        self._set_class(x + i, y, MIXED if self.odd[v].take(self.bits) else 1 - v)
        return i + 1

    def _class(self, x, y):
        at, span = self.plane.class_at, self.plane.span
        classes = lambda *four: joined(*((2, c) for c in four))
        near = classes(at(x - 1, y), at(x, y - 1), at(x + 1, y - 1), at(x - 1, y - 1))
        far = classes(at(x - 2, y), at(x, y - 2), at(x + 2, y - 1), at(x - 2, y - 1))
        both = classes(at(x - 1, y), at(x, y - 1))
        above, west, east = (span(8 * x, 8 * y - 1, first, first + 7) for first in (0, -8, 8))
        edge = int(above != 0) | int(above == 255) << 1
        if self.references:
            mx, my = self._moved(x, y)
            window = self.reference.window(mx, my)
            inner = [row >> 2 & 255 for row in window]
            tile, flags, beyond = inner[2:10], 0, 0
            for number, (rows, full) in enumerate(((tile, 255), (window, 4095), (tile[:4], 255), (tile[4:], 255))):
                flags |= int(any(rows)) << 2 * number | int(all(r == full for r in rows)) << 2 * number + 1
            for number, row in enumerate((inner[0], inner[11])):
                beyond |= int(row != 0) << 2 * number | int(row == 255) << 2 * number + 1
            coarse = flags & 15 | both << 4
            columns = (8, self.reference.column(mx - 2, my)), (8, self.reference.column(mx + 9, my))
            inputs = (joined((8, near), (8, flags)), joined((8, tile[0]), (8, tile[7])), joined(*columns),
                      joined((8, above), (4, both)), joined((8, far), (4, beyond), (2, edge)))
        else:
            coarse = near
            inputs = (joined((8, near), (8, above)), joined((8, far), (4, west >> 4), (4, east & 15)),
                      joined((8, span(8 * x, 8 * y - 2, 0, 7)), (4, both), (2, edge)))
        if self.mixed.take(self.bits, self.class_net.output(inputs, 0), both, coarse):
            return MIXED
        return self.lit.take(self.bits, self.class_net.output(inputs, 1), both, coarse)

    # ---- pixels

    def _pixel_row(self, tile_x, tile_y, r):
        """Row r of a tile. `of(k, a, b)` are pixels of the row k above, `there(k, a, b)` of the reference's k below."""
        self.tile, self.r, y = (tile_x, tile_y), r, 8 * tile_y + r
        above = [self.plane.span(8 * tile_x, 8 * tile_y + k, 0, 7) for k in range(r)]
        self.uniform = [all(row == 255 * v for row in above) for v in (0, 1)]
        moved = self._moved(tile_x, tile_y) if self.references else None
        c = 0
        while c < 8:
            x = 8 * tile_x + c
            of = lambda k, a, b, x=x: self.plane.span(x, y - k, a, b)
            there = lambda k, a, b, c=c: self.reference.span(moved[0] + c, moved[1] + r + k, a, b)
            v = of(0, -1, -1)
            n = 0
            if of(0, -2, -1) == 3 * v and of(1, 0, 0) == v:
                while c + n < 8 and self._is_even(of, there, n, v):
                    n += 1
            if n:
                kept = self._run(of, there, c, n, v)
                pixels = (1 << kept) - 1 if v else int(kept < n) << kept
                c_next = min(kept + 1, n)
            else:
                pixels, c_next = self._pixel(of, there, c), 1
            self.plane.rows[y] |= pixels << x
            c += c_next

    def _is_even(self, of, there, n, v):
        spans = ([(of, 1, -1, 2), (of, 2, -1, 1), (there, -1, -1, 1), (there, 0, -2, 2), (there, 1, -1, 1)]
                 if self.references else [(of, 1, -2, 3), (of, 2, -1, 2)])
        return all(row(k, n + a, n + b) == v * ((1 << b - a + 1) - 1) for row, k, a, b in spans)

    def _run(self, of, there, c, n, v):
        u = int(self.uniform[v] and (c == 0 or of(0, -c, -1) == v * ((1 << c) - 1)))
        end = n - 1

        def other(row, k, a, b):
            return b - a + 1, row(k, end + a, end + b) ^ v * ((1 << b - a + 1) - 1)
        place = (3, n - 1), (1, u), (3, self.r)
        if self.references:
            inputs = (joined(*place, other(of, 1, 2, 4), other(there, 0, 2, 4), other(there, 1, 1, 3)),
                      joined(other(of, 2, 1, 3), other(there, -1, 1, 3), other(there, 1, 1, 3),
                             other(there, 0, 2, 4), (1, v)))
        else:
            inputs = (joined(*place, other(of, 1, 2, 5), other(of, 2, 2, 5), (1, v)),
                      joined(other(of, 3, 0, 4), other(of, 2, 2, 5), other(of, 1, 3, 4), (1, u)))
        if not self.runs.take(self.bits, self.run_net.output(inputs), n - 1, n - 1 | u << 3):
            return n
        i = 0
        while i < n - 1 and not self.breaks[v, n, i].take(self.bits):
            i += 1
        return i

    def _pixel(self, of, there, c):
        def some(row, k, a, b):
            return b - a + 1, row(k, a, b)
        left, e = some(of, 0, -1, -1), (1, int(any(self.uniform)))
        near = joined(some(of, 0, -4, -1), some(of, 1, -3, 4), some(of, 2, -1, 2))
        fine = of(0, -2, -1) | of(1, -1, 1) << 2
        if self.references:
            coarse = fine | there(0, -1, 1) << 5
            inputs = (near, joined(left, some(there, -1, -1, 1), some(there, 0, -3, 3), some(there, 1, -2, 2)),
                      joined(some(of, 0, -2, -1), some(of, 1, -2, 2), some(there, -1, -2, 2), some(there, 0, -1, 2)),
                      joined(left, some(of, 1, 0, 0), some(there, -2, -1, 1), some(there, 2, -1, 1),
                             some(there, 0, 2, 4), some(of, 1, 2, 4), some(of, 2, 0, 0), e))
        else:
            coarse = fine | of(0, -3, -3) << 5 | of(1, 2, 2) << 6 | of(2, 0, 0) << 7
            right = self.plane.class_at(self.tile[0] + 1, self.tile[1])
            inputs = (near, joined(left, some(of, 1, 0, 1), some(of, 2, -4, 4), some(of, 3, -1, 2)),
                      joined((3, c), (3, self.r), (2, right), left, some(of, 1, 0, 1), some(of, 1, 5, 8), e))
        return self.pixels.take(self.bits, self.pixel_net.output(inputs), fine, coarse)


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
