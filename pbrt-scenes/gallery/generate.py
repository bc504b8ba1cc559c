#!/usr/bin/env python3
"""Write the geometry that the gallery's scenes include: python3 generate.py

Most files in geometry/ are one shape or one list of copies, without a material. The z axis points up, except in the
dahlias, the house, the paper, the mill and the smoke, where y points up. arbor.pbrt and screw.pbrt are written by hand.
"""

import math
import random
import struct
import zlib
from pathlib import Path

FOLDER = Path(__file__).parent / "geometry"


def number(x):
    """A coordinate with at most three decimals, and without a trailing zero."""
    text = f"{x:.3f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def wrapped(numbers, per_line):
    """Numbers as text, a fixed count on each line."""
    return "\n".join("    " + " ".join(numbers[i : i + per_line]) for i in range(0, len(numbers), per_line))


def write(name, comment, body):
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{name}.pbrt").write_text(f"# {comment} Written by generate.py.\n{body}\n")


def mesh(shape, points, faces):
    """A mesh directive. Seen from outside, the corners of each face run clockwise."""
    coordinates = [number(x) for point in points for x in point]
    indices = [str(i) for face in faces for i in face]
    return f'Shape {shape}\n  "integer indices" [\n{wrapped(indices, 24)}\n  ]\n  "point P" [\n{wrapped(coordinates, 12)}\n  ]'


def turned(profile, segments=10):
    """A surface of revolution: a profile of (radius, height) from the axis at the bottom, along the outside, to the axis."""
    points, rows = [], []
    for radius, height in profile:
        start = len(points)
        if radius == 0:
            points.append((0, 0, height))
            rows.append([start] * segments)
        else:
            turns = [2 * math.pi * i / segments for i in range(segments)]
            points += [(radius * math.cos(a), radius * math.sin(a), height) for a in turns]
            rows.append([start + i for i in range(segments)])
    faces = []
    for low, high in zip(rows, rows[1:]):
        for i in range(segments):
            j = (i + 1) % segments
            a, b, c, d = low[i], low[j], high[j], high[i]
            faces += [face for face in ((a, c, b), (a, d, c)) if len(set(face)) == 3]
    return points, faces


def lathe(name, comment, profile, segments=10, levels=4):
    write(name, comment, mesh(f'"loopsubdiv" "integer nlevels" [{levels}]', *turned(profile, segments)))


def chess():
    foot = [(0, 0), (0.36, 0), (0.38, 0.0), (0.38, 0.07), (0.36, 0.13), (0.31, 0.16), (0.31, 0.19), (0.26, 0.24)]
    pawn = foot + [(0.17, 0.36), (0.12, 0.58), (0.11, 0.64), (0.2, 0.66), (0.2, 0.69), (0.1, 0.72)]
    pawn += [(0.14, 0.76), (0.2, 0.86), (0.17, 0.98), (0.08, 1.04), (0, 1.05)]
    lathe("pawn", "A pawn.", pawn)
    tall = foot + [(0.2, 0.4), (0.14, 0.7), (0.12, 1.0), (0.13, 1.06)]
    collar = [(0.23, 1.08), (0.23, 1.11), (0.15, 1.13), (0.15, 1.16), (0.2, 1.18), (0.2, 1.2), (0.13, 1.22)]
    bishop = tall + collar + [(0.14, 1.26), (0.2, 1.36), (0.16, 1.5), (0.06, 1.62), (0.04, 1.64)]
    lathe("bishop", "A bishop.", bishop + [(0.07, 1.67), (0.07, 1.71), (0, 1.74)])
    queen = tall + collar + [(0.13, 1.28), (0.19, 1.5), (0.24, 1.58), (0.24, 1.6), (0.19, 1.6), (0.16, 1.57)]
    lathe("queen", "A queen.", queen + [(0.1, 1.62), (0.05, 1.65), (0.07, 1.69), (0.06, 1.74), (0, 1.75)])
    king = tall + collar + [(0.14, 1.28), (0.2, 1.52), (0.22, 1.58), (0.22, 1.6), (0.17, 1.64), (0.06, 1.7)]
    lathe("king", "A king without his cross.", king + [(0.04, 1.74), (0, 1.75)])
    rook = [(0, 0), (0.36, 0), (0.38, 0), (0.38, 0.07), (0.36, 0.13), (0.31, 0.16), (0.31, 0.19), (0.26, 0.26)]
    rook += [(0.2, 0.4), (0.17, 0.7), (0.18, 0.74), (0.27, 0.78), (0.28, 0.8), (0.28, 1.0), (0.27, 1.01)]
    lathe("rook", "A rook.", rook + [(0.21, 1.01), (0.2, 0.99), (0.2, 0.88), (0.18, 0.86), (0, 0.86)])


def glasses():
    """Vessels with an outer and an inner wall, and what fills them, a little smaller than the inner wall."""
    bowl = [(0.05, 1.1), (0.22, 1.17), (0.5, 1.38), (0.62, 1.75), (0.6, 2.1), (0.5, 2.55), (0.45, 2.8)]
    foot = [(0, 0), (0.5, 0), (0.56, 0.0), (0.56, 0.03), (0.3, 0.07), (0.08, 0.14), (0.05, 0.3), (0.045, 0.8)]
    inner = [(r - 0.03, z) for r, z in reversed(bowl[2:])] + [(0.2, 1.22), (0, 1.2)]
    rim = [(0.445, 2.82), (0.425, 2.82)]
    lathe("wine-glass", "A wine glass.", foot + bowl + rim + inner, 12)
    wine = [
        (0, 1.21),
        (0.19, 1.235),
        (0.45, 1.4),
        (0.575, 1.72),
        (0.575, 1.76),
        (0.565, 1.765),
        (0.3, 1.765),
        (0, 1.765),
    ]
    lathe("wine", "The wine in the glass.", wine, 12)
    body = [
        (0, 0),
        (0.6, 0),
        (0.68, 0.02),
        (0.74, 0.12),
        (0.78, 0.5),
        (0.76, 1.0),
        (0.6, 1.5),
        (0.3, 1.85),
        (0.22, 2.1),
    ]
    neck = [(0.21, 2.6), (0.3, 2.95), (0.31, 2.97), (0.29, 2.98)]
    inside = [
        (0.17, 2.6),
        (0.18, 2.1),
        (0.26, 1.83),
        (0.55, 1.47),
        (0.71, 0.99),
        (0.73, 0.5),
        (0.7, 0.17),
        (0.6, 0.1),
        (0, 0.1),
    ]
    lathe("carafe", "A carafe.", body + neck + inside, 12)
    fill = [
        (0, 0.11),
        (0.59, 0.115),
        (0.68, 0.19),
        (0.715, 0.5),
        (0.7, 0.94),
        (0.685, 1.0),
        (0.66, 1.01),
        (0.3, 1.01),
        (0, 1.01),
    ]
    lathe("carafe-filling", "What is in the carafe.", fill, 12)
    out = [(0, 0), (0.5, 0), (0.56, 0.01), (0.58, 0.06), (0.62, 0.5), (0.66, 1.1), (0.662, 1.13), (0.64, 1.14)]
    lathe("tumbler", "A tumbler.", out + [(0.62, 1.1), (0.57, 0.5), (0.52, 0.26), (0.46, 0.22), (0, 0.2)], 12)


def box(low, high):
    points = [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return points, [face for a, b, c, d in quads for face in ((a, c, b), (a, d, c))]


def cross():
    parts = [box((-0.03, -0.03, -0.1), (0.03, 0.03, 0.14)), box((-0.09, -0.028, 0.02), (0.09, 0.028, 0.075))]
    write("cross", "The cross of a king.", "\n".join(mesh('"trianglemesh"', *part) for part in parts))


def lamps():
    """Lamps far behind the chess board."""
    rng = random.Random(5)
    colors = [(1, 0.55, 0.2), (1, 0.7, 0.36), (1, 0.42, 0.14), (0.5, 0.62, 1)]
    text = 'Material "matte" "rgb Kd" [0 0 0]'
    for i in range(18):
        y = rng.uniform(14, 26)
        x, z = (i / 17 - 0.5) * 0.62 * y + rng.uniform(-0.6, 0.6), 0.3 + rng.uniform(0.0, 0.17) * y
        brightness = rng.uniform(0.7, 1.7)
        color = " ".join(number(brightness * c) for c in rng.choice(colors))
        place = " ".join(map(number, (x, y, z)))
        text += f'\nAttributeBegin AreaLightSource "diffuse" "rgb L" [{color}] Translate {place}'
        text += ' Shape "sphere" "float radius" [0.3] AttributeEnd'
    write("lamps", "Lamps out of focus.", text)


def extruded(outline, low, high):
    """Walls of an outline in x and y that is followed anticlockwise, from z = low to z = high."""
    count = len(outline)
    points = [(x, y, low) for x, y in outline] + [(x, y, high) for x, y in outline]
    faces = []
    for i in range(count):
        j = (i + 1) % count
        faces += [(i, j, j + count), (i, j + count, i + count)]
    return points, faces


def filled(strips, low, high):
    """Both faces of a plate, from pairs of points of its two long edges."""
    points = [(x, y, z) for z in (low, high) for pair in strips for x, y in pair]
    count, faces = len(strips) * 2, []
    for i in range(0, count - 2, 2):
        faces += [(i, i + 2, i + 1), (i + 1, i + 2, i + 3)]
        faces += [(count + i, count + i + 1, count + i + 2), (count + i + 1, count + i + 3, count + i + 2)]
    return points, faces


def house():
    """Parts of the architect's model: a unit box, ten steps and an arch, with y up."""
    write("box", "A cube from 0 to 1.", mesh('"trianglemesh"', *box((0, 0, 0), (1, 1, 1))))
    steps = [box((i / 10, i / 10, 0), (1, (i + 1) / 10, 1)) for i in range(10)]
    write(
        "stairs",
        "Ten steps up along x, in a cube from 0 to 1.",
        "\n".join(mesh('"trianglemesh"', *step) for step in steps),
    )
    turns = [math.pi * i / 24 for i in range(25)]
    bow = [(0.36 * math.cos(a), 1 + 0.36 * math.sin(a)) for a in turns]
    inside = [(0.36, 0)] + bow + [(-0.36, 0)]
    top = [(0.5 - i / 22, 1.55) for i in range(23)]
    outside = [(0.5, 0), (0.5, 1), *top, (-0.5, 1), (-0.5, 0)]
    parts = [filled(list(zip(inside, outside)), 0, 0.3), extruded(inside[::-1], 0, 0.3)]
    parts.append(extruded([(0.5, 0), (0.5, 1.55), (-0.5, 1.55), (-0.5, 0)], 0, 0.3))
    write(
        "arch", "An arch, 1 wide, 1.55 high and 0.3 deep.", "\n".join(mesh('"trianglemesh"', *part) for part in parts)
    )


def petal():
    widths = [0.07, 0.2, 0.3, 0.33, 0.27, 0.14, 0.02]
    points, faces = [], []
    for i, width in enumerate(widths):
        along = i / (len(widths) - 1)
        for across in (-1, -0.6, 0, 0.6, 1):
            lift = width * 0.75 * across**2 + 0.16 * along**2
            points.append((along, lift, width * across))
    for i in range(len(widths) - 1):
        for j in range(4):
            a = 5 * i + j
            faces += [(a, a + 1, a + 6), (a, a + 6, a + 5)]
    write("petal", "A petal along x.", mesh('"loopsubdiv" "integer nlevels" [2]', points, faces))


def dahlia(count=210):
    """Petals in the golden angle, upright in the middle and flat at the rim."""
    rng = random.Random(1)
    rows = []
    for n in range(count):
        t = (n / count) ** 0.5
        turn = number(n * 137.508 % 360)
        tilt = number(88 - 92 * t**1.5 + rng.uniform(-4, 4))
        size = number((0.26 + 0.74 * t) * rng.uniform(0.94, 1.05))
        out, up = number(0.04 + 0.36 * t), number(0.42 - 0.5 * t**2.2)
        rows.append(
            f"AttributeBegin Rotate {turn} 0 1 0 Translate {out} {up} 0 Rotate {tilt} 0 0 1 Scale {size} {size} {size}"
            ' Include "geometry/petal.pbrt" AttributeEnd'
        )
    write("dahlia", f"A dahlia of {count} petals.", "\n".join(rows))


def field(spacing=0.85, depth=52):
    """Dahlias in bands of color that run away from the camera, where it sees them."""
    rng = random.Random(3)
    rows = []
    for k in range(int(depth / spacing)):
        z = k * spacing
        half = 3 + 0.5 * z
        for i in range(-int(half / spacing), int(half / spacing) + 1):
            color = ("coral", "cream", "plum")[(i + 60) // 3 % 3]
            x = i * spacing + rng.uniform(-0.2, 0.2)
            place = " ".join(map(number, (x, rng.uniform(-0.16, 0.16), z + rng.uniform(-0.2, 0.2))))
            turn, tilt, size = rng.uniform(0, 360), rng.uniform(-34, -4), rng.uniform(0.38, 0.5)
            rows.append(
                f"AttributeBegin Translate {place} Rotate {tilt:.0f} 1 0 0 Rotate {turn:.0f} 0 1 0"
                f' Scale {size:.2f} {size:.2f} {size:.2f} ObjectInstance "{color}" AttributeEnd'
            )
    write("field", f"{len(rows)} dahlias.", "\n".join(rows))


def knot(rounds=64, sides=8):
    """A trefoil knot: a tube whose section is an ellipse that turns as it goes."""
    points, faces = [], []

    def center(t):
        return (math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t))

    for i in range(rounds):
        t = 2 * math.pi * i / rounds
        before, here, after = center(t - 0.01), center(t), center(t + 0.01)
        along = [b - a for a, b in zip(before, after)]
        length = math.hypot(*along)
        along = [x / length for x in along]
        bend = [a + b - 2 * h for a, b, h in zip(before, after, here)]
        inward = sum(b * a for a, b in zip(along, bend))
        side = [b - inward * a for a, b in zip(along, bend)]
        length = math.hypot(*side)
        side = [x / length for x in side]
        up = [
            along[1] * side[2] - along[2] * side[1],
            along[2] * side[0] - along[0] * side[2],
            along[0] * side[1] - along[1] * side[0],
        ]
        for j in range(sides):
            a = 2 * math.pi * j / sides
            x, y = 0.36 * math.cos(a), 0.72 * math.sin(a)
            points.append(tuple(h + x * s + y * u for h, s, u in zip(here, side, up)))
    for i in range(rounds):
        for j in range(sides):
            a, b = i * sides + j, i * sides + (j + 1) % sides
            c, d = (b + sides) % len(points), (a + sides) % len(points)
            faces += [(a, c, b), (a, d, c)]
    write("knot", "A trefoil knot.", mesh('"loopsubdiv" "integer nlevels" [4]', points, faces))


def half_exr(path, width, height, pixel):
    """An OpenEXR file of 16-bit floats, ZIP-compressed. pixel(x, y) is linear red, green and blue."""

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(name + b"\0" + struct.pack("<iiii", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<iiii", 0, 0, width - 1, height - 1)
    header = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", channels)
    header += attribute("compression", "compression", b"\3") + attribute("dataWindow", "box2i", window)
    header += attribute("displayWindow", "box2i", window) + attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    blocks = []
    for top in range(0, height, 16):
        data = b""
        for y in range(top, min(top + 16, height)):
            row = [pixel(x, y) for x in range(width)]
            data += b"".join(struct.pack(f"<{width}e", *(color[c] for color in row)) for c in (2, 1, 0))
        split = data[::2] + data[1::2]
        differences = bytes([split[0]]) + bytes((b - a + 128) & 255 for a, b in zip(split, split[1:]))
        packed = zlib.compress(differences, 9)
        blocks.append(struct.pack("<ii", top, len(packed)) + packed)
    offset = len(header) + 8 * len(blocks)
    offsets = b""
    for block in blocks:
        offsets += struct.pack("<Q", offset)
        offset += len(block)
    path.write_bytes(header + offsets + b"".join(blocks))


def noise(x, y, z, seed=0):
    """Smooth noise from 0 to 1 with a period of 1."""
    cell = [math.floor(c) for c in (x, y, z)]
    part = [c - f for c, f in zip((x, y, z), cell)]
    part = [p * p * (3 - 2 * p) for p in part]
    total = 0
    for corner in range(8):
        offsets = [corner >> k & 1 for k in range(3)]
        weight = math.prod(p if o else 1 - p for p, o in zip(part, offsets))
        key = sum((c + o) * m for c, o, m in zip(cell, offsets, (73856093, 19349663, 83492791))) ^ seed * 2654435761
        key = (key ^ key >> 13) * 1274126177 & 0xFFFFFFFF
        total += weight * ((key ^ key >> 16) & 0xFFFF) / 0xFFFF
    return total


def sky(width=512, height=256):
    """Dusk: the sun low at +x, high clouds that it lights from below. Rows go from +z, the zenith, down."""

    def blend(a, b, t):
        return [p + (q - p) * t for p, q in zip(a, b)]

    def pixel(x, y):
        theta, phi = math.pi * (y + 0.5) / height, 2 * math.pi * (x + 0.5) / width
        d = (math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta))
        up = max(d[2], 0.0)
        toward = 0.5 + 0.5 * d[0] / max(math.hypot(d[0], d[1]), 1e-6)
        horizon = blend((0.55, 0.4, 0.5), (1.0, 0.5, 0.2), toward**2.2)
        middle = blend((0.26, 0.3, 0.5), (0.5, 0.42, 0.45), toward**2)
        color = blend(horizon, middle, min(up / 0.22, 1) ** 0.7)
        color = blend(color, (0.07, 0.14, 0.34), min(max(up - 0.12, 0) / 0.75, 1) ** 0.7)
        if d[2] > 0.02:
            px, py = d[0] / (d[2] + 0.12), d[1] / (d[2] + 0.12)
            cloud = sum(noise(px * 0.9 * 2**k, py * 2.4 * 2**k, 3.7 + k, k) * 0.5**k for k in range(5)) / 1.94
            cloud = min(max((cloud - 0.5) / 0.22, 0), 1) * min((d[2] - 0.02) / 0.1, 1)
            lit = blend((0.3, 0.24, 0.36), (1.5, 0.62, 0.34), toward**2)
            color = blend(color, lit, 0.75 * cloud)
        sun = d[0] * math.cos(0.12) + d[2] * math.sin(0.12)
        color = [c + g * math.exp((sun - 1) * 60) for c, g in zip(color, (1.4, 0.7, 0.25))]
        color = [c + g * min(max((sun - 0.9935) / 0.003, 0), 1) for c, g in zip(color, (42, 24, 10.5))]
        return color if d[2] > -0.05 else [c * 0.3 for c in color]

    half_exr(FOLDER / "dusk.exr", width, height, pixel)


def fruit():
    pear = [(0, 0.06), (0.12, 0.02), (0.34, 0.02), (0.6, 0.2), (0.7, 0.5), (0.62, 0.82), (0.4, 1.12), (0.27, 1.38)]
    lathe("pear", "A pear.", pear + [(0.22, 1.56), (0.14, 1.66), (0.05, 1.64), (0, 1.62)])
    apple = [(0, 0.14), (0.1, 0.07), (0.26, 0.0), (0.48, 0.12), (0.66, 0.42), (0.7, 0.75), (0.58, 1.06), (0.34, 1.22)]
    lathe("apple", "An apple.", apple + [(0.16, 1.18), (0.06, 1.05), (0, 1.0)])
    body = [(0, 0), (0.6, 0), (0.66, 0), (0.7, 0.06), (0.95, 0.5), (1.08, 1.0), (0.98, 1.5), (0.66, 1.95), (0.46, 2.25)]
    neck = [(0.44, 2.6), (0.58, 2.95), (0.61, 2.98), (0.57, 3.0)]
    lathe("jug", "A jug.", body + neck + [(0.4, 2.6), (0.4, 2.2), (0.55, 1.9), (0.8, 1.4), (0.6, 0.4), (0, 0.3)], 12)
    points = [(0.02, 0, 1.0), (0.03, 0, 1.25), (0.08, 0.02, 1.42), (0.17, 0.05, 1.5)]
    spine = " ".join(number(x) for point in points for x in point)
    write(
        "stalk",
        "The stalk of an apple.",
        f'Shape "curve" "string type" "cylinder" "point P" [{spine}] "float width0" [0.05] "float width1" [0.09]',
    )


def rings():
    rng = random.Random(8)
    rows, radius, shade = [], 1.36, 0.3
    while radius < 2.75:
        width = rng.uniform(0.008, 0.045)
        target = 0.18 if radius < 1.6 else 0.72 if radius < 2.2 else 0.5
        shade = min(max(0.6 * shade + 0.4 * target + rng.uniform(-0.13, 0.13), 0.06), 0.85)
        if not 2.2 < radius < 2.31:
            color = " ".join(number(shade * c) for c in (1, 0.87, 0.7))
            rows.append(f'Material "matte" "rgb Kd" [{color}]')
            rows.append(
                f'Shape "disk" "float radius" [{number(radius + width)}] "float innerradius" [{number(radius)}]'
            )
        radius = round(radius + width, 3)
    write("rings", "The rings of the planet, inside to outside.", "\n".join(rows))
    rows = []
    for _ in range(520):
        x, y, size = rng.uniform(-34, 30), rng.uniform(-20, 20), 0.012 + 0.05 * rng.random() ** 4
        rows.append(
            f'AttributeBegin Translate {x:.2f} {y:.2f} 60 Scale {size:.3f} {size:.3f} {size:.3f} ObjectInstance "star" AttributeEnd'
        )
    write("stars", "Stars.", "\n".join(rows))


def paper():
    """Sheets of paper cut to ridges, the farthest first, each with a material that the scene names."""
    text = []
    for layer in range(7):
        rng = random.Random(layer * 7 + 2)
        rough, base = 0.9 - 0.07 * layer, 1.8 - 0.68 * layer
        heights = [0.0] * 129
        heights[0], heights[128] = rng.uniform(-0.6, 0.6), rng.uniform(-0.6, 0.6)
        step, swing = 128, 1.25
        while step > 1:
            for i in range(step // 2, 128, step):
                heights[i] = (heights[i - step // 2] + heights[i + step // 2]) / 2 + rng.uniform(-1, 1) * swing * rough
            step, swing = step // 2, swing * 0.47
        top = [(-9 + 18 * i / 128, base + h) for i, h in enumerate(heights)]
        if layer >= 5:
            firs = []
            for x, y in top:
                if firs and x <= firs[-1][0]:
                    continue
                firs.append((x, y))
                if rng.random() < (0.3 if layer == 5 else 0.42):
                    tall, wide = rng.uniform(0.3, 0.62) * (layer - 3.6), 0.045 * (layer - 3.6)
                    side = [(0.1, 0.0), (0.45, 0.42), (0.5, 0.33), (0.75, 0.72), (0.8, 0.64), (1.0, 1.0)]
                    firs += [(x + wide * along, y + tall * up) for along, up in side]
                    firs += [(x + wide * (2 - along), y + tall * up) for along, up in side[-2::-1]]
            top = firs
        strips = [((x, -6), (x, y)) for x, y in top]
        points, faces = filled(strips, 0, 0.04)
        z = number(3.6 - 0.6 * layer)
        text.append(f'AttributeBegin Translate 0 0 {z} NamedMaterial "sheet {layer}"')
        text.append(mesh('"trianglemesh"', points, faces) + " AttributeEnd")
        if layer < 6:
            # A lamp below the crest of the next sheet shines up at this one.
            y, front = number(base - 1.9), float(z) - 0.5
            glow = " ".join(number(strength * (0.9 - 0.08 * layer)) for strength in (3.6, 2.3, 1.7))
            corners = f"-9 {y} {front:.2f}  9 {y} {front:.2f}  9 {y} {front + 0.3:.2f}  -9 {y} {front + 0.3:.2f}"
            text.append(f'AttributeBegin AreaLightSource "diffuse" "rgb L" [{glow}] "bool twosided" "true"')
            text.append(f'Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point P" [{corners}] AttributeEnd')
    write("ridges", "Seven sheets of paper.", "\n".join(text))


def dandelion(seeds=170, hairs=22):
    rng = random.Random(4)
    rows = []

    def curve(points, low, high):
        coordinates = " ".join(number(x) for point in points for x in point)
        return f'Shape "curve" "string type" "cylinder" "point P" [{coordinates}] "float width0" [{low}] "float width1" [{high}]'

    rows.append('Material "matte" "rgb Kd" [0.28 0.2 0.1]')
    rows.append(curve([(0, 0, 0.2), (0, 0, 0.26), (0, 0, 0.3), (0, 0, 0.36)], 0.012, 0.03))
    rows.append('Material "matte" "rgb Kd" [0.8 0.8 0.76]')
    rows.append(curve([(0, 0, 0.36), (0, 0, 0.5), (0, 0, 0.6), (0, 0, 0.72)], 0.012, 0.008))
    for i in range(hairs):
        turn, rise = 2 * math.pi * (i + rng.uniform(-0.3, 0.3)) / hairs, rng.uniform(0.12, 0.3)
        length = rng.uniform(0.26, 0.32)
        x, y = math.cos(turn) * length, math.sin(turn) * length
        rows.append(
            curve(
                [
                    (0, 0, 0.72),
                    (x * 0.3, y * 0.3, 0.73 + rise * 0.2),
                    (x * 0.7, y * 0.7, 0.72 + rise * 0.6),
                    (x, y, 0.72 + rise),
                ],
                0.006,
                0.003,
            )
        )
    write("seed", "A seed of a dandelion along z.", "\n".join(rows))
    rows = []
    for n in range(seeds):
        z = 1 - 1.86 * (n + 0.5) / seeds
        if rng.random() < 0.06:
            continue
        tilt, turn = math.degrees(math.acos(z)), n * 137.508 % 360
        rows.append(
            f'AttributeBegin Rotate {turn:.1f} 0 0 1 Rotate {tilt:.1f} 0 1 0 ObjectInstance "seed" AttributeEnd'
        )
    write("dandelion", f"{len(rows)} seeds.", "\n".join(rows))


def gear(name, teeth, module=0.05, spokes=5, thick=0.06):
    """A wheel with teeth, a rim, a hub and spokes, all one plate from z = 0. The pitch radius is teeth * module / 2."""
    radius = teeth * module / 2
    root, tip = radius - 1.2 * module, radius + module
    edge = []
    for i in range(teeth):
        for part, r in ((0, root), (0.22, root), (0.38, tip), (0.58, tip), (0.74, root)):
            a = 2 * math.pi * (i + part) / teeth
            edge.append((r * math.cos(a), r * math.sin(a)))
    inner = root - 1.6 * module
    rim = [(inner * x / math.hypot(x, y), inner * y / math.hypot(x, y)) for x, y in edge]
    hub = [(0.24 * radius * math.cos(math.pi * i / 24), 0.24 * radius * math.sin(math.pi * i / 24)) for i in range(48)]
    eye = [(x * 0.4, y * 0.4) for x, y in hub]

    def closed(outline):
        return outline + outline[:1]

    parts = [
        filled(list(zip(closed(rim), closed(edge))), 0, thick),
        extruded(edge, 0, thick),
        extruded(rim[::-1], 0, thick),
    ]
    parts += [filled(list(zip(closed(eye), closed(hub))), 0, thick), extruded(hub, 0, thick)]
    for k in range(spokes):
        a = 2 * math.pi * k / spokes
        c, d = math.cos(a), math.sin(a)
        wide, far, near = 0.055 * radius, inner + 0.01, 0.22 * radius
        corners = [(near, -wide), (far, -wide * 0.7), (far, wide * 0.7), (near, wide)]
        bar = [(x * c - y * d, x * d + y * c) for x, y in corners]
        parts += [filled([(bar[0], bar[3]), (bar[1], bar[2])], 0, thick), extruded(bar, 0, thick)]
    write(
        name,
        f"A wheel of {teeth} teeth, pitch radius {number(radius)}.",
        "\n".join(mesh('"trianglemesh"', *part) for part in parts),
    )


def clockwork():
    gear("wheel-60", 60)
    gear("wheel-40", 40)
    gear("wheel-28", 28, spokes=4)
    gear("pinion", 12, spokes=0, thick=0.22)


def mill():
    """A hall with three windows in the far wall, beams, sacks, barrels and a millstone. The y axis points up."""
    window_middles, half, sill, top = [-1.85, 0.05, 1.95], 0.4, 1.45, 3.6
    edges = [-3.3] + [x + side * half for x in window_middles for side in (-1, 1)] + [3.3]
    walls = [((-3.3, 0, -8), (-3, 4.6, 8)), ((3, 0, -8), (3.3, 4.6, 8)), ((-3.3, 0, -8.2), (3.3, 4.6, -8))]
    walls += [((left, 0, 8), (right, 4.6, 8.25)) for left, right in zip(edges[::2], edges[1::2])]
    wood = [((-3.3, 4.5, -8.2), (3.3, 4.6, 8.2)), ((-0.14, 3.8, -8), (0.14, 4.15, 8))]
    wood += [((-3, 4.15, z - 0.11), (3, 4.5, z + 0.11)) for z in (-6.4, -4.1, -1.9, 0.3, 2.5, 4.7, 6.9)]
    wood += [((x - 0.14, 0, z - 0.14), (x + 0.14, 4.2, z + 0.14)) for x, z in ((-1.9, 3.1), (2.2, 1.6))]
    for x in window_middles:
        left, right = x - half, x + half
        walls += [((left, 0, 8), (right, sill, 8.25)), ((left, top, 8), (right, 4.6, 8.25))]
        wood += [((x - 0.025, sill, 8.1), (x + 0.025, top, 8.16))]
        wood += [((left, y - 0.02, 8.1), (right, y + 0.02, 8.16)) for y in (sill + 0.72, sill + 1.44)]
        wood += [((left - 0.06, sill - 0.07, 7.85), (right + 0.06, sill, 8.1))]

    def placed(x, y, z, shapes):
        return f"AttributeBegin\n  Translate {number(x)} {number(y)} {number(z)}\n  {shapes}\nAttributeEnd"

    def boxes(all_boxes):
        return [mesh('"trianglemesh"', *box(low, high)) for low, high in all_boxes]

    parts = ['NamedMaterial "floor"', *boxes([((-3.3, -0.2, -8), (3.3, 0, 8))])]
    parts += ['NamedMaterial "wall"', *boxes(walls), 'NamedMaterial "beam"', *boxes(wood)]
    barrels = [(-2.3, -1.5), (-2.35, 4.6)]
    for x, z in barrels:
        body = '"float radius" 0.36 "float zmin" 0 "float zmax" 0.9'
        lid = 'Shape "disk" "float radius" 0.36 "float height" 0.86'
        parts.append(placed(x, 0, z, f'Rotate -90 1 0 0 Shape "cylinder" {body} {lid}'))
    parts.append('NamedMaterial "iron"')
    for x, z in barrels:
        hoops = " ".join(
            f'Shape "cylinder" "float radius" 0.366 "float zmin" {low} "float zmax" {high}'
            for low, high in ((0.2, 0.25), (0.68, 0.73))
        )
        parts.append(placed(x, 0, z, f"Rotate -90 1 0 0 {hoops}"))
    parts.append('NamedMaterial "sack"')
    for x, z, size, lift in ((-2.45, 1.2, 0.36, 0), (-2.35, 2.1, 0.4, 0), (-1.75, 1.65, 0.34, 0), (-2.3, 1.62, 0.33, 0.52)):
        tip = f'Translate 0 0 {number(0.9 * size)} Shape "cone" "float radius" {number(0.3 * size)} "float height" {number(0.4 * size)}'
        shapes = f'Rotate -90 1 0 0 Scale 1 0.85 0.8 Shape "sphere" "float radius" {size} {tip}'
        parts.append(placed(x, 0.75 * size + lift, z, shapes))
    parts.append('NamedMaterial "stone"')
    stone = 'Shape "cylinder" "float radius" 0.72 "float zmin" 0 "float zmax" 0.22 Shape "disk" "float radius" 0.72 "float innerradius" 0.12'
    parts.append(placed(-2.35, 0.72, 6.6, f"Rotate 60 0 1 0 Rotate -12 1 0 0 {stone}"))
    write("mill", "The hall of a mill.", "\n".join(parts))


def smoke(cells=(30, 60, 30)):
    """Densities of smoke that rises and curls, in a box 2 wide and 4 high, as a medium. The y axis points up."""

    def octaves(x, y, z):
        return sum((2 * noise(x * 2**k, y * 2**k, z * 2**k, k) - 1) / 2**k for k in range(3))

    def density(x, y, z):
        share = y / 4
        # Folds move the middle of the column and widen it with its height.
        middle_x = share * (0.34 * math.sin(2.1 * y + 0.4) + 0.3 * octaves(0.3, 1.1 * y, 0))
        middle_z = share * (0.34 * math.cos(2.1 * y - 0.3) + 0.3 * octaves(9.3, 1.1 * y, 4))
        fold = 0.2 * share**0.7
        u = x + fold * octaves(2 * x, 1.6 * y, 2 * z)
        w = z + fold * octaves(2 * x + 5, 1.6 * y, 2 * z + 3)
        radius = 0.07 + 0.36 * share
        within = max(0, 1 - ((u - middle_x) ** 2 + (w - middle_z) ** 2) / radius**2)
        sheets = 0.12 + 1.5 * max(0, 1 - 3.2 * abs(octaves(2.4 * u, 1.9 * y, 2.4 * w))) ** 2
        thin = 6 * (1 - share) ** 0.8 / (radius / 0.07) ** 0.6
        edge = min(1, 8 * (1 - max(abs(x), abs(z)))) * min(1, 6 * (1 - share))
        return max(0, within * sheets * thin * edge - 0.03)

    nx, ny, nz = cells
    densities = [
        f"{density((i + 0.5) / nx * 2 - 1, (j + 0.5) / ny * 4, (k + 0.5) / nz * 2 - 1):.2f}".strip("0").rstrip(".") or "0"
        for k in range(nz)
        for j in range(ny)
        for i in range(nx)
    ]
    coefficients = '"rgb sigma_a" [0.6 0.7 0.8] "rgb sigma_s" [7 7 7] "float g" [0.25]'
    size = f'"point p0" [-1 0 -1] "point p1" [1 4 1] "integer nx" [{nx}] "integer ny" [{ny}] "integer nz" [{nz}]'
    write(
        "smoke",
        "Smoke that rises and curls.",
        f'MakeNamedMedium "smoke" "string type" "heterogeneous" {coefficients}\n  {size}\n'
        f'  "float density" [\n{wrapped(densities, nx)}\n  ]',
    )


def candle(segments=16):
    """A candle with a bowl around its wick, and wax that has run down its side. The axis is z; the height 1.6, the radius 0.5."""
    side = [(0, 0), (0.46, 0), (0.5, 0.02), (0.5, 0.12), (0.49, 0.5), (0.49, 0.9), (0.485, 1.25), (0.485, 1.5)]
    bowl = [(0.47, 1.58), (0.43, 1.6), (0.39, 1.56), (0.33, 1.42), (0.2, 1.35), (0.07, 1.34), (0, 1.34)]
    points, faces = turned(side + bowl, segments)
    # How far down the wax has run, along some of the segments.
    runs = {1: 0.45, 4: 1.0, 5: 0.75, 9: 1.15, 12: 0.3, 13: 0.85}

    def with_runs(index, x, y, z):
        end = runs.get((index - 1) % segments, 2)
        out = 1.09 if 0.05 < z < 1.6 and math.hypot(x, y) > 0.47 and z > end else 1
        return (x * out, y * out, z)

    points = [with_runs(index, *point) for index, point in enumerate(points)]
    write("candle", "A candle.", mesh('"loopsubdiv" "integer nlevels" [4]', points, faces))


if __name__ == "__main__":
    chess()
    cross()
    glasses()
    lamps()
    house()
    petal()
    dahlia()
    field()
    knot()
    sky()
    fruit()
    rings()
    paper()
    dandelion()
    clockwork()
    mill()
    smoke()
    candle()
