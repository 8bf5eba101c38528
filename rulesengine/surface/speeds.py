"""Speeds along stripes: the least time that holds every place in the cone as long as required, by a linear program.

The unknowns are the times of stretches of the stripes and of the pauses at poses of their own; a cell gets from each
its rate, integrated along the stretch. Limits of speed and of turning bound the times from below.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import coo_array, csr_array

from geometry.arrays import Indices, Scalars
from geometry.coverage.dwell import Unknowns, least_time
from geometry.coverage.time_bound import golden_shares
from rulesengine.surface.coverage import Covered, Sight, cover, strongest_of
from rulesengine.surface.piece import Piece, seconds_along
from rulesengine.surface.site import PartSite

MARGIN = 1.02
"""Times the required time that is aimed at: other places than the middles of the cells are held too."""
_REACHED = 0.5
"""Rate that some stretch must have on a cell before the cell is required of the stripes: others need their own pose."""
_MOST_UNKNOWNS = 1500
"""Above it neighbouring segments of a stripe share one factor."""
_TANGENTS = 3
"""Times that the bounds of acceleration are laid anew."""
_LONGEST = 3.0
"""Times the required time that a segment takes at most; no cell above ``_REACHED`` needs more."""
_LEAST_PAUSE_S = 0.02
_PREFERENCE = 1e-3
"""Of the costs: of equally short solutions the same one is taken wherever the part lies."""


@dataclass(frozen=True, slots=True, eq=False)
class _Stretches:
    """The unknown times of pieces, in their order."""

    of_time: csr_array
    """(times, unknowns) share of each unknown in each time of ``moments_of``."""
    least: Scalars
    """(unknowns,) by limits of speed and turning, and from rest to rest."""
    ways: Scalars
    """(unknowns,) of the orifice, mm; infinite of pauses."""
    pairs: Indices
    """(c, 2) neighbouring unknowns of a piece, in both senses."""


def choose_speeds(site: PartSite, covered: Covered, sight: Sight) -> Covered:
    """Give the pieces the times that hold all that they see long enough in the least time; useless pauses go."""
    stretches = _stretches(site, covered.pieces)
    rates = csr_array(rates_of(covered) @ stretches.of_time)
    required_cells = np.flatnonzero(sight.visible & (strongest_of(rates) >= _REACHED))
    count = len(stretches.least)
    required = MARGIN * site.spec.required_s
    longest = _LONGEST * required * stretches.of_time.sum(axis=0)
    # Of a way hardly longer than corners are cut by, little is left to be slow on.
    unknowns = Unknowns(
        seconds=preferred(count),
        least=stretches.least,
        most=np.where(
            stretches.ways > 2.0 * site.limits.blend_mm, np.maximum(stretches.least, longest), stretches.least
        ),
        pairs=np.empty((0, 2), dtype=np.int64),
        slope=np.empty(0),
        change=np.empty(0),
    )
    some, needed = csr_array(rates[required_cells]), np.full(len(required_cells), required)
    found = least_time(some, needed, unknowns)
    for _ in range(_TANGENTS):
        found = least_time(some, needed, _with_acceleration(site, unknowns, stretches, found.values), found.cells)
    times = np.asarray(stretches.of_time @ found.values, dtype=np.float64)
    return cover(site, _with_times(covered.pieces, times))


def _with_acceleration(site: PartSite, unknowns: Unknowns, stretches: _Stretches, times: Scalars) -> Unknowns:
    """Bound the times of neighbouring segments so that the orifice keeps to its acceleration between them.

    A segment of length d that is entered at the speed v of its neighbour takes 2 d / (v + (v² + 2 a d)^(1/2)) at least.
    That is concave in the neighbour's time: its tangents at times near by allow too little and never too much.
    """
    one, other = stretches.pairs.T
    ways, speed = stretches.ways[one], stretches.ways[other] / times[other]
    onward = np.sqrt(speed**2 + 2.0 * site.acceleration_mm_s2 * ways)
    least = 2.0 * ways / (speed + onward)
    # d least / d speed = -least / onward; d speed / d time = -speed / time
    slope = np.minimum(least / onward * speed / times[other], 1.0)
    return replace(unknowns, pairs=stretches.pairs, slope=slope, change=slope * times[other] - least)


def rates_of(covered: Covered) -> csr_array:
    """(cells, times) seconds in the cone of each cell for a second of each time: of segments, then of pauses."""
    moments = covered.moments
    total = sum(len(piece.seconds) + len(piece.tcp) for piece in covered.pieces)
    rows = np.arange(len(moments.part))
    shares = csr_array(coo_array((moments.share, (rows, moments.part)), shape=(len(rows), total)))
    return csr_array(covered.view.T @ shares)


def preferred(count: int) -> Scalars:
    """(count,) costs of a second: all but equal, so that the cheapest solution is one."""
    return 1.0 + _PREFERENCE * golden_shares(count)


def _stretches(site: PartSite, pieces: tuple[Piece, ...]) -> _Stretches:
    segments = sum(len(piece.seconds) for piece in pieces)
    together = max(1, int(np.ceil(segments / _MOST_UNKNOWNS)))
    rows: list[Indices] = []
    columns: list[Indices] = []
    shares: list[Scalars] = []
    least: list[Scalars] = []
    lengths: list[Scalars] = []
    pairs: list[Indices] = []
    first, pose, unknown = 0, segments, 0
    for piece in pieces:
        count = len(piece.seconds)
        fastest = seconds_along(site, piece.targets, piece.tcp, piece.approach, site.max_speed_mm_s)
        group = np.arange(count) // together
        groups = int(group[-1]) + 1 if count else 0
        whole = np.bincount(group, fastest, groups)
        ways = np.asarray(np.bincount(group, piece.ways_mm, groups), dtype=np.float64)
        held = np.flatnonzero(piece.pauses_s > 0)
        rows += [first + np.arange(count), pose + held]
        columns += [unknown + group, unknown + groups + np.arange(len(held))]
        shares.append(np.asarray(fastest / whole[group] if count else np.empty(0), dtype=np.float64))
        shares.append(np.ones(len(held)))
        least += [np.maximum(np.asarray(whole, dtype=np.float64), _from_rest(site, ways)), np.zeros(len(held))]
        lengths += [ways, np.full(len(held), np.inf)]
        long = ways > 2.0 * site.limits.blend_mm
        inner = unknown + np.flatnonzero(long[1:] & long[:-1])
        pairs += [np.column_stack([inner, inner + 1]), np.column_stack([inner + 1, inner])]
        first, pose, unknown = first + count, pose + len(piece.tcp), unknown + groups + len(held)
    places = np.concatenate(rows).astype(np.int64), np.concatenate(columns).astype(np.int64)
    of_time = csr_array(coo_array((np.concatenate(shares), places), shape=(pose, unknown)))
    return _Stretches(of_time, np.concatenate(least), np.concatenate(lengths), np.concatenate(pairs).astype(np.int64))


def _from_rest(site: PartSite, ways: Scalars) -> Scalars:
    """(n,) least times of segments of a way that begins and ends at rest."""
    along = np.concatenate([[0.0], np.cumsum(ways)])
    from_begin = np.diff(np.sqrt(2.0 * along / site.acceleration_mm_s2))
    from_end = -np.diff(np.sqrt(2.0 * np.maximum(along[-1] - along, 0.0) / site.acceleration_mm_s2))
    return np.maximum(from_begin, from_end)


def _with_times(pieces: tuple[Piece, ...], times: Scalars) -> list[Piece]:
    """Pieces with their times; what only pauses and need not, is left out."""
    first, pose = 0, sum(len(piece.seconds) for piece in pieces)
    found: list[Piece] = []
    for piece in pieces:
        count = len(piece.tcp)
        pauses = np.where(times[pose : pose + count] >= _LEAST_PAUSE_S, times[pose : pose + count], 0.0)
        if count > 1 or pauses[0] > 0:
            found.append(replace(piece, seconds=times[first : first + count - 1], pauses_s=pauses))
        first, pose = first + count - 1, pose + count
    return found
