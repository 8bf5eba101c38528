"""Sample parts with leads: small-outline and quad flat packages, transistors, moulded diodes."""

from dataclasses import dataclass

from sample_boards.shape import Shape
from sample_boards.shapes import bar, block, rotated, shifted

from geometry.arrays import Triangles


@dataclass(frozen=True, slots=True)
class GullWing:
    """Sizes of a body with gull-wing leads, mm."""

    body: tuple[float, float]
    """Plan size of the body."""
    span: float
    """Lead tip to lead tip along x."""
    height: float
    standoff: float
    pitch: float
    lead: tuple[float, float, float]
    """Width and thickness of a lead, and the length of its foot."""


def dual(sizes: GullWing, pins: int, package: str) -> Shape:
    """Leads along the left and the right side; pin 1 is the upper left one."""
    rows = _row(sizes, pins // 2, turns=2), _row(sizes, pins // 2, turns=0)
    return Shape(package, pins, sizes.standoff, (("body", (_moulded(sizes),)), ("leads", rows[0] + rows[1])))


def quad(sizes: GullWing, pins: int, package: str) -> Shape:
    """Leads along all four sides of a square body; pin 1 is the upper one of the left side."""
    leads = tuple(lead for turns in (2, 3, 0, 1) for lead in _row(sizes, pins // 4, turns))
    return Shape(package, pins, sizes.standoff, (("body", (_moulded(sizes),)), ("leads", leads)))


def sot(sizes: GullWing, left: tuple[float, ...], right: tuple[tuple[float, float], ...], package: str) -> Shape:
    """Make a small transistor: leads at given y on the left, leads of given (y, width) on the right."""
    leads = [rotated(_lead(sizes, -y, sizes.lead[0]), 180.0) for y in left]
    leads += [_lead(sizes, y, width) for y, width in right]
    solids = (("body", (_moulded(sizes),)), ("leads", tuple(leads)))
    return Shape(package, len(left) + len(right), sizes.standoff, solids)


def folded(body: tuple[float, float, float], terminal: tuple[float, float], package: str) -> Shape:
    """Make a moulded two-terminal part (diode, tantalum) whose terminals are folded under its ends.

    Args:
        body: Length, width and height.
        terminal: Width and the length under the body.
        package: Name of the package.
    """
    length, width, height = body
    thickness = 0.12
    end, middle = length / 2, height / 2
    inside = end - thickness
    profile = [
        (inside - terminal[1], 0.0),
        (end, 0.0),
        (end, middle),
        (inside, middle),
        (inside, thickness),
        (inside - terminal[1], thickness),
    ]
    fold = bar(profile, terminal[0])
    solids = (("body", (block((2 * inside, width), thickness, height),)), ("terminals", (fold, rotated(fold, 180.0))))
    return Shape(package, 2, thickness, solids)


def _moulded(sizes: GullWing) -> Triangles:
    return block(sizes.body, sizes.standoff, sizes.height)


def _row(sizes: GullWing, count: int, turns: int) -> tuple[Triangles, ...]:
    """One side's leads, from the first pin of that side on when walking counter-clockwise."""
    first = -(count - 1) / 2 * sizes.pitch
    leads = (_lead(sizes, first + k * sizes.pitch, sizes.lead[0]) for k in range(count))
    return tuple(rotated(lead, 90.0 * turns) for lead in leads)


def _lead(sizes: GullWing, y: float, width: float) -> Triangles:
    """Bend a lead of the right-hand side: out of the body at half its height, down, and a foot on the board."""
    _, thickness, foot = sizes.lead
    tip, root = sizes.span / 2, sizes.body[0] / 2
    out = (sizes.standoff + sizes.height) / 2
    heel = tip - foot
    knee = heel - 0.3 * (heel - thickness - root)
    profile = [
        (root, out),
        (knee - thickness, out),
        (heel - thickness, 0.0),
        (tip, 0.0),
        (tip, thickness),
        (heel, thickness),
        (knee, out + thickness),
        (root, out + thickness),
    ]
    return shifted(bar(profile, width), 0.0, y)
