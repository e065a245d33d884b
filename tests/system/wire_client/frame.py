"""A frame, put together from slices in any order."""
import parity
from datagrams import FrameSlice
from fields import Malformed, require
from mask_codecs import decode


class Frame:
    """`words[plane][tile]`: 64 bits, None where nothing has come. Each light has one plane, or several where its points
    are counted."""

    def __init__(self, number, size, planes, kept=None):
        """`planes`: as messages.planes_of() gives them, or the number of lights that have one each. `kept`: words of frames
        that slices may refer to, by number; others add to it and take from it."""
        self.planes = [(light, 1) for light in range(planes)] if isinstance(planes, int) else planes
        first, samples = self.planes[-1]
        self.number, self.kept = number, kept
        self.width, self.height = size
        self.tiles_x, self.tiles_y = (self.width + 7) // 8, (self.height + 7) // 8
        self.words = [[None] * (self.tiles_x * self.tiles_y) for _ in range(first + samples.bit_length())]
        self.slice_count = self.moment = None
        self.slices = {}  # bodies, by number
        self.parity = {}  # shards by index, by group
        self.groups = None
        self.codecs = set()
        self.server_us = self.gpu_us = 0

    def complete(self):
        return self.slice_count is not None and len(self.slices) == self.slice_count

    def bit(self, plane, x, y):
        return self.words[plane][y // 8 * self.tiles_x + x // 8] >> (8 * (y % 8) + x % 8) & 1

    def seen(self, light, x, y):
        """How many of the light's points the pixel sees."""
        first, samples = self.planes[light]
        if self.bit(first, x, y):
            return samples
        number = 0
        for plane in range(first + 1, first + samples.bit_length()):
            number = 2 * number + self.bit(plane, x, y)
        return number

    def add_slice(self, body):
        """Whether it was new."""
        slice_ = FrameSlice.read(body)
        require(slice_.frame == self.number, "a slice of another frame")
        require(self.slice_count in (None, slice_.slice_count), "a slice of another count")
        require(self.moment in (None, slice_.moment), "a slice of another moment")
        require(slice_.first_tile + slice_.tile_count <= self.tiles_x * self.tiles_y, "tiles beyond the frame")
        require(slice_.first_light + slice_.light_count <= len(self.words), "lights beyond the frame")
        if slice_.slice in self.slices:
            require(self.slices[slice_.slice] == body, "a slice that came again, but not the same")
            return False
        self._put(slice_, decode(slice_, self.tiles_x, self.tiles_y, self.kept))
        self.slices[slice_.slice] = body
        self.slice_count, self.moment = slice_.slice_count, slice_.moment
        self.server_us, self.gpu_us = slice_.server_us, slice_.gpu_us
        self.codecs.add(slice_.codec)
        if self.complete():
            require(all(None not in light for light in self.words), "a whole frame without some tile")
        return True

    def _put(self, slice_, tiles):
        end = slice_.first_tile + slice_.tile_count
        places = self.words[slice_.first_light:slice_.first_light + slice_.light_count]
        require(not any(word is not None for light in places for word in light[slice_.first_tile:end]),
                "a tile that came in two slices")
        for light, words in zip(places, tiles):
            light[slice_.first_tile:end] = words

    def add_parity(self, shard):
        require(self.slice_count in (None, shard.slice_count), "parity of another count of slices")
        require(self.groups in (None, shard.groups), "parity of another count of groups")
        shard.members()
        self.slice_count, self.groups = shard.slice_count, shard.groups
        self.parity.setdefault(shard.group, {})[shard.index] = shard

    def rebuild(self):
        """Adds what parity makes known; how many slices that were."""
        return sum(self._rebuild_group(shards) for shards in self.parity.values())

    def _rebuild_group(self, shards):
        one = next(iter(shards.values()))
        members, length = one.members(), len(one.shard)
        have = {j: parity.shard_of(self.slices[s], length) for j, s in enumerate(members) if s in self.slices}
        if len(have) == len(members):
            return 0
        require(all(len(shard) == length for shard in have.values()), "shards of several lengths")
        codes = {index: shard.shard for index, shard in shards.items() if len(shard.shard) == length}
        added = 0
        for j, shard in parity.rebuild(len(members), have, codes).items():
            body = parity.body_of(shard)
            if body is None or FrameSlice.read(body).slice != members[j]:
                raise Malformed("parity that rebuilds no slice")
            added += self.add_slice(body)
        return added
