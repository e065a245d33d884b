"""Bodies of datagrams, once opened."""
import struct
from dataclasses import dataclass
from enum import IntEnum

from fields import Reader, require
from messages import are_samples


class Kind(IntEnum):
    CAMERA_UPDATE = 1
    FRAME_SLICE = 2
    FEEDBACK = 3
    FRAME_PARITY = 4
    PROBE = 5
    PING = 6
    PONG = 7
    PATH_CHALLENGE = 8
    PATH_RESPONSE = 9


PING = bytes(1164)
TOKEN_BYTES = 8
MOST_ACKNOWLEDGEMENTS = 16
MOST_AGES = 512
AGE_UNIT_US = 32
HAS_MOMENT, PADDED, HAS_SIZE, HAS_SAMPLES = 1, 2, 4, 8  # flags of a slice


def newer(a, b):
    """Whether frame number a was counted after b."""
    return 1 <= (a - b) % (1 << 32) < 1 << 31


def camera_update(frame, camera, client_time_us, deadline_us, acknowledgements, have=0):
    """`acknowledgements`: of (frame, first slice, bits). `have`: the newest frame that may be referred to; 0: none."""
    body = struct.pack("<I", frame) + camera.bytes()
    body += struct.pack("<QIB", client_time_us, deadline_us, len(acknowledgements))
    body += b"".join(struct.pack("<IHQ", *a) for a in acknowledgements)
    return body + (struct.pack("<I", have) if have else b"")


def feedback(time_us, first, recovered, incomplete, ages):
    return struct.pack(f"<QQIIH{len(ages)}H", time_us, first, recovered, incomplete, len(ages), *ages)


def age(arrival_us, time_us):
    """In a Feedback's units; `arrival_us` None: it has not arrived."""
    if arrival_us is None:
        return 0
    return min(1 + max(0, time_us - arrival_us) // AGE_UNIT_US, 65535)


@dataclass
class FrameSlice:
    frame: int
    slice: int
    slice_count: int
    first_tile: int
    tile_count: int
    first_light: int
    light_count: int
    codec: int
    server_us: int
    gpu_us: int
    moment: tuple  # scene_time_us, lights_version
    size: tuple  # None: the granted one
    samples: int  # None: the granted ones
    payload: bytes

    @staticmethod
    def read(body):
        reader = Reader(body)
        fields = (reader.u32(), reader.u16(), reader.u16(), reader.u32(), reader.u32(), reader.u16(), reader.u16(),
                  reader.u8())
        flags, padding = reader.u8(), reader.u16()
        server_us, gpu_us = reader.u32(), reader.u32()
        moment = (reader.u32(), reader.u32()) if flags & HAS_MOMENT else (0, 0)
        size = (reader.u16(), reader.u16()) if flags & HAS_SIZE else None
        samples = reader.u8() if flags & HAS_SAMPLES else None
        require(samples is None or are_samples(samples), f"{samples} samples")
        payload = reader.rest()
        if flags & PADDED:
            require(padding <= len(payload), "more padding than there are bytes")
            payload = payload[:len(payload) - padding]
        slice_ = FrameSlice(*fields, server_us, gpu_us, moment, size, samples, payload)
        require(slice_.slice < slice_.slice_count, "a slice beyond the frame's count")
        require(slice_.tile_count and slice_.light_count, "a slice of nothing")
        return slice_


@dataclass
class FrameParity:
    frame: int
    slice_count: int
    groups: int
    group: int
    index: int
    shard: bytes

    @staticmethod
    def read(body):
        reader = Reader(body)
        fields = reader.u32(), reader.u16(), reader.u16(), reader.u16(), reader.u8()
        reader.u8()
        parity = FrameParity(*fields, reader.rest())
        require(parity.groups and parity.group < parity.groups and parity.group < parity.slice_count, "no such group")
        require(parity.index < 64 and len(parity.shard) >= 3, "no such shard")
        return parity

    def members(self):
        """The group's slices."""
        members = range(self.group, self.slice_count, self.groups)
        require(len(members) <= 128, "a group of more than 128 slices")
        return members
