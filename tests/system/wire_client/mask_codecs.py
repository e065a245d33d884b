"""Payloads of slices: tiles as 64-bit words, `decode(...)[light][tile]`, counted from the slice's first ones."""
import struct

import lz4.block

from context_codec import tiles_context
from fields import Reader, require

MOST_PLAIN_BYTES = 65536
LIT = (1 << 64) - 1
RING = (0x00, 0x01, 0x03, 0x07, 0x0F, 0x1F, 0x3F, 0x7F, 0xFF, 0xFE, 0xFC, 0xF8, 0xF0, 0xE0, 0xC0, 0x80)
RAW32, TILES, CONTEXT = 0, 1, 3


def plain_bytes(payload):
    require(payload, "an empty payload")
    form, rest = payload[0], payload[1:]
    require(form <= 1, f"a payload of form {form}")
    if form == 1:
        try:
            return lz4.block.decompress(rest, uncompressed_size=MOST_PLAIN_BYTES)
        except lz4.block.LZ4BlockError as error:
            require(False, str(error))
    require(len(rest) <= MOST_PLAIN_BYTES, "too many plain bytes")
    return rest


def word(rows):
    return int.from_bytes(bytes(rows), "little")


def transposed(tile):
    return sum((tile >> (8 * r + c) & 1) << (8 * c + r) for r in range(8) for c in range(8))


def line(reader):
    start, steps = reader.u8(), reader.u8()
    number, step = start & 15, -1 if start >> 4 & 1 else 1
    rows = [RING[number]]
    for i in range(7):
        number = (number + step * (steps >> i & 1)) % 16
        rows.append(RING[number])
    return transposed(word(rows)) if start >> 5 & 1 else word(rows)


def rows(reader):
    differs, rows_, row = reader.u8(), [], 0
    for r in range(8):
        row = reader.u8() if differs >> r & 1 else row
        rows_.append(row)
    return word(rows_)


TILE = (lambda _: 0, lambda _: LIT, line, rows)  # by class


def tiles_lz4(slice_):
    reader = Reader(plain_bytes(slice_.payload))
    planes = [reader.bytes((slice_.tile_count + 3) // 4) for _ in range(slice_.light_count)]
    lights = [[TILE[plane[t // 4] >> 2 * (t % 4) & 3](reader) for t in range(slice_.tile_count)] for plane in planes]
    require(not reader.rest(), "more plain bytes than tiles need")
    return lights


def raw32_lz4(slice_):
    plain = plain_bytes(slice_.payload)
    words = (slice_.light_count + 31) // 32
    require(len(plain) == 256 * slice_.tile_count * words, "not as many plain bytes as tiles need")
    pixels = struct.unpack(f"<{len(plain) // 4}I", plain)

    def tile(light, number):
        first = 64 * words * number + light // 32
        return sum((pixels[first + words * p] >> light % 32 & 1) << p for p in range(64))
    return [[tile(light, t) for t in range(slice_.tile_count)] for light in range(slice_.light_count)]


def decode(slice_, tiles_x=0, tiles_y=0, kept=None):
    """Of a frame of tiles_x by tiles_y. `kept`: words of frames that may be referred to, by number."""
    require(slice_.codec in (RAW32, TILES, CONTEXT), f"codec {slice_.codec}")
    if slice_.codec == CONTEXT:
        return tiles_context(slice_, tiles_x, tiles_y, kept or {})
    return (raw32_lz4 if slice_.codec == RAW32 else tiles_lz4)(slice_)
