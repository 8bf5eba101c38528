"""KiCad boards, versions 5 to 9: ``.kicad_pcb``."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from shapely import LineString, MultiPolygon, Polygon

from boards.board import Body
from boards.errors import BoardError
from boards.formats.kicad.footprint import Footprint, body_outline, drill_loops, flat_pads, is_copper, read_footprint
from boards.formats.kicad.items import Item, drawn, read_items
from boards.formats.loops import CHAIN_MM, Point2, chain, outline_of
from boards.formats.names import distinct_names, listed
from boards.formats.prism import NOMINAL_HEIGHT, prism
from boards.packages.families import package_family
from boards.packages.gap_height import gap_height
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import ASSUMED_HEIGHT, KICAD_VERSION, NO_BODY, OPEN_EDGE, OUTLINE_FROM_PADS

_EDGE = "Edge.Cuts"
_ASSUMED_MM = 3.0
"""Height of a part whose package no family knows: higher than most of what is soldered flat, and always reported."""

_FIRST_VERSION, _LAST_VERSION = 20160000, 20250300
_DEFAULT_THICKNESS_MM = 1.6

_NO_PART = re.compile(
    r"fiducial|mounting_?hole|test_?(?:point|pad)|solder_?jumper|^sj(?:_|$)|net_?tie|logo|symbol_|svg2mod",
    re.IGNORECASE,
)
"""Names of footprints that are copper or print only, unless they name a family of packages."""

_VIRTUAL = frozenset({"virtual", "exclude_from_bom"})
"""Attributes of what is not bought: before version 6, and since."""


@dataclass(slots=True)
class _Notes:
    """Names for the findings, as they are met."""

    left_out: list[str] = field(default_factory=list[str])
    assumed: list[str] = field(default_factory=list[str])
    from_pads: list[str] = field(default_factory=list[str])
    opened: list[str] = field(default_factory=list[str])
    renamed: list[Finding] = field(default_factory=list[Finding])


def read_kicad(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a KiCad board: outline, and one prism a component.

    KiCad's y points down; it is turned round (y = -y of KiCad) and the origin is kept, so that the frame is x right,
    y back, z up with the board's underside at z = 0, and positions agree with KiCad's own ``.pos`` files.
    A body's outline is the footprint's fabrication drawing, else its courtyard less 0.25 mm, else the box around its
    pads. Its height and the gap beneath it are nominal, from the package's name: the body carries them as
    ``x-height=nominal``, so that a parts table may replace them. ``gap_height_mm`` stays unknown, as KiCad does not
    state it. Pads that are soldered flat come along. Drilled holes and slots from 1 mm across are cut out of the board.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, or its outline is missing, open or crosses itself.
    """
    board, items = read_items(path)
    footprints = [read_footprint(item) for item in items if item.head in ("footprint", "module")]
    general = next((item for item in items if item.head == "general"), None)
    thickness = None if general is None else general.first("thickness")
    thickness_mm = _DEFAULT_THICKNESS_MM if thickness is None else thickness.number(0)
    if thickness is not None and thickness_mm <= 0.0:
        raise thickness.error("the board's thickness must be above 0. Correct it in the board setup.")
    notes = _Notes()
    bodies = [Body("board", "board", *prism(_read_outline(items, footprints, path, notes), 0.0, thickness_mm))]
    parts = [(part, *body_outline(part)) for part in footprints if _is_part(part, notes)]
    notes.left_out += [_name_of(part) for part, outline, _ in parts if outline is None]
    solid = [(part, outline, source) for part, outline, source in parts if outline is not None]
    names, notes.renamed = distinct_names([_name_of(part) for part, _, _ in solid])
    for (part, outline, source), name in zip(solid, names, strict=True):
        if source == "pads":
            notes.from_pads.append(name)
        bodies.append(_build_body(part, outline, name, thickness_mm, notes))
    return tuple(bodies), tuple(_findings(notes, int(board.atoms[0]) if board.atoms else 0))


def _name_of(part: Footprint) -> str:
    return "".join(part.reference.split()) or part.package or "unnamed"


def _read_outline(
    items: Sequence[Item], footprints: Sequence[Footprint], path: Path, notes: _Notes
) -> Polygon | MultiPolygon:
    """Chain everything that is drawn on Edge.Cuts, footprints included.

    Lines that enclose nothing are noted where a closed edge lies around them: breaking and scoring lines.
    """
    edges = drawn(items, "gr_", _EDGE)
    drills: list[Points2] = []
    for footprint in footprints:
        edges.extend(footprint.place(line) for line in footprint.drawn(_EDGE))
        drills.extend(drill_loops(footprint))
    loops, opened = chain(edges)
    largest = max((Polygon(loop) for loop in loops), key=lambda loop: round(loop.area, 4), default=Polygon())
    if opened and not (largest.is_valid and all(largest.buffer(CHAIN_MM).covers(LineString(line)) for line in opened)):
        more = f" and in {len(opened) - 1} more places" if len(opened) > 1 else ""
        gap = f"is open between {_spot(opened[0][0])} and {_spot(opened[0][-1])}{more} (KiCad's coordinates)"
        raise BoardError(f"the board outline on {_EDGE} {gap}. Close it within {CHAIN_MM:g} mm in KiCad.", file=path)
    notes.opened += [_spot(line[0]) for line in opened]
    return outline_of(loops, drills, file=path, spot=_spot)


def _spot(point: Point2) -> str:
    """Describe a point as KiCad shows it, y down."""
    return f"x {point[0]:.3f}, y {-point[1] + 0.0:.3f} mm"


def _is_part(part: Footprint, notes: _Notes) -> bool:
    """Whether a footprint carries a body; what does not is noted."""
    family = package_family(part.package)
    flat = family is not None and family.source == "no body"
    bare = not part.pads and not part.is_drawn
    # Real connectors are marked virtual, too: what has two pins or more stays in the nozzle's way.
    virtual = family is None and (part.pins or 0) < 2 and bool(part.attributes & _VIRTUAL)
    copper = family is None and (is_copper(part) or _NO_PART.search(part.package) is not None)
    if flat or bare or virtual or copper or "dnp" in part.attributes:
        notes.left_out.append(_name_of(part))
        return False
    return True


def _build_body(part: Footprint, outline: Polygon | MultiPolygon, name: str, top_z_mm: float, notes: _Notes) -> Body:
    """Stand a prism of nominal height on the part's side."""
    family = package_family(part.package)
    if family is None:
        notes.assumed.append(f"{name} ({part.package})")
    height_mm = _ASSUMED_MM if family is None else family.height_mm
    gap_mm = gap_height(part.package, None).nominal_mm or 0.0
    gap_mm = gap_mm if gap_mm < height_mm else 0.0
    low, high = (-height_mm, -gap_mm) if part.side == "bottom" else (top_z_mm + gap_mm, top_z_mm + height_mm)
    return Body(
        name,
        "component",
        *prism(part.place_outline(outline), low, high),
        package=part.package or None,
        part=part.part or None,
        value=part.value or None,
        pins=part.pins,
        side=part.side,
        extra=((NOMINAL_HEIGHT, "nominal"),),
        pads=flat_pads(part),
    )


def _findings(notes: _Notes, version: int) -> Iterator[Finding]:
    if not _FIRST_VERSION <= version <= _LAST_VERSION:
        known = "versions 5 to 9 of KiCad are known"
        yield Finding(KICAD_VERSION, f"The file is of format version {version}; {known}. Check what was read.")
    yield from notes.renamed
    yield from listed(NO_BODY, notes.left_out, "footprints without a body or not mounted are left out: {}.")
    text = f"lines on {_EDGE} enclose nothing and were left out; they start at {{}} (KiCad's coordinates). "
    yield from listed(OPEN_EDGE, notes.opened, f"{text}Close them if they are cut-outs.")
    text = f"components are of no known package family and were given a height of {_ASSUMED_MM:g} mm: {{}}. "
    yield from listed(ASSUMED_HEIGHT, notes.assumed, f"{text}Give a parts table with a height column.")
    text = "footprints have neither a fabrication drawing nor a courtyard; the box around their pads was taken for the "
    yield from listed(OUTLINE_FROM_PADS, notes.from_pads, f"{text}body: {{}}. Draw F.Fab where the body is larger.")
