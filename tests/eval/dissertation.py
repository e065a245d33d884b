"""What the dissertation measured, as far as it prints numbers: RTX 2080 in client and server, i7-7700K, 1920x1080. The
values of its Figures 10, 12 and 15 are in plots alone; what its text says of them stands in `SAYS`."""

SCENES = {"living_room": "Pink Room", "temple": "Sun Temple"}  # ours, made after what it says of its own

CARD, SIZE = "RTX 2080", "1920x1080"

FPS = {("living_room", "0"): 154, ("living_room", "64x36"): 148, ("living_room", "128x72"): 142,
       ("temple", "0"): 133, ("temple", "64x36"): 127, ("temple", "128x72"): 125}
VBPS = {("living_room", "0"): 154, ("living_room", "64x36"): 148, ("living_room", "128x72"): 142,
        ("temple", "0"): 80, ("temple", "64x36"): 77, ("temple", "128x72"): 74}
VBPS_OF_TWO = {("living_room", "0"): 213, ("living_room", "64x36"): 204, ("living_room", "128x72"): 196,
               ("temple", "0"): 80, ("temple", "64x36"): 77, ("temple", "128x72"): 74}

SAYS = {
    "errors": "The error grows with x, nearly in a straight line. A larger buffer lowers it by roughly a constant amount, most "
              "noticeable at low x, where 128x72 almost halves it; with 640x360 more yet goes (4.1.2).",
    "auto": "Switches between sequential and not by a weighted sum of camera changes and latency, three thresholds and a dwell "
            "time (3.5); an x set at run time is future work (5.3). No figures.",
    "videos": "VMAF falls with x, with anomalies at high x (4.1.4). VMAF is shown here only where ffmpeg has it.",
    "rates": "Client and server in Figures 13 and 14: the table has both where the size is theirs. In Pink Room the server keeps up with the client, in "
             "Sun Temple it does not.",
    "response": "Each frame predicted ahead takes about one frame's time off the response time, at every network latency; larger "
                "buffers begin higher and converge (4.3.2).",
    "clients": "With two clients Pink Room's buffers per second grow, Sun Temple's stay: there the server was the limit already "
               "(4.4).",
    "sharing": "Wished for in 5.3: the server loads a scene once for all of its clients.",
    "remote": "Left open, and asked by its reviewers: how hybrid rendering compares with sending finished pictures.",
    "pictures": "Figure 6: what prediction gets wrong.",
}
