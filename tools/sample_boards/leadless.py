"""Sample parts without leads: chips, QFN, BGA, crystals, inductors, cans on a base."""

from sample_boards.shape import Shape
from sample_boards.shapes import bar, block, circle, prism, rectangle, rotated, shifted, turned


def chip(size: tuple[float, float, float], terminal: float, standoff: float, package: str) -> Shape:
    """Make a chip of length, width and height, with a cap of length ``terminal`` at each end."""
    length, width, height = size
    centre = (length - terminal) / 2
    caps = tuple(block((terminal, width), 0.0, height, (x, 0.0)) for x in (-centre, centre))
    body = block((length - 2 * terminal, width - 0.04), standoff, height - 0.02)
    return Shape(package, 2, standoff, (("body", (body,)), ("terminals", caps)))


def light(size: tuple[float, float, float], package: str) -> Shape:
    """Make a chip light-emitting diode: a flat base with a narrower lens on it."""
    length, width, height = size
    pads = tuple(block((0.5, width), 0.0, 0.3, (x, 0.0)) for x in (0.25 - length / 2, length / 2 - 0.25))
    base = block((length - 1.0, width), 0.04, 0.4)
    lens = block((length * 0.6, width), 0.4, height)
    return Shape(package, 2, 0.04, (("base", (base,)), ("lens", (lens,)), ("terminals", pads)))


def quad_flat(side: float, pins: int, pitch: float, exposed: float, package: str) -> Shape:
    """Make a QFN: the body stands on the solder of its lands and of the exposed pad."""
    standoff, length, width = 0.06, 0.4, round(pitch / 2, 3)
    count = pins // 4
    offsets = [(k - (count - 1) / 2) * pitch for k in range(count)]
    inset = side / 2 - length / 2
    lands = [block((length, width), 0.0, standoff, (-inset, -y)) for y in offsets]
    lands += [block((width, length), 0.0, standoff, (x, -inset)) for x in offsets]
    lands += [block((length, width), 0.0, standoff, (inset, y)) for y in offsets]
    lands += [block((width, length), 0.0, standoff, (-x, inset)) for x in offsets]
    pad = block((exposed, exposed), 0.0, standoff)
    body = block((side, side), standoff, 0.9)
    return Shape(package, pins, standoff, (("body", (body,)), ("lands", tuple(lands)), ("exposed-pad", (pad,))))


def ball_grid(side: float, rows: int, pitch: float, package: str) -> Shape:
    """Make a BGA with a full square grid of balls, coarse barrels of six sides."""
    gap, radius = 0.36, 0.25
    offsets = [(k - (rows - 1) / 2) * pitch for k in range(rows)]
    barrel = [(0.16, 0.0), (radius, gap / 2), (0.16, gap)]
    balls = tuple(turned(barrel, 6, (x, -y)) for y in offsets for x in offsets)
    carrier = block((side, side), gap, gap + 0.34)
    cap = block((side - 1.0, side - 1.0), gap + 0.34, 1.4)
    solids = (("carrier", (carrier,)), ("cap", (cap,)), ("balls", balls))
    return Shape(package, rows * rows, gap, solids)


def can(diameter: float, height: float, package: str) -> Shape:
    """Make a surface-mount aluminium electrolytic: a round can on a square base with two corners cut off."""
    a = diameter / 2 + 0.15
    cut = 0.3 * a
    ring = [(-a, -a), (a - cut, -a), (a, cut - a), (a, a - cut), (a - cut, a), (-a, a)]
    base = prism(ring, 0.1, 1.0)
    profile = [(diameter / 2, 1.0), (diameter / 2, 1.6), (diameter / 2 - 0.3, 1.9), (diameter / 2, 2.2)]
    body = turned([*profile, (diameter / 2, height)], 20)
    reach = a - 0.25 * diameter + 0.5
    centre = a + 0.5 - reach / 2
    tabs = tuple(block((reach, 0.8), 0.0, 0.1, (x, 0.0)) for x in (-centre, centre))
    return Shape(package, 2, 0.1, (("base", (base,)), ("can", (body,)), ("terminals", tabs)))


def inductor(side: float, height: float, package: str) -> Shape:
    """Make a shielded power inductor: a square ferrite with cut corners over two flat terminals."""
    body = prism(rectangle((side, side), corner=side / 6), 0.15, height - 0.1)
    tabs = tuple(block((side / 4, side * 0.6), 0.0, 0.15, (x, 0.0)) for x in (-side * 0.36, side * 0.36))
    core = prism(circle(side / 3, 16), height - 0.1, height)
    return Shape(package, 2, 0.15, (("body", (body,)), ("core", (core,)), ("terminals", tabs)))


def crystal(length: float, width: float, package: str) -> Shape:
    """Make a ceramic crystal with a metal lid and four lands."""
    lands = tuple(
        block((0.9, 0.8), 0.0, 0.06, (x, y))
        for x, y in (
            (0.45 - length / 2, 0.4 - width / 2),
            (length / 2 - 0.45, 0.4 - width / 2),
            (length / 2 - 0.45, width / 2 - 0.4),
            (0.45 - length / 2, width / 2 - 0.4),
        )
    )
    base = block((length, width), 0.06, 0.55)
    lid = block((length - 0.4, width - 0.4), 0.55, 0.8)
    return Shape(package, 4, 0.06, (("base", (base,)), ("lid", (lid,)), ("lands", lands)))


def melf(length: float, diameter: float, package: str) -> Shape:
    """Make a MELF diode: a glass cylinder, here with twelve sides, between two metal caps."""
    radius, cap = diameter / 2, 0.4
    centre = (length - cap) / 2
    glass = rotated(bar(circle(radius - 0.04, 12, (0.0, radius)), length - 2 * cap), 90.0)
    metal = rotated(bar(circle(radius, 12, (0.0, radius)), cap), 90.0)
    caps = (shifted(metal, -centre, 0.0), shifted(metal, centre, 0.0))
    return Shape(package, 2, 0.04, (("body", (glass,)), ("terminals", caps)))
