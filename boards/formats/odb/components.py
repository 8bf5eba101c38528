"""The packages of an ODB++ step, ``eda/data``, and its components, ``layers/<layer>/components``."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely import Polygon

from boards.board import Pad, Side
from boards.bounds import number_within
from boards.formats.layout import part_number, plain_key, stated_height
from boards.formats.loops import Point2, circle, enclosed
from boards.formats.odb.text import AGAIN, Record, attributes, quoted, read_contours
from boards.formats.placed import Land, PackageShape, PlacedPart, TurnConvention, fit_convention
from geometry.arrays import Points2

_USUAL = TurnConvention(is_mirrored=False, sign=-1.0)
"""Clockwise."""
_MIRRORED = TurnConvention(is_mirrored=True, sign=-1.0)
_DRAWN = frozenset({"RC", "CR", "SQ", "CT", "OB", "OS", "OC", "OE", "CE"})
_KEPT = _DRAWN | {"PKG", "PIN", "PRP"}
_SMALLEST_MM = 1e-3


@dataclass(slots=True)
class _Pin:
    head: Record
    drawn: list[Record] = field(default_factory=list[Record])


@dataclass(slots=True)
class _Package:
    head: Record
    pins: list[_Pin] = field(default_factory=list[_Pin])
    drawn: list[Record] = field(default_factory=list[Record])
    properties: dict[str, str] = field(default_factory=dict[str, str])


def read_packages(records: Iterable[Record]) -> list[PackageShape]:
    """Read the packages of ``eda/data`` in their order, by which components name them; mm.

    Raises:
        BoardError: A number of one cannot be read.
    """
    packages: list[_Package] = []
    for record in records:
        word = record.words[0] if record.words else ""
        if word == "PKG":
            packages.append(_Package(record))
        elif not packages or word not in _KEPT:
            continue
        elif word == "PIN":
            packages[-1].pins.append(_Pin(record))
        elif word == "PRP" and not packages[-1].pins and len(record.words) > 2:
            packages[-1].properties[record.words[1].lower()] = quoted(" ".join(record.words[2:]))
        elif word in _DRAWN:
            (packages[-1].pins[-1] if packages[-1].pins else packages[-1]).drawn.append(record)
    return [_shape(package) for package in packages]


def _shape(package: _Package) -> PackageShape:
    head = package.head
    if len(head.words) < 7:
        raise head.error(f"a package has a name, a pitch and the corners of its box. {AGAIN}")
    shape = max(map(Polygon, _rings(package.drawn)), key=lambda each: round(each.area, 6), default=Polygon())
    outline = shape if shape.area > _SMALLEST_MM**2 else None
    if not shape.is_valid:
        outline = enclosed([np.asarray(shape.exterior.coords)])
    if outline is None:
        x0, y0, x1, y1 = (head.length(3 + place, "corner of a package's box") for place in range(4))
        outline = shapely.box(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)) if x0 != x1 and y0 != y1 else None
    lands = tuple(_land(pin) for pin in package.pins)
    description = " ".join(package.properties.get(key, "") for key in ("description", "descr")).strip()
    return PackageShape(head.words[1], outline, lands, len({land.number for land in lands}) or None, None, description)


def _rings(records: Sequence[Record]) -> list[Points2]:
    """Rectangles, squares, circles and contours of a package or a pin."""
    rings = [contour.ring for contour in read_contours(records) if not contour.is_hole]
    for record in records:
        match record.words[0]:
            case "RC":
                (x, y), width, height = record.point(1), record.length(3, "width"), record.length(4, "height")
                rings.append(np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]]))
            case "SQ":
                (x, y), half = record.point(1), record.length(3, "half side")
                rings.append(np.array([x, y]) + np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half)
            case "CR":
                rings.append(circle(record.point(1), record.length(3, "radius")))
            case _:
                pass
    return rings


def _land(pin: _Pin) -> Land:
    """Read a pin: ``PIN name type x y …``; its shape is the box around what is drawn of it."""
    head = pin.head
    if len(head.words) < 5:
        raise head.error(f"a pin has a name, a type and a place. {AGAIN}")
    x, y = head.length(3, "x of a pin"), head.length(4, "y of a pin")
    rings = _rings(pin.drawn)
    is_round = len(pin.drawn) == 1 and pin.drawn[0].words[0] == "CR"
    # Surface pins; the last word is how it is mounted: S flat, T through the board, and others.
    flat = head.words[2].upper() == "S"
    number = re.sub(r"^'|'$", "", head.words[1])
    if not rings:
        return Land(number, Pad(x, y, 0.0, 0.0), flat)
    points = np.concatenate(rings)
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return Land(number, Pad((x0 + x1) / 2.0, (y0 + y1) / 2.0, x1 - x0, y1 - y0, 0.0, is_round), flat)


@dataclass(slots=True)
class Component:
    """A component as the file states it."""

    head: Record
    side: Side
    package: int
    """Number of the package in ``eda/data``."""
    place: Point2
    turn_rad: float
    """As stated, clockwise."""
    is_mirrored: bool
    name: str
    part: str
    attributes: dict[str, str]
    properties: dict[str, str] = field(default_factory=dict[str, str])
    toeprints: dict[int, Point2] = field(default_factory=dict[int, Point2])
    """Where pins lie on the board, by their number in the package, mm."""


def read_components(records: Iterable[Record], side: Side) -> list[Component]:
    """Read the components of a layer in file order.

    Raises:
        BoardError: A number of one cannot be read.
    """
    names: dict[str, str] = {}
    texts: dict[str, str] = {}
    found: list[Component] = []
    for record in records:
        word = record.words[0] if record.words else ""
        if word[:1] in ("@", "&") and len(record.words) > 1:
            (names if word[0] == "@" else texts)[word[1:]] = " ".join(record.words[1:])
        elif word == "CMP":
            found.append(_component(record, side, names, texts))
        elif word == "PRP" and found and len(record.words) > 1:
            found[-1].properties[plain_key(record.words[1])] = quoted(" ".join(record.words[2:]))
        elif word in ("TOP", "BOT") and found and len(record.words) > 3:
            found[-1].toeprints[record.count(1, "number of a pin")] = record.point(2)
    return found


def _component(record: Record, side: Side, names: Mapping[str, str], texts: Mapping[str, str]) -> Component:
    """``CMP package x y rotation mirror name part ;attributes``."""
    if len(record.words) < 7:
        raise record.error(f"a component has a package, a place, a rotation, a mirror and a name. {AGAIN}")
    stated = {names.get(key, ""): texts.get(value, value) if value else "" for key, value in attributes(record.rest)}
    return Component(
        record,
        side,
        record.count(1, "number of a package"),
        record.point(2),
        record.angle(4, "rotation"),
        record.words[5].upper() == "M",
        record.words[6],
        record.words[7] if len(record.words) > 7 else "",
        stated,
    )


def conventions_of(components: Sequence[Component], packages: Sequence[PackageShape]) -> dict[Side, TurnConvention]:
    """Find how rotations are meant on each side: such that pins lie on their toeprints."""
    result: dict[Side, TurnConvention] = {}
    for side in ("top", "bottom"):
        own = [each for each in components if each.side == side]
        found = (
            (lands[number].pad, place - each.place, each.turn_rad)
            for each in own
            for lands in [packages[each.package].lands]
            for number, place in each.toeprints.items()
            if number < len(lands)
        )
        usual = _MIRRORED if any(each.is_mirrored for each in own) else _USUAL
        result[side] = fit_convention(found, usual)
    return result


def is_mounted(component: Component) -> bool:
    """Whether it is there, by its attributes."""
    return not any(key.lower() in (".no_pop", ".comp_ignore") for key in component.attributes)


def place_component(component: Component, convention: TurnConvention) -> PlacedPart:
    """Return where a component stands, and what is known of it."""
    stated = {key.lower(): value for key, value in component.attributes.items()}
    height = number_within(stated.get(".comp_height", ""), 1000.0, component.head.scale_mm)
    return PlacedPart(
        component.name,
        convention.pose(component.place, component.turn_rad),
        component.side,
        part=part_number(component.properties),
        value=component.properties.get("value", ""),
        height_mm=height if height > 0.0 else stated_height(component.properties),
    )
