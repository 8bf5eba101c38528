"""Put sample parts on a sample board."""

import math
from dataclasses import dataclass, replace

import numpy as np
from sample_boards.catalogue import shape_of
from sample_boards.fit import check_apart, check_holes, check_inside
from sample_boards.lands import lands_of
from sample_boards.shape import Shape, Solids
from sample_boards.shapes import Ring, circle, flipped, prism, rotated, shifted

from boards.board import Body, Pad, Role, Side, Surface
from geometry.arrays import Triangles

_DRILL_SIDES = 12


@dataclass(frozen=True, slots=True)
class Place:
    """Where one part goes, as seen from the top."""

    name: str
    package: str
    x: float
    y: float
    turn_deg: float = 0.0
    value: str | None = None
    side: Side = "top"


def row(first: Place, count: int, step: tuple[float, float]) -> tuple[Place, ...]:
    """Repeat a part along a line and count its name up: C7, C8, C9."""
    letters = first.name.rstrip("0123456789")
    number = int(first.name[len(letters) :])
    return tuple(
        replace(first, name=f"{letters}{number + k}", x=first.x + k * step[0], y=first.y + k * step[1])
        for k in range(count)
    )


@dataclass(frozen=True, slots=True)
class Sample:
    """A bare board, what is on it and what holds it. Board frame, mm."""

    name: str
    outline: Ring
    holes: tuple[Ring, ...]
    bottom: float
    top: float
    places: tuple[Place, ...]
    clamps: tuple[tuple[str, Triangles], ...] = ()
    states_pads: bool = False
    """Whether the file says what each part is soldered to."""


def assemble(sample: Sample) -> tuple[Body, ...]:
    """Make the bodies of a sample: the board, the components, the fixtures.

    Raises:
        ValueError: Two parts or two holes are too near to each other, or one is outside the board.
    """
    components: list[Body] = []
    drills: list[Ring] = []
    for place in sample.places:
        shape = shape_of(place.package)
        component = _component(shape, place, sample)
        check_inside(component, shape.overhang_mm, sample.outline, sample.holes)
        components.append(component)
        drills += _drills(shape, place)
    clamps = [_body(name, "fixture", (("clamp", (solid,)),)) for name, solid in sample.clamps]
    check_holes(sample.outline, [*sample.holes, *drills])
    check_apart([*components, *clamps], sample.bottom, sample.top)
    return (_board(sample, drills), *components, *clamps)


def _board(sample: Sample, drills: list[Ring]) -> Body:
    """Make the bare board; its faces are sorted into top, bottom and edge."""
    patches = prism(sample.outline, sample.bottom, sample.top, [*sample.holes, *drills])
    up = np.ptp(patches[:, :, 2], axis=1) == 0.0
    top = up & (patches[:, 0, 2] == sample.top)
    bottom = up & ~top
    faces = (("top", (patches[top],)), ("bottom", (patches[bottom],)), ("edge", (patches[~up],)))
    return _body("board", "board", faces)


def _component(shape: Shape, place: Place, sample: Sample) -> Body:
    solids = tuple((name, tuple(_placed(solid, place, sample) for solid in group)) for name, group in shape.solids)
    bare = _body(place.name, "component", solids)
    return replace(
        bare,
        package=shape.package,
        value=place.value,
        pins=shape.pins,
        side=place.side,
        gap_height_mm=shape.gap_height_mm,
        pads=_pads(shape, place) if sample.states_pads else (),
    )


def _pads(shape: Shape, place: Place) -> tuple[Pad, ...]:
    turn = math.radians(place.turn_deg)
    spots = ((pad, _on_board(pad.x_mm, pad.y_mm, place)) for pad in lands_of(shape))
    return tuple(replace(pad, x_mm=x, y_mm=y, turn_rad=turn) for pad, (x, y) in spots)


def _placed(solid: Triangles, place: Place, sample: Sample) -> Triangles:
    if place.side == "top":
        return shifted(rotated(solid, place.turn_deg), place.x, place.y, sample.top)
    return shifted(rotated(flipped(solid), place.turn_deg), place.x, place.y, sample.bottom)


def _drills(shape: Shape, place: Place) -> list[Ring]:
    return [circle(diameter / 2, _DRILL_SIDES, _on_board(x, y, place)) for x, y, diameter in shape.drills]


def _on_board(x: float, y: float, place: Place) -> tuple[float, float]:
    """Find where a spot of a part comes to lie."""
    mirror = 1.0 if place.side == "top" else -1.0
    turned = rotated(np.array([[[mirror * x, y, 0.0]]]), place.turn_deg)[0, 0]
    return place.x + float(turned[0]), place.y + float(turned[1])


def _body(name: str, role: Role, solids: Solids) -> Body:
    """Join named solids; normals come from the winding."""
    patches = np.concatenate([solid for _, group in solids for solid in group])
    across = np.cross(patches[:, 1] - patches[:, 0], patches[:, 2] - patches[:, 0])
    normals = across / np.linalg.norm(across, axis=1, keepdims=True)
    surfaces = tuple(Surface(surface, sum(len(solid) for solid in group)) for surface, group in solids)
    return Body(name, role, patches, normals, surfaces)
