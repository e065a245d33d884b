"""The conventions of protocol/WIRE.md: little-endian fields without gaps, texts, lists, and what is malformed."""
import math
import struct


class Malformed(Exception):
    """Bytes of which nothing may be acted on."""


def require(condition, what):
    if not condition:
        raise Malformed(what)


class Reader:
    """Takes fields from the front of `data`."""

    def __init__(self, data):
        self.data = memoryview(bytes(data))

    def bytes(self, count):
        require(count <= len(self.data), f"{count} bytes wanted, {len(self.data)} left")
        taken, self.data = self.data[:count], self.data[count:]
        return taken.tobytes()

    def rest(self):
        return self.bytes(len(self.data))

    def _number(self, code):
        return struct.unpack("<" + code, self.bytes(struct.calcsize("<" + code)))[0]

    def u8(self):
        return self._number("B")

    def u16(self):
        return self._number("H")

    def u32(self):
        return self._number("I")

    def u64(self):
        return self._number("Q")

    def f32(self):
        value = self._number("f")
        require(math.isfinite(value), "a number that is not finite")
        return value

    def not_negative(self):
        value = self.f32()
        require(value >= 0, f"{value} is negative")
        return value

    def vec3(self):
        return tuple(self.f32() for _ in range(3))

    def quat(self):
        return tuple(self.f32() for _ in range(4))

    def text(self, most):
        length = self.u16()
        require(length <= most, f"a text of {length} bytes, {most} at most")
        try:
            text = self.bytes(length).decode("utf-8")
        except UnicodeDecodeError as error:
            raise Malformed(str(error)) from error
        require(not any(ord(c) < 0x20 or 0x7F <= ord(c) <= 0x9F for c in text), "a control character in a text")
        return text

    def list(self, most, item):
        """`item`: reads one."""
        count = self.u16()
        require(count <= most, f"a list of {count}, {most} at most")
        return [item() for _ in range(count)]


def unit_length(vector, what):
    require(abs(math.sqrt(sum(v * v for v in vector)) - 1) <= 0.001, what + " is not of length 1")
    return vector


def text(value):
    encoded = value.encode("utf-8")
    return struct.pack("<H", len(encoded)) + encoded


def list_of(items, item):
    """`item`: writes one."""
    return struct.pack("<H", len(items)) + b"".join(item(i) for i in items)


def u8(value):
    return struct.pack("<B", value)
