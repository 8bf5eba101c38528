"""IDF 3.0 and 2.0: a board file (``.emn``) and its library of outlines (``.emp``)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, Polygon

from boards.board import Body, Side
from boards.errors import BoardError
from boards.formats.idf.idf_library import Package, find_packages
from boards.formats.idf.idf_text import Record, Section, read_loops, read_sections, spot_mm, unit_mm
from boards.formats.loops import DRILL_MM, outline_of, slot
from boards.formats.names import distinct_names, some
from boards.formats.prism import prism
from specs.finding import Finding
from specs.finding_rules import DOUBTFUL_HEIGHT, IDF_UNPLACED, NO_BODY, SMALL_DRILLS

_PARTNERS = {
    "board": (".emn", ".brd", ".idb", ".bdf", ".idf"),
    "library": (".emp", ".lib", ".idl", ".ldf", ".pro"),
}


@dataclass(frozen=True, slots=True)
class _Placement:
    """Two records of the board file."""

    first: Record
    package: str
    part: str
    refdes: str
    x_mm: float
    y_mm: float
    offset_mm: float
    rotation_rad: float
    side: Side
    placed: bool


def read_idf(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read an IDF board with the library beside it (same stem, any case); either of the two may be named.

    The frame is that of the file: x right, y back, seen from the top; the board's underside is z = 0, which IDF does
    not state. A component is the prism of its outline from its mounting offset to its height. On the bottom its
    outline is turned by its angle as seen from there and then mirrored about the y axis, as the exporters do.

    Drilled holes from 1 mm are cut out of the board; smaller ones, vias and the leads of parts, are left out.

    Args:
        path: The ``.emn`` or the ``.emp``.

    Returns:
        The board and the placed components in file order, and what was noticed.

    Raises:
        BoardError: A file is missing or broken, or a package has no height or is not in the library.
    """
    board_path, library_path = _pair(path)
    sections = read_sections(board_path)
    scale_mm = _read_header(sections[0])
    edge = [section for section in sections if section.name == "BOARD_OUTLINE"]
    if not edge:
        raise BoardError("there is no .BOARD_OUTLINE section. Export the board, not the panel.", file=board_path)
    board = _read_board(edge[0], sections, scale_mm)
    bottom_z, top_z = 0.0, _thickness_mm(edge[0], scale_mm)
    placements = [
        placement
        for section in sections
        if section.name == "PLACEMENT"
        for placement in _read_placements(section, scale_mm)
    ]
    placed = [item for item in placements if item.placed]
    packages = find_packages([(item.first, item.package, item.part) for item in placed], library_path)
    stand = [(item, package) for item, package in zip(placed, packages, strict=True) if not package.flat]
    patches, normals, surfaces = prism(board, bottom_z, top_z)
    bodies = [Body("board", "board", patches, normals, surfaces)]
    names, notes = distinct_names([_wish(item) for item, _ in stand])
    for (item, package), name in zip(stand, names, strict=True):
        bodies.append(_place(item, package, name, bottom_z if item.side == "bottom" else top_z))
    flat = [item.refdes for item, package in zip(placed, packages, strict=True) if package.flat]
    absent = [item.refdes for item in placements if not item.placed]
    high = [
        f"{name} ({package.height_mm:g} mm)"
        for (_, package), name in zip(stand, names, strict=True)
        if package.doubtful
    ]
    return tuple(bodies), (*_doubts(high), *notes, *_notes(absent, flat, _read_drills(sections, scale_mm)))


def _pair(path: Path) -> tuple[Path, Path | None]:
    """Find the other file; the header, not the suffix, says which of the two was named."""
    header = read_sections(path)[0]
    header.need(1)
    if header.records[0].fields[0].upper() == "LIBRARY_FILE":
        board = _beside(path, _PARTNERS["board"])
        if board is None:
            raise BoardError(
                f"this is the library; the board file {path.stem}.emn is not beside it. Put it there.", file=path
            )
        return board, path
    return path, _beside(path, _PARTNERS["library"])


def _beside(path: Path, suffixes: Sequence[str]) -> Path | None:
    twins = sorted(
        (suffixes.index(other.suffix.lower()), other.name, other)
        for other in path.parent.iterdir()
        if other.stem.lower() == path.stem.lower() and other.suffix.lower() in suffixes and other != path
    )
    return twins[0][2] if twins else None


def _read_header(header: Section) -> float:
    """Check kind and version; return the length of the file's unit, mm."""
    header.need(2)
    first, second = header.records[:2]
    if first.fields[0].upper() != "BOARD_FILE":
        raise first.error(f"a BOARD_FILE is needed, not {first.fields[0][:40]!r}. Export the board, not a panel.")
    if first.number(1, "version") not in (2.0, 3.0):
        raise first.error(f"version {first.fields[1]} is not read. Export as IDF 3.0.")
    return unit_mm(second, len(second.fields) - 1)


def _thickness_mm(edge: Section, scale_mm: float) -> float:
    edge.need(2)
    thickness_mm = edge.records[0].number(0, "board thickness") * scale_mm
    if thickness_mm <= 0.0:
        raise edge.records[0].error("the board has no thickness. State it in the board outline.")
    return thickness_mm


def _read_board(edge: Section, sections: Sequence[Section], scale_mm: float) -> Polygon | MultiPolygon:
    _thickness_mm(edge, scale_mm)
    loops = [ring for _, ring in read_loops(edge.records[1:], scale_mm)]
    along = loops[0][1] - loops[0][0]
    along = along / math.hypot(along[0], along[1])
    drills = [
        slot(np.array([x, y]), along, 0.0, diameter / 2.0)
        for diameter, x, y in _read_drills(sections, scale_mm)
        if diameter >= DRILL_MM
    ]
    return outline_of(loops, drills, file=edge.opening.file, spot=spot_mm)


def _read_drills(sections: Sequence[Section], scale_mm: float) -> list[tuple[float, float, float]]:
    """Diameter, x and y of every drilled hole, mm."""
    return [
        (
            record.number(0, "hole diameter") * scale_mm,
            record.number(1, "x") * scale_mm,
            record.number(2, "y") * scale_mm,
        )
        for section in sections
        if section.name == "DRILLED_HOLES"
        for record in section.records
    ]


def _read_placements(section: Section, scale_mm: float) -> list[_Placement]:
    if len(section.records) % 2:
        raise section.records[-1].error("a placement has two lines; the second one is missing.")
    return [
        _read_placement(first, second, scale_mm)
        for first, second in zip(section.records[::2], section.records[1::2], strict=True)
    ]


def _read_placement(first: Record, second: Record, scale_mm: float) -> _Placement:
    """Package, part, reference; then x, y, offset (not in IDF 2.0), rotation, side, status."""
    if len(first.fields) != 3:
        raise first.error("a placement begins with package, part number and reference designator; quote blanks.")
    if len(second.fields) not in (5, 6):
        raise second.error("the second line of a placement is x, y, offset, rotation, side and status.")
    late = len(second.fields) - 6
    offset_mm = second.number(2, "mounting offset") * scale_mm if late == 0 else 0.0
    side, status = second.fields[4 + late].upper(), second.fields[5 + late].upper()
    if side not in ("TOP", "BOTTOM"):
        raise second.error(f"the side is TOP or BOTTOM, not {side[:40]!r}.")
    return _Placement(
        first,
        *first.fields,
        second.number(0, "x") * scale_mm,
        second.number(1, "y") * scale_mm,
        offset_mm,
        math.radians(second.number(3 + late, "rotation")),
        "top" if side == "TOP" else "bottom",
        status != "UNPLACED",
    )


def _wish(item: _Placement) -> str:
    """Name of a component; a mechanical part has no reference designator and is called after its package."""
    return item.package if item.refdes.upper() in ("NOREFDES", "BOARD") else item.refdes


def _place(item: _Placement, package: Package, name: str, surface_z_mm: float) -> Body:
    """Stand a package on its side of the board."""
    cos, sin = math.cos(item.rotation_rad), math.sin(item.rotation_rad)
    ring = package.ring @ np.array([[cos, sin], [-sin, cos]])
    up = 1.0
    if item.side == "bottom":
        ring, up = ring * np.array([-1.0, 1.0]), -1.0
    # The offset lifts the whole package: its height is counted from its own underside.
    near, far = surface_z_mm + up * item.offset_mm, surface_z_mm + up * (item.offset_mm + package.height_mm)
    patches, normals, surfaces = prism(Polygon(ring + np.array([item.x_mm, item.y_mm])), min(near, far), max(near, far))
    return Body(
        name,
        "component",
        patches,
        normals,
        surfaces,
        package=package.name,
        part=item.part or None,
        side=item.side,
        gap_height_mm=item.offset_mm if item.offset_mm > 0.0 else None,
    )


def _doubts(high: Sequence[str]) -> list[Finding]:
    if not high:
        return []
    message = (
        f"{len(high)} components are far higher in the library than their packages are: {some(high)}. The library's "
        "heights were taken; correct them there, or the nozzle keeps far above the board."
    )
    return [Finding(DOUBTFUL_HEIGHT, message)]


def _notes(absent: Sequence[str], flat: Sequence[str], drills: Sequence[tuple[float, float, float]]) -> list[Finding]:
    """Say what was left out."""
    small = sum(1 for diameter, _, _ in drills if diameter < DRILL_MM)
    stated = (
        (IDF_UNPLACED, len(absent), f"components are not placed yet and left out: {some(absent)}."),
        (NO_BODY, len(flat), f"objects without a body are left out: {some(flat)}."),
        (SMALL_DRILLS, small, f"drilled holes below {DRILL_MM:g} mm are left out of the board's outline."),
    )
    return [Finding(rule, f"{count} {text}") for rule, count, text in stated if count]
