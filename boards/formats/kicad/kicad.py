"""KiCad boards, versions 5 to 9: ``.kicad_pcb``."""

import re
from collections.abc import Sequence
from pathlib import Path

from shapely import MultiPolygon, Polygon

from boards.board import Body
from boards.bounds import check_crowds
from boards.formats.kicad.footprint import (
    Footprint,
    body_outline,
    drill_loops,
    flat_pads,
    has_leads,
    is_copper,
    read_footprint,
)
from boards.formats.kicad.items import Item, drawn, read_items
from boards.formats.layout import THICKNESS_MM, LayoutNotes, LayoutPart, LayoutWords, build_bodies, read_outline
from boards.formats.loops import Point2
from boards.packages.families import package_family
from boards.packages.heights import HeightEvidence
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import KICAD_VERSION

_EDGE = "Edge.Cuts"
_FIRST_VERSION, _LAST_VERSION = 20160000, 20250300

_NO_PART = re.compile(
    r"fiducial|mounting_?hole|test_?(?:point|pad)|solder_?jumper|^sj(?:_|$)|net_?tie|logo|symbol_|svg2mod",
    re.IGNORECASE,
)
"""Names of footprints that are copper or print only, unless they name a family of packages."""

_VIRTUAL = frozenset({"virtual", "exclude_from_bom"})
"""Attributes of what is not bought: before version 6, and since."""


def _spot(point: Point2) -> str:
    """Describe a point as KiCad shows it, y down."""
    return f"x {point[0]:.3f}, y {-point[1] + 0.0:.3f} mm"


_WORDS = LayoutWords("KiCad", _EDGE, "F.Fab", _spot)


def read_kicad(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a KiCad board: outline, and one prism a component.

    KiCad's y points down; it is turned round (y = -y of KiCad) and the origin is kept, so that the frame is x right,
    y back, z up with the board's underside at z = 0, and positions agree with KiCad's own ``.pos`` files.
    A body's outline is the footprint's fabrication drawing, else its courtyard less 0.25 mm, else the box around its
    pads. Its height and the gap beneath it are nominal, from the names of the package and of its 3-D model: the body
    carries their source as ``x-height``, so that a parts table may replace them. ``gap_height_mm`` stays unknown, as
    KiCad does not state it. Pads that are soldered flat come along. Drilled holes and slots from 1 mm across are cut
    out of the board.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, or its outline is missing, open or crosses itself.
    """
    board, items = read_items(path)
    footprints = [read_footprint(item) for item in items if item.head in ("footprint", "module")]
    check_crowds([footprint.origin for footprint in footprints], path)
    general = next((item for item in items if item.head == "general"), None)
    thickness = None if general is None else general.first("thickness")
    thickness_mm = THICKNESS_MM if thickness is None else thickness.number(0)
    if thickness is not None and thickness_mm <= 0.0:
        raise thickness.error("the board's thickness must be above 0. Correct it in the board setup.")
    notes = LayoutNotes()
    edges, drills = _read_edges(items, footprints)
    outline = read_outline(edges, drills, path, _WORDS, notes)
    parts = [(part, *body_outline(part)) for part in footprints if _is_part(part, notes)]
    notes.left_out += [_name_of(part) for part, body, _ in parts if body is None]
    solid = [_part(part, body, source == "pads") for part, body, source in parts if body is not None]
    bodies, findings = build_bodies(outline, thickness_mm, solid, _WORDS, notes)
    return bodies, (*_version_findings(int(board.atoms[0]) if board.atoms else 0), *findings)


def _name_of(part: Footprint) -> str:
    return "".join(part.reference.split()) or part.package or "unnamed"


def _read_edges(items: Sequence[Item], footprints: Sequence[Footprint]) -> tuple[list[Points2], list[Points2]]:
    """Collect everything that is drawn on Edge.Cuts, footprints included, and the drilled holes."""
    edges = drawn(items, "gr_", _EDGE)
    drills: list[Points2] = []
    for footprint in footprints:
        edges.extend(footprint.place(line) for line in footprint.drawn(_EDGE))
        drills.extend(drill_loops(footprint))
    return edges, drills


def _is_part(part: Footprint, notes: LayoutNotes) -> bool:
    """Whether a footprint carries a body; what does not is noted."""
    family = package_family(part.package)
    flat = family is not None and not family.has_body
    bare = not part.pads and not part.is_drawn
    # Real connectors are marked virtual, too: what has two pins or more stays in the nozzle's way.
    virtual = family is None and (part.pins or 0) < 2 and bool(part.attributes & _VIRTUAL)
    copper = family is None and (is_copper(part) or _NO_PART.search(part.package) is not None)
    if flat or bare or virtual or copper or "dnp" in part.attributes:
        notes.left_out.append(_name_of(part))
        return False
    return True


def _part(part: Footprint, outline: Polygon | MultiPolygon, from_pads: bool) -> LayoutPart:
    x0, y0, x1, y1 = outline.bounds
    evidence = HeightEvidence(
        part.package, part.reference, part.models, part.description, has_leads(part), max(x1 - x0, y1 - y0)
    )
    return LayoutPart(
        _name_of(part),
        part.place_outline(outline),
        part.side,
        evidence,
        from_pads,
        part=part.part,
        value=part.value,
        pins=part.pins,
        pads=flat_pads(part),
        stated_height_mm=part.stated_height_mm,
    )


def _version_findings(version: int) -> list[Finding]:
    if _FIRST_VERSION <= version <= _LAST_VERSION:
        return []
    known = "versions 5 to 9 of KiCad are known"
    return [Finding(KICAD_VERSION, f"The file is of format version {version}; {known}. Check what was read.")]
