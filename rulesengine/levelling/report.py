"""What levelling changed, step by step."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

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
    """Greatest |film - target| / target; of least time, the greatest share by which a cell misses the film, or all but
    the least tenth of a component what they had."""


@dataclass(frozen=True, slots=True)
class FilmOf:
    """The film of one set of speeds on the cells of the program, and on a finer, shifted set."""

    planned: FilmSpread
    finer: FilmSpread


@dataclass(frozen=True, slots=True)
class LevelledStep:
    """One step of the sequence."""

    levelled: bool
    """False: ramps would take back all that is saved, and the step keeps its speeds."""
    made_by: Source
    function: str
    nozzle: str
    target_um: float | None
    """Film to reach: everywhere (even film), or wherever a place got as much before (least time). None: each component
    keeps what nine tenths of its cells had, and so does the bare board."""
    surfaces: int
    """Components that the step reaches, with the bare board; 0 with a film to reach."""
    before: FilmOf
    """Of the timed program, with its ramps."""
    after: FilmOf
    """Of the linear program."""
    timed: FilmOf
    """Of the timed program, with its ramps."""
    spray_before_s: float
    """Of the passes that were levelled, in the timed program."""
    spray_after_s: float
    """In the timed program, with its ramps."""
    planned_s: float
    """Without them."""
    bound_s: float
    """Least spraying time of the linear program, by duality; of even film the least deviation there can be."""
    gap: float
    """Relative duality gap over all cells."""
    segments: int
    knots: int
    rows: int
    rounds: int
    below: int
    """Finer cells that had less than they would have to keep, and lose some of it."""
    below_lose: float
    """Share that one of them loses at most."""
    kept_s: float
    """Spraying time that was kept for ``least_time_s`` of the step, of what could be saved."""
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
