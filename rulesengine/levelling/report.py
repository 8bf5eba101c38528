"""What levelling changed, step by step."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Scalars
from specs.source import Source

Goal: TypeAlias = Literal["least-time", "even-film"]


@dataclass(frozen=True, slots=True)
class FilmSpread:
    """A film over some cells, um."""

    cells: int
    least: float
    mean: float
    most: float
    deviation: float
    """Greatest |film - target| / target; of least time, the greatest share by which a cell misses what it requires."""


@dataclass(frozen=True, slots=True)
class FilmOf:
    """The film of one set of speeds on the cells of the program, and on a finer, shifted set."""

    planned: FilmSpread
    finer: FilmSpread


@dataclass(frozen=True, slots=True)
class LevelledStep:
    """One step of the sequence."""

    made_by: Source
    function: str
    nozzle: str
    target_um: float
    """Film to reach: everywhere (even film), or wherever a place got as much before (least time)."""
    before: FilmOf
    after: FilmOf
    timed: FilmSpread
    """Film of the timed program, with its ramps, on the finer cells."""
    spray_before_s: float
    """Of the passes that were levelled, at their programmed speeds."""
    spray_after_s: float
    bound_s: float
    """Least spraying time, by duality; of even film the least deviation there can be."""
    gap: float
    """Relative duality gap over all cells."""
    segments: int
    knots: int
    rows: int
    rounds: int
    below: int
    """Finer cells that had less than the target before."""
    below_lose: float
    """Share that one of them loses at most."""
    short: int
    """Cells that could not get what they require at the slowest speeds."""


@dataclass(frozen=True, slots=True)
class Amounts:
    """Of a timed program."""

    duration_s: float
    spray_s: float
    litres: float


@dataclass(frozen=True, slots=True)
class LevelReport:
    """What levelling changed."""

    goal: Goal
    steps: tuple[LevelledStep, ...]
    before: Amounts
    after: Amounts


def spread_of(film: Scalars, required: Scalars, goal: Goal) -> FilmSpread:
    """Compare (n,) films with what each cell is to have."""
    some = required > 0.0
    off = (required - film)[some] / required[some]
    off = off if goal == "least-time" else np.abs(off)
    worst = float(np.max(off, initial=0.0))
    return FilmSpread(len(film), float(film.min()), float(film.mean()), float(film.max()), worst)
