"""The placed components of an ODB++ step: ``layers/<layer>/components``."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from boards.board import Side
from boards.bounds import number_within
from boards.formats.layout import part_number, plain_key, stated_height
from boards.formats.loops import Point2
from boards.formats.odb.text import AGAIN, Record, attributes, quoted
from boards.formats.placed import PackageShape, PlacedPart, TurnConvention, fit_convention

_USUAL = TurnConvention(is_mirrored=False, sign=-1.0)
"""Clockwise."""
_MIRRORED = TurnConvention(is_mirrored=True, sign=-1.0)


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
