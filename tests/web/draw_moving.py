"""A copy of the built-in living room in which things move: furniture turns, jumps and mirrors itself, a lamp swings."""
import json
import math
import pathlib
import struct


def read(file):
    data = pathlib.Path(file).read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), bytearray(data[28 + length:])


def write(file, root, binary):
    root["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    with open(file, "wb") as out:
        out.write(struct.pack("<III", 0x46546c67, 2, 28 + len(text) + len(binary)))
        out.write(struct.pack("<II", len(text), 0x4e4f534a) + text)
        out.write(struct.pack("<II", len(binary), 0x004e4942) + binary)


def about_y(angle):
    return [0, math.sin(angle / 2), 0, math.cos(angle / 2)]


def to_parts(node):
    """A matrix that turns about the vertical, moves and scales, as the three parts that animations need."""
    m = node.pop("matrix", None)
    if m:
        size = math.hypot(m[0], m[1], m[2])
        node.update(translation=m[12:15], rotation=about_y(math.atan2(-m[2], m[0])), scale=[size] * 3)
    return node


class Moving:
    def __init__(self, source):
        self.root, self.binary = read(source)
        self.animation = {"channels": [], "samplers": []}
        self.root.setdefault("animations", []).append(self.animation)

    def nodes(self, name, kind="mesh"):
        is_light = kind == "light"
        return [i for i, node in enumerate(self.root["nodes"])
                if node.get("name") == name and ("extensions" in node) == is_light]

    def numbers(self, kind, values):
        self.binary += b"\0" * (-len(self.binary) % 4)
        flat = [x for value in values for x in (value if isinstance(value, list) else [value])]
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": 4 * len(flat)})
        self.binary += struct.pack(f"<{len(flat)}f", *flat)
        accessor = {"bufferView": len(self.root["bufferViews"]) - 1, "componentType": 5126, "count": len(values),
                    "type": kind}
        if kind == "SCALAR":
            accessor.update(min=[min(values)], max=[max(values)])
        self.root["accessors"].append(accessor)
        return len(self.root["accessors"]) - 1

    def animate(self, node, path, interpolation, times, values):
        to_parts(self.root["nodes"][node])
        kind = "VEC4" if path == "rotation" else "VEC3"
        self.animation["samplers"].append({"input": self.numbers("SCALAR", times), "interpolation": interpolation,
                                           "output": self.numbers(kind, values)})
        self.animation["channels"].append({"sampler": len(self.animation["samplers"]) - 1,
                                           "target": {"node": node, "path": path}})


def moving_copy(source, target):
    made = Moving(source)
    for number, chair in enumerate(made.nodes("dining chair")):
        made.animate(chair, "rotation", "LINEAR", [0, 1, 2.5, 4], [about_y(a + number) for a in (0, 1.2, 2.9, 4.4)])
    for screen in made.nodes("lattice screen"):
        at = to_parts(made.root["nodes"][screen])["translation"]
        high = [at[0] - 0.3, at[1] + 0.4, at[2]]
        made.animate(screen, "translation", "CUBICSPLINE", [0, 2, 4],
                     [[0, 0, 0], at, [0, 0.5, 0], [0.2, 0, 0], high, [0, 0, -0.3], [0, 0, 0], at, [0, 0, 0]])
    for vase in made.nodes("vase") + made.nodes("sofa"):
        made.animate(vase, "scale", "STEP", [0, 1, 2], [[1, 1, 1], [-1, 1.2, 1], [1, 0.8, 1]])
    for lamp in made.nodes("pendant", "light"):
        x, y, z = made.root["nodes"][lamp]["translation"]
        made.animate(lamp, "translation", "LINEAR", [0, 2, 4], [[x, y, z], [x - 1, y, z + 0.5], [x, y, z]])
    for sun in made.nodes("low sun", "light"):
        q = made.root["nodes"][sun]["rotation"]
        turned = [q[0] + 0.02, q[1] - 0.03, q[2], q[3]]
        made.animate(sun, "rotation", "LINEAR", [0, 2, 4], [q, [x / math.hypot(*turned) for x in turned], q])
    write(target, made.root, made.binary)
