"""Standoffs along passes that make a film more even: sequential linear programs over paces and standoffs at once.

On concave ground a jet's pattern is narrower across the pass than on a plane, on convex ground wider, which speeds
cannot mend: neighbouring passes no longer overlap as their spacing was chosen for. Moving the nozzle along its axis
scales the pattern. The film is linear in the paces and smooth in the standoffs, so a few linear programs with its
derivatives, in bounds about the last standoffs, find both.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array, diags_array, hstack

from cleaning.exposure.segment_rates import Segments
from geometry.arrays import Indices, Scalars
from geometry.coverage.dwell import Unknowns, even_film
from rulesengine.levelling.segments import interpolated

_ROUNDS = 3
_REACH = 0.04
"""Of the standoff, by which a program may change it at first."""
_STEP = 0.005
"""Of the standoff: a difference for derivatives."""
_STEEPEST = 0.1
"""Change of the standoff along the way, mm/mm, at most."""
_APART = 0.6
"""Way between knots, as a share of the standoff."""
_GAIN = 1e-4
"""Of the film: the search ends where a program promises less."""


@dataclass(frozen=True, slots=True, eq=False)
class StandoffFit:
    """Standoffs that were found."""

    segments: Segments
    """Moved along their axes."""
    shifts_mm: Scalars
    """(segments, 2) by which begin and end of each are moved away from the surface."""
    deviation: float
    """Greatest relative deviation from the film, with the best paces."""
    before: float
    """The same with the standoffs as they were."""


def moved(segments: Segments, shifts_mm: Scalars) -> Segments:
    """Move the ends of segments away from the surface, along the jet, by (n, 2) mm."""
    return replace(segments, tcp=segments.tcp - segments.approach * shifts_mm[:, :, None])


def fit_standoffs(
    lay: Callable[[Segments], csr_array],
    passes: tuple[Segments, Sequence[int], float],
    paces: tuple[csr_array, Unknowns],
    film: Scalars,
    band_mm: float,
) -> StandoffFit:
    """Find standoffs within a band about the present ones whose film, with the best paces, deviates least.

    Args:
        lay: (m, n) what segments lay on the cells, um/s.
        passes: n segments, how many of them each pass has, and the present standoff, mm.
        paces: (n, k) seconds of each segment for one unit of each knot's pace, and the bounds of those.
        film: (m,) above 0, to lay on the cells, um.
        band_mm: By which the nozzle may be moved along its axis, towards the surface and away from it.

    Raises:
        ValueError: no paces keep to their bounds.
    """
    segments, counts, standoff_mm = passes
    seconds, unknowns = paces
    begin, end, pairs, ways = _knots(segments, counts, _APART * standoff_mm)
    knots = begin.shape[1]
    shifts, reach, difference = np.zeros(knots), _REACH * standoff_mm, _STEP * standoff_mm

    def at(values: Scalars, more: tuple[float, float] = (0.0, 0.0)) -> Segments:
        return moved(segments, np.column_stack([begin @ values + more[0], end @ values + more[1]]))

    rates = lay(segments)
    first = even_film(csr_array(rates @ seconds), film, unknowns)
    pace, best = first.values, first.value
    for _ in range(_ROUNDS):
        spent = diags_array(seconds @ pace / difference)
        slopes = (lay(at(shifts, (difference, 0.0))) - rates) @ spent @ begin
        slopes = slopes + (lay(at(shifts, (0.0, difference))) - rates) @ spent @ end
        low, high = np.maximum(-reach, -band_mm - shifts), np.minimum(reach, band_mm - shifts)
        rest = _STEEPEST * ways - (shifts[pairs[:, 1]] - shifts[pairs[:, 0]])
        both = _joint(unknowns, (low, high), pairs, rest)
        found = even_film(csr_array(hstack([rates @ seconds, slopes])), film, both)
        trial = shifts + found.values[len(pace) :]
        tried = lay(at(trial))
        deviation = float(np.abs(tried @ (seconds @ found.values[: len(pace)]) / film - 1.0).max())
        promised = best - found.value
        if deviation < best:
            shifts, pace, best, rates = trial, found.values[: len(pace)], deviation, tried
        else:
            reach /= 3.0
        if promised < _GAIN:
            break
    ends = np.column_stack([begin @ shifts, end @ shifts])
    return StandoffFit(moved(segments, ends), ends, best, first.value)


def _knots(segments: Segments, counts: Sequence[int], apart_mm: float) -> tuple[csr_array, csr_array, Indices, Scalars]:
    """Shares (n, k) of knots in the shifts of begins and of ends, (c, 2) neighbours, and (c,) ways between them, mm."""
    lengths = segments.lengths
    ends = np.cumsum(counts)
    ways = [float(lengths[end - count : end].sum()) for end, count in zip(ends.tolist(), counts, strict=True)]
    parts = [max(1, round(way / apart_mm)) for way in ways]
    begin, pairs = interpolated(counts, parts, 0.0)
    end, _ = interpolated(counts, parts, 1.0)
    apart = np.repeat(np.array(ways) / np.array(parts), parts)
    return begin, end, np.concatenate([pairs, pairs[:, ::-1]]), np.concatenate([apart, apart])


def _joint(unknowns: Unknowns, bounds: tuple[Scalars, Scalars], pairs: Indices, change: Scalars) -> Unknowns:
    """Paces and changes of standoffs as the unknowns of one program."""
    low, high = bounds
    return Unknowns(
        seconds=np.append(unknowns.seconds, np.zeros(len(low))),
        least=np.append(unknowns.least, low),
        most=np.append(unknowns.most, high),
        pairs=np.concatenate([unknowns.pairs, pairs + len(unknowns.seconds)]),
        slope=np.append(unknowns.slope, np.ones(len(pairs))),
        change=np.append(unknowns.change, change),
    )
