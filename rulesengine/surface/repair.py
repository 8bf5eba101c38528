"""Automatic repair: stripes chosen among many, speeds that hold what they see, and poses of their own for the rest.

The least time that holds every place in the cone as long as required is found by linear programs. The unknowns are the
times of stretches of the stripes and of the pauses at poses of their own; a cell gets from each its rate, integrated
along the stretch. Limits of speed and of turning bound the times from below.
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.sparse import coo_array, csr_array

from geometry.arrays import Indices, Scalars
from geometry.coverage.dwell import Unknowns, least_time
from geometry.coverage.time_bound import golden_shares, times_of_few_groups
from geometry.solids.cone_view import Cells
from recipes.paths import Surface
from rulesengine.surface.coverage import (
    Covered,
    Sight,
    cover,
    held_at,
    poses_around,
    refine,
    share_held,
    strongest_of,
    view_of,
)
from rulesengine.surface.negotiate import negotiate_sides
from rulesengine.surface.site import PartSite, Piece, seconds_along, spot
from rulesengine.surface.striping.divide import candidate_stripes
from specs.progress import Progress, no_progress

MARGIN = 1.01
"""Times the required time that is aimed at: other places than the middles of the cells are held too."""
_OF_STRIPES = 0.5
"""Rate that some stretch must have on a cell before the cell is required of the stripes: others need their own pose."""
_MOST_UNKNOWNS = 1500
"""Above it neighbouring segments of a stripe share one factor."""
_TANGENTS = 3
"""Times that the bounds of acceleration are laid anew."""
_LONGEST = 3.0
"""Times the required time that a segment takes at most; no cell above ``_OF_STRIPES`` needs more."""
_LEAST_PAUSE_S = 0.02
_PREFERENCE = 1e-3
"""Of the costs: of equally short solutions the same one is taken wherever the part lies."""
_APART = 0.125
"""Of the footprint's diameter, between neighbouring candidates."""
_WIDEST = 0.35
"""As ``_APART``: farther from each other they are no choice."""
_DIRECTIONS = 2
_MOST_POSES = 15_000
"""Of all candidates."""
_SETUP_S = 0.3
"""What a stripe costs beside its spraying: the way to it, and its beginning and end at rest."""
_LEAST_S = 0.1
_REACHED = 0.9
_MOST_CELLS = 8000
ENOUGH = 0.995
"""Share of the visible area from which on nothing is repaired: measured on other cells it is a little less."""
ENOUGH_OF_A_FACE = 0.993
_ROUNDS = 5
_MUCH = 0.31
_LOOKED_AT = 120
"""Cells at most around which poses are looked for."""
_NEARLY_ALL = 0.97
_LEAST_SHARE = 4e-5
"""Of the visible area that a pose must help at least."""
_MOST_AT_ONCE = 150


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
    required_cells = np.flatnonzero(sight.visible & (strongest_of(rates) >= _OF_STRIPES))
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


def choose_stripes(site: PartSite, sight: Sight) -> tuple[list[Piece], int] | None:
    """Choose stripes for the faces of a part among candidates an eighth of the footprint's diameter apart.

    Returns:
        Their pieces, and the number of pieces that they were chosen of; ``None`` where the template states how wide
        stripes are, or the part is too large for as many candidates.
    """
    area = sum(face.area_mm2 for face in site.part.served)
    apart = max(_APART * site.diameter_mm, _DIRECTIONS * area / (_MOST_POSES * site.step_mm))
    if not isinstance(site.spec, Surface) or site.spec.width_mm != "auto" or apart > _WIDEST * site.diameter_mm:
        return None
    fine = replace(site, spec=site.spec.model_copy(update={"width_mm": apart}))
    stripes = [stripe for face in site.part.served for stripe in candidate_stripes(fine, face)]
    candidates = [piece for piece in negotiate_sides(fine, stripes) if len(piece.tcp) > 1]
    if not candidates:
        return None
    owner = np.repeat(np.arange(len(candidates)), [len(piece.seconds) for piece in candidates])
    # Of the visible cells some, evenly spread in their order.
    visible = np.flatnonzero(sight.visible)
    some = visible[np.unique(np.linspace(0, len(visible) - 1, min(len(visible), _MOST_CELLS)).round().astype(np.int64))]
    cells = Cells(**{each.name: getattr(site.cells, each.name)[some] for each in fields(Cells)})
    fewer = replace(site, cells=cells, cell_face=site.cell_face[some])
    rates = csr_array(rates_of(cover(fewer, candidates))[:, : len(owner)])
    reached = np.flatnonzero(strongest_of(rates) >= _REACHED)
    required = np.full(len(reached), site.spec.required_s)
    fastest = [seconds_along(site, each.targets, each.tcp, each.approach, site.max_speed_mm_s) for each in candidates]
    times = times_of_few_groups(csr_array(rates[reached]), required, owner, np.concatenate(fastest), _SETUP_S)
    spent = np.bincount(owner, times, len(candidates))
    chosen: list[Piece] = []
    for piece, time in zip(candidates, spent, strict=True):
        if time > _LEAST_S:  # pauses at its ends, where it is at rest: a program chooses how long they are
            pauses = np.zeros(len(piece.tcp))
            pauses[[0, -1]] = site.spec.required_s
            chosen.append(replace(piece, pauses_s=pauses))
    return chosen, len(candidates)


@dataclass(frozen=True, slots=True, eq=False)
class Round:
    """One round of a repair."""

    what: str
    share: float
    """Of the visible area that is held for the required time after it."""
    spray_s: float
    """Time with the jet on after it."""


def _is_enough(site: PartSite, covered: Covered, sight: Sight) -> bool:
    """Whether nothing is repaired any more: of no face much is missing, and little of all."""
    areas = site.cells.areas_mm2 * sight.visible
    held = areas * (covered.seconds >= site.spec.required_s * (1 - 1e-9))
    whole, mine = (np.bincount(site.cell_face, each) for each in (areas, held))
    return bool(held.sum() >= ENOUGH * areas.sum() and (mine >= ENOUGH_OF_A_FACE * whole).all())


def repair(
    site: PartSite, covered: Covered, sight: Sight, progress: Progress = no_progress
) -> tuple[Covered, tuple[Round, ...]]:
    """Repair in at most five rounds: stripes and speeds; then poses for what is still missing, and speeds with them.

    What is held is measured on smaller cells than the part's.
    """
    own, known = site, sight
    site, sight = refine(site, sight)
    rounds: list[Round] = []
    for number in range(_ROUNDS):
        if number:
            if _is_enough(site, covered, sight):
                break
            spots = _poses(site, covered, sight)
            if not spots:
                break
            covered = cover(site, [*covered.pieces, *spots])
            what = f"pauses at {len(spots)} poses of their own, and the speeds again"
        else:
            what, chosen = "a speed for each segment, by a linear program", choose_stripes(own, known)
            if chosen is not None:
                what = f"{len(chosen[0])} stripes chosen among {chosen[1]}, and {what}"
            covered = cover(site, covered.pieces if chosen is None else chosen[0])
        covered = choose_speeds(site, covered, sight)
        rounds.append(Round(what, share_held(site, covered, sight), covered.spray_s))
        progress("repairing", (number + 1) / _ROUNDS)
    return cover(own, covered.pieces), tuple(rounds)


def _greedy(site: PartSite, view: csr_array, missing: Scalars, sight: Sight) -> list[tuple[int, float]]:
    """Choose rows of a view and seconds for each, the one that helps most first, until what is left is little."""
    areas = site.cells.areas_mm2
    least = _LEAST_SHARE * float((areas * sight.visible).sum()) * site.spec.required_s
    chosen: list[tuple[int, float]] = []
    missing = missing.copy()
    while len(chosen) < _MOST_AT_ONCE:
        gains = np.asarray(view @ (areas * missing))
        if not len(gains) or gains.max() < least:
            break
        row = int(np.argmax(np.round(gains / gains.max(), 3)))  # the first of equal ones, wherever the part lies
        cells = view.indices[view.indptr[row] : view.indptr[row + 1]]
        cells = cells[missing[cells] > 0]
        order = cells[np.argsort(missing[cells], kind="stable")]
        share = np.cumsum(areas[order]) / areas[cells].sum()
        # After so long nearly all of the area lacks nothing.
        seconds = float(missing[order][min(int(np.searchsorted(share, _NEARLY_ALL)), len(order) - 1)])
        missing[cells] = np.maximum(missing[cells] - seconds, 0.0)
        chosen.append((row, seconds))
    return chosen


def _poses(site: PartSite, covered: Covered, sight: Sight) -> list[Piece]:
    """Pauses at poses of their own, of those that are known to see what nothing else does."""
    required = MARGIN * site.spec.required_s
    missing = np.where(sight.visible, np.maximum(required - covered.seconds, 0.0), 0.0)
    lacking = np.flatnonzero(missing > _MUCH * site.spec.required_s)  # what hardly misses it depends on rounding
    if not len(lacking):
        return []
    some = lacking[np.unique(np.linspace(0, len(lacking) - 1, _LOOKED_AT).round().astype(np.int64))]
    tcp, approach = poses_around(site, some)
    known = lacking[np.isfinite(sight.tcp[lacking, 0])]
    tcp, approach = np.vstack([tcp, sight.tcp[known]]), np.vstack([approach, sight.approach[known]])
    view = view_of(site, held_at(tcp, approach))
    found: list[Piece] = []
    for row, seconds in _greedy(site, view, missing, sight):
        cells = view.indices[view.indptr[row] : view.indptr[row + 1]]
        helped = np.bincount(site.cell_face[cells], (site.cells.areas_mm2 * missing)[cells])
        found.append(spot(site, site.part.faces[int(np.argmax(helped))].name, tcp[row], approach[row], seconds))
    return found
