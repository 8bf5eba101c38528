"""The packages of an ODB++ step: ``eda/data``."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from shapely import MultiPolygon, Polygon

from boards.board import Pad
from boards.formats.loops import circle, enclosed
from boards.formats.odb.text import AGAIN, Record, quoted, read_contours
from boards.formats.placed import Land, PackageShape
from geometry.arrays import Points2

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
    rings = _rings(package.drawn)
    outline = _outline(rings)
    if outline is None:
        x0, y0, x1, y1 = (head.length(3 + place, "corner of a package's box") for place in range(4))
        outline = shapely.box(min(x0, x1), min(y0, y1), max(x0, x1), max(y0, y1)) if x0 != x1 and y0 != y1 else None
    lands = tuple(_land(pin) for pin in package.pins)
    description = " ".join(package.properties.get(key, "") for key in ("description", "descr")).strip()
    return PackageShape(head.words[1], outline, lands, len({land.number for land in lands}) or None, None, description)


def _outline(rings: Sequence[Points2]) -> Polygon | MultiPolygon | None:
    shapes = [Polygon(ring) for ring in rings]
    if not shapes:
        return None
    shape = max(shapes, key=lambda each: round(each.area, 6))
    if shape.is_valid:
        return shape if shape.area > _SMALLEST_MM**2 else None
    ring = np.asarray(shape.exterior.coords)
    return enclosed([ring])


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
