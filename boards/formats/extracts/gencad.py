"""GenCAD 1.4 boards, as layout systems hand them to test and assembly: ``.cad``."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree
from shapely import MultiPolygon, Polygon

from boards.board import Body, Pad, Side
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, check_crowds, number_within
from boards.errors import Line, read_bytes
from boards.formats.layout import EdgeDrawing, LayoutNotes, LayoutWords, build_bodies, first_thickness, read_outline
from boards.formats.loops import DRILL_MM, Point2, arc_about, circle, enclosed, slot
from boards.formats.placed import Land, PackageShape, PlacedPart, Pose, TurnConvention, stand_parts
from geometry.arrays import Points2
from specs.finding import Finding

_AGAIN = "Export the board again as GenCAD 1.4."
_WORDS = LayoutWords("GenCAD", "$BOARD", "lines of the shape")
_WORD = re.compile(r'"((?:[^"\\]|\\.)*)"|(\S+)')
_UNITS_MM = {"INCH": 25.4, "THOU": 0.0254, "MM": 1.0, "MM100": 0.01}
_PER_UNIT_MM = {"USER": 25.4, "USERCM": 10.0, "USERMM": 1.0}
"""Of units that state how many of them make an inch, a centimetre or a millimetre."""
_ON_TRACK_MM = 0.05
"""A track ends as near to the middle of a pin of its net."""


@dataclass(frozen=True, slots=True)
class _Record(Line):
    """One line: its words, and the length of the file's unit."""

    words: tuple[str, ...]
    scale_mm: float

    @property
    def key(self) -> str:
        """First word, in capitals."""
        return self.words[0].upper()

    def word(self, place: int) -> str:
        """Word at a place, empty where there is none."""
        return self.words[place] if place < len(self.words) else ""

    def number(self, place: int, bound: float, scale: float = 1.0) -> float:
        """Word at a place as a number.

        Raises:
            BoardError: It is none, or beyond the bound.
        """
        value = number_within(self.word(place), bound, scale)
        if math.isnan(value):
            stated = self.word(place)[:40] or "nothing"
            raise self.error(
                f"number {place} of {self.key} must be within ±{bound / scale:g}, not {stated!r}. {_AGAIN}"
            )
        return value

    def length(self, place: int) -> float:
        """Word at a place as a length or a coordinate, mm."""
        return self.number(place, FARTHEST_MM, self.scale_mm)

    def angle(self, place: int) -> float:
        """Word at a place as an angle, rad."""
        return math.radians(self.number(place, MOST_TURN_DEG))

    def point(self, place: int) -> Point2:
        """Two words as a point, mm."""
        return np.array([self.length(place), self.length(place + 1)])

    def drawn(self) -> Points2 | None:
        """Points (n, 2) of what it draws, closed shapes end on their first; ``None`` where it draws nothing."""
        match self.key:
            case "LINE":
                return np.array([self.point(1), self.point(3)])
            case "ARC":
                points = arc_about(self.point(1), self.point(3), self.point(5), clockwise=False)
                if points is None:
                    raise self.error(f"the ends of this ARC are not equally far from its centre. {_AGAIN}")
                return points
            case "CIRCLE":
                ring = circle(self.point(1), abs(self.length(3)))
                return np.concatenate([ring, ring[:1]])
            case "RECTANGLE":
                (x, y), width, depth = self.point(1).tolist(), self.length(3), self.length(4)
                return np.array([[x, y], [x + width, y], [x + width, y + depth], [x, y + depth], [x, y]])
            case _:
                return None


@dataclass(slots=True)
class _Entry:
    """What a section lists, such as one component: its record, and those below it."""

    head: _Record
    records: list[_Record] = field(default_factory=list[_Record])

    @property
    def name(self) -> str:
        """What it is called."""
        return self.head.word(1)

    def first(self, key: str) -> _Record | None:
        """First record of a key."""
        return next((each for each in self.records if each.key == key), None)

    def all(self, key: str) -> Iterator[_Record]:
        """Records of a key."""
        return (each for each in self.records if each.key == key)

    def text(self, key: str) -> str:
        """First word of the first record of a key."""
        record = self.first(key)
        return "" if record is None else record.word(1)


@dataclass(frozen=True, slots=True)
class _Stack:
    """The copper of a pin: a box in its own frame, and the drilled hole."""

    pad: Pad
    drill_mm: float
    is_through: bool


def read_gencad(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a GenCAD board: its edge, and one prism a component.

    The frame is that of the file, in mm, with the board's underside at z = 0. Bodies are what the shapes draw, else the
    box around their pads. A shape is mirrored as the file states and then turned; where programs mean something else,
    tracks end at the pins of their nets under one meaning alone, which is taken. Holes from 1 mm are cut out.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, is no GenCAD file, or its edge is missing or open.
    """
    sections = _read_sections(path)
    notes = LayoutNotes()
    stacks = _read_stacks(sections)
    shapes = {each.name: each for each in _entries(sections.get("SHAPES", ()), "SHAPE")}
    devices = {each.name: each for each in _entries(sections.get("DEVICES", ()), "DEVICE")}
    components = _entries(sections.get("COMPONENTS", ()), "COMPONENT")
    lands = {name: _lands(shape, stacks) for name, shape in shapes.items()}
    outlines = {name: enclosed([*_drawn(shape.records)]) for name, shape in shapes.items()}
    poses = _find_poses(components, lands, sections)
    check_crowds([(pose.x_mm, pose.y_mm) for pose, _ in poses], path)
    placed = [
        (
            PlacedPart(each.name, pose, side, *_part_and_value(each, devices)),
            _package(each, shapes, devices, lands, outlines),
            True,
        )
        for each, (pose, side) in zip(components, poses, strict=True)
    ]
    drills = [
        slot(pose.place(np.array([land.pad.x_mm, land.pad.y_mm])), np.array([1.0, 0.0]), 0.0, drill_mm / 2.0)
        for each, (pose, _) in zip(components, poses, strict=True)
        for land, drill_mm in lands.get(_shape_name(each), ())
        if drill_mm >= DRILL_MM
    ]
    drills += _mechanical_holes(sections.get("MECH", ()))
    edges, thickness_mm = _read_edge(sections.get("BOARD", ()))
    soldered = np.array([(pose.x_mm, pose.y_mm) for pose, _ in poses]).reshape(-1, 2)
    outline = read_outline(EdgeDrawing(edges, drills, holds=soldered), path, _WORDS, notes)
    return build_bodies(outline, thickness_mm, list(stand_parts(placed, notes)), _WORDS, notes)


def _read_sections(path: Path) -> dict[str, list[_Record]]:
    """Read the records of each section by its name."""
    data = read_bytes(path)
    text = data.decode("utf-8-sig", "replace")
    if re.search(r"^[ \t]*GENCAD[ \t]+\d", text[:20_000], re.MULTILINE | re.IGNORECASE) is None:
        raise Line(path, 1).error(f"not a GenCAD file: its header has no line GENCAD 1.4. {_AGAIN}")
    sections: dict[str, list[_Record]] = {}
    name, scale_mm = "", 25.4
    for number, line in enumerate(text.splitlines(), start=1):
        words = tuple(hit[1] if hit[1] is not None else hit[2] for hit in _WORD.finditer(line))
        if not words:
            continue
        if words[0].startswith("$"):
            name = "" if words[0].upper().startswith("$END") else words[0][1:].upper()
            continue
        record = _Record(path, number, words, scale_mm)
        if name == "HEADER" and record.key == "UNITS":
            scale_mm = _unit_mm(record)
        sections.setdefault(name, []).append(record)
    return sections


def _unit_mm(record: _Record) -> float:
    unit = record.word(1).upper()
    if unit in _PER_UNIT_MM:
        per_unit = record.number(2, 1e9)
        if per_unit <= 0.0:
            raise record.error(f"the number of units must be above 0. {_AGAIN}")
        return _PER_UNIT_MM[unit] / per_unit
    if unit not in _UNITS_MM:
        known = ", ".join([*_UNITS_MM, *_PER_UNIT_MM])
        raise record.error(f"the unit is one of {known}, not {unit[:40]!r}. {_AGAIN}")
    return _UNITS_MM[unit]


def _entries(records: Iterable[_Record], key: str) -> list[_Entry]:
    """Entries of a section, in file order."""
    found: list[_Entry] = []
    for record in records:
        if record.key == key:
            found.append(_Entry(record))
        elif found:
            found[-1].records.append(record)
    return found


def _drawn(records: Iterable[_Record]) -> Iterator[Points2]:
    """Lines that records draw."""
    lines = (record.drawn() for record in records)
    return (line for line in lines if line is not None)


def _read_edge(records: Sequence[_Record]) -> tuple[list[Points2], float]:
    """Lines of the edge and of cut-outs, and the thickness; masks, texts and artworks are none."""
    lines: list[Points2] = []
    thickness: list[float] = []
    is_edge = True
    for record in records:
        if record.key in ("CUTOUT", "MASK", "ARTWORK", "TEXT"):
            is_edge = record.key in ("CUTOUT", "TEXT") and (is_edge or record.key == "CUTOUT")
        elif record.key == "THICKNESS":
            thickness.append(record.length(1))
        elif is_edge and (line := record.drawn()) is not None:
            lines.append(line)
    return lines, first_thickness(thickness)


def _mechanical_holes(records: Sequence[_Record]) -> Iterator[Points2]:
    """Rings of the holes of mechanical parts."""
    for entry in _entries(records, "MECH"):
        place = entry.first("PLACE")
        origin = np.zeros(2) if place is None else place.point(1)
        for hole in entry.all("HOLE"):
            if hole.length(3) >= DRILL_MM:
                yield slot(origin + hole.point(1), np.array([1.0, 0.0]), 0.0, hole.length(3) / 2.0)


def _read_stacks(sections: Mapping[str, Sequence[_Record]]) -> dict[str, _Stack]:
    """Copper of pads and of stacks of pads, by name; pins may name either."""
    pads: dict[str, _Stack] = {}
    for entry in _entries(sections.get("PADS", ()), "PAD"):
        drawn = list(_drawn(entry.records))
        if not drawn:
            continue
        points = np.concatenate(drawn)
        (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
        is_round = entry.head.word(2).upper() == "ROUND"
        drill_mm = max(entry.head.length(3), 0.0) if entry.head.word(3) else 0.0
        box = Pad((x0 + x1) / 2.0, (y0 + y1) / 2.0, x1 - x0, y1 - y0, 0.0, is_round)
        pads[entry.name] = _Stack(box, drill_mm, drill_mm > 0.0)
    stacks = dict(pads)
    for entry in _entries(sections.get("PADSTACKS", ()), "PADSTACK"):
        outer = [each for each in entry.all("PAD") if each.word(2).upper() in ("TOP", "BOTTOM", "ALL")]
        first = next((each for each in outer if each.word(1) in pads), None)
        if first is None:
            continue
        drill_mm = max(entry.head.length(2), 0.0) if entry.head.word(2) else 0.0
        layers = {each.word(2).upper() for each in outer}
        is_through = drill_mm > 0.0 or "ALL" in layers or len(layers) > 1
        own = pads[first.word(1)]
        turn = first.angle(3) if first.word(3) else 0.0
        stacks[entry.name] = _Stack(replace(own.pad, turn_rad=turn), drill_mm or own.drill_mm, is_through)
    return stacks


def _lands(shape: _Entry, stacks: Mapping[str, _Stack]) -> list[tuple[Land, float]]:
    """Pins of a shape, each with the hole that is drilled for it, mm; one that is on both sides is there once."""
    found: dict[str, tuple[Land, float]] = {}
    for record in shape.all("PIN"):
        x, y = record.point(3).tolist()
        stack = stacks.get(record.word(2))
        if stack is None:
            stack = _Stack(Pad(0.0, 0.0, 0.0, 0.0), 0.0, is_through=False)
        turn = record.angle(6) if record.word(6) else 0.0
        pose = Pose(x, y, turn)
        middle = pose.place(np.array([stack.pad.x_mm, stack.pad.y_mm])).tolist()
        pad = replace(stack.pad, x_mm=middle[0], y_mm=middle[1], turn_rad=pose.turn(stack.pad.turn_rad))
        key = f"{record.word(1)} {x:.4f} {y:.4f}"
        is_flat = not stack.is_through and key not in found
        found[key] = Land(record.word(1), pad, is_flat), stack.drill_mm
    return list(found.values())


def _shape_name(component: _Entry) -> str:
    return component.text("SHAPE")


def _package(
    component: _Entry,
    shapes: Mapping[str, _Entry],
    devices: Mapping[str, _Entry],
    lands: Mapping[str, list[tuple[Land, float]]],
    outlines: Mapping[str, Polygon | MultiPolygon | None],
) -> PackageShape:
    """Package of a component: its shape, whose name may be that of the device."""
    name = _shape_name(component)
    shape = shapes.get(name)
    if shape is None:
        raise component.head.error(
            f"{component.name[:40]} is of the shape {name[:60]!r}, which $SHAPES lacks. {_AGAIN}"
        )
    device = devices.get(component.text("DEVICE"))
    package = device.text("PACKAGE") if device is not None else ""
    height = shape.first("HEIGHT")
    own = [land for land, _ in lands[name]]
    return PackageShape(
        (package or name).rpartition(":")[2],
        outlines[name],
        tuple(own),
        len({land.number for land in own}) or None,
        height.length(1) or None if height is not None else None,
        device.text("DESC") if device is not None else "",
    )


def _part_and_value(component: _Entry, devices: Mapping[str, _Entry]) -> tuple[str, str]:
    device = devices.get(component.text("DEVICE"))
    if device is None:
        return "", component.text("VALUE")
    return device.text("PART"), component.text("VALUE") or device.text("VALUE")


def _find_poses(
    components: Sequence[_Entry],
    lands: Mapping[str, list[tuple[Land, float]]],
    sections: Mapping[str, Sequence[_Record]],
) -> list[tuple[Pose, Side]]:
    """Where each component lies, by the meaning of its flags under which most of its pins lie at ends of tracks."""
    read: list[tuple[Point2, float, Side, str]] = []
    for each in components:
        place, turn, shape = each.first("PLACE"), each.first("ROTATION"), each.first("SHAPE")
        if place is None or shape is None:
            raise each.head.error(f"{each.name[:40]} has no PLACE or no SHAPE. {_AGAIN}")
        side: Side = "bottom" if each.text("LAYER").upper().startswith("BOT") else "top"
        flags = " ".join([side, shape.word(2).upper(), shape.word(3).upper()])
        read.append((place.point(1), 0.0 if turn is None else turn.angle(1), side, flags))
    routes, nets = _entries(sections.get("ROUTES", ()), "ROUTE"), _nets(sections)
    ends = {net.name: [line.point(place) for line in net.all("LINE") for place in (1, 3)] for net in routes}
    conventions: dict[str, TurnConvention] = {}
    for flags in {row[3] for row in read}:
        # Mirrored about x and turned is mirrored about y and turned by half a turn more.
        usual = TurnConvention("MIRROR" in flags, 1.0, 2 if "MIRRORX" in flags else 0)
        pins = [
            (land.pad, at, turn, net)
            for each, (at, turn, _, own) in zip(components, read, strict=True)
            if own == flags
            for land, _ in lands.get(_shape_name(each), ())
            if (net := nets.get((each.name, land.number))) is not None
        ]
        conventions[flags] = _settle(pins, ends, usual)
    return [(conventions[flags].pose(at, turn), side) for at, turn, side, flags in read]


def _settle(
    pins: Sequence[tuple[Pad, Point2, float, str]], ends: Mapping[str, Sequence[Point2]], usual: TurnConvention
) -> TurnConvention:
    """Convention under which most pins lie at the end of a track of their net; the usual one where none has more."""
    order = {name: number for number, name in enumerate(sorted(ends))}
    rows = [(*end.tolist(), order[name] * FARTHEST_MM) for name, own in ends.items() for end in own]
    known = [pin for pin in pins if pin[3] in order]
    if not rows or not known:
        return usual
    tree = KDTree(rows)

    own = np.array([(pad.x_mm, pad.y_mm, *place, turn, order[net] * FARTHEST_MM) for pad, place, turn, net in known])
    x, y, *places, turns, level = own.T

    def hits(convention: TurnConvention) -> int:
        turn = convention.sign * turns + convention.quarters * math.pi / 2.0
        over = -x if convention.is_mirrored else x
        at_x, at_y = over * np.cos(turn) - y * np.sin(turn), over * np.sin(turn) + y * np.cos(turn)
        at = np.column_stack([places[0] + at_x, places[1] + at_y, level])
        return int((np.asarray(tree.query(at)[0]) <= _ON_TRACK_MM).sum())

    others = [TurnConvention(over, sign, n) for over in (False, True) for sign in (1.0, -1.0) for n in range(4)]
    return max((usual, *others), key=hits)


def _nets(sections: Mapping[str, Sequence[_Record]]) -> dict[tuple[str, str], str]:
    """Net of each pin, by component and pin."""
    return {
        (node.word(1), node.word(2)): entry.name
        for entry in _entries(sections.get("SIGNALS", ()), "SIGNAL")
        for node in entry.all("NODE")
    }
