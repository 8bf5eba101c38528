"""IDF 3.0 and 2.0: a board file (``.emn``) and its library of outlines (``.emp``)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, Polygon

from boards.board import NOMINAL_HEIGHT, Body, Side
from boards.bounds import check_crowds
from boards.errors import BoardError, read_bytes
from boards.formats.idf.text import Record, Section, read_loops, read_sections, spot_mm, unit_mm
from boards.formats.layout import CORRECT_HEIGHTS
from boards.formats.loops import DRILL_MM, outline_of, slot
from boards.formats.names import distinct_names, listed, some
from boards.formats.placed import Pose
from boards.formats.prism import prism
from boards.packages.families import is_bare
from boards.packages.heights import CheckedHeight, HeightEvidence, checked_height
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import DOUBTFUL_HEIGHT, IDF_UNPLACED, NO_BODY, SMALL_DRILLS

_PARTNERS = {"board": (".emn", ".brd", ".idb", ".bdf", ".idf"), "library": (".emp", ".lib", ".idl", ".ldf", ".pro")}


@dataclass(frozen=True, slots=True, eq=False)
class Package:
    """One outline of the library."""

    head: Record
    name: str
    part: str
    ring: Points2
    """Open ring, mm, about the package's own origin."""
    height_mm: float


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


def is_idf(path: Path) -> bool:
    """Whether a file of Eagle's suffix is the board file of an IDF, as some tools call theirs."""
    return read_bytes(path)[:200].lstrip(b"\xef\xbb\xbf \t\r\n").upper().startswith(b".HEADER")


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
    sections, library = _read_files(path)
    scale_mm = _read_header(sections[0])
    edge = next((section for section in sections if section.name == "BOARD_OUTLINE"), None)
    if edge is None:
        where = sections[0].opening.file
        raise BoardError("there is no .BOARD_OUTLINE section. Export the board, not the panel.", file=where)
    drills = [
        tuple(record.length(place, name, scale_mm) for place, name in enumerate(("hole diameter", "x", "y")))
        for section in sections
        if section.name == "DRILLED_HOLES"
        for record in section.records
    ]
    outline, top_z = _read_board(edge, drills, scale_mm)
    placements = [item for section in sections if section.name == "PLACEMENT" for item in _read(section, scale_mm)]
    placed = [item for item in placements if item.placed]
    check_crowds([(item.x_mm, item.y_mm) for item in placed], path)
    packages = _find_packages([(item.first, item.package, item.part) for item in placed], library)
    found = list(zip(placed, packages, strict=True))
    flat = [is_bare([package.name, package.part], item.refdes, 0, package.height_mm) for item, package in found]
    stand = [each for each, bare in zip(found, flat, strict=True) if not bare]
    bodies = [Body("board", "board", *prism(outline, 0.0, top_z))]
    # A mechanical part has no reference designator and is called after its package.
    unnamed = ("NOREFDES", "BOARD")
    names, renamed = distinct_names(
        [item.package if item.refdes.upper() in unnamed else item.refdes for item, _ in stand],
        [(item.x_mm, item.y_mm, item.side == "top", item.rotation_rad, item.package, item.part) for item, _ in stand],
    )
    heights = [_seated_height(package, item.refdes) for item, package in stand]
    rows = [(*each, name, height) for each, name, height in zip(stand, names, heights, strict=True)]
    bodies += [_place(item, package, height, name, top_z) for item, package, name, height in rows]
    small = sum(1 for diameter, _, _ in drills if diameter < DRILL_MM)
    text = f"{small} drilled holes below {DRILL_MM:g} mm are left out of the board's outline."
    return tuple(bodies), (
        *listed(
            DOUBTFUL_HEIGHT,
            [f"{name} ({each.doubt})" for *_, name, each in rows if each.doubt and each.height.source != "assumed"],
            "components have heights in the library that contradict their packages or were never measured: {}. "
            f"{CORRECT_HEIGHTS}",
        ),
        *renamed,
        *listed(
            IDF_UNPLACED,
            [item.refdes for item in placements if not item.placed],
            "components are not placed yet and left out: {}.",
        ),
        *listed(
            NO_BODY,
            [item.refdes for (item, _), bare in zip(found, flat, strict=True) if bare],
            "objects without a body are left out: {}.",
        ),
        *([Finding(SMALL_DRILLS, text)] if small else []),
    )


def _read_files(path: Path) -> tuple[tuple[Section, ...], Path | None]:
    """Read the sections of the board file and find the library; the header, not the suffix, states which was named."""
    sections = read_sections(path)
    sections[0].need(1)
    if sections[0].records[0].fields[0].upper() != "LIBRARY_FILE":
        return sections, _beside(path, _PARTNERS["library"])
    board = _beside(path, _PARTNERS["board"])
    if board is None:
        missing = f"the board file {path.stem}.emn is not beside it"
        raise BoardError(f"this is the library; {missing}. Put it there.", file=path)
    return read_sections(board), path


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


def _read_board(
    edge: Section, drills: Sequence[tuple[float, ...]], scale_mm: float
) -> tuple[Polygon | MultiPolygon, float]:
    """Read the outline, with drilled holes cut out, and the thickness, mm."""
    edge.need(2)
    thickness_mm = edge.records[0].length(0, "board thickness", scale_mm)
    if thickness_mm <= 0.0:
        raise edge.records[0].error("the board has no thickness. State it in the board outline.")
    loops = [ring for _, ring in read_loops(edge.records[1:], scale_mm)]
    along = loops[0][1] - loops[0][0]
    along = along / math.hypot(along[0], along[1])
    holes = [slot(np.array([x, y]), along, 0.0, diameter / 2.0) for diameter, x, y in drills if diameter >= DRILL_MM]
    return outline_of(loops, holes, file=edge.opening.file, spot=spot_mm), thickness_mm


def _read(section: Section, scale_mm: float) -> list[_Placement]:
    """Read placements: package, part, reference; then x, y, offset (not in IDF 2.0), rotation, side, status."""
    if len(section.records) % 2:
        raise section.records[-1].error("a placement has two lines; the second one is missing.")
    placements: list[_Placement] = []
    for first, second in zip(section.records[::2], section.records[1::2], strict=True):
        if len(first.fields) != 3:
            raise first.error("a placement begins with package, part number and reference designator; quote blanks.")
        if len(second.fields) not in (5, 6):
            raise second.error("the second line of a placement is x, y, offset, rotation, side and status.")
        late = len(second.fields) - 6
        side, status = second.fields[4 + late].upper(), second.fields[5 + late].upper()
        if side not in ("TOP", "BOTTOM"):
            raise second.error(f"the side is TOP or BOTTOM, not {side[:40]!r}.")
        placement = _Placement(
            first,
            *first.fields,
            x_mm=second.length(0, "x", scale_mm),
            y_mm=second.length(1, "y", scale_mm),
            offset_mm=second.length(2, "mounting offset", scale_mm) if late == 0 else 0.0,
            rotation_rad=second.angle(3 + late, "rotation"),
            side="top" if side == "TOP" else "bottom",
            placed=status != "UNPLACED",
        )
        placements.append(placement)
    return placements


def _place(item: _Placement, package: Package, checked: CheckedHeight, name: str, top_z_mm: float) -> Body:
    """Stand a package on its side of the board."""
    over = item.side == "bottom"
    pose = Pose(item.x_mm, item.y_mm, -item.rotation_rad if over else item.rotation_rad, over)
    surface_z_mm, up = (0.0, -1.0) if over else (top_z_mm, 1.0)
    # The offset lifts the whole package: its height is counted from its own underside.
    near, far = surface_z_mm + up * item.offset_mm, surface_z_mm + up * (item.offset_mm + checked.height.height_mm)
    return Body(
        name,
        "component",
        *prism(Polygon(pose.place(package.ring)), min(near, far), max(near, far)),
        package=package.name,
        part=item.part or None,
        side=item.side,
        gap_height_mm=item.offset_mm if item.offset_mm > 0.0 else None,
        extra=((NOMINAL_HEIGHT, checked.height.reason),) if checked.height.source != "stated" else (),
    )


def _seated_height(package: Package, reference: str) -> CheckedHeight:
    """Check the library's height against the sizes that the package's name, part number and family state.

    Raises:
        BoardError: There is no height, and nothing is known of the package.
    """
    x, y = np.ptp(package.ring, axis=0).tolist()
    evidence = HeightEvidence(package.name, reference, (package.part,), length_mm=max(x, y))
    checked = checked_height(package.height_mm, evidence)
    if package.height_mm < 0.0 or (package.height_mm == 0.0 and checked.height.source == "assumed"):
        raise package.head.error(f"package {package.name} has no height. State it in the library.")
    return checked


def _find_packages(placed: Sequence[tuple[Record, str, str]], library: Path | None) -> list[Package]:
    """Find the outline of each placement: by package and part number, else by package alone.

    Of several outlines of one package the highest is taken, to stay clear of it.

    Args:
        placed: Record of the placement, package and part number.
        library: The ``.emp``, if there is one.

    Raises:
        BoardError: There is no library, or a package is not in it.
    """
    if not placed:
        return []
    if library is None:
        record = placed[0][0]
        raise record.error(f"the library {record.file.stem}.emp is not beside the board file. Put it there.")
    sections = [each for each in read_sections(library) if each.name in ("ELECTRICAL", "MECHANICAL")]
    # The highest last, and of equal ones always the same, whatever their order in the file.
    packages = sorted(map(_read_package, sections), key=lambda each: (each.height_mm, each.part, each.ring.tolist()))
    exact = {(package.name, package.part): package for package in packages}
    loose = {package.name: package for package in packages}
    missing = [record for record, name, _ in placed if name not in loose]
    if missing:
        names = list(dict.fromkeys(record.fields[0] for record in missing))
        raise missing[0].error(f"not in the library {library.name}: {some(names)}. Export board and library together.")
    return [exact.get((name, part), loose[name]) for _, name, part in placed]


def _read_package(section: Section) -> Package:
    section.need(2)
    head = section.records[0]
    if len(head.fields) < 3:
        raise head.error("a package begins with its name, part number, unit and height.")
    scale_mm = unit_mm(head, 2)
    height_mm = head.length(3, f"height of package {head.fields[0]}", scale_mm)
    points = [record for record in section.records[1:] if record.fields[0].upper() != "PROP"]
    loops = read_loops(points, scale_mm)
    if not loops:
        raise head.error(f"package {head.fields[0]} has no outline.")
    ring = max((ring for _, ring in loops), key=lambda ring: round(Polygon(ring).area, 4))
    return Package(head, head.fields[0], head.fields[1], ring, height_mm)
