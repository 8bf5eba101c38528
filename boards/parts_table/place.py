"""Bodies of a board that is known by its Gerber files, placed by a table or by the pads that name their component."""

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import shapely
from shapely import Polygon

from boards.board import Body, Pad, Side
from boards.bounds import check_crowds
from boards.formats.gerber.gerber import WORDS, read_gerber
from boards.formats.layout import LayoutPart, build_bodies, evidence_of
from boards.formats.names import listed
from boards.formats.placed import LEAST_PAD_MM, Pose
from boards.packages.families import package_family, package_sizes
from boards.packages.undersides import underside_family
from boards.parts_table.copper import lay_rows, middle_of
from boards.parts_table.read import Row
from boards.parts_table.tables import NOT_FITTED, Reference, Statements, join_tables
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import (
    PART_WITHOUT_GEOMETRY,
    PARTS_NOT_FITTED,
    PARTS_NOT_IN_TABLE,
    PARTS_NOT_ON_BOARD,
)

_LEAST_MM = 0.01
_CROSSWISE = 0.8
"""A quarter turn that makes the box of body and pads as small is taken."""


def place_parts(path: Path, given: Statements) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read the Gerber files of a board and place parts on it.

    A part stands where a table places it, turned as the table states, or else where the pads are that name it. Its body
    is the box around its pads, those that name it or lie around its place, and around the sizes that its package's name
    states; a part of which neither is known is left out. Tables without places add what they state by designator.

    Args:
        path: A folder or an archive of the files, or the one of the profile.
        given: Tables and netlists; the layers are added to its files, and what contradicts the copper.

    Returns:
        The board and its components: those of the tables in their order, then the others; and what was noticed.

    Raises:
        BoardError: The files or a table cannot be read.
    """
    board = read_gerber(path)
    centres = {name.casefold(): middle_of([pad for _, pad, *_ in pads]) for name, pads in board.pads.items()}
    x0, y0, x1, y1 = board.outline.bounds
    given.others[:0] = board.layers if len(board.layers) > 1 else ()
    stated, noticed = join_tables(given, Reference(centres, np.array([[x0, y0], [x1, y1]])))
    check_crowds([row.xy_mm for row in stated if row.xy_mm is not None], given.tables[0].file if given.tables else None)
    loose = {name.casefold(): name for name in board.pads}
    stated = tuple(replace(row, ref=loose.get(row.ref.casefold(), row.ref)) for row in stated)
    fitted = [row for row in stated if row.is_fitted]
    rows, pads, laid = lay_rows(fitted, board)
    omitted = [row.ref for row in stated if not row.is_fitted]
    known = {row.ref for row in stated}
    others = [name for name in board.pads if name not in known]
    notes = board.notes
    found: list[LayoutPart] = []
    unknown: list[str] = []
    lost: list[str] = []
    for row in (*rows, *(Row(0, name) for name in others)):
        own = pads.get(row.ref, ())
        part = _placed_part(row, own, given)
        if part is not None:
            found.append(part)
        elif row.xy_mm is None and not own:
            lost.append(row.ref)
        elif row.line:
            # A part without an outline has a body, or is a fiducial, a hole or a test point.
            family = package_family(row.package)
            has_body = family.has_body if family is not None else len(own) != 1
            (unknown if has_body else notes.left_out).append(row.ref)
    bodies, findings = build_bodies(board.outline, board.thickness_mm, found, WORDS, notes)
    text = (
        "parts of the table have neither pads in the copper layers nor a size in their package's name and are missing: "
        "{}. Name the folder of all Gerber files, written with X2 attributes."
    )
    return bodies, (
        *noticed,
        *laid,
        *findings,
        *listed(PART_WITHOUT_GEOMETRY, unknown, text),
        *listed(PARTS_NOT_FITTED, omitted, NOT_FITTED),
        *listed(PARTS_NOT_ON_BOARD, lost, "rows of the parts table are not on the board: {}."),
        *listed(PARTS_NOT_IN_TABLE, others if stated else [], "components are not in the parts table: {}."),
    )


def _placed_part(row: Row, pads: Sequence[tuple[str, Pad, Side, bool]], given: Statements) -> LayoutPart | None:
    family = package_family(row.package)
    if (family is not None and not family.has_body) or (not pads and row.xy_mm is None):
        return None
    if family is None and len(pads) == 1:  # copper alone: a test point or a fiducial
        return None
    stated = [each for _, _, each, flat in pads if flat]
    side = row.side or ("bottom" if stated and all(each == "bottom" for each in stated) else "top")
    own = [pad for _, pad, each, flat in pads if each == side or not flat]
    centre = np.array(row.xy_mm) if row.xy_mm is not None else np.mean([[pad.x_mm, pad.y_mm] for pad in own], axis=0)
    turn = _turn(row, side, own)
    outline, from_pads = _outline(row, own, centre, turn)
    crosswise = _outline(row, own, centre, turn + math.pi / 2.0)[0] if row.turn_deg is not None and own else None
    if outline is not None and crosswise is not None and crosswise.area < _CROSSWISE * outline.area:
        # The body lies across its pads: programs and libraries differ in what they call no turn.
        taken = f"{round(math.degrees(turn) + 90.0) % 180} degrees"
        given.contradict(row, "turn", (taken, "copper"), (f"{row.turn_deg:g} degrees", row.source("turn_deg")))
        outline, turn = crosswise, turn + math.pi / 2.0
    if outline is None:
        return None
    flat_pads = [
        pad for _, pad, each, flat in pads if flat and each == side and min(pad.length_mm, pad.width_mm) > LEAST_PAD_MM
    ]
    through = any(not flat for _, _, _, flat in pads) if pads else True
    return LayoutPart(
        row.ref,
        Pose(float(centre[0]), float(centre[1]), turn).place_outline(outline),
        side,
        evidence_of(outline, row.package, row.ref, through, ""),
        from_pads,
        part=row.part,
        value=row.value,
        pins=row.pins if row.pins is not None else len({pin for pin, *_ in pads if pin}) or None,
        pads=tuple(flat_pads),
        stated_height_mm=row.height_mm or None,
        gap_height_mm=row.gap_height_mm,
    )


def _turn(row: Row, side: Side, pads: Sequence[Pad]) -> float:
    """Turn of the part as seen from the top: programs state that of the bottom from either side.

    Where pads are known, it is the one of the two by which the box around them is smaller.
    """
    stated = math.radians(row.turn_deg) if row.turn_deg is not None else (pads[0].turn_rad if pads else 0.0)
    if side == "top" or not pads:
        return stated
    return min(
        (stated, -stated), key=lambda turn: round(float(np.prod(np.ptp(_box(pads, np.zeros(2), turn), axis=0))), 4)
    )


def _outline(row: Row, pads: Sequence[Pad], centre: Points2, turn: float) -> tuple[Polygon | None, bool]:
    """Body in the turned frame about the part's place, and whether it is only the box around its pads."""
    stated = package_sizes(row.package).body_mm or underside_family(package_family(row.package)).body_mm
    around = _box(pads, centre, turn) if pads else None
    if stated is None:
        is_wide = around is not None and bool(np.ptp(around, axis=0).min() > _LEAST_MM)
        return (_rectangle(around) if around is not None and is_wide else None), True
    half = np.array(stated) / 2.0
    middle = np.zeros(2) if around is None else around.mean(axis=0)
    body = np.array([middle - half, middle + half])
    if around is not None:
        body = np.array([np.minimum(body[0], around[0]), np.maximum(body[1], around[1])])
    return _rectangle(body), False


def _rectangle(corners: Points2) -> Polygon:
    (x0, y0), (x1, y1) = corners.tolist()
    return shapely.box(x0, y0, x1, y1)


def _box(pads: Sequence[Pad], centre: Points2, turn: float) -> Points2:
    """Least and largest corner (2, 2) around pads, in a frame that is turned about a point."""
    stated = np.array([[pad.x_mm, pad.y_mm, pad.length_mm, pad.width_mm, pad.turn_rad] for pad in pads])
    x, y = stated[:, 0] - centre[0], stated[:, 1] - centre[1]
    cos, sin = math.cos(turn), math.sin(turn)
    middles = np.column_stack([cos * x + sin * y, cos * y - sin * x])
    c, s = np.abs(np.cos(stated[:, 4] - turn)), np.abs(np.sin(stated[:, 4] - turn))
    length, width = stated[:, 2] / 2.0, stated[:, 3] / 2.0
    half = np.column_stack([c * length + s * width, s * length + c * width])
    return np.array([(middles - half).min(axis=0), (middles + half).max(axis=0)])
