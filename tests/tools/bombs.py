"""Scene files of a few kilobytes that are meant to cost whoever reads them memory or time.

    bombs.py FOLDER      # writes them, and prints each one's size

make(FOLDER) does the same for tests; the values of BOMBS say what each is meant to do.
"""
import json
import pathlib
import struct
import sys
import zlib

TRIANGLE = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
CORNER_UVS = struct.pack("<6f", 0, 0, 1, 0, 0, 1)
FLOAT, UNSIGNED = 5126, 5125


class Gltf:
    """A scene under one lamp: its parts are added, then bytes() is the .glb."""

    def __init__(self):
        self.binary = b""
        self.root = {
            "asset": {"version": "2.0"},
            "extensionsUsed": ["KHR_lights_punctual"],
            "extensions": {"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 10}]}},
            "nodes": [{"translation": [0, 0, 2], "extensions": {"KHR_lights_punctual": {"light": 0}}}],
            "bufferViews": [], "accessors": [], "meshes": [], "scene": 0,
        }

    def view(self, data):
        self.root["bufferViews"].append({"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(data)})
        self.binary += data + b"\0" * (-len(data) % 4)
        return len(self.root["bufferViews"]) - 1

    def accessor(self, kind, count, data=None, component=FLOAT, **more):
        accessor = {"componentType": component, "count": count, "type": kind, **more}
        if data is not None:
            accessor["bufferView"] = self.view(data)
        self.root["accessors"].append(accessor)
        return len(self.root["accessors"]) - 1

    def mesh(self, *primitives):
        self.root["meshes"].append({"primitives": list(primitives)})
        return len(self.root["meshes"]) - 1

    def place(self, mesh, times=1):
        self.root["nodes"] += [{"mesh": mesh}] * times

    def texture(self, image, mime, materials=1, **material):
        self.root["images"] = [{"bufferView": self.view(image), "mimeType": mime}]
        self.root["textures"] = [{"source": 0}]
        self.root["materials"] = [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, **material} for _ in range(materials)]

    def textured_triangle(self, materials=1, primitives=1):
        at = {"POSITION": self.accessor("VEC3", 3, TRIANGLE), "TEXCOORD_0": self.accessor("VEC2", 3, CORNER_UVS)}
        return self.mesh(*({"attributes": at, "material": i % materials} for i in range(primitives)))

    def bytes(self):
        self.root["scenes"] = [{"nodes": list(range(len(self.root["nodes"])))}]
        if self.binary:
            self.root["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.root, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if self.binary:
            chunks += struct.pack("<II", len(self.binary), 0x004E4942) + self.binary
        return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def segment(marker, body):
    return struct.pack(">BBH", 0xFF, marker, 2 + len(body)) + body


def jpeg(side, refinements=None):
    """A grey JPEG of which nothing but headers is there; progressive with so many empty refinements."""
    frame = struct.pack(">BHHB", 8, side, side, 1) + bytes([1, 0x11, 0])
    out = b"\xff\xd8" + segment(0xDB, bytes(1) + bytes([1] * 64))
    out += segment(0xC0 if refinements is None else 0xC2, frame)
    for kind in (0x00, 0x10):
        out += segment(0xC4, bytes([kind, 1] + [0] * 15 + [0]))
    if refinements is None:
        out += segment(0xDA, bytes([1, 1, 0, 0, 63, 0])) + bytes(8)
    else:
        out += segment(0xDA, bytes([1, 1, 0, 0, 0, 0x01]))
        out += segment(0xDA, bytes([1, 1, 0, 0, 0, 0x10])) * refinements
    return out + b"\xff\xd9"


def png(side):
    """Grey and alpha, all zero."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    packer = zlib.compressobj(9)
    rows = b"".join(packer.compress(bytes(1 + 2 * side)) for _ in range(side)) + packer.flush()
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, 8, 4, 0, 0, 0)) +
            chunk(b"IDAT", rows) + chunk(b"IEND", b""))


def huge_image():
    gltf = Gltf()
    gltf.texture(jpeg(16384), "image/jpeg", alphaMode="MASK")  # what colours alone need is not decoded
    gltf.place(gltf.textured_triangle())
    return gltf.bytes()


def many_scans():
    gltf = Gltf()
    gltf.texture(jpeg(8192, refinements=2000), "image/jpeg", alphaMode="MASK")
    gltf.place(gltf.textured_triangle())
    return gltf.bytes()


def alternating_alpha():
    gltf = Gltf()
    gltf.texture(png(4096), "image/png", materials=2, alphaMode="MASK")
    gltf.place(gltf.textured_triangle(materials=2, primitives=2), times=2000)
    return gltf.bytes()


def sparse_zeros():
    gltf = Gltf()
    indices, values = gltf.view(struct.pack("<I", 1)), gltf.view(struct.pack("<3f", 1, 2, 3))
    position = gltf.accessor("VEC3", 1 << 20, sparse={
        "count": 1, "indices": {"bufferView": indices, "componentType": UNSIGNED}, "values": {"bufferView": values}})
    gltf.place(gltf.mesh(*({"attributes": {"POSITION": position}} for _ in range(95))))
    return gltf.bytes()


def many_triangles():
    """31.5 million triangles, within every limit of the loader."""
    gltf = Gltf()
    corners = b"".join(struct.pack("<3f", i * 37 % 1000 / 100, i * 91 % 1000 / 100, i * 13 % 1000 / 100)
                       for i in range(1 << 18))
    gltf.place(gltf.mesh({"attributes": {"POSITION": gltf.accessor("VEC3", 1 << 18, corners)}}), times=360)
    return gltf.bytes()


def heavy_vertices():
    """A mesh of many vertices and one triangle, placed a million times: work that no count of triangles shows."""
    gltf = Gltf()
    corners = b"".join(struct.pack("<3f", i % 7, i % 11, i % 13) for i in range(1 << 16))
    at = gltf.accessor("VEC3", 1 << 16, corners)
    indices = gltf.accessor("SCALAR", 3, struct.pack("<3I", 0, 1, 2), UNSIGNED)
    gltf.place(gltf.mesh({"attributes": {"POSITION": at}, "indices": indices}), times=200_000)
    return gltf.bytes()


BOMBS = {
    "huge_image": (huge_image, "1 KB that claims an image of 16384x16384"),
    "many_scans": (many_scans, "a JPEG with 2,000 scans"),
    "alternating_alpha": (alternating_alpha, "two alpha tests in turn over one large image"),
    "sparse_zeros": (sparse_zeros, "100 million vertices without bytes"),
    "many_triangles": (many_triangles, "31.5 million triangles, within every limit"),
    "heavy_vertices": (heavy_vertices, "13 billion vertices to look at, 200,000 triangles"),
}


def make(folder):
    """Writes every bomb into the folder; their file names."""
    for name, (build, _) in BOMBS.items():
        (pathlib.Path(folder) / f"{name}.glb").write_bytes(build())
    return [f"{name}.glb" for name in BOMBS]


if __name__ == "__main__":
    for file in make(sys.argv[1]):
        print(f"{(pathlib.Path(sys.argv[1]) / file).stat().st_size:>9} {file}: {BOMBS[file[:-4]][1]}")
