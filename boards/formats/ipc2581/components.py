"""The packages of an IPC-2581 file, and its components with what its bill of materials states of them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from shapely import MultiPolygon, Polygon
from shapely.affinity import scale

from boards.board import Pad, Side
from boards.bounds import FARTHEST_MM
from boards.formats.ipc2581.elements import (
    WORDS,
    Drawing,
    Element,
    Primitive,
    largest,
    location,
    read_primitive,
    strokes,
    turn_rad,
)
from boards.formats.layout import part_number, plain_key, stated_height
from boards.formats.loops import Point2, box_around, enclosed
from boards.formats.placed import Land, PackageShape, PlacedPart, TurnConvention, fit_convention

_MOST_PINS = 1_000_000
_USUAL = TurnConvention(is_mirrored=False, sign=1.0)
_MIRRORED = TurnConvention(is_mirrored=True, sign=-1.0)
"""Turned, then mirrored."""
_SEEN_THROUGH = TurnConvention(is_mirrored=False, sign=-1.0, quarters=2)
"""Packages that are drawn as seen through the board."""
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


@dataclass(slots=True)
class Copper:
    """Where the file places the copper of pins, by component and pin, in its units; taken from the stream."""

    places: dict[tuple[str, str], tuple[float, float]] = field(
        default_factory=dict[tuple[str, str], tuple[float, float]]
    )

    def take(self, pad: Element) -> None:
        """Note the first place of each pin.

        Raises:
            BoardError: It is no number.
        """
        reference, place = pad.first("PinRef"), pad.first("Location")
        if reference is not None and place is not None and len(self.places) < _MOST_PINS:
            key = (reference.word("componentRef"), reference.word("pin"))
            self.places.setdefault(key, (place.number("x", 1e9), place.number("y", 1e9)))


@dataclass(frozen=True, slots=True, eq=False)
class Component:
    """A placed component, its place in mm and its turn as stated."""

    element: Element
    reference: str
    """As in the file."""
    package: str
    place: Point2
    turn_rad: float
    is_mirrored: bool
    side: Side


@dataclass(frozen=True, slots=True)
class BomEntry:
    """What the bill of materials states of one reference designator."""

    package: str = ""
    is_populated: bool = True
    part: str = ""
    properties: Mapping[str, str] = field(default_factory=dict[str, str])


def read_components(step: Element, data: Element, drawing: Drawing) -> list[Component]:
    """Components of a step in file order.

    Raises:
        BoardError: One has no place, or a number that cannot be read.
    """
    sides: dict[str, Side] = {}
    for layer in data.all("Layer"):
        sides[layer.word("name")] = "bottom" if layer.word("side").upper() == "BOTTOM" else "top"
    found: list[Component] = []
    for element in step.all("Component"):
        turn, is_mirrored = turn_rad(element)
        layer = element.word("layerRef")
        side: Side = sides.get(layer, "bottom" if is_mirrored else "top")
        reference = element.word("refDes")
        if not reference:
            raise element.error(f"a component has no refDes. {WORDS.again}")
        package = element.word("packageRef")
        found.append(Component(element, reference, package, location(element, drawing), turn, is_mirrored, side))
    return found


def read_bom(top: Element) -> dict[str, BomEntry]:
    """Read what the bills of materials state, by reference designator."""
    found: dict[str, BomEntry] = {}
    for item in (item for bom in top.all("Bom") for item in bom.all("BomItem")):
        stated = {
            plain_key(each.word("textualCharacteristicName")): each.word("textualCharacteristicValue")
            for characteristics in item.all("Characteristics")
            for each in characteristics.all("Textual")
        }
        for reference in item.all("RefDes"):
            populated = reference.word("populate").lower() != "false"
            found[reference.word("name")] = BomEntry(
                reference.word("packageRef"), populated, part_number(stated), stated
            )
    return found


def conventions_of(
    components: Sequence[Component],
    packages: Mapping[str, PackageShape],
    copper: Copper,
    drawing: Drawing,
    seen_through: frozenset[str],
) -> dict[Side, TurnConvention]:
    """Find how rotations are meant on each side: such that pins lie on their copper where the file places it."""
    result: dict[Side, TurnConvention] = {}
    for side in ("top", "bottom"):
        own = [each for each in components if each.side == side]
        found = (
            (land.pad, np.array(there) * drawing.scale_mm - each.place, each.turn_rad)
            for each in own
            for land in packages[each.package].lands
            if (there := copper.places.get((each.reference, land.number))) is not None
        )
        through = bool(own) and all(each.package in seen_through for each in own)
        usual = _USUAL if not any(each.is_mirrored for each in own) else _SEEN_THROUGH if through else _MIRRORED
        result[side] = fit_convention(found, usual)
    return result


def place_component(
    component: Component, convention: TurnConvention, name: str, entry: BomEntry, drawing: Drawing
) -> PlacedPart:
    """Return where a component stands, and what is known of it."""
    element = component.element
    stated = {
        key: element.number(key, FARTHEST_MM, drawing.scale_mm)
        for key in ("height", "standoff")
        if key in element.attributes
    }
    properties = dict(entry.properties) | {
        plain_key(each.word("name")): each.word("value") for each in element.all("NonstandardAttribute")
    }
    height = stated.get("height", 0.0)
    standoff = stated.get("standoff", 0.0)
    return PlacedPart(
        name,
        convention.pose(component.place, component.turn_rad),
        component.side,
        part=entry.part or part_number(properties),
        value=properties.get("value", ""),
        height_mm=height if height > 0.0 else stated_height(properties),
        standoff_mm=standoff if standoff > 0.0 else None,
    )
