"""Allegro boards as tables of an extract: views with titles (A), one line of facts (J) and rows (S), ``!`` between."""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

import numpy as np

from boards.board import Body, Pad, Side
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, check_crowds, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.formats.layout import EdgeDrawing, LayoutNotes, LayoutWords, build_bodies, first_thickness, read_outline
from boards.formats.loops import DRILL_MM, Point2, arc_about, circle, enclosed, slot
from boards.formats.placed import Land, PackageShape, PlacedPart, Pose, stand_parts
from boards.packages.heights import length_in
from geometry.arrays import Points2
from specs.finding import Finding

_AGAIN = "Export the extract again."
_WORDS = LayoutWords("Allegro", "BOARD GEOMETRY / OUTLINE", "PLACE_BOUND_TOP")
_UNITS_MM = {"MILS": 0.0254, "MILLIMETERS": 1.0, "MICRONS": 0.001, "INCHES": 25.4, "CENTIMETERS": 10.0}
_EDGE = re.compile(rb"!(?:DESIGN_)?OUTLINE!|!CUTOUT!", re.IGNORECASE)
_THICKNESS = re.compile(r"[\d.]+ [a-z]+", re.IGNORECASE)
_EDGES = ("OUTLINE", "DESIGN_OUTLINE", "CUTOUT")
_BODIES = ("PLACE_BOUND", "ASSEMBLY", "SILKSCREEN")
"""Drawings of parts, what bounds their bodies first."""
_HERE = Pose(0.0, 0.0, 0.0)
"""All that an extract draws is placed on the board."""


@dataclass(frozen=True, slots=True)
class _View:
    """Titles of a view, and the length of its unit."""

    titles: Mapping[str, int]
    """In small letters without marks."""
    scale_mm: float
    thickness_mm: float
    """Of the board, 0 where none is stated before."""


@dataclass(frozen=True, slots=True)
class _Row(Line):
    """One row of a view."""

    cells: tuple[str, ...]
    view: _View

    def text(self, *titles: str) -> str:
        """Cell of the first of these titles that is there, empty without one."""
        places = (self.view.titles[title] for title in titles if title in self.view.titles)
        return next((self.cells[place].strip() for place in places if place < len(self.cells)), "")

    def number(self, title: str, bound: float, scale: float) -> float:
        """Cell as a number.

        Raises:
            BoardError: It is none, or beyond the bound.
        """
        value = number_within(self.text(title), bound, scale)
        if math.isnan(value):
            stated = self.text(title)[:40] or "nothing"
            raise self.error(f"{title} must be a number within ±{bound / scale:g}, not {stated!r}. {_AGAIN}")
        return value

    def length(self, title: str) -> float:
        """Cell as a length or a coordinate, mm."""
        return self.number(title, FARTHEST_MM, self.view.scale_mm)

    def angle(self, title: str) -> float:
        """Cell as an angle, rad; 0 where it is empty."""
        return math.radians(self.number(title, MOST_TURN_DEG, 1.0)) if self.text(title) else 0.0

    def point(self, x: str, y: str) -> Point2:
        """Two cells as a point, mm."""
        return np.array([self.length(x), self.length(y)])

    def drawn(self) -> Points2 | None:
        """Points (n, 2) of what a row draws; ``None`` where it draws no line."""
        start, end = ("graphicdata1", "graphicdata2"), ("graphicdata3", "graphicdata4")
        match self.text("graphicdataname").upper():
            case "LINE":
                return np.array([self.point(*start), self.point(*end)])
            case "ARC":
                is_clockwise = self.text("graphicdata9").upper().startswith("CLOCK")
                centre = self.point("graphicdata5", "graphicdata6")
                points = arc_about(self.point(*start), self.point(*end), centre, clockwise=is_clockwise)
                if points is None:
                    raise self.error(f"the ends of this arc are not equally far from its centre. {_AGAIN}")
                return points
            case "RECTANGLE" | "FIG_RECTANGLE":
                (ax, ay), (bx, by) = self.point(*start), self.point(*end)
                return np.array([[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]])
            case "CIRCLE":
                ring = circle(self.point(*start), abs(self.length("graphicdata3")) / 2.0)
                return np.concatenate([ring, ring[:1]])
            case _:
                return None


def has_edge(content: bytes) -> bool:
    """Whether an extract draws the edge of a board; a table of components alone does not."""
    return _EDGE.search(content) is not None


def read_allegro(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a board from the views of an extract, which lie one after the other in a text.

    The frame is that of the board, in mm, with its underside at z = 0. Bodies are what bounds the place of a part, else
    its assembly drawing, else the box around its pads.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, or its edge is missing or open.
    """
    rows = list(_read_rows(path))
    notes = LayoutNotes()
    pads, drills_mm = _read_stacks(rows)
    pins: dict[str, list[_Row]] = {}
    drawings: dict[str, dict[str, list[Points2]]] = {}
    edges: list[Points2] = []
    for row in rows:
        titles, ref = row.view.titles, row.text("refdes")
        if {"pinx", "piny", "padstackname"} <= titles.keys() and ref:
            pins.setdefault(ref, []).append(row)
        elif "graphicdataname" in titles:
            layer = row.text("subclass").upper()
            is_edge = layer in _EDGES and row.text("class").upper() in ("", "BOARD GEOMETRY")
            kind = next((each for each in _BODIES if layer.startswith(each)), "")
            line = row.drawn() if is_edge or (kind and ref) else None
            if line is not None and is_edge:
                edges.append(line)
            elif line is not None:
                drawings.setdefault(ref, {}).setdefault(kind, []).append(line)
    components = [row for row in rows if "symx" in row.view.titles and row.text("refdes") and row.text("symx")]
    places = np.array([row.point("symx", "symy") for row in components]).reshape(-1, 2)
    check_crowds(places, path)
    placed = [
        (_placed(row), _package(row, pins.get(row.text("refdes"), ()), drawings, pads, drills_mm), True)
        for row in components
    ]
    drills = [
        slot(row.point("pinx", "piny"), np.array([1.0, 0.0]), 0.0, drill_mm / 2.0)
        for row in chain.from_iterable(pins.values())
        if (drill_mm := drills_mm.get(row.text("padstackname"), 0.0)) >= DRILL_MM
    ]
    outline = read_outline(EdgeDrawing(edges, drills, holds=places), path, _WORDS, notes)
    return build_bodies(
        outline, first_thickness(row.view.thickness_mm for row in rows), list(stand_parts(placed, notes)), _WORDS, notes
    )


def _read_rows(path: Path) -> Iterator[_Row]:
    """Yield the rows of all views."""
    view, is_found = _View({}, _UNITS_MM["MILS"], 0.0), False
    for number, line in enumerate(read_bytes(path).decode("utf-8-sig", "replace").splitlines(), start=1):
        cells = tuple(line.split("!"))
        match cells[0].strip().upper():
            case "A":
                plain = (re.sub(r"[^a-z0-9]", "", cell.lower()) for cell in cells)
                titles = {title: place for place, title in enumerate(plain) if title}
                view, is_found = _View(titles, view.scale_mm, view.thickness_mm), True
            case "J":
                units = (_UNITS_MM[word] for cell in cells if (word := cell.strip().upper()) in _UNITS_MM)
                stated = (length_in(cell) for cell in cells if _THICKNESS.fullmatch(cell.strip()))
                thick = next((mm for mm in stated if mm is not None), view.thickness_mm)
                view = _View(view.titles, next(units, view.scale_mm), thick)
            case "S" if is_found:
                yield _Row(path, number, cells, view)
            case _:
                pass
    if not is_found:
        raise BoardError(f"not an extract of Allegro: no line begins with A!. {_AGAIN}", file=path)


def _read_stacks(rows: Sequence[_Row]) -> tuple[dict[str, Pad], dict[str, float]]:
    """Copper of each stack of pads on its outer layer, in its own frame, and the hole that is drilled for it, mm."""
    pads: dict[str, Pad] = {}
    drills: dict[str, float] = {}
    for row in rows:
        if not {"padname", "layer", "padshape1"} <= row.view.titles.keys():
            continue
        name, layer = row.text("padname"), row.text("layer").upper()
        if layer == "~DRILL":
            drills[name] = abs(row.length("padshape1")) if row.text("padshape1") else 0.0
        elif layer in ("TOP", "BOTTOM") and name not in pads and row.text("padwidth"):
            width = abs(row.length("padwidth"))
            depth = abs(row.length("padhght")) if row.text("padhght") else width
            x, y = (row.length(each) if row.text(each) else 0.0 for each in ("padxoff", "padyoff"))
            pads[name] = Pad(x, y, width, depth or width, 0.0, row.text("padshape1").upper() == "CIRCLE")
    return pads, drills


def _placed(row: _Row) -> PlacedPart:
    side: Side = "bottom" if row.text("symmirror").upper().startswith("Y") else "top"
    part = row.text("comppartnumber", "comppart")
    return PlacedPart(row.text("refdes"), _HERE, side, part, row.text("compvalue"))


def _package(
    row: _Row,
    pins: Sequence[_Row],
    drawings: Mapping[str, Mapping[str, Sequence[Points2]]],
    pads: Mapping[str, Pad],
    drills_mm: Mapping[str, float],
) -> PackageShape:
    """Package of one component, where it lies on the board."""
    lands: list[Land] = []
    for pin in pins:
        x, y = pin.point("pinx", "piny").tolist()
        stack = pin.text("padstackname")
        pad, pose = pads.get(stack, Pad(0.0, 0.0, 0.0, 0.0)), Pose(x, y, pin.angle("pinrotation"))
        at = pose.place(np.array([pad.x_mm, pad.y_mm])).tolist()
        copper = Pad(at[0], at[1], pad.length_mm, pad.width_mm, pose.turn(0.0), pad.round)
        lands.append(Land(pin.text("pinnumber", "pinname"), copper, drills_mm.get(stack, 0.0) <= 0.0))
    own = drawings.get(row.text("refdes"), {})
    outlines = (enclosed(own[kind]) for kind in _BODIES if kind in own)
    height = row.text("compheight", "symheight", "packageheightmax")
    bare = number_within(height, FARTHEST_MM, row.view.scale_mm)
    stated = length_in(height) if math.isnan(bare) else bare
    return PackageShape(
        row.text("symname"),
        next((each for each in outlines if each is not None), None),
        tuple(lands),
        len({land.number for land in lands}) or None,
        stated or None,
        row.text("compdevicelabel", "compdevicetype"),
    )
