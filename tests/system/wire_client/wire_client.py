#!/usr/bin/python3
"""Asks a Gnomon daemon for frames and says what came. A second implementation of the client's side of the wire, written
from protocol/WIRE.md alone; it shades nothing. Needs Debian's python3-openssl, python3-cryptography and python3-lz4."""
import argparse
import hashlib
import json
import math
import pathlib
import sys
from dataclasses import replace

from control import Closed, NotTheServer
from fields import Malformed
from mask_codecs import CONTEXT, LIT, RAW32, TILES
from messages import FEEDBACK, MOMENTS, PARITY, REFERENCES, SIZES, Hello
from seal import AES_128_GCM, CHACHA20_POLY1305
from session import RefusedBy, Session

CODECS = {"raw32": RAW32, "tiles": TILES, "context": CONTEXT}
CIPHERS = {"aes": AES_128_GCM, "chacha": CHACHA20_POLY1305}
FEATURES = {"moments": MOMENTS, "feedback": FEEDBACK, "parity": PARITY, "references": REFERENCES, "sizes": SIZES}
STEP_RADIANS = 0.05


def turned(camera, angle):
    """About the vertical axis of the world."""
    s, c = math.sin(angle / 2), math.cos(angle / 2)
    x, y, z, w = camera.orientation
    return replace(camera, orientation=(c * x + s * z, c * y + s * w, c * z - s * x, c * w - s * y))


def digest(frame):
    """Of all masks: what two clients compare."""
    return hashlib.sha256(b"".join(word.to_bytes(8, "little") for light in frame.words for word in light)).hexdigest()


def mask_image(frame, light):
    """PBM, white where the light comes."""
    rows = bytearray()
    for y in range(frame.height):
        row = (frame.words[light][y // 8 * frame.tiles_x + t] >> 8 * (y % 8) & 255 for t in range(frame.tiles_x))
        rows += bytes(int(f"{byte:08b}"[::-1], 2) ^ 255 for byte in row)  # PBM: 1 is black, the leftmost pixel on top
    return b"P4\n%d %d\n" % (frame.width, frame.height) + bytes(rows)


def summary(frame):
    tiles = [word for light in frame.words for word in light]
    return {"frame": frame.number, "slices": frame.slice_count, "codecs": sorted(frame.codecs),
            "server_us": frame.server_us, "gpu_us": frame.gpu_us, "tiles": len(tiles), "lit": tiles.count(LIT),
            "dark": tiles.count(0), "sha256": digest(frame)}


def parsed(arguments):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--server", required=True, metavar="HOST:PORT")
    parser.add_argument("--pin", required=True, metavar="sha256:HEX|FILE", help="the server's certificate")
    parser.add_argument("--tenant", default="")
    parser.add_argument("--token-file", type=pathlib.Path)
    parser.add_argument("--certificate", type=pathlib.Path, help="the client's own, PEM")
    parser.add_argument("--key", type=pathlib.Path)
    parser.add_argument("--fleet", metavar="NAME", help="where the server is the door of this fleet")
    parser.add_argument("--scene", required=True)
    parser.add_argument("--size", default="320x180", metavar="WxH")
    parser.add_argument("--frames", type=int, default=1)
    parser.add_argument("--codec", choices=CODECS, default="tiles")
    parser.add_argument("--cipher", choices=CIPHERS, default="aes")
    parser.add_argument("--features", nargs="*", choices=FEATURES, default=[])
    parser.add_argument("--out", type=pathlib.Path, metavar="DIR", help="masks, as PBM pictures")
    return parser.parse_args(arguments)


def hello_for(options):
    width, height = map(int, options.size.split("x"))
    token = options.token_file.read_text().strip() if options.token_file else ""
    return Hello(scene=options.scene, width=width, height=height, tenant=options.tenant, token=token,
                 codecs=(CODECS[options.codec],), ciphers=(CIPHERS[options.cipher],),
                 features=sum(FEATURES[name] for name in options.features))


def fly(session, options):
    camera = session.welcome.scene.default_camera
    for number in range(options.frames):
        frame = session.picture(turned(camera, STEP_RADIANS * number))
        print(json.dumps(summary(frame)))
        if options.out:
            options.out.mkdir(parents=True, exist_ok=True)
            for light in range(len(frame.words)):
                (options.out / f"{number}-{light}.pbm").write_bytes(mask_image(frame, light))


def main(arguments):
    options = parsed(arguments)
    pin = options.pin if options.pin.startswith("sha256:") else pathlib.Path(options.pin).read_text().split("\n")[0]
    host, _, port = options.server.rpartition(":")
    try:
        with Session(host.strip("[]"), int(port), pin.strip(), hello_for(options), options.certificate,
                     options.key, fleet=options.fleet) as session:
            fly(session, options)
            print(json.dumps({"session": session.welcome.session, "news": list(map(str, session.news)),
                              **session.counts}))
    except RefusedBy as error:
        print(error, file=sys.stderr)
        return int(error.refused.code) + 100
    except (Closed, Malformed, NotTheServer, OSError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
