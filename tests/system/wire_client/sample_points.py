"""The points that soft shadows and ambient occlusion count, after protocol/WIRE.md alone."""
import math
import struct

POINT, SPHERE, DISC, RECTANGLE = range(4)
DIRECTIONS = ((1, 1, 1, 1, 1, 1, 1, 1), (1, 3, 5, 15, 17, 51, 85, 255), (1, 3, 3, 9, 29, 23, 71, 197))


def pattern(x, y):
    def order(i, j):
        return 2 * (i ^ j) + j
    return 4 * order(x // 2 % 2, y // 2 % 2) + order(x % 2, y % 2)


def coordinates(point, samples):
    for directions in DIRECTIONS:
        number = 0
        for i in range(8):
            if point >> i & 1:
                number ^= directions[i] << 7 - i
        yield number / 256 + 0.5 / (16 * samples)


def ball_angle(share):
    low, high = 0.0, math.pi / 2
    for _ in range(60):
        middle = 0.5 * (low + high)
        if middle - math.sin(middle) * math.cos(middle) < share * math.pi / 2:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def offset(area, point, samples):
    """From the light's position, as three binary32."""
    a, b, c = coordinates(point, samples)
    turn = 2 * math.pi * b
    if area.shape == RECTANGLE:
        along_u, along_v = 2 * a - 1, 2 * b - 1
    elif area.shape == DISC:
        along_u, along_v = math.sqrt(a) * math.cos(turn), math.sqrt(a) * math.sin(turn)
    elif area.shape == SPHERE:
        z = 1 - 2 * a
        across = math.sqrt(1 - z * z)
        length = math.sqrt(sum(x * x for x in area.u)) * math.sin(ball_angle(c))
        return rounded(length * across * math.cos(turn), length * across * math.sin(turn), length * z)
    else:
        along_u = along_v = 0
    return rounded(*(along_u * u + along_v * v for u, v in zip(area.u, area.v)))


def rounded(*numbers):
    return struct.unpack("<3f", struct.pack("<3f", *numbers))


def offsets(area, x, y, samples):
    """Of the points that pixel (x, y) looks at."""
    first = pattern(x, y) * samples
    return [offset(area, first + i, samples) for i in range(samples)]


def around_surface(x, y, segments):
    """Where on the sphere that touches the surface the segments of pixel (x, y) end: unit vectors."""
    first = pattern(x, y) * segments
    for point in range(first, first + segments):
        a, b, _ = coordinates(point, segments)
        z, turn = 1 - 2 * a, 2 * math.pi * b
        across = math.sqrt(1 - z * z)
        yield rounded(across * math.cos(turn), across * math.sin(turn), z)
