"""The packages of an IPC-2581 file."""

from collections.abc import Mapping

import numpy as np
from shapely import MultiPolygon, Polygon
from shapely.affinity import scale

from boards.board import Pad
from boards.formats.ipc2581.elements import (
    Drawing,
    Element,
    Primitive,
    largest,
    location,
    read_primitive,
    strokes,
    turn_rad,
)
from boards.formats.loops import box_around, enclosed
from boards.formats.placed import Land, PackageShape

_DRAWN = 0.6
"""Part of the assembly outline that lines inside it enclose at least, if they are the drawing of the body."""


def read_package(package: Element, primitives: Mapping[str, Primitive], drawing: Drawing) -> PackageShape:
    """Read one package: outline, pins and height, mm.

    The body is what the lines of the assembly drawing enclose, else the assembly outline, else the outline. Of a
    package that is drawn for the other side alone, that drawing is taken the way round that lies over its pins.

    Raises:
        BoardError: A number of it cannot be read.
    """
    lands = tuple(land for pin in package.all("Pin") if (land := _read_land(pin, primitives, drawing)) is not None)
    numbers = {pin.word("number") for pin in package.all("Pin") if pin.word("electricalType") != "MECHANICAL"}
    outline = _read_outline(package, drawing)
    other = package.first("OtherSideView")
    if outline is None and other is not None:
        outline = _over_pins(_read_outline(other, drawing), lands)
    height = package.number("height", scale=drawing.scale_mm) if "height" in package.attributes else 0.0
    return PackageShape(
        package.word("name"),
        outline,
        lands,
        len(numbers) or None,
        height if height > 0.0 else None,
        package.word("comment"),
    )


def is_seen_through(package: Element) -> bool:
    """Whether the package is drawn for the other side alone, as seen through the board."""
    return package.first("OtherSideView") is not None and package.first("Outline") is None


def _read_outline(package: Element, drawing: Drawing) -> Polygon | MultiPolygon | None:
    assembly = package.first("AssemblyDrawing")
    stated = None if assembly is None else _polygon(assembly, drawing)
    drawn = None if assembly is None else enclosed(list(strokes(assembly.all("Marking"), drawing)))
    if drawn is not None and (stated is None or drawn.area >= _DRAWN * stated.area):
        return drawn
    return _polygon(package, drawing) if stated is None else stated


def _polygon(owner: Element, drawing: Drawing) -> Polygon | MultiPolygon | None:
    """Largest outline of a package or of its assembly drawing; what crosses itself is closed as it is drawn."""
    polygons = [polygon for outline in owner.all("Outline") for polygon in outline.all("Polygon")]
    rings = [ring for polygon in polygons if len(ring := drawing.ring(polygon)) > 2]
    if not rings:
        return None
    ring = largest(rings)
    shape = Polygon(ring)
    if shape.is_valid:
        return shape if shape.area > 0.0 else None
    return enclosed([np.concatenate([ring, ring[:1]])])


def _over_pins(outline: Polygon | MultiPolygon | None, lands: tuple[Land, ...]) -> Polygon | MultiPolygon | None:
    """Mirror an outline, if it lies over the pins only then."""
    around = box_around([np.array([[land.pad.x_mm, land.pad.y_mm]]) for land in lands])
    if outline is None or around is None:
        return outline
    turned = [scale(outline, x, y, origin=(0.0, 0.0)) for x, y in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0))]
    return max(turned, key=lambda each: round(each.intersection(around).area, 6))


def _read_land(pin: Element, primitives: Mapping[str, Primitive], drawing: Drawing) -> Land | None:
    shape = None
    for child in pin.children:
        if child.tag.endswith("PrimitiveRef"):
            shape = primitives.get(child.word("id"))
        elif child.tag not in ("Location", "Xform"):
            shape = read_primitive(child, drawing)
        if shape is not None:
            break
    if shape is None or pin.first("Location") is None:
        return None
    x, y = location(pin, drawing).tolist()
    angle, is_mirrored = turn_rad(pin)
    turned = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ shape.middle
    dx, dy = turned.tolist()
    pad = Pad(x + (-dx if is_mirrored else dx), y + dy, shape.length_mm, shape.width_mm, angle, shape.is_round)
    return Land(pin.word("number"), pad, pin.word("type").upper() == "SURFACE")
