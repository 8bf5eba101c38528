"""Several boards in one file: beside each other, scored, on tabs, or repeated; each becomes an instance of a panel."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import shapely
import shapely.affinity
from scipy.spatial import KDTree
from shapely import MultiPoint, MultiPolygon, Polygon

from boards.board import SCORES, UNFITTED, Board, Body, Component, Instance
from boards.formats.loops import cells_of
from boards.formats.names import copy_marks, some
from boards.formats.prism import prism
from boards.panel import assemble, place_order, turned_over
from boards.understand import understand
from geometry.arrays import Points2
from geometry.polygons import polygons_of, project
from specs.finding import Finding
from specs.finding_rules import BOARD_IN_PIECES, PANEL_BOARDS, PANEL_FOUND, REPEATED_NAME

_TABS_MM = (1.0, 2.0, 3.2)
"""Half widths of what holds boards in a frame, the narrowest first."""
_HOLE_MM = 8.0
"""Smaller holes are no slots between boards."""
_SAME_MM = 0.1
"""Parts of two copies of a board lie upon each other within this."""
_SAME_OUTLINE = 0.05
"""Part of the area by which the outlines of two copies may differ."""
_FEWEST_ALIKE = 3
"""Parts that are placed alike on two pieces that tabs hold, and are named differently."""
_SHARED = 0.5
"""Part of the names that copies have in common at least."""
_FEWEST_SHARED = 2
"""Names that different boards of one panel have in common at least."""
_REPEATED = 0.8
"""Part of the components of a panel whose names are repeated."""
_LEAST_SHARE = 1.0 / 3.0
"""Part of the components of the fullest board that a piece has more than; others are rails with accessories."""


@dataclass(frozen=True, slots=True, eq=False)
class _Piece:
    """What may be one board."""

    outline: Polygon
    parts: tuple[Component, ...]
    own: tuple[str, ...]
    """Names of the parts on the board alone."""

    def spots(self) -> Points2:
        """Middles (n, 2) of the parts."""
        return np.array([each.outline.centroid.coords[0] for each in self.parts])


@dataclass(frozen=True, slots=True)
class _Cut:
    """One way to take material apart."""

    pieces: tuple[_Piece, ...]
    how: str
    needs: Literal["nothing", "copies", "statement"]
    """What shows that the pieces are boards: that they are there, that designators repeat or the pieces are alike, or
    nothing but a statement."""
    doubt: Literal["error", "warning"] | None
    """Severity where nothing shows that they are; ``None`` where they are one board then."""


def take_apart(board: Board, read: Sequence[Finding], stated: Literal["apart", "whole"] | None) -> Board:
    """Give the panel that a file with several boards is; the board itself where it is one, or nothing shows it.

    Boards are pieces of material apart from each other, or within scores or tabs where they carry the same parts or
    repeat designators. Gaps, rails and tabs are none, and what stands on them is an obstacle. Copies are one board:
    their components are called as those of the first, without what tools add to repeated names.

    Args:
        board: As it was read.
        read: What was noticed while reading.
        stated: What the columns file states.
    """
    if stated == "whole" or len(board.components) < 2:
        return board
    doubts: list[Finding] = []
    for cut in _cuts(board, is_stated=stated == "apart"):
        if stated == "apart" or cut.needs == "nothing" or (cut.needs == "copies" and _are_copies(cut.pieces)):
            return _panel(board, read, cut)
        if cut.doubt is not None and not doubts:
            count = len(cut.pieces)
            text = (
                f"Whether {board.name} is one board or a panel of {count} is open: {cut.how}. It is read as one board. "
                f"State `panel: apart` in columns.yaml beside it to have it read as {count} boards, or `panel: whole`."
            )
            doubts.append(Finding(PANEL_BOARDS, text, override=cut.doubt))
    if stated == "apart":
        text = f"`panel: apart` is stated, but {board.name} has no second piece that carries components."
        doubts = [Finding(PANEL_BOARDS, text, override="warning")]
    return replace(board, findings=(*doubts, *board.findings)) if doubts else board


def _cuts(board: Board, *, is_stated: bool) -> "Sequence[_Cut]":
    """Ways in which the material may be several boards, the surest first."""
    slab = next(body for body in board.bodies if body.role == "board")
    is_whole = not any(each.rule is BOARD_IN_PIECES for each in board.findings)
    material = [board.outline] if is_whole else polygons_of(project(slab.patches))
    found: list[_Cut] = []
    apart = _pieces(board, material, 0.0)
    if len(apart) > 1:
        return [_Cut(apart, "their outlines are apart from each other", needs="nothing", doubt=None)]
    whole = MultiPolygon(material)
    text = next((value for key, value in slab.extra if key == SCORES), "")
    lines = [np.array(line.split(","), dtype=np.float64).reshape(2, 2) for line in text.split(";") if line]
    scored = _pieces(board, cells_of(whole, lines)) if lines else ()
    if len(scored) > 1:
        found.append(_Cut(scored, "lines score it from edge to edge", needs="copies", doubt="error"))
    held = [cut for width_mm in _TABS_MM if (cut := _held_in_tabs(board, whole, width_mm)) is not None]
    found += sorted(held, key=lambda cut: cut.doubt is None)
    copies = _repeated(board, whole)
    if len(copies) > 1 and (is_stated or not found):
        found.append(
            _Cut(copies, "the file repeats its designators in the same pattern", needs="statement", doubt="error")
        )
    return found


def _held_in_tabs(board: Board, whole: MultiPolygon, half_mm: float) -> _Cut | None:
    """Pieces that are left of the material without what is narrower than tabs."""
    filled = (
        Polygon(each.exterior, [ring for ring in each.interiors if max(np.ptp(ring.coords, axis=0)) >= _HOLE_MM])
        for each in polygons_of(whole)
    )
    plain = shapely.simplify(MultiPolygon(list(filled)), 0.02)
    opened = plain.buffer(-half_mm, join_style="mitre").buffer(half_mm * 1.0001, join_style="mitre")
    pieces = _pieces(board, polygons_of(opened.intersection(plain)))
    if len(pieces) < 2:
        return None
    tabs = polygons_of(plain.difference(opened.buffer(1e-3)))
    met = shapely.STRtree([piece.outline for piece in pieces]).query(tabs, predicate="dwithin", distance=0.01)[1]
    counts = np.bincount(met, minlength=len(pieces))
    is_framed = bool((counts > 1).all())
    how = f"tabs narrower than {2.0 * half_mm:g} mm hold its pieces"
    return _Cut(pieces, how, needs="copies", doubt="warning" if is_framed else None)


def _pieces(board: Board, outlines: Sequence[Polygon], least_share: float = _LEAST_SHARE) -> tuple[_Piece, ...]:
    """Pieces that carry components, with those whose middles lie on them, or that reach over their edges."""
    if len(outlines) < 2:
        return ()
    tree = shapely.STRtree(outlines)
    bodies = np.array([each.outline for each in board.components], dtype=object)
    middles = shapely.centroid(bodies)
    owner = dict(tree.query(middles, predicate="within").T.tolist())
    rest = [place for place in range(len(bodies)) if place not in owner]
    for place, number in tree.query(bodies[rest], predicate="intersects").T.tolist():
        owner.setdefault(rest[place], number)
    held: dict[int, list[Component]] = {}
    for place, component in enumerate(board.components):
        if place in owner:
            held.setdefault(owner[place], []).append(component)
    least = least_share * max(map(len, held.values()), default=0)
    names = {each.name for each in board.components}
    return tuple(
        _Piece(outlines[number], tuple(parts), _own_names([each.name for each in parts], names))
        for number, parts in sorted(held.items())
        if len(parts) > least
    )


def _own_names(names: Sequence[str], everywhere: set[str]) -> tuple[str, ...]:
    """Names on a board alone: without the number of a repeated name, and without what all of a board begin or end with.

    They stay as they are where two would be alike.
    """
    plain = [base if (base := name.rpartition("-")[0]) in everywhere else name for name in names]
    marks = [dict(copy_marks(name)) for name in plain]
    common = set(marks[0]).intersection(*marks[1:]) if len(plain) > 1 else set[str]()
    for mark in common:
        plain = [own[mark] for own in marks]
    return tuple(plain) if len(set(plain)) == len(plain) else tuple(names)


def _are_copies(pieces: Sequence[_Piece]) -> bool:
    """Whether each piece is a board beside another: by the names of its parts, or because they lie alike."""
    left = list(pieces)
    while left:
        first, *rest = left
        has_enough = len(first.parts) >= _FEWEST_ALIKE
        kin = [
            each for each in rest if _shares_names(first, each) or (has_enough and _lay_upon(first, each) is not None)
        ]
        if not kin:
            return False
        left = [each for each in rest if each not in kin]
    return True


def _shares_names(one: _Piece, other: _Piece) -> bool:
    """Whether designators repeat, which they do not on one board: most of all, or several of the smaller piece's."""
    common = len({*one.own} & {*other.own})
    counts = len(one.own), len(other.own)
    return common >= _SHARED * max(counts) or common >= max(_FEWEST_SHARED, _SHARED * min(counts))


@dataclass(frozen=True, slots=True)
class _Lay:
    """How one piece is laid upon another: turned over, turned, moved."""

    is_turned_over: bool
    turn_rad: float
    shift_mm: tuple[float, float]

    def points(self, points: Points2) -> Points2:
        """Move points (n, 2)."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        flipped = points * [-1.0, 1.0] if self.is_turned_over else points
        return flipped @ np.array([[cos, sin], [-sin, cos]]) + self.shift_mm


def _lay_upon(first: _Piece, other: _Piece) -> _Lay | None:
    """Find how the first comes to lie upon its copy, best with equal names on equal places; ``None`` if it is none."""
    if len(first.parts) != len(other.parts) or abs(first.outline.area / other.outline.area - 1.0) > _SAME_OUTLINE:
        return None
    here, there = first.spots(), other.spots()
    numbers = {name: number for number, name in enumerate(other.own)}
    tree = KDTree(there)
    best: tuple[int, _Lay] | None = None
    for over in (False, True):
        sides = [({"top": "bottom", "bottom": "top"}[each.side] if over else each.side) for each in first.parts]
        if Counter(sides) != Counter(each.side for each in other.parts):
            continue
        centred = (here - here.mean(axis=0)) * ([-1.0, 1.0] if over else [1.0, 1.0])
        turns = [quarter * math.pi / 2.0 for quarter in range(4)]
        if len(here) > 1 and {*first.own} == {*other.own}:
            target = there[[numbers[name] for name in first.own]] - there.mean(axis=0)
            cross = float((centred[:, 0] * target[:, 1] - centred[:, 1] * target[:, 0]).sum())
            turns.insert(0, math.atan2(cross, float((centred * target).sum())))
        for turn in turns:
            bare = _Lay(over, turn, (0.0, 0.0))
            shift = there.mean(axis=0) - bare.points(here).mean(axis=0)
            lay = replace(bare, shift_mm=(float(shift[0]), float(shift[1])))
            far, nearest = tree.query(lay.points(here))
            pairs = np.asarray(nearest).tolist()
            if float(np.max(far)) > _SAME_MM or len(set(pairs)) < len(pairs):
                continue
            if not all(_is_same(*each, lay) for each in zip(first.parts, sides, (other.parts[n] for n in pairs),
                                                            strict=True)):  # fmt: skip
                continue
            moved = shapely.transform(first.outline, lay.points)
            if moved.symmetric_difference(other.outline).area > _SAME_OUTLINE * moved.area:
                continue
            agree = sum(name == other.own[number] for name, number in zip(first.own, pairs, strict=True))
            if best is None or agree > best[0]:
                best = agree, lay
    return best[1] if best is not None else None


def _is_same(one: Component, side: str, other: Component, lay: _Lay) -> bool:
    known = one.package, one.pins, side
    return (
        known == (other.package, other.pins, other.side)
        and abs(one.height_mm - other.height_mm) <= _SAME_MM
        and shapely.transform(one.outline, lay.points).hausdorff_distance(other.outline) <= 2.0 * _SAME_MM
    )


def _repeated(board: Board, whole: MultiPolygon) -> tuple[_Piece, ...]:
    """Copies of which only the repeated designators are there: the material that is nearer to each than to the others.

    Copies are those of the same offsets, and have in common what all of them have around their parts.
    """
    names = {each.name for each in board.components}
    copies: dict[str, list[Component]] = {}
    for each in board.components:
        base = each.name.rpartition("-")[0]
        copies.setdefault(base if base in names else each.name, []).append(each)
    count = Counter(map(len, copies.values())).most_common(1)[0][0]
    groups = [own for own in copies.values() if len(own) == count]
    if count < 2 or len(groups) < 2 or count * len(groups) < _REPEATED * len(board.components):
        return ()
    spots = np.array([sorted(np.round(each.outline.centroid.coords[0], 3).tolist() for each in own) for own in groups])
    offsets = spots - spots[:, :1]
    if float(np.abs(offsets - offsets[0]).max()) > _SAME_MM:
        return ()
    boxes = np.array([[spots[:, n].min(axis=0), spots[:, n].max(axis=0)] for n in range(count)])
    middles = boxes.mean(axis=1)
    cells = polygons_of(shapely.voronoi_polygons(MultiPoint(middles), extend_to=whole))
    near = [next(cell for cell in cells if cell.contains(shapely.Point(at))) for at in middles]
    common = shapely.intersection_all(
        [shapely.affinity.translate(cell.intersection(whole), *(-offsets[0][n])) for n, cell in enumerate(near)]
    )
    return _pieces(board, [each for n in range(count) for each in
                           polygons_of(shapely.affinity.translate(common, *offsets[0][n]))])  # fmt: skip


def _panel(board: Board, read: Sequence[Finding], cut: _Cut) -> Board:
    """Compose the panel: each board once, its copies as instances of it, and what stands beside them as obstacles."""
    bodies = {body.name: body for body in board.bodies}
    marks = tuple(mark for body in board.bodies if body.role == "board" for mark in body.extra if mark[0] == UNFITTED)
    singles: list[tuple[_Piece, Board]] = []
    over: dict[int, Board] = {}
    placed: list[tuple[Instance, list[tuple[str, str]]]] = []
    for piece in cut.pieces:
        found = ((first, own, lay) for first, own in singles if (lay := _lay_upon(first, piece)) is not None)
        first, own, lay = next(found, (piece, None, _Lay(is_turned_over=False, turn_rad=0.0, shift_mm=(0.0, 0.0))))
        if own is None:
            named = (replace(bodies[part.name], name=name) for part, name in zip(piece.parts, piece.own, strict=True))
            slab = Body("board", "board", *prism(piece.outline, board.bottom_z_mm, board.top_z_mm), extra=marks)
            own = understand([slab, *named], board.name)
            singles.append((piece, own))
        if lay.is_turned_over:
            own = over.setdefault(id(own), turned_over(own))
        renamed = _renamed(first, piece, lay) if first is not piece else []
        placed.append((Instance("", own, lay.turn_rad, *lay.shift_mm), renamed))
    placed.sort(key=lambda each: place_order(each[0]))
    instances = [replace(each, name=f"{number}") for number, (each, _) in enumerate(placed, start=1)]
    taken = {part.name for piece in cut.pieces for part in piece.parts}
    loose = [body for body in board.bodies if body.role == "component" and body.name not in taken]
    others = [body for body in board.bodies if body.role != "component"]
    others += [replace(body, role="fixture") for body in loose]
    kinds = f", {len(singles)} of them different" if 1 < len(singles) < len(instances) else ""
    alike = " of one kind" if len(singles) == 1 else kinds
    words = [f"{board.name} is read as a panel of {len(instances)} boards{alike}: {cut.how}."]
    other = next(((pair, each) for each, (_, pairs) in zip(instances, placed, strict=True) for pair in pairs), None)
    if other is not None:
        (name, own_name), instance = other
        words.append(f"Copies are called as the first: {name} is {instance.rename(own_name)}.")
    if loose:
        words.append(f"On no board are {some([body.name for body in loose])}: obstacles.")
    words.append("State `panel: whole` in columns.yaml beside it to have it read as one board.")
    kept = [each for each in read if each.rule is not REPEATED_NAME]
    return assemble(instances, others, board.name, [*kept, Finding(PANEL_FOUND, " ".join(words))])


def _renamed(first: _Piece, piece: _Piece, lay: _Lay) -> list[tuple[str, str]]:
    """Names of a copy that its board does not have, with what they are called."""
    nearest = np.asarray(KDTree(piece.spots()).query(lay.points(first.spots()))[1]).tolist()
    pairs = ((piece.own[number], name) for name, number in zip(first.own, nearest, strict=True))
    return [(other, name) for other, name in pairs if other != name]
