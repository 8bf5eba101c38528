"""What each place of a surface is to have, and how far films are from it."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from geometry.arrays import Indices, Scalars
from rulesengine.levelling.report import FilmSpread, Goal
from rulesengine.levelling.seen_cells import SeenCells

_TENTH = 0.1
_LEAST_SHARE = 0.1
"""A cell that gets less than this share of the mean is taken as hidden: it is for the paths around components."""


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """Cells that the levelled passes reach, and what each is to have."""

    cells: SeenCells
    rates: csr_array
    """(m, segments) of the passes that are levelled."""
    others: Scalars
    """(m,) film of the other passes of the step, timed."""
    before: Scalars
    """(m,) film at the present speeds, timed, others included."""
    surface: Indices
    """(m,) from 0: which component, or the bare board; all 0 with one film for all."""
    least: Scalars
    """(m,) film of all cells of a surface but its least tenth; or the film to reach."""
    film_um: float | None
    """The film to reach, the same for all; None where surfaces keep what they had."""

    def required(self, goal: Goal, factors: Scalars) -> Scalars:
        """(m,) that each cell is to have, with (surfaces,) factors; 0 where it is free."""
        if goal == "even-film":
            return self.least
        return np.where(self.before >= self.least, self.least * factors[self.surface], 0.0)

    def shares(self, film: Scalars) -> Scalars:
        """(surfaces,) what all cells but the least tenth have, as a share of what they had."""
        return least_tenths(film, self.surface) / least_tenths(self.before, self.surface)

    def spread(self, film: Scalars, goal: Goal) -> FilmSpread:
        """Compare (m,) films with what is to be had."""
        if self.film_um is None:
            off = 1.0 - self.shares(film)
        else:
            required = self.required(goal, np.ones(int(self.surface.max(initial=0)) + 1))
            some = required > 0.0
            off = (required - film)[some] / required[some]
            off = off if goal == "least-time" else np.abs(off)
        worst = float(np.max(off, initial=0.0))
        return FilmSpread(len(film), float(film.min()), float(film.mean()), float(film.max()), worst)


def aim(
    cells: SeenCells, rates: csr_array, films: tuple[Scalars, Scalars], goal: Goal, film_um: float | None
) -> Target:
    """Find what each cell that the levelled passes reach is to have.

    Args:
        cells: m of them.
        rates: (m, segments) of the levelled passes.
        films: (m,) of the levelled passes and of the others, timed, at the present speeds.
        goal: What the speeds are for.
        film_um: To be reached. Left out: each surface keeps its least tenth (least time), or the mean (even film).
    """
    own, others = films
    before = own + others
    equal = goal == "least-time" and film_um is None
    seen = np.flatnonzero(own > (0.0 if equal else _LEAST_SHARE * float(before.mean())))
    before = before[seen]
    surface = np.zeros(len(seen), dtype=np.int64)
    if equal:
        _, surface = np.unique(cells.surface[seen], return_inverse=True)
        least = least_tenths(before, surface)[surface]
    else:
        film_um = float(before.mean()) if film_um is None else film_um
        least = np.full(len(before), film_um)
    kept = SeenCells(cells.points[seen], cells.normals[seen], cells.surface[seen])
    return Target(kept, csr_array(rates[seen]), others[seen], before, surface.astype(np.int64), least, film_um)


def least_tenths(film: Scalars, surface: Indices) -> Scalars:
    """(surfaces,) the greatest film that at least nine tenths of the cells of a surface have.

    Args:
        film: (m,)
        surface: (m,) from 0, none without a cell.
    """
    order = np.lexsort((film, surface))
    counts = np.bincount(surface)
    first = np.cumsum(counts) - counts
    return film[order[first + np.floor(_TENTH * counts).astype(np.int64)]]
