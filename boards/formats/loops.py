"""Lines and arcs of a drawing, chained into closed loops and the loops into one outline with holes.

Nothing here looks at absolute directions: a loop starts where the file starts it, so it moves with the board.
"""

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy.spatial import KDTree
from shapely import MultiPolygon, Polygon
from shapely.geometry.polygon import orient

from boards.bounds import FARTHEST_MM, MOST_CORNERS, check_corners
from boards.errors import BoardError
from geometry.arrays import Points2

Point2: TypeAlias = NDArray[np.float64]  # (2,)

SAGITTA_MM = 0.01
"""How far the chord of an arc may be from the arc."""

CHAIN_MM = 0.02
"""Ends closer than this are joined, as KiCad does."""

MIL_MM = 0.0255
"""Programs in mils round the ends of lines by as much, a hair more than one mil."""

_FEWEST_HELD = 2
"""Places in cut-outs that make a loop a frame; one part may be mounted in a cut-out."""

_WIDEST_PEN_MM = 0.5
"""Wider pens draw areas, whose gaps mean something."""

_EXACT_MM = 0.001
"""Ends closer than this are the same point; edges may be shorter than ``CHAIN_MM``, so such ends are joined first."""

_RADIUS_MM = 0.1
"""The two ends of an arc may be stated with radii that differ by this."""

_TWIN = 0.2
"""Two edges lie upon each other only if their ends are nearer than this part of their length."""

SCORE_NAME = re.compile(r"v[-_ +]?(?:cut|scor|groove)", re.IGNORECASE)
"""In the name of a layer whose lines score a panel."""

_LEAST_SCORE_MM = 5.0
_RIM_MM = 0.5
"""So far from an edge a score may end."""
_MOST_LINES = 3000
_MOST_CROSSINGS = 50_000
"""Of the drawing of one body; the cells between lines that cross grow with the square of their number."""

DRILL_MM = 1.0
"""Smaller drilled holes are left out of the outline: vias and the leads of parts, most of them full of solder."""


_LEAST_SAGITTA = 1e-12
"""As share of the radius: with less, the cosine of a step is 1."""


def arc(start: Point2, centre: Point2, sweep_rad: float) -> Points2:
    """Points along an arc, ``(n, 2)`` with both ends; a positive sweep is counter-clockwise.

    A full turn ends on its first point.

    Raises:
        BoardError: No number, or one so large that the arc has more points than an outline.
    """
    arm = np.asarray(start, dtype=np.float64) - centre
    radius = float(np.hypot(arm[0], arm[1]))
    if radius <= SAGITTA_MM or abs(sweep_rad) < 1e-9:
        return np.array([start, start], dtype=np.float64)
    # A circle of any size that a file may hold has a step above nothing.
    step = 2.0 * np.arccos(1.0 - max(min(SAGITTA_MM / radius, 0.25), _LEAST_SAGITTA))
    if not abs(sweep_rad) <= MOST_CORNERS * step:
        raise _no_arc()
    # Rounded first, so that a board that was moved has as many points as before.
    count = max(int(np.ceil(np.round(abs(sweep_rad) / step, 3))), 2)
    turn = np.linspace(0.0, sweep_rad, count + 1)
    points = centre + np.column_stack(
        [arm[0] * np.cos(turn) - arm[1] * np.sin(turn), arm[0] * np.sin(turn) + arm[1] * np.cos(turn)]
    )
    if abs(abs(sweep_rad) - 2.0 * np.pi) < 1e-9:
        points[-1] = points[0]
    return points


def _no_arc() -> BoardError:
    return BoardError("an arc has a radius or an angle that no drawing has. Correct it, and check the units.")


def is_too_far(start: Point2, end: Point2, sweep_rad: float) -> bool:
    """Whether the arc from one point to another with this included angle leads more than 10 m away.

    Of nearly a full turn between two places it does, however near each other they are.
    """
    chord = float(np.hypot(*(np.asarray(end, dtype=np.float64) - start)))
    return 0.5 * chord * abs(np.tan(sweep_rad / 4.0)) > FARTHEST_MM


def arc_between(start: Point2, end: Point2, sweep_rad: float) -> Points2:
    """Points along the arc from one point to another with this included angle, ``(n, 2)`` with both ends exact.

    Readers check that it is not ``is_too_far``.
    """
    half = (np.asarray(end, dtype=np.float64) - start) / 2.0
    if abs(sweep_rad) < 1e-6:
        return np.array([start, end], dtype=np.float64)
    left = np.array([-half[1], half[0]])
    points = arc(start, start + half + left / np.tan(sweep_rad / 2.0), sweep_rad)
    points[-1] = end
    return points


def circle(centre: Point2, radius_mm: float) -> Points2:
    """A full circle as an open counter-clockwise ring ``(n, 2)``, from its point on the right."""
    return arc(centre + np.array([radius_mm, 0.0]), centre, 2.0 * np.pi)[:-1]


def arc_about(start: Point2, end: Point2, centre: Point2, *, clockwise: bool, same_mm: float = 1e-6) -> Points2 | None:
    """Points along the arc about a centre, ``(n, 2)`` with both ends exact; a full circle where they are the same.

    ``None`` where the ends are not equally far from the centre.
    """
    (ax, ay), (bx, by) = start - centre, end - centre
    if abs(np.hypot(ax, ay) - np.hypot(bx, by)) > _RADIUS_MM:
        return None
    sweep = float(np.arctan2(ax * by - ay * bx, ax * bx + ay * by)) % (2.0 * np.pi)
    if float(np.hypot(*(end - start))) < same_mm:
        sweep = -2.0 * np.pi if clockwise else 2.0 * np.pi
    elif clockwise:
        sweep -= 2.0 * np.pi
    points = arc(start, centre, sweep)
    points[-1] = end
    return points


def sweep_through(start: Point2, middle: Point2, end: Point2) -> float:
    """Included angle of the arc through three points, rad, counter-clockwise; 0 if they are in a row."""
    first, second = np.asarray(middle, dtype=np.float64) - start, np.asarray(end, dtype=np.float64) - middle
    # Inscribed angle: the arc's included angle is twice the turn at its middle.
    turn = np.arctan2(first[0] * second[1] - first[1] * second[0], float(first @ second))
    return 2.0 * float(turn)


def chain(edges: Sequence[Points2]) -> tuple[list[Points2], list[Points2]]:
    """Join edges end to end, beginning with the first of the file: where they meet, then within ``CHAIN_MM``.

    Args:
        edges: Polylines ``(n, 2)`` in file order, in any direction.

    Returns:
        Closed loops ``(n, 2)`` without the repeated first point, and the chains that stayed open.

    Raises:
        BoardError: A point is no place on a board.
    """
    check_corners(edges)
    loops, opened = _chain_within(edges, _EXACT_MM)
    more, opened = _chain_within(opened, CHAIN_MM)
    return [*loops, *more], opened


def close_chains(opened: Sequence[Points2], pen_mm: float) -> tuple[list[Points2], list[Points2]]:
    """Close what ``chain`` left open over gaps that the pen covers, or that are no wider than a mil.

    Args:
        opened: Open chains ``(n, 2)``.
        pen_mm: Width of the finest line among them; 0 where it is not stated.

    Returns:
        Loops whose corners are all kept, and the chains that stayed open.
    """
    return _chain_within(opened, max(MIL_MM, min(pen_mm, _WIDEST_PEN_MM)))


def _chain_within(edges: Sequence[Points2], gap_mm: float) -> tuple[list[Points2], list[Points2]]:
    kept = _distinct(edges, gap_mm)
    loops: list[Points2] = []
    opened: list[Points2] = []
    if not kept:
        return loops, opened
    ends = np.array([[edge[0], edge[-1]] for edge in kept]).reshape(-1, 2)
    tree, free = KDTree(ends), np.ones(len(kept), dtype=bool)
    for seed in range(len(kept)):
        if not free[seed]:
            continue
        free[seed] = False
        path = _extend(kept[seed], kept, tree, free, gap_mm)
        if not _closed(path, gap_mm):
            path = _extend(path[::-1], kept, tree, free, gap_mm)
        if _closed(path, gap_mm):
            loops.append(path if gap_mm > CHAIN_MM else path[:-1])
        else:
            opened.append(path[::-1])  # as its first edge was drawn
    return loops, opened


def _closed(path: Points2, gap_mm: float) -> bool:
    return len(path) > 3 and bool(np.hypot(*(path[-1] - path[0])) <= gap_mm)


def _distinct(edges: Sequence[Points2], gap_mm: float) -> list[Points2]:
    """Leave out edges without length and the second of two that lie upon each other."""
    # Copies go first: the pairs of what lies within a tolerance grow with the square of their number.
    kept = _without_copies([edge for edge in edges if np.ptp(edge, axis=0).max() > gap_mm])
    if len(kept) < 2:
        return kept
    # Two ends and the mean of the points, the ends in an order that does not depend on the direction of drawing.
    means = np.array([edge.mean(axis=0) for edge in kept])
    twins = np.sort(KDTree(means).query_pairs(CHAIN_MM, output_type="ndarray"), axis=1)
    ends = np.array([[edge[0], edge[-1]] for edge in kept])
    one, two = ends[twins[:, 0]], ends[twins[:, 1]]
    straight, crossed = (np.hypot(*(one - other).T).sum(axis=0) for other in (two, two[:, ::-1]))
    near = np.minimum(CHAIN_MM, _TWIN * np.array([np.ptp(edge, axis=0).max() for edge in kept]))[twins[:, 0]]
    counts = np.array([len(edge) for edge in kept])[twins]
    alike = (counts[:, 0] == counts[:, 1]) & (np.minimum(straight, crossed) <= 2.0 * near)
    dropped = set(twins[alike, 1].tolist())
    return [edge for number, edge in enumerate(kept) if number not in dropped]


def _without_copies(edges: Sequence[Points2]) -> list[Points2]:
    """Leave out edges that were drawn before, in either direction."""
    first: dict[bytes, Points2] = {}
    for edge in edges:
        first.setdefault(min(edge.tobytes(), edge[::-1].tobytes()), edge)
    return [*first.values()]


def _extend(path: Points2, edges: Sequence[Points2], tree: KDTree, free: np.ndarray, gap_mm: float) -> Points2:
    """Append free edges to the end of a path until it closes or nothing is there."""
    pieces, length, first, last = [path], len(path), path[0], path[-1]
    while not (length > 3 and np.hypot(*(last - first)) <= gap_mm):
        near = [int(end) for end in tree.query_ball_point(last, gap_mm) if free[int(end) // 2]]
        if not near:
            break
        nearest = min(near, key=lambda end: (round(float(np.hypot(*(tree.data[end] - last))), 6), end))
        edge = edges[nearest // 2]
        free[nearest // 2] = False
        piece = edge[1:] if nearest % 2 == 0 else edge[-2::-1]
        pieces.append(piece)
        length, last = length + len(piece), piece[-1]
    return np.concatenate(pieces)


def outline_of(
    loops: Sequence[Points2],
    drills: Sequence[Points2],
    *,
    file: Path,
    spot: Callable[[Point2], str],
    holds: Points2 | None = None,
) -> Polygon | MultiPolygon:
    """One outline from the loops of a board: an outermost loop is an edge, one within it is cut out, and so on inwards.

    Args:
        loops: Closed loops ``(n, 2)``, mm.
        drills: Loops of drilled holes and slots; what lies outside the edge is ignored.
        file: For the messages.
        spot: Describes a point as the file does.
        holds: Places ``(n, 2)`` of what is soldered to the board: a loop under which most of them would lie in cut-outs
            is a frame around the drawing, and left out.

    Returns:
        A valid polygon, or several if the file holds several boards side by side; an edge starts at its loop's first
        point.

    Raises:
        BoardError: There is no loop, one crosses itself, or two edges cross each other.
    """
    if not loops:
        raise BoardError("no board outline in the file. Draw the board's edge as a closed line.", file=file)
    check_corners([*loops, *drills], file)
    polygons = [Polygon(loop) for loop in loops]
    for polygon, loop in zip(polygons, loops, strict=True):
        if not polygon.is_valid or polygon.area < CHAIN_MM**2:
            message = f"the outline that starts at {spot(loop[0])} crosses itself or has no area. "
            raise BoardError(f"{message}Redraw it as one closed line.", file=file)
    # How many larger loops each loop lies in.
    points = np.array([polygon.representative_point() for polygon in polygons], dtype=object)
    areas = np.round([polygon.area for polygon in polygons], 4)
    within, around = shapely.STRtree(polygons).query(points, predicate="within")
    depths = np.bincount(within[areas[around] > areas[within]], minlength=len(polygons))
    if holds is not None and len(holds) and (frame := _frame(polygons, depths, holds)) is not None:
        rest = [loop for place, loop in enumerate(loops) if place != frame]
        return outline_of(rest, drills, file=file, spot=spot, holds=holds)
    drilled = [Polygon(drill) for drill in drills]
    pieces: list[Polygon] = []
    for polygon, depth in zip(polygons, depths.tolist(), strict=True):
        if depth % 2 == 0:
            inner = [hole for hole, level in zip(polygons, depths.tolist(), strict=True) if level == depth + 1]
            piece = _cut(polygon, [*inner, *drilled], file)
            if any(piece.intersects(other) for other in pieces):
                start = spot(np.asarray(polygon.exterior.coords[0]))
                raise BoardError(f"the outline that starts at {start} crosses another one. Join the two.", file=file)
            pieces.append(piece)
    return pieces[0] if len(pieces) == 1 else MultiPolygon(pieces)


def _frame(polygons: Sequence[Polygon], depths: NDArray[np.int64], holds: Points2) -> int | None:
    """Find the outermost loop that puts most places into cut-outs; ``None`` where the loops are edge and cut-outs."""
    which, around = shapely.STRtree(polygons).query(shapely.points(holds), predicate="within")
    loops_around = np.bincount(which, minlength=len(holds))
    in_cut_outs = (loops_around % 2 == 0) & (loops_around > 0)
    if 2 * int(in_cut_outs.sum()) <= int((loops_around > 0).sum()) or int(in_cut_outs.sum()) < _FEWEST_HELD:
        return None
    outermost = around[in_cut_outs[which] & (depths[around] == 0)]
    return int(np.bincount(outermost).argmax())


def _cut(edge: Polygon, holes: list[Polygon], file: Path) -> Polygon:
    """Cut the holes out; where none touches another or the edge, every ring stays exactly as it was drawn."""
    holes = [hole for hole in holes if edge.intersects(hole)]
    if not holes:
        return edge
    alone = len(shapely.STRtree(holes).query(holes, predicate="intersects")[0]) == len(holes)
    if alone and bool(np.all(shapely.contains_properly(edge, holes))):
        return orient(Polygon(edge.exterior.coords, [hole.exterior.coords for hole in holes]))
    rest = edge.difference(shapely.union_all(holes))
    pieces = [piece for piece in shapely.get_parts(rest).tolist() if isinstance(piece, Polygon)]
    whole = max(pieces, key=lambda piece: round(piece.area, 4), default=Polygon())
    if whole.area < 0.5 * edge.area:
        raise BoardError("the cut-outs cut the board into pieces. Check the loops of the outline.", file=file)
    whole, start = orient(whole), np.asarray(edge.exterior.coords[0])
    rings: list[Points2] = []
    for ring in (whole.exterior, *whole.interiors):  # shapely starts them anywhere: they begin nearest to the start
        points = np.asarray(ring.coords, dtype=np.float64)[:-1]
        rings.append(np.roll(points, -int(np.argmin(np.round(np.hypot(*(points - start).T), 4))), axis=0))
    inner = sorted(rings[1:], key=lambda ring: round(float(np.hypot(*(ring[0] - start))), 4))
    return Polygon(rings[0], inner)


def slot(centre: Point2, along: Point2, half_mm: float, radius_mm: float) -> Points2:
    """A drilled slot, or a round hole where ``half_mm`` is zero, as an open counter-clockwise ring ``(n, 2)``.

    Args:
        centre: Middle of the slot, mm.
        along: Unit vector of its length; a round hole starts there too, so that it moves with the board.
        half_mm: From the middle to the centre of either round end.
        radius_mm: Radius of the ends.

    Raises:
        BoardError: No number.
    """
    if not math.isfinite(half_mm + radius_mm):
        raise _no_arc()
    if half_mm <= CHAIN_MM:
        return arc(centre + along * radius_mm, centre, 2.0 * np.pi)[:-1]
    side = np.array([-along[1], along[0]]) * radius_mm
    right, left = centre + along * half_mm, centre - along * half_mm
    return np.concatenate([arc(right - side, right, np.pi), arc(left + side, left, np.pi)])


def enclosed(lines: Sequence[Points2]) -> Polygon | MultiPolygon | None:
    """Everything that the drawing of a body encloses; marks beside the body are left out.

    Returns:
        The outline, ``None`` if nothing is enclosed, or so many lines cross each other that they are no drawing.

    Raises:
        BoardError: A point is no place on a board.
    """
    check_corners(lines)
    drawn = _without_copies([line for line in lines if len(line) > 1 and np.ptp(line, axis=0).max() > 0.0])
    if not drawn or len(drawn) > _MOST_LINES:
        return None
    strings = np.array([shapely.LineString(line) for line in drawn], dtype=object)
    if len(shapely.STRtree(strings).query(strings, predicate="intersects")[0]) > _MOST_CROSSINGS:
        return None
    # Ends that miss each other by a rounding are snapped to 0.001 mm, or nothing would be enclosed.
    noded = shapely.union_all(shapely.set_precision(strings, 0.001))
    cells = [cell for cell in shapely.get_parts(shapely.polygonize([noded])).tolist() if isinstance(cell, Polygon)]
    if not cells:
        return None
    whole = shapely.union_all([Polygon(cell.exterior) for cell in cells])
    pieces = [Polygon(part.exterior) for part in shapely.get_parts(whole).tolist() if isinstance(part, Polygon)]
    largest = max(piece.area for piece in pieces)
    # A mark beside the body, such as the dot of pin 1, is no part of it.
    kept = [piece for piece in pieces if piece.area >= 0.2 * largest]
    return kept[0] if len(kept) == 1 else MultiPolygon(kept)


def cells_of(outline: Polygon | MultiPolygon, lines: Sequence[Points2]) -> list[Polygon]:
    """Pieces into which straight lines (2, 2) cut an outline; the lines are led on by a tenth of a millimetre."""
    ways = [(line[1] - line[0]) / float(np.hypot(*(line[1] - line[0]))) for line in lines]
    ends = [line + 0.1 * np.array([-1.0, 1.0])[:, None] * way for line, way in zip(lines, ways, strict=True)]
    drawn = [outline.boundary, *map(shapely.LineString, ends)]
    noded = shapely.union_all(shapely.set_precision(drawn, 0.001))
    cells = [cell for cell in shapely.get_parts(shapely.polygonize([noded])).tolist() if isinstance(cell, Polygon)]
    return [cell for cell in cells if cell.area > 1.0 and outline.contains(cell.representative_point())]


def find_scores(
    outline: Polygon | MultiPolygon, lines: Sequence[Points2], bodies: Sequence[Polygon | MultiPolygon]
) -> list[Points2]:
    """Find the straight lines that lead from edge to edge, through the middle of no body, and cut the outline."""
    plain = (shapely.get_coordinates(shapely.LineString(line).simplify(CHAIN_MM)) for line in lines if len(line) > 1)
    straight = [line for line in plain if len(line) == 2 and float(np.hypot(*(line[1] - line[0]))) >= _LEAST_SCORE_MM]
    if not straight:
        return []
    inner, strings = outline.buffer(-_RIM_MM), np.array([shapely.LineString(line) for line in straight], dtype=object)
    middles = shapely.STRtree([body.centroid for body in bodies])
    met = set(middles.query(strings, predicate="dwithin", distance=_RIM_MM)[0].tolist())
    shapely.prepare(inner)
    starts, ends = (shapely.contains_xy(inner, np.array([line[end] for line in straight])) for end in (0, 1))
    long = shapely.length(shapely.intersection(strings, inner)) >= _LEAST_SCORE_MM - 2.0 * _RIM_MM
    found = [
        line for place, line in enumerate(straight) if long[place] and not (starts | ends)[place] and place not in met
    ]
    return found if found and len(found) <= _MOST_LINES and len(cells_of(outline, found)) > 1 else []


def box_around(pieces: Sequence[Points2]) -> Polygon | None:
    """Give the rectangle around points (n, 2); ``None`` where there are none, or it is not 0.01 mm wide."""
    if not pieces:
        return None
    points = np.concatenate(pieces)
    (x0, y0), (x1, y1) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    return shapely.box(x0, y0, x1, y1) if min(x1 - x0, y1 - y0) > 0.01 else None
