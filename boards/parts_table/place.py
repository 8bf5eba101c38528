"""Bodies of a board that is known by its Gerber files, placed by tables and by the pads that are around their places.

Pads are named by attributes of the layers or by a netlist; else those that lie around a row's place are its part's.
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import shapely
from scipy.spatial import KDTree
from shapely import Polygon

from boards.board import Body, Pad, Side
from boards.bounds import check_crowds
from boards.formats.gerber.gerber import WORDS, GerberBoard, read_gerber
from boards.formats.layout import LayoutPart, build_bodies, evidence_of
from boards.formats.names import listed
from boards.formats.placed import LEAST_PAD_MM, Pose
from boards.packages.families import header_size, package_family, plan_size
from boards.packages.undersides import underside_family
from boards.parts_table.copper import FEWEST_PINS, find_copper, find_hits, lay_rows, middle_of
from boards.parts_table.fit import fit_points
from boards.parts_table.netlist import Netlist
from boards.parts_table.read import Row
from boards.parts_table.tables import (
    Reference,
    Statements,
    files_of,
    join_tables,
    not_fitted,
    not_on_board,
    spread_rows,
)
from boards.parts_table.turns import TurnedPart, Turns, judge_turns
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import (
    PART_WITHOUT_GEOMETRY,
    PARTS_FRAME,
    PARTS_NOT_IN_TABLE,
    PARTS_POSITION,
    REPEATED_NAME,
)

_LEAST_MM = 0.01
_NAMED_MM = 0.3
"""A place of a netlist and the pad that it names are as near."""
_REPEATED = 0.8
"""Part of the designators that a panel repeats."""


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
        BoardError: The files cannot be read.
    """
    board = read_gerber(path)
    board, taken = find_copper(board, [row for table in given.tables for row in table.rows])
    given.others[:0] = board.layers if len(board.layers) > 1 else ()
    given.contradictions.extend(board.contradictions)
    board, named = _name_pads(board, given)
    board, copies = _split_copies(board)
    centres = {name.casefold(): middle_of([pad for _, pad, *_ in pads]) for name, pads in board.pads.items()}
    x0, y0, x1, y1 = board.outline.bounds
    hits = None if board.pads or not any(board.unnamed.values()) else partial(find_hits, board)
    stated, noticed = join_tables(given, Reference(centres, np.array([[x0, y0], [x1, y1]]), hits))
    check_crowds([row.xy_mm for row in stated if row.xy_mm is not None], given.tables[0].file if given.tables else None)
    loose = {name.casefold(): name for name in board.pads}
    stated = tuple(
        row if (name := loose.get(row.ref.casefold(), row.ref)) == row.ref else replace(row, ref=name) for row in stated
    )
    repeated = [ref for ref, count in Counter(row.ref for row in stated).items() if count > 1]
    stated = spread_rows(stated, copies)
    fitted = [row for row in stated if row.is_fitted]
    rows, pads, laid = lay_rows(fitted, board, given)
    omitted = [row for row in stated if not row.is_fitted]
    known = {row.ref for row in stated}
    others = [name for name in board.pads if name not in known]
    turned = [
        TurnedPart(row, side, tuple((pin, pad) for pin, pad, *_ in own), math.radians(row.turn_deg))
        for row in rows
        if row.turn_deg is not None
        for side, own in [_own_pads(row, pads.get(row.ref, ()))]
        if own
    ]
    turns, settled = judge_turns(turned, given, _area)
    notes = board.notes
    found: list[LayoutPart] = []
    unknown: list[str] = []
    lost: list[str] = []
    for row in (*rows, *(Row(0, name) for name in others)):
        own = pads.get(row.ref, ())
        part = _placed_part(row, own, turns)
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
        *board.findings,
        *taken,
        *named,
        *noticed,
        *laid,
        *settled,
        *findings,
        *listed(REPEATED_NAME, repeated, "designators are placed more than once: {}. Later ones were renamed."),
        *listed(PART_WITHOUT_GEOMETRY, unknown, text),
        *not_fitted(omitted, [row.ref for row in omitted]),
        *not_on_board(lost, stated),
        *listed(PARTS_NOT_IN_TABLE, others if stated else [], f"components are not in {files_of(stated)}: {{}}."),
    )


def _split_copies(board: GerberBoard) -> tuple[GerberBoard, dict[str, list[str]]]:
    """Split the pads of designators that a panel repeats: most of them, with each of their pins equally often.

    Returns:
        The board, and the names of the copies by designator, in the order of their places.
    """
    spots = {name: {(pin, round(pad.x_mm, 3), round(pad.y_mm, 3)) for pin, pad, *_ in own} for name, own in
             board.pads.items()}  # fmt: skip
    counts = {name: {*Counter(pin for pin, *_ in own).values()} for name, own in spots.items()}
    usual = Counter(min(each) for each in counts.values() if len(each) == 1).most_common(1)
    count, members = usual[0] if usual else (0, 0)
    if count < FEWEST_PINS or members < FEWEST_PINS or members < _REPEATED * len(counts):
        return board, {}
    pads: dict[str, tuple[tuple[str, Pad, Side, bool], ...]] = {}
    copies: dict[str, list[str]] = {}
    for name, own in board.pads.items():
        first = min(pin for pin, *_ in own)
        starts = sorted((x, y) for pin, x, y in spots[name] if pin == first)
        nearest = np.asarray(KDTree(starts).query([(pad.x_mm, pad.y_mm) for _, pad, *_ in own])[1]).tolist()
        split = [tuple(each for each, at in zip(own, nearest, strict=True) if at == place) for place in range(count)]
        if counts[name] == {count} and len({frozenset(pin for pin, *_ in each) for each in split}) == 1:
            copies[name.casefold()] = [name, *(f"{name}-{n}" for n in range(2, count + 1))]
            pads |= dict(zip(copies[name.casefold()], split, strict=True))
        else:
            pads[name] = own
    return replace(board, pads=pads), copies


def _name_pads(board: GerberBoard, given: Statements) -> tuple[GerberBoard, list[Finding]]:
    """Name bare pads by the netlists whose places lie on them."""
    notes: list[Finding] = []
    for netlist in given.netlists:
        bare = [(pad, side, flat) for side, pads in board.unnamed.items() for pad, flat in pads]
        if not bare or not netlist.pads:
            continue
        spots = np.array([(pad.x_mm, pad.y_mm) for pad, *_ in bare])
        at = np.array([(pad.x_mm, pad.y_mm) for pad in netlist.pads])
        fit = fit_points(at, np.unique(spots, axis=0))
        at = at if fit is None else fit.apply(at)
        if fit is not None and (words := fit.describe()):
            notes.append(Finding(PARTS_FRAME, f"The places in {netlist.file.name} were {words} to fit the copper."))
        board, lost = _named_by(board, netlist, at, given)
        text = f"pads that {netlist.file.name} names have no copper: {{}}. Is it of this revision?"
        notes += listed(PARTS_POSITION, lost, text)
    return board, notes


def _named_by(board: GerberBoard, netlist: Netlist, at: Points2, given: Statements) -> tuple[GerberBoard, list[str]]:
    """Name the pads at the places of a netlist; and the pins at whose places none is."""
    refs = netlist.names(row.ref for table in given.tables for row in table.rows)
    named = {name: list(pads) for name, pads in board.pads.items()}
    rest: dict[Side, tuple[tuple[Pad, bool], ...]] = {}
    hit: set[int] = set()
    for side, pads in board.unnamed.items():
        here = [number for number, each in enumerate(netlist.pads) if each.side in (side, None)]
        taken: set[int] = set()
        if here and pads:
            tree = KDTree([(pad.x_mm, pad.y_mm) for pad, _ in pads])
            far, nearest = (np.asarray(each).tolist() for each in tree.query(at[here]))
            for number, mm, place in zip(here, far, nearest, strict=True):
                if mm <= _NAMED_MM and place not in taken:
                    each, (pad, flat) = netlist.pads[number], pads[place]
                    named.setdefault(refs[each.ref], []).append((each.pin, pad, side, flat and each.side is not None))
                    taken.add(place)
                    hit.add(number)
        rest[side] = tuple(each for place, each in enumerate(pads) if place not in taken)
    lost = [f"{each.ref}-{each.pin}" for number, each in enumerate(netlist.pads) if number not in hit]
    return replace(board, pads={name: tuple(pads) for name, pads in named.items()}, unnamed=rest), lost


def _own_pads(row: Row, pads: Sequence[tuple[str, Pad, Side, bool]]) -> tuple[Side, list[tuple[str, Pad, Side, bool]]]:
    """Side of a part, and its pads that count there."""
    stated = [each for _, _, each, flat in pads if flat]
    side = row.side or ("bottom" if stated and all(each == "bottom" for each in stated) else "top")
    return side, [pad for pad in pads if pad[2] == side or not pad[3]]


def _area(part: TurnedPart, turn_rad: float) -> float:
    """Box around body and pads of a part, mm²; 0 where nothing has an area."""
    outline, _ = _outline(
        part.row, [pad for _, pad in part.pads], _centre(part.row, [pad for _, pad in part.pads]), turn_rad
    )
    return 0.0 if outline is None else outline.area


def _centre(row: Row, pads: Sequence[Pad]) -> Points2:
    return np.array(row.xy_mm) if row.xy_mm is not None else np.mean([[pad.x_mm, pad.y_mm] for pad in pads], axis=0)


def _placed_part(row: Row, pads: Sequence[tuple[str, Pad, Side, bool]], turns: Turns) -> LayoutPart | None:
    family = package_family(row.package)
    if (family is not None and not family.has_body) or (not pads and row.xy_mm is None):
        return None
    if family is None and len(pads) == 1:  # copper alone: a test point or a fiducial
        return None
    side, here = _own_pads(row, pads)
    own = [pad for _, pad, *_ in here]
    centre = _centre(row, own)
    stated = turns.turn_rad(row, side)
    turn = stated if stated is not None else own[0].turn_rad if own else 0.0
    outline, from_pads = _outline(row, own, centre, turn)
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


def _outline(row: Row, pads: Sequence[Pad], centre: Points2, turn: float) -> tuple[Polygon | None, bool]:
    """Body in the turned frame about the part's place, and whether it is only the box around its pads."""
    family = underside_family(package_family(row.package))
    stated = plan_size(row.package)
    around = _box(pads, centre, turn) if pads else None
    if stated is None and family.body_mm is not None:
        stated = family.body_mm
        if family.joints == "outside" and len(pads) > FEWEST_PINS:
            stated = _between_leads(stated, pads, centre, turn)
    if stated is None and around is not None and (sides := header_size(row.package)) is not None:
        width, depth = np.ptp(around, axis=0)
        stated = sides if depth > width else (sides[1], sides[0])
    if stated is None:
        is_wide = around is not None and bool(np.ptp(around, axis=0).min() > _LEAST_MM)
        return (_rectangle(around) if around is not None and is_wide else None), True
    half = np.array(stated) / 2.0
    middle = np.zeros(2) if around is None else around.mean(axis=0)
    body = np.array([middle - half, middle + half])
    if around is not None:
        body = np.array([np.minimum(body[0], around[0]), np.maximum(body[1], around[1])])
    return _rectangle(body), False


def _between_leads(size: tuple[float, float], pads: Sequence[Pad], centre: Points2, turn: float) -> tuple[float, float]:
    """Length and width of a body in the order in which it lies on fewer pads: leads stand beside it."""
    own = Pose(float(centre[0]), float(centre[1]), turn)
    spots = (np.array([(pad.x_mm, pad.y_mm) for pad in pads]) - centre) @ own.matrix()
    spots -= (spots.min(axis=0) + spots.max(axis=0)) / 2.0
    return min(
        (size, (size[1], size[0])), key=lambda each: int((np.abs(spots) <= np.array(each) / 2.0).all(axis=1).sum())
    )


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
