"""Control messages: those of a client are written, those of a server are read."""
import hashlib
import ipaddress
import struct
from dataclasses import dataclass, field
from enum import IntEnum

from fields import Malformed, Reader, list_of, require, text, u8, unit_length

VERSION = 2
LONGEST = 1_048_572
MOST_PIXELS_A_SIDE = 7680

MOMENTS, FEEDBACK, PARITY, _, RESUME, SIZES, PATHS, WAITING, _, FLEET, SOFT, REFERENCES = (
    1 << bit for bit in range(12))


class Type(IntEnum):
    HELLO = 1
    WELCOME = 2
    REFUSED = 3
    SCENE_CHANGED = 4
    LIGHTS_CHANGED = 5
    DEGRADED = 6
    DRAINING = 7
    STATS = 8
    BYE = 9
    RESUME = 11
    WAITING = 12


class Refusal(IntEnum):
    MALFORMED = 1
    VERSION = 2
    UNKNOWN_TENANT = 3
    BAD_TOKEN = 4
    UNKNOWN_SCENE = 5
    SCENE_UNAVAILABLE = 6
    BAD_SIZE = 7
    TOO_MANY_SESSIONS = 8
    OVER_CAPACITY = 9
    UNKNOWN_PASS = 10
    DRAINING = 11
    INTERNAL = 12
    UNKNOWN_SESSION = 13
    KEPT_OUT = 14

    @classmethod
    def _missing_(cls, _):
        return cls.INTERNAL  # a later version's code


def framed(type_, body):
    return struct.pack("<IH", len(body) + 2, type_) + body


@dataclass
class Hello:
    scene: str
    width: int
    height: int
    border_x: int = 0
    border_y: int = 0
    rate_hz: float = 0
    codecs: tuple = (1,)
    ciphers: tuple = (1,)
    features: int = 0
    client: str = "gnomon wire client (python)"
    tenant: str = ""
    token: str = ""
    passes: tuple = ()
    version_min: int = VERSION
    version_max: int = VERSION
    samples: int = 1

    def message(self):
        body = struct.pack("<HHQ", self.version_min, self.version_max, self.features)
        body += text(self.client) + text(self.tenant) + text(self.token)
        body += list_of(self.ciphers, u8) + text(self.scene)
        body += struct.pack("<HHHHf", self.width, self.height, self.border_x, self.border_y, self.rate_hz)
        body += list_of(self.codecs, u8) + list_of(self.passes, text)
        body += u8(self.samples) if self.features & SOFT else b""
        return framed(Type.HELLO, body)


@dataclass
class Resume:
    session: int
    proof: bytes

    def message(self):
        return framed(Type.RESUME, struct.pack("<Q", self.session) + self.proof)


@dataclass
class Camera:
    """A pinhole: where it stands, how it is turned (camera to world), and tangents of its frustum's half-angles."""

    position: tuple
    orientation: tuple
    tan_left: float
    tan_right: float
    tan_up: float
    tan_down: float
    near_plane: float

    @staticmethod
    def read(reader):
        camera = Camera(reader.vec3(), unit_length(reader.quat(), "an orientation"), *(reader.f32() for _ in range(5)))
        require(camera.tan_left + camera.tan_right > 0, "a frustum without width")
        require(camera.tan_up + camera.tan_down > 0, "a frustum without height")
        require(camera.near_plane > 0, "a near plane that is not in front")
        return camera

    def bytes(self):
        return struct.pack("<12f", *self.position, *self.orientation, self.tan_left, self.tan_right, self.tan_up,
                           self.tan_down, self.near_plane)


@dataclass
class Light:
    kind: int
    position: tuple
    direction: tuple
    color: tuple
    intensity: float
    range: float
    inner_cone_cos: float
    outer_cone_cos: float

    @staticmethod
    def read(reader):
        kind = reader.u8()
        require(kind <= 2, f"a light of kind {kind}")
        light = Light(kind, reader.vec3(), reader.vec3(), reader.vec3(), reader.not_negative(), reader.not_negative(),
                      reader.f32(), reader.f32())
        if kind:
            unit_length(light.direction, "a light's direction")
        require(abs(light.inner_cone_cos) <= 1 and abs(light.outer_cone_cos) <= 1, "a cone's cosine")
        return light


@dataclass
class Area:
    shape: int = 0
    u: tuple = (0, 0, 0)
    v: tuple = (0, 0, 0)

    @staticmethod
    def read(reader):
        area = Area(reader.u8(), reader.vec3(), reader.vec3())
        require(area.shape <= 3, f"an area of shape {area.shape}")
        return area


HALF, FULL = 64, 128  # added to the points of a light: ambient occlusion of a quarter of the pixels, of all
OPEN_SEGMENTS = 8


def are_samples(byte):
    return byte & 63 in (1, 4, 16) and byte < 192


def read_samples(reader):
    samples = reader.u8()
    require(are_samples(samples), f"{samples} samples")
    return samples


def read_soft(reader, lights):
    """Samples and areas, of a message that says them of `lights`."""
    samples, areas = read_samples(reader), reader.list(256, lambda: Area.read(reader))
    require(len(areas) == len(lights), "areas of another number of lights")
    return samples, areas


def planes_of(samples, areas, lights):
    """For each light, the number of its first plane and how many of its points are counted; then of ambient occlusion."""
    planes, first = [], 0
    for light in range(lights):
        of_light = samples & 63 if light < len(areas) and areas[light].shape else 1
        planes.append((first, of_light))
        first += of_light.bit_length()
    return planes + [(first, OPEN_SEGMENTS)] * (samples >= HALF)


@dataclass
class Motion:
    node: str
    kind: int
    vector: tuple
    period_us: int

    @staticmethod
    def read(reader):
        motion = Motion(reader.text(256), reader.u8(), reader.vec3(), reader.u32())
        require(motion.kind <= 1, f"a motion of kind {motion.kind}")
        require(motion.period_us, "a motion without a period")
        return motion


@dataclass
class Manifest:
    name: str
    content_hash: bytes
    triangles: int
    bounds_min: tuple
    bounds_max: tuple
    default_camera: Camera
    lights: list

    @staticmethod
    def read(reader):
        return Manifest(reader.text(1024), reader.bytes(16), reader.u64(), reader.vec3(), reader.vec3(),
                        Camera.read(reader), reader.list(256, lambda: Light.read(reader)))


def read_address(reader):
    """IPv4 or IPv6, as text."""
    words = reader.text(256)
    try:
        ipaddress.ip_address(words)
    except ValueError:
        raise Malformed(f"{words} is no address") from None
    return words


def read_size(reader):
    width, height = reader.u16(), reader.u16()
    require(1 <= width <= MOST_PIXELS_A_SIDE and 1 <= height <= MOST_PIXELS_A_SIDE, f"a size of {width}x{height}")
    return width, height


@dataclass
class Welcome:
    version: int
    features: int
    session: int
    data_port: int
    cipher: int
    size: tuple
    rate_hz: float
    codec: int
    passes: list
    tracer: str
    silence_timeout_ms: int
    scene: Manifest
    lights_version: int = 0
    motions: list = field(default_factory=list)
    data_host: str = ""
    home_host: str = ""
    home_port: int = 0
    samples: int = 1
    areas: list = field(default_factory=list)

    @staticmethod
    def read(reader):
        welcome = Welcome(reader.u16(), reader.u64(), reader.u64(), reader.u16(), reader.u8(), read_size(reader),
                          reader.not_negative(), reader.u8(), reader.list(32, lambda: reader.text(256)),
                          reader.text(256), reader.u32(), Manifest.read(reader))
        require(welcome.data_port, "no data port")
        if welcome.features & MOMENTS:
            welcome.lights_version = reader.u32()
            welcome.motions = reader.list(256, lambda: Motion.read(reader))
        if welcome.features & FLEET:
            welcome.data_host, welcome.home_host = read_address(reader), read_address(reader)
            welcome.home_port = reader.u16()
            require(welcome.home_port, "no home port")
        if welcome.features & SOFT:
            welcome.samples, welcome.areas = read_soft(reader, welcome.scene.lights)
        return welcome


@dataclass
class Refused:
    code: Refusal
    text: str
    fit_width: int
    fit_height: int
    fit_rate_hz: float

    @staticmethod
    def read(reader):
        return Refused(Refusal(reader.u16()), reader.text(1024), reader.u16(), reader.u16(), reader.not_negative())


@dataclass
class SceneChanged:
    scene: Manifest
    samples: int = 1
    areas: list = field(default_factory=list)

    @staticmethod
    def read(reader):
        changed = SceneChanged(Manifest.read(reader))
        if reader.data:
            changed.samples, changed.areas = read_soft(reader, changed.scene.lights)
        return changed


@dataclass
class LightsChanged:
    lights: list
    version: int

    @staticmethod
    def read(reader):
        return LightsChanged(reader.list(256, lambda: Light.read(reader)), reader.u32())


@dataclass
class Degraded:
    size: tuple
    rate_hz: float
    reason: str
    untraced: list
    samples: int | None = None

    @staticmethod
    def read(reader):
        degraded = Degraded(read_size(reader), reader.not_negative(), reader.text(1024), reader.list(256, reader.u16))
        if reader.data:
            degraded.samples = read_samples(reader)
        return degraded


@dataclass
class Draining:
    deadline_ms: int | None
    move_now: bool = False

    @staticmethod
    def read(reader):
        deadline_ms = reader.u32()
        flags = reader.u8() if reader.data else 0
        return Draining(None if deadline_ms == 0xFFFFFFFF else deadline_ms, bool(flags & 1))


@dataclass
class Stats:
    frames: int
    coalesced: int
    queue_us: int
    gpu_us: int
    total_us: int

    @staticmethod
    def read(reader):
        return Stats(reader.u64(), reader.u64(), reader.u32(), reader.u32(), reader.u32())


@dataclass
class Bye:
    reason: str = ""
    stay_out_ms: int = 0

    @staticmethod
    def read(reader):
        return Bye(reader.text(1024), reader.u32() if reader.data else 0)

    def message(self):
        return framed(Type.BYE, text(self.reason) + struct.pack("<I", self.stay_out_ms))


@dataclass
class Waiting:
    text: str
    percent: int | None

    @staticmethod
    def read(reader):
        words, percent = reader.text(1024), reader.u8()
        require(percent <= 100 or percent == 255, f"{percent} percent")
        return Waiting(words, None if percent == 255 else percent)


def server_name(scene, fleet):
    """By which the door of a fleet sends those who ask for one scene to one server."""
    return f"s-{hashlib.sha256(scene.encode()).hexdigest()[:16]}.{fleet}"


FROM_SERVER = {Type.WELCOME: Welcome, Type.REFUSED: Refused, Type.SCENE_CHANGED: SceneChanged,
               Type.LIGHTS_CHANGED: LightsChanged, Type.DEGRADED: Degraded, Type.DRAINING: Draining,
               Type.STATS: Stats, Type.BYE: Bye, Type.WAITING: Waiting}


def take_message(buffer):
    """The first message of `buffer`, a bytearray, which loses it: a value, or the number of a type to skip. None: more
    bytes are needed."""
    if len(buffer) < 4:
        return None
    length = struct.unpack_from("<I", buffer)[0]
    require(2 <= length <= LONGEST, f"a message of {length} bytes")
    if len(buffer) < 4 + length:
        return None
    reader = Reader(buffer[4:4 + length])
    del buffer[:4 + length]
    type_ = reader.u16()
    if type_ in FROM_SERVER:
        return FROM_SERVER[type_].read(reader)
    require(type_ not in (Type.HELLO, Type.RESUME), "a server that speaks as a client")
    return type_
