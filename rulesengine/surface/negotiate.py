"""Negotiation of the spray angle: as perpendicular as possible, tilted only to avoid a collision (Sandia 1993, 2.3)."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Directions, Indices, Points, Scalars
from rulesengine.surface.site import PartSite, Piece, blocked_segments, seconds_along
from rulesengine.surface.striping.stripe import Stripe
from specs.progress import Progress, no_progress

TILT_STEP_DEG = 2.5
AZIMUTHS = 16
_SPARE_DEG = 5.0
"""Tilts above the least that the programme along a stripe may choose from."""
_TURN_WEIGHT = 0.05
"""Degrees of tilt that a degree of turn is worth: a needless tilt never pays."""
_SIDE_WEIGHT_DEG = 0.5
"""Degrees of tilt that leaning to the preferred side is worth at most: less than a step of the tilt."""
_ALIKE_MM, _ALIKE = 1e-2, 1e-3
_TOO_FAST = 1e3
_FORBIDDEN = 1e9
_TRIES = 12


@dataclass(frozen=True, slots=True, eq=False)
class Leans:
    """Free directions at the points of stripes: as many as there are, point after point."""

    point: Indices
    """(k,) ascending."""
    outward: Directions
    """(k, 3) from the surface to the orifice."""
    tilt_deg: Scalars
    """(k,) from the normal."""
    cost_deg: Scalars
    """(k,) that the programme along a stripe adds up: the tilt, less where a side is preferred."""


def negotiate(site: PartSite, stripes: Sequence[Stripe], progress: Progress = no_progress) -> list[list[Piece]]:
    """Choose the jet's direction along stripes: the least tilt at which the lance is free, turning within the limits.

    A stripe is cut where no direction within the largest tilt is free, or no way from one pose to the next.

    Returns:
        The pieces of each stripe, in its order.
    """
    if not stripes:
        return []
    points, normals, travel = _points_of(site, stripes)
    return _along_all(site, stripes, free_leans(site, points, normals, travel, progress), progress)


def negotiate_sides(site: PartSite, stripes: Sequence[Stripe]) -> list[Piece]:
    """Negotiate as ``negotiate``; of tilts that are equally small also those nearest to four sides, each way once.

    Near a wall a jet that leans may hold some of the wall too, or of the floor behind it: which side it leans to is
    free where several have the least tilt.
    """
    if not stripes:
        return []
    points, normals, travel = _points_of(site, stripes)
    leans = free_leans(site, points, normals, travel)
    across = np.cross(normals, travel)
    found = _along_all(site, stripes, leans, no_progress)
    tilted = [any((piece.tilts_deg > 0).any() for piece in pieces) for pieces in found]
    for side in (travel, -travel, across, -across):
        toward = np.einsum("ij,ij->i", leans.outward, side[leans.point])
        cost = leans.tilt_deg - np.where(leans.tilt_deg > 0, _SIDE_WEIGHT_DEG * toward, 0.0)
        more = _along_all(site, stripes, replace(leans, cost_deg=cost), no_progress, tilted)
        for known, pieces in zip(found, more, strict=True):
            known += [piece for piece in pieces if not any(_are_alike(piece, each) for each in known)]
    return [piece for pieces in found for piece in pieces]


def _are_alike(one: Piece, other: Piece) -> bool:
    """Whether two pieces differ by rounding only."""
    return len(one.tcp) == len(other.tcp) and bool(
        np.abs(one.tcp - other.tcp).max() <= _ALIKE_MM and np.abs(one.approach - other.approach).max() <= _ALIKE
    )


def _points_of(site: PartSite, stripes: Sequence[Stripe]) -> tuple[Points, Directions, Directions]:
    """(n, 3) places, normals, and directions of travel of all stripes."""
    points, normals = (np.concatenate([getattr(each, name) for each in stripes]) for name in ("targets", "normals"))
    return points, normals, np.concatenate([_travel(site, each) for each in stripes])


def _along_all(
    site: PartSite, stripes: Sequence[Stripe], leans: Leans, progress: Progress, which: Sequence[bool] | None = None
) -> list[list[Piece]]:
    """Pieces of each stripe; of some only, none of the others."""
    ends = np.cumsum([len(each.targets) for each in stripes])
    pieces: list[list[Piece]] = []
    for number, (stripe, end) in enumerate(zip(stripes, ends.tolist(), strict=True)):
        begin = end - len(stripe.targets)
        pieces.append(_along(site, stripe, leans, begin) if which is None or which[number] else [])
        progress("negotiating the tilt", 0.7 + 0.3 * (number + 1) / len(stripes))
    return pieces


def free_leans(
    site: PartSite, points: Points, normals: Directions, travel: Directions, progress: Progress = no_progress
) -> Leans:
    """Find free directions at (n, 3) points of the surface: those at the least tilt, and up to 5 degrees above it."""
    least = np.full(len(points), np.inf)
    found: list[tuple[Indices, Directions, Scalars]] = []
    tilts = np.arange(0.0, site.most_tilt_deg + 1e-9, TILT_STEP_DEG)
    for level, tilt in enumerate(tilts.tolist()):
        at = np.flatnonzero((tilt <= least + _SPARE_DEG) & (least > 0))
        if not len(at):
            break
        outward = leaning(normals[at], travel[at], tilt)
        point = np.repeat(at, outward.shape[1])
        outward = outward.reshape(-1, 3)
        free = site.are_free(points[point] + outward * site.spec.standoff_mm, -outward, points[point])
        found.append((point[free], outward[free], np.full(int(free.sum()), tilt)))
        least[point[free]] = np.minimum(least[point[free]], tilt)
        progress("negotiating the tilt", 0.7 * (level + 1) / len(tilts))
    point = np.concatenate([each for each, _, _ in found])
    order = np.argsort(point, kind="stable")
    outward = np.concatenate([each for _, each, _ in found])[order]
    tilt = np.concatenate([each for _, _, each in found])[order]
    return Leans(point[order], outward, tilt, tilt)


def leaning(normals: Directions, travel: Directions, tilt_deg: float) -> Directions:
    """(n, k, 3) directions at a tilt from (n, 3) normals: one without a tilt, else sixteen around, travel's first."""
    if tilt_deg == 0:
        return normals[:, None].copy()
    azimuths = 2 * np.pi * np.arange(AZIMUTHS) / AZIMUTHS
    across = np.cross(normals, travel)
    around = travel[:, None] * np.cos(azimuths)[:, None] + across[:, None] * np.sin(azimuths)[:, None]
    tilt = np.radians(tilt_deg)
    return normals[:, None] * np.cos(tilt) + around * np.sin(tilt)


def _travel(site: PartSite, stripe: Stripe) -> Directions:
    """(n, 3) directions along a stripe, at right angles to the normals."""
    if len(stripe.targets) == 1:
        return site.across(stripe.normals)
    ways = np.gradient(stripe.targets, axis=0)
    ways = ways - stripe.normals * np.einsum("ij,ij->i", ways, stripe.normals)[:, None]
    lengths = np.linalg.norm(ways, axis=1, keepdims=True)
    bare = lengths[:, 0] < 1e-9
    if bare.any():
        ways[bare] = site.across(stripe.normals[bare])
        lengths[bare] = 1.0
    return ways / lengths


def _along(site: PartSite, stripe: Stripe, leans: Leans, begin: int) -> list[Piece]:
    count = len(stripe.targets)
    first = np.searchsorted(leans.point, begin + np.arange(count + 1))
    has = np.diff(first) > 0
    if stripe.closed and has.any() and not has.all():
        return _along(site, *_opened(stripe, has, leans, begin), begin)
    edges = np.diff(np.concatenate([[0], has.astype(np.int8), [0]]))
    runs = zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True)
    return [piece for low, high in runs for piece in _programme(site, stripe, leans, first, (low, high))]


def _opened(
    stripe: Stripe, has: np.ndarray[tuple[int], np.dtype[np.bool_]], leans: Leans, begin: int
) -> tuple[Stripe, Leans]:
    """Give a ring as a line that begins after a gap, so that no run of it is cut where the ring closed."""
    count = len(stripe.targets) - 1
    shift = int(np.flatnonzero(~has[:-1] if not has[:-1].all() else ~has)[0])
    numbers = (np.arange(count + 1) + shift) % count
    rows = [np.flatnonzero(leans.point == number + begin) for number in numbers]
    point = np.repeat(np.arange(count + 1), [len(each) for each in rows]) + begin
    row = np.concatenate(rows)
    line = Stripe(stripe.face, stripe.targets[numbers], stripe.normals[numbers], stripe.width_mm)
    return line, Leans(point, leans.outward[row], leans.tilt_deg[row], leans.cost_deg[row])


def _programme(site: PartSite, stripe: Stripe, leans: Leans, first: Indices, run: tuple[int, int]) -> list[Piece]:
    """Dynamic programme over a run of points: least tilt, then least turning; ways between poses are proved free."""
    low, high = run
    forbidden: dict[int, set[tuple[int, int]]] = {}
    rows = np.empty(0, dtype=np.int64)
    blocked = np.zeros(max(0, high - low - 1), dtype=np.bool_)
    for _ in range(_TRIES):
        rows = _cheapest(site, stripe, leans, first[low : high + 1], forbidden)
        outward = leans.outward[rows]
        tcp = stripe.targets[low:high] + outward * site.spec.standoff_mm
        if high - low == 1:
            break
        blocked = blocked_segments(site, tcp, -outward)
        known = [int(at) for at in np.flatnonzero(blocked)]
        fresh = [at for at in known if (int(rows[at]), int(rows[at + 1])) not in forbidden.get(at, ())]
        if not fresh:
            break
        for at in fresh:
            forbidden.setdefault(at, set()).add((int(rows[at]), int(rows[at + 1])))
    cuts = [0, *(int(at) + 1 for at in np.flatnonzero(blocked)), high - low]
    return [_piece(site, stripe, leans, rows[a:b], low + a) for a, b in pairwise(cuts) if b > a]


def _cheapest(
    site: PartSite, stripe: Stripe, leans: Leans, first: Indices, forbidden: dict[int, set[tuple[int, int]]]
) -> Indices:
    """(m,) rows of ``leans``, one for each point of a run."""
    speed = site.speed_mm_s(stripe.width_mm)
    most_turn = site.limits.rotation_deg_s * site.step_mm / speed
    cost = leans.cost_deg[first[0] : first[1]].copy()
    came: list[Indices] = []
    for number in range(1, len(first) - 1):
        before, here = (slice(first[number - 1], first[number]), slice(first[number], first[number + 1]))
        cosines = np.clip(leans.outward[before] @ leans.outward[here].T, -1.0, 1.0)
        turns = np.degrees(np.arccos(cosines))
        edges = cost[:, None] + _TURN_WEIGHT * turns + np.where(turns > most_turn, _TOO_FAST, 0.0)
        for one, two in forbidden.get(number - 1, ()):
            edges[one - first[number - 1], two - first[number]] += _FORBIDDEN
        edges = np.round(edges, 6)  # ties go to the first, wherever the part lies
        best = np.argmin(edges, axis=0)
        came.append(best)
        cost = edges[best, np.arange(len(best))] + leans.cost_deg[here]
    rows = [int(np.argmin(np.round(cost, 6)))]
    for best in reversed(came):
        rows.append(int(best[rows[-1]]))
    return np.array(rows[::-1], dtype=np.int64) + first[:-1]


def _piece(site: PartSite, stripe: Stripe, leans: Leans, rows: Indices, begin: int) -> Piece:
    targets = stripe.targets[begin : begin + len(rows)]
    outward = leans.outward[rows]
    tcp = targets + outward * site.spec.standoff_mm
    speed = site.speed_mm_s(stripe.width_mm)
    pauses = np.zeros(len(rows))
    if len(rows) == 1:
        pauses[0] = site.spec.required_s
    seconds = seconds_along(site, targets, tcp, -outward, speed)
    return Piece(stripe.face, targets, tcp, -outward, leans.tilt_deg[rows], seconds, pauses)
