"""The judge's checks against the board: distances, turns around components, coverage, pauses.

Like ``judge.py`` it imports nothing of the house.
"""

import math
from collections import defaultdict
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import TypeAlias

import numpy as np
import shapely
from judge import Array, IsMaker, Track
from numpy.typing import NDArray
from shapely import Polygon, STRtree

Vector: TypeAlias = tuple[float, float]
_PAIRS_AT_ONCE = 200_000
_PIECE_MM = 10.0
_GRAZE_MM = 0.05
_ALONG_MM = 0.005
_SLANT_MM = 1.0  # an edge moved by 0.005 mm is met so much earlier or later where the line runs nearly along it


def too_close(track: Track, triangles: Array, clearance: float) -> list[str]:
    """Places where the orifice, on its way between two poses, comes closer to a triangle than the clearance.

    Args:
        track: The program.
        triangles: (m, 3, 3) everything that may be hit.
        clearance: The least distance; half a micrometre of rounding is granted.
    """
    begin, end, times = _pieces(track)
    found: dict[int, tuple[float, int]] = {}
    for piece, triangle in _near_pairs(begin, end, triangles, clearance):
        distances = segment_triangle_distances(begin[piece], end[piece], triangles[triangle])
        for row in np.flatnonzero(distances < clearance - 1e-3):
            key = int(piece[row])
            found[key] = min(found.get(key, (np.inf, -1)), (float(distances[row]), int(triangle[row])))
    return [
        f"before {times[key]:.4f} s: {distance:.3f} mm from triangle {triangle} near {np.round(begin[key], 2).tolist()}"
        for key, (distance, triangle) in sorted(found.items())
    ]


def _pieces(track: Track) -> tuple[Array, Array, Array]:
    """Cut the distinct swept segments into short pieces, so that their boxes are small."""
    ends = np.round(np.hstack([track.tcp[:-1], track.tcp[1:]]), 4)
    _, first = np.unique(ends, axis=0, return_index=True)
    count = np.maximum(np.ceil(track.lengths[first] / _PIECE_MM).astype(int), 1)
    segment = np.repeat(first, count)
    number = np.arange(len(segment)) - np.repeat(np.cumsum(count) - count, count)
    step = (track.tcp[1:] - track.tcp[:-1])[segment] / np.repeat(count, count)[:, None]
    begin = track.tcp[:-1][segment] + number[:, None] * step
    return begin, begin + step, track.times[1:][segment]


def _near_pairs(
    begin: Array, end: Array, triangles: Array, clearance: float
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Pieces and triangles whose boxes come within the clearance, some at a time."""
    low, high = np.minimum(begin, end) - clearance, np.maximum(begin, end) + clearance
    floor, roof = triangles.min(axis=1), triangles.max(axis=1)
    for pieces in np.array_split(np.argsort(low[:, 2], kind="stable"), max(1, len(begin) // 4000)):
        layer = np.flatnonzero((roof[:, 2] >= low[pieces, 2].min()) & (floor[:, 2] <= high[pieces, 2].max()))
        if not len(layer):
            continue
        tree = STRtree(shapely.box(*floor[layer, :2].T, *roof[layer, :2].T))
        for some in np.array_split(pieces, max(1, len(pieces) // 500)):
            row, column = tree.query(shapely.box(*low[some, :2].T, *high[some, :2].T))
            piece, triangle = some[row], layer[column]
            near = (roof[triangle, 2] >= low[piece, 2]) & (floor[triangle, 2] <= high[piece, 2])
            piece, triangle = piece[near], triangle[near]
            for part in range(0, len(piece), _PAIRS_AT_ONCE):
                cut = slice(part, part + _PAIRS_AT_ONCE)
                yield piece[cut], triangle[cut]


def segment_triangle_distances(begin: Array, end: Array, triangles: Array) -> Array:
    """Exact distances of (p, 3)-(p, 3) segments from (p, 3, 3) triangles, pair by pair.

    The least is reached at an edge, at an end of the segment above the face, or where the segment goes through it.
    """
    corners = [triangles[:, i] for i in range(3)]
    least = np.min([_segment_distances(begin, end, corners[i], corners[(i + 1) % 3]) for i in range(3)], axis=0)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    size = np.linalg.norm(normal, axis=1)
    normal = normal / np.maximum(size, 1e-300)[:, None]
    above = [np.sum((point - corners[0]) * normal, axis=1) for point in (begin, end)]
    is_flat = size < 1e-12
    for point, height in zip((begin, end), above, strict=True):
        inside = _is_inside(point, corners, normal) & ~is_flat
        least = np.where(inside, np.minimum(least, np.abs(height)), least)
    crosses = (above[0] * above[1] < 0) & ~is_flat
    share = np.divide(above[0], above[0] - above[1], out=np.zeros_like(least), where=crosses)
    through = crosses & _is_inside(begin + share[:, None] * (end - begin), corners, normal)
    return np.where(through, 0.0, least)


def _is_inside(point: Array, corners: list[Array], normal: Array) -> NDArray[np.bool_]:
    sides = [np.sum(np.cross(corners[(i + 1) % 3] - corners[i], point - corners[i]) * normal, axis=1) for i in range(3)]
    return np.min(sides, axis=0) >= 0


def _segment_distances(p1: Array, q1: Array, p2: Array, q2: Array) -> Array:
    """Distances of segments pair by pair (Ericson, Real-Time Collision Detection, 5.1.9)."""
    d1, d2, r = q1 - p1, q2 - p2, p1 - p2
    a, e, f = (np.sum(u * v, axis=1) for u, v in ((d1, d1), (d2, d2), (d2, r)))
    b, c = np.sum(d1 * d2, axis=1), np.sum(d1 * r, axis=1)
    tiny = 1e-18
    spread = a * e - b * b
    s = np.clip(np.divide(b * f - c * e, spread, out=np.zeros_like(a), where=spread > tiny), 0, 1)
    t = np.divide(b * s + f, e, out=np.zeros_like(a), where=e > tiny)
    t = np.clip(t, 0, 1)
    s = np.clip(np.divide(b * t - c, a, out=np.zeros_like(a), where=a > tiny), 0, 1)
    return np.linalg.norm((p1 + s[:, None] * d1) - (p2 + t[:, None] * d2), axis=1)


def turns_around(track: Track, template: str, centres: Mapping[str, tuple[float, float]]) -> dict[str, float]:
    """How often the path winds around each component, in the sense of its own direction.

    Args:
        track: The program.
        template: Recipe path of the perimeter, such as ``"sequence[0]/around"``; a segment belongs to the components
            named behind it, joined by ``+``.
        centres: A point inside each component.

    Returns:
        Full turns of each component that a segment names; reversed runs do not cancel each other.
    """
    turns: dict[str, float] = defaultdict(float)
    for maker, rows in _runs(track, lambda maker: maker.startswith(template + "/") and not maker.endswith("/transfer")):
        for name in maker.removeprefix(template + "/").split("+"):
            if name in centres:
                turns[name] += abs(_winding(track.tcp[rows, :2] - centres[name]))
    return dict(turns)


def _winding(points: Array) -> float:
    x, y = points.T
    return float(np.arctan2(x[:-1] * y[1:] - y[:-1] * x[1:], x[:-1] * x[1:] + y[:-1] * y[1:]).sum() / (2 * np.pi))


def _runs(track: Track, belongs: IsMaker) -> Iterator[tuple[str, list[int]]]:
    """Runs of consecutive poses, the one they come from included, whose segments have one maker that belongs."""
    for maker, group in groupby(range(1, len(track.times)), key=track.makers.__getitem__):
        rows = list(group)
        if belongs(maker):
            yield maker, [rows[0] - 1, *rows]


def cone_footprints(tcp: Array, quaternion: Array, half_angle_deg: float, plane_z: float) -> Array:
    """(m, 48, 2) where the mantles of cones meet the plane; NaN where a part of one never does."""
    w, x, y, z = quaternion.T
    axes = np.moveaxis(
        np.array(
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        ),
        2,
        0,
    )
    around, half = np.linspace(0, 2 * np.pi, 48, endpoint=False), np.radians(half_angle_deg)
    rays = np.stack([np.sin(half) * np.cos(around), np.sin(half) * np.sin(around), np.full(48, np.cos(half))])
    directions = np.swapaxes(axes @ rays, 1, 2)
    falls = directions[..., 2]
    reach = np.divide(plane_z - tcp[:, 2:], falls, out=np.full(falls.shape, -1.0), where=np.abs(falls) > 1e-6)
    meets = (reach > 0).all(axis=1)
    return np.where(meets[:, None, None], tcp[:, None, :2] + reach[..., None] * directions[..., :2], np.nan)


def covered_share(track: Track, belongs: IsMaker, half_angle_deg: float, plane_z: float, area: Polygon) -> float:
    """Part of an area of the board that lies in the cone at some moment of the segments that belong.

    Between two poses the footprint sweeps the convex hull of both, exactly so while the orientation stays.
    """
    sprayed = np.flatnonzero(track.sprayed_s > 0).tolist()
    index = np.array([each for each in sprayed if belongs(track.makers[each + 1])], dtype=np.int64)
    prints = [cone_footprints(track.tcp[i], track.quaternion[i], half_angle_deg, plane_z) for i in (index, index + 1)]
    both = np.concatenate(prints, axis=1)
    # A line has the hull of its points, and no geometry of its own for each of them.
    swept = shapely.convex_hull(shapely.linestrings(both[~np.isnan(both).any(axis=(1, 2))]))
    return float(shapely.union_all(swept).intersection(area).area / area.area)


def wrong_pauses(track: Track, template: str, outlines: Mapping[str, Polygon], plane_z: float) -> list[str]:
    """Lines of a step function whose pauses are not the component edges that the jet's axis crosses, in order.

    An outline crossed over less than 0.05 mm, at the very end of a line, or along its own edge within 5 um, may count
    or not.
    """
    wrong: list[str] = []
    smaller, larger = (
        [outline.buffer(by, join_style="mitre") for outline in outlines.values()] for by in (-_ALONG_MM, _ALONG_MM)
    )
    tree, names = STRtree(larger), list(outlines)
    reach = np.divide(plane_z - track.tcp[:, 2], track.approach[:, 2])
    aim = track.tcp[:, :2] + reach[:, None] * track.approach[:, :2]
    for rows in _straight_lines(track, template):
        line = shapely.LineString(aim[rows])  # where a jet that leans sideways is raised, what it meets swerves
        near = tree.query(line, predicate="intersects")
        must, may = (sorted(_edges(line, [shapes[i] for i in near])) for shapes in (smaller, larger))
        begin, end = track.times[rows[0]], track.times[rows[-1]]
        pauses = [
            line.project(shapely.Point(aim[np.searchsorted(track.times, stamp + length / 2)]))
            for stamp, length, maker in track.waits
            if begin - 1e-6 <= stamp <= end + 1e-6 and _is_of(maker, template)
        ]
        if not (_is_part(must, pauses) and _is_part(pauses, may)):
            wrong.append(
                f"{begin:.4f} s: pauses at {np.round(pauses, 2).tolist()} mm of a line of {line.length:.2f} mm, "
                f"edges at {np.round(may, 2).tolist()} mm of {[names[i] for i in near]}"
            )
    return wrong


def _is_part(some: list[float], more: list[float]) -> bool:
    """Whether each of some ascending numbers has its own among others, in order, nearly."""
    rest = iter(more)
    return all(any(abs(one - other) <= _SLANT_MM for other in rest) for one in some)


def _edges(line: shapely.LineString, outlines: list[Polygon]) -> Iterator[float]:
    for outline in outlines:
        for piece in shapely.get_parts(shapely.line_merge(line.intersection(outline))):
            at = [line.project(shapely.Point(point)) for point in shapely.get_coordinates(piece)]
            if at and max(at) - min(at) >= _GRAZE_MM:
                yield from (each for each in (min(at), max(at)) if _GRAZE_MM < each < line.length - _GRAZE_MM)


def _is_of(maker: str, template: str) -> bool:
    return (maker == template or maker.startswith(template + "/")) and not maker.endswith("/transfer")


def _turns(along: Vector, heading: Vector) -> bool:
    """Whether a plan vector leaves the direction of another by more than 2 degrees and the rounding of both."""
    length, step = math.hypot(*along), math.hypot(*heading)
    aside = abs(along[0] * heading[1] - along[1] * heading[0]) / length
    behind = along[0] * heading[0] + along[1] * heading[1] < 0
    return behind or aside > 0.04 * step + 2e-3 * (1 + step / length)


def _straight_lines(track: Track, template: str) -> Iterator[list[int]]:
    """Poses of each straight sprayed line of a template, with the pauses in it."""
    run: list[int] = []
    x, y = track.tcp[:, 0].tolist(), track.tcp[:, 1].tolist()
    for index in range(1, len(track.times)):
        belongs = _is_of(track.makers[index], template)
        if not (belongs or run):
            continue
        # A line that is raised stays straight in plan.
        heading = x[index] - x[index - 1], y[index] - y[index - 1]
        moves = math.hypot(*heading) > 2e-3
        along = (x[run[-1]] - x[run[0]], y[run[-1]] - y[run[0]]) if run else heading
        turns = moves and _turns(along, heading)
        if run and (not belongs or turns):
            yield run
            run = []
        if belongs and not run and moves:
            run = [index - 1]
        if run:
            run.append(index)
    if run:
        yield run
