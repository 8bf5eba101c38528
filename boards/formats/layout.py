"""Boards from layout files, which draw the edge and the outlines of parts and state no heights: KiCad and Eagle."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon

from boards.board import NOMINAL_HEIGHT, SCORES, UNFITTED, Body, Pad, Side
from boards.errors import BoardError
from boards.formats.loops import CHAIN_MM, Point2, chain, close_chains, enclosed, find_scores, outline_of
from boards.formats.names import distinct_names, listed
from boards.formats.prism import prism
from boards.packages.heights import BodyHeight, HeightEvidence, checked_height, length_in
from boards.packages.undersides import gap_height
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import (
    DOUBTFUL_HEIGHT,
    EDGE_GAP,
    EDGE_LAYERS,
    NO_BODY,
    OPEN_EDGE,
    OUTLINE_FROM_PADS,
)

CORRECT_HEIGHTS = (
    "State how high they are: heights_mm in columns.yaml beside the board, or a height column in a parts table."
)

THICKNESS_MM = 1.6
"""Of a board whose file states none."""

_THINNEST_MM, THICKEST_MM = 0.1, 10.0


@dataclass(frozen=True, slots=True, eq=False)
class LayoutPart:
    """A placed part. Board frame, mm, as seen from the top."""

    name: str
    outline: Polygon | MultiPolygon
    side: Side
    evidence: HeightEvidence
    from_pads: bool = False
    """Whether the outline is only the box around the pads."""
    part: str = ""
    value: str = ""
    pins: int | None = None
    pads: tuple[Pad, ...] = ()
    stated_height_mm: float | None = None
    """From a property of the part, if it has one."""
    gap_height_mm: float | None = None
    """Between the board and the underside of the body, if the file states it."""


def spot_mm(point: Point2) -> str:
    """Describe a point in a message."""
    return f"x {point[0]:z.3f}, y {point[1]:z.3f} mm"


@dataclass(frozen=True, slots=True)
class LayoutWords:
    """How a program calls what the messages are about."""

    program: str
    edge: str
    """Layer of the board's edge."""
    drawing: str
    """Layer in which the outline of a body is drawn."""
    spot: Callable[[Point2], str] = spot_mm
    """Describes a point as the program shows it."""
    box: str = "pads"
    """What the box around is taken for a body of which nothing closed is drawn."""


def first_thickness(stated_mm: Iterable[float]) -> float:
    """First thickness that a board can have, mm; 1.6 mm without one."""
    return next((each for each in stated_mm if _THINNEST_MM <= each <= THICKEST_MM), THICKNESS_MM)


def evidence_of(
    outline: Polygon | MultiPolygon,
    package: str,
    reference: str,
    through_hole: bool,
    description: str,
    models: tuple[str, ...] = (),
) -> HeightEvidence:
    """What is known of the height of a body, whose outline is in the frame of its package."""
    x0, y0, x1, y1 = outline.bounds
    return HeightEvidence(package, reference, models, description, through_hole, max(x1 - x0, y1 - y0))


_HEIGHT_KEYS = (
    "height",
    "heightmm",
    "maximumpackageheight",
    "maxheight",
    "packageheight",
    "bodyheight",
    "componentheight",
)
_PART_KEYS = (
    *("mpn", "manufacturerpartnumber", "mfrpartnumber", "mfgpartnumber", "mfrpn", "partnumber", "manufacturerpn", "pn"),
    *("part", "prodid"),
)


def plain_key(key: str) -> str:
    """Reduce the name of a part's property to what counts in it: small letters and digits."""
    return re.sub(r"[^a-z0-9]", "", key.lower())


def part_number(properties: Mapping[str, str]) -> str:
    """Maker's part number among a part's properties, whose keys are in lower case without marks; empty if none."""
    return next((text for key in _PART_KEYS if (text := properties.get(key, "").strip())), "")


def stated_height(properties: Mapping[str, str]) -> float | None:
    """Height among the properties of a part, mm, as the footprints of part suppliers bring it along."""
    lengths = (length_in(properties.get(key, "")) for key in _HEIGHT_KEYS)
    return next((length for length in lengths if length is not None), None)


@dataclass(slots=True)
class LayoutNotes:
    """Names for the findings, as they are met."""

    left_out: list[str] = field(default_factory=list[str])
    not_fitted: list[str] = field(default_factory=list[str])
    """Of those: the ones that the file states not to be fitted."""
    opened: list[str] = field(default_factory=list[str])
    gaps: list[str] = field(default_factory=list[str])
    edges: list[str] = field(default_factory=list[str])
    lines: list[Points2] = field(default_factory=list[Points2])
    """What may score the board: open lines of its edge, and lines of layers that are neither copper nor print."""


@dataclass(frozen=True, slots=True, eq=False)
class EdgeDrawing:
    """What is drawn on the layer of the edge, and what sets the edge apart from other loops. mm."""

    lines: Sequence[Points2]
    """Polylines ``(n, 2)``."""
    drills: Sequence[Points2] = ()
    """Loops of drilled holes and slots."""
    pens_mm: Sequence[float] = ()
    """Widths of its lines, as far as they are stated."""
    holds: Points2 | None = None
    """Places ``(n, 2)`` of what is soldered to the board; ``None`` where it is not known."""


def read_outline(edge: EdgeDrawing, file: Path, words: LayoutWords, notes: LayoutNotes) -> Polygon | MultiPolygon:
    """Chain what is drawn on the layer of the edge into the board's outline.

    Gaps that the finest pen covers, or of a mil, are closed and noted. Lines that enclose nothing are noted where the
    edge is closed without them: breaking and scoring lines in it, dimensions beside it.

    Raises:
        BoardError: The edge is missing, open or crosses itself.
    """
    loops, opened = chain(edge.lines)
    closed, rest = close_chains(opened, min((pen for pen in edge.pens_mm if pen > 0.0), default=0.0))
    if closed:
        notes.gaps += [words.spot(loop[0]) for loop in closed]
        loops, opened = [*loops, *closed], rest
    crossed = enclosed(opened)
    if crossed is not None and all(crossed.buffer(CHAIN_MM).covers(LineString(line)) for line in opened):
        # Lines that cross instead of meeting, such as the scores of a panel.
        notes.lines += opened
        rings = [piece.exterior for piece in shapely.get_parts(crossed).tolist() if isinstance(piece, Polygon)]
        loops, opened = [*loops, *(np.asarray(ring.coords)[:-1, :2] for ring in rings)], []
    if opened and not _is_closed_without(opened, loops, edge.holds):
        more = f" and in {len(opened) - 1} more places" if len(opened) > 1 else ""
        gap = f"is open between {words.spot(opened[0][0])} and {words.spot(opened[0][-1])}{more}"
        close = f"({words.program}'s coordinates). Close it within {CHAIN_MM:g} mm in {words.program}."
        raise BoardError(f"the board outline on {words.edge} {gap} {close}", file=file)
    notes.opened += [words.spot(line[0]) for line in opened]
    notes.lines += opened
    return outline_of(loops, edge.drills, file=file, spot=words.spot, holds=edge.holds)


def _is_closed_without(opened: Sequence[Points2], loops: Sequence[Points2], holds: Points2 | None) -> bool:
    """Whether loops are the edge without the open lines: these lie in the largest, or what is soldered lies in loops.

    Where nothing is known to be soldered, an open line that goes around the largest loop may be the edge itself.
    """
    polygons = [polygon for polygon in map(Polygon, loops) if polygon.is_valid]
    largest = max(polygons, key=lambda loop: round(loop.area, 4), default=None)
    if largest is None:
        return False
    inner, lines = largest.buffer(CHAIN_MM), [LineString(line) for line in opened]
    beside = [line for line in lines if not inner.covers(line)]
    if beside and holds is not None and len(holds):
        return 2 * int(shapely.contains_xy(shapely.union_all(polygons), holds).sum()) > len(holds)
    return not any(line.convex_hull.intersects(largest) for line in beside)


def build_bodies(
    outline: Polygon | MultiPolygon,
    thickness_mm: float,
    parts: Sequence[LayoutPart],
    words: LayoutWords,
    notes: LayoutNotes,
) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Stand the parts on the board, whose underside is z = 0, with their nominal heights.

    Returns:
        The board and its components in file order, and what was noticed.
    """
    names, renamed = distinct_names(
        [part.name for part in parts],
        [
            (*np.round([*part.outline.bounds, part.side == "top"], 3).tolist(), repr(replace(part, outline=Polygon())))
            for part in parts
        ],
    )
    checked = [checked_height(part.stated_height_mm, part.evidence) for part in parts]
    rows = list(zip(parts, names, checked, strict=True))
    scores = find_scores(outline, notes.lines, [part.outline for part in parts])
    drawn = ";".join(",".join(f"{mm:.4f}" for mm in line.ravel().tolist()) for line in scores)
    marks = ((SCORES, drawn), (UNFITTED, ";".join(notes.not_fitted)))
    board = Body("board", "board", *prism(outline, 0.0, thickness_mm), extra=tuple(each for each in marks if each[1]))
    bodies = (board, *(_stand(part, name, each.height, thickness_mm) for part, name, each in rows))
    doubtful = [f"{name} ({each.doubt})" for _, name, each in rows if each.doubt]
    noticed = (
        (NO_BODY, notes.left_out, "footprints without a body or not mounted are left out: {}."),
        (
            OPEN_EDGE,
            notes.opened,
            f"lines on {words.edge} enclose nothing and were left out; they start at {{}} ({words.program}'s "
            "coordinates). Close them if they are cut-outs.",
        ),
        (
            EDGE_LAYERS,
            notes.edges,
            "layers that are named like the board's edge draw within it and were left out: {}. "
            "Draw cut-outs on the layer of the edge.",
        ),
        (
            EDGE_GAP,
            notes.gaps,
            f"loops on {words.edge} were open by no more than their pen or a mil, and were closed; they start at {{}} "
            f"({words.program}'s coordinates).",
        ),
        (
            DOUBTFUL_HEIGHT,
            doubtful,
            "components have heights in the file that contradict their packages or were never measured: {}. "
            f"{CORRECT_HEIGHTS}",
        ),
        (
            OUTLINE_FROM_PADS,
            [name for part, name, _ in rows if part.from_pads],
            f"footprints have no closed drawing; the box around their {words.box} was taken for the body: {{}}. "
            f"Draw {words.drawing} where the body is larger.",
        ),
    )
    return bodies, (*renamed, *(finding for each in noticed for finding in listed(*each)))


def _stand(part: LayoutPart, name: str, height: BodyHeight, top_z_mm: float) -> Body:
    gap_mm = gap_height(part.evidence.package, part.gap_height_mm).nominal_mm or 0.0
    gap_mm = gap_mm if gap_mm < height.height_mm else 0.0
    low, high = (-height.height_mm, -gap_mm)
    if part.side == "top":
        low, high = top_z_mm + gap_mm, top_z_mm + height.height_mm
    return Body(
        name,
        "component",
        *prism(part.outline, low, high),
        package=part.evidence.package or None,
        part=part.part or None,
        value=part.value or None,
        pins=part.pins,
        side=part.side,
        gap_height_mm=part.gap_height_mm,
        extra=((NOMINAL_HEIGHT, height.reason),),
        pads=part.pads,
    )
