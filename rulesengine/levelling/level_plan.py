"""Levelling a plan: speeds along its passes that lay an even film, or what is required in the least time.

The path stays as it is. Passes are divided into short segments; the pace (seconds per mm) is linear between knots, so
that speeds change smoothly; a linear program finds the paces (``geometry.coverage.dwell``). What other passes of the
step lay is counted. The result is always compared on a finer, shifted set of cells, and after timing.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from boards.board import Board, Side
from cleaning.exposure.segment_rates import Segments, segment_rates
from cleaning.jet.compiled_jet import JetForm
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from cleaning.surface.facets import build_scene
from geometry.arrays import Indices, Scalars
from geometry.coverage.dwell import DwellTimes, Unknowns, even_film, least_time
from geometry.rays import RayScene
from programs.plan import Plan, SprayPass
from programs.program import MoveTo, SetNozzle, TimedProgram
from recipes.errors import RecipeError
from recipes.footprint import footprint
from recipes.paths import FinalFlush, Raster
from recipes.recipe import Recipe
from rulesengine.levelling.report import (
    Amounts,
    FilmOf,
    Goal,
    LevelledStep,
    LevelReport,
    spread_of,
)
from rulesengine.levelling.seen_cells import SeenCells, cells_of_side
from rulesengine.timing.time_plan import time_plan
from specs.progress import Progress, no_progress
from specs.source import Source

_LEVELLED = (Raster, FinalFlush)
_SEGMENTS, _KNOTS = 5.0, 2
"""Segments in the radius of the spray, and segments from knot to knot."""
_CELLS = 14.0
"""Cells in the radius of the spray."""
_FINER, _SHIFT = 0.61, 0.37
"""Pitch of the finer cells, and their shift in shares of it."""
_SLOWEST = 0.05
"""Slowest speed, as a share of the function's maximum."""
_QUANTILE = 0.05
"""Of the cells, which set the film that least time keeps."""
_LEAST_SHARE = 0.1
"""A cell that gets less than this share of the mean is taken as hidden: it is for the paths around components."""


@dataclass(frozen=True, slots=True, eq=False)
class _Target:
    """Cells, and what each is to have."""

    cells: SeenCells
    rates: csr_array
    """(m, segments) of the passes that are levelled."""
    others: Scalars
    """(m,) film of the other passes of the step."""
    before: Scalars
    """(m,) film at the present speeds, others included."""
    required: Scalars
    """(m,)"""


def level_plan(
    plan: Plan,
    board: Board,
    recipe: Recipe,
    goal: Goal,
    film_um: float | None = None,
    progress: Progress = no_progress,
) -> tuple[Plan, LevelReport]:
    """Level the rasters and flushes of a plan, step by step; air knives and gas are left aside.

    Args:
        plan: Of the recipe on the board.
        board: Whose surface is sprayed.
        recipe: As it was planned.
        goal: ``least-time`` keeps ``film_um`` wherever it is now; what has less, mostly in the shadow of components, is
            for other paths, and the report states what it loses. ``even-film`` makes the greatest deviation from
            ``film_um`` least.
        film_um: Left out: the film that all but a twentieth of the cells get now (least time); the mean (even film).
        progress: Receives the stage and the share done.

    Raises:
        RecipeError: no raster or flush sprays a liquid.
    """
    passes = [(at, each) for at, each in enumerate(plan.items) if isinstance(each, SprayPass) and each.jet.liquid]
    steps = dict.fromkeys(each.made_by.step for _, each in passes if _is_levelled(each, recipe))
    if not steps:
        raise RecipeError("no raster or final_flush sprays a liquid, so there is nothing to level", path="templates")
    scene = build_scene(board)
    items = list(plan.items)
    levellers: list[_Leveller] = []
    for done, step in enumerate(steps):
        progress("levelling", done / len(steps))
        mine = [(at, each) for at, each in passes if each.made_by.step == step]
        leveller = _Leveller(board, scene, recipe, goal, mine)
        leveller.solve(film_um)
        for at, each in leveller.levelled:
            items[at] = each
        levellers.append(leveller)
    after = replace(plan, items=tuple(items))
    timed = [time_plan(each, recipe.limits) for each in (plan, after)]
    reports = tuple(each.report(timed[1]) for each in levellers)
    progress("done", 1.0)
    return after, LevelReport(goal, reports, *(_amounts(each) for each in timed))


def _is_levelled(each: SprayPass, recipe: Recipe) -> bool:
    return isinstance(recipe.templates.get(each.made_by.template), _LEVELLED)


def _amounts(program: TimedProgram) -> Amounts:
    totals = program.totals
    return Amounts(totals.duration_s, totals.spray_s, sum(litres for _, litres in totals.liquid_l))


class _Leveller:
    """Levels the passes of one step."""

    def __init__(
        self, board: Board, scene: RayScene, recipe: Recipe, goal: Goal, passes: Sequence[tuple[int, SprayPass]]
    ) -> None:
        self._goal: Goal = goal
        self._board, self._scene = board, scene
        _, first = passes[0]
        nozzle = recipe.nozzles[first.jet.nozzle]
        self._form: JetForm = form_of(nozzle, first.jet.flow_lpm, load_parameters("default").spray)
        self._side: Side = "top" if float(first.approach[0, 2]) < 0.0 else "bottom"
        height = float(np.mean([abs(each.tcp[:, 2] - board.surface_z_mm(self._side)).mean() for _, each in passes]))
        down, along = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
        self._radius_mm = float(np.linalg.norm(footprint(nozzle, height, down, along), axis=1).min())
        self._fastest = recipe.functions[first.jet.function].max_speed_mm_s
        self._acceleration = recipe.limits.acceleration_mm_s2
        self._before = [(at, _divided(each, self._radius_mm / _SEGMENTS)) for at, each in passes]
        self._chosen = [(at, each) for at, each in self._before if _is_levelled(each, recipe)]
        self._others = [each for _, each in self._before if not _is_levelled(each, recipe)]
        self._segments = _segments_of([each for _, each in self._chosen])
        self._makers = frozenset(each.made_by for _, each in passes)
        self.levelled: list[tuple[int, SprayPass]] = []

    def solve(self, film_um: float | None) -> None:
        """Find the speeds."""
        pitch = self._radius_mm / _CELLS
        cells = cells_of_side(self._board, self._side, self._scene, pitch, 0.5)
        self._target = self._aim(cells, film_um)
        finer = cells_of_side(self._board, self._side, self._scene, pitch * _FINER, _SHIFT)
        self._finer = self._aim(finer, self._film_um)
        lengths = self._segments.lengths
        counts = [len(each.speeds_mm_s) for _, each in self._chosen]
        weights, pairs = _knots(counts)
        seconds_of = csr_array(weights.multiply(lengths[:, None]))
        self._knots = len(pairs) + len(counts)
        knot_mm = _KNOTS * float(lengths.mean())
        # A pass begins and ends at rest: nearer to its ends than a ramp no speed above the ramp's is had.
        ramp_mm = np.maximum(_from_end(counts), 0.5) * knot_mm
        reached = np.minimum(np.sqrt(2.0 * self._acceleration * ramp_mm), self._fastest)
        least = 1.0 / reached
        unknowns = Unknowns(
            seconds=np.asarray(seconds_of.sum(axis=0)).ravel(),
            least=least,
            most=np.maximum(least, 1.0 / (_SLOWEST * self._fastest)),
            pairs=pairs,
            # d(pace)/ds = -a / v³: the paper's eq. (6), linearised where the passes are fastest.
            change=np.full(len(pairs), self._acceleration * knot_mm / self._fastest**3),
        )
        rates = csr_array(self._target.rates @ seconds_of)
        self._found = self._solved(rates, unknowns)
        paces = weights @ self._found.values
        self._times = lengths * paces
        speeds = np.minimum(1.0 / paces, self._fastest)
        ends = np.cumsum(counts)
        for (at, each), end, count in zip(self._chosen, ends.tolist(), counts, strict=True):
            self.levelled.append((at, replace(each, speeds_mm_s=speeds[end - count : end])))

    def _solved(self, rates: csr_array, unknowns: Unknowns) -> DwellTimes:
        left = self._target.required - self._target.others
        if self._goal == "least-time":
            return least_time(rates, np.maximum(left, 0.0), unknowns)
        open_ = left > 0.0
        return even_film(csr_array(rates[np.flatnonzero(open_)]), left[open_], unknowns)

    def _aim(self, cells: SeenCells, film_um: float | None) -> _Target:
        """What each cell that is not hidden is to have."""
        rates = segment_rates(self._form, self._segments, cells.points, cells.normals, self._scene)
        others = np.zeros(len(cells.points))
        if self._others:
            along = segment_rates(self._form, _segments_of(self._others), cells.points, cells.normals, self._scene)
            others = along @ _seconds(self._others)
        before = others + rates @ _seconds([each for _, each in self._chosen])
        seen = np.flatnonzero(before - others > _LEAST_SHARE * float(before.mean()))
        rates, others, before = csr_array(rates[seen]), others[seen], before[seen]
        level = film_um
        if level is None:
            level = float(np.quantile(before, _QUANTILE) if self._goal == "least-time" else before.mean())
        self._film_um = level
        required = np.full(len(before), level)
        if self._goal == "least-time":
            required[before < level] = 0.0
        return _Target(SeenCells(cells.points[seen], cells.normals[seen]), rates, others, before, required)

    def report(self, timed: TimedProgram) -> LevelledStep:
        """What was changed, with the film of the timed program."""
        goal = self._goal
        both = (self._target, self._finer)
        before = [spread_of(each.before, each.required, goal) for each in both]
        after = [spread_of(each.others + each.rates @ self._times, each.required, goal) for each in both]
        moves, seconds = _sprayed_moves(timed, self._makers)
        moves, seconds = _cut(moves, seconds, self._radius_mm / _SEGMENTS)
        cells = self._finer.cells
        film = segment_rates(self._form, moves, cells.points, cells.normals, self._scene) @ seconds
        _, first = self._chosen[0]
        found = self._found
        return LevelledStep(
            made_by=Source(first.made_by.step),
            function=first.jet.function,
            nozzle=first.jet.nozzle,
            target_um=self._film_um,
            before=FilmOf(*before),
            after=FilmOf(*after),
            timed=spread_of(film, self._finer.required, goal),
            spray_before_s=float(_seconds([each for _, each in self._chosen]).sum()),
            spray_after_s=float(self._times.sum()),
            bound_s=found.bound,
            gap=found.gap,
            segments=len(self._times),
            knots=self._knots,
            rows=found.rows,
            rounds=found.rounds,
            short=len(found.short),
            below=self._below(),
            below_lose=self._lost(),
        )

    def _below(self) -> int:
        """Finer cells that had less than the target before."""
        return int((self._finer.before < self._film_um).sum())

    def _lost(self) -> float:
        """Share of its film that a place below the target loses at most, on the finer cells."""
        target = self._finer
        below = target.before < self._film_um
        after = target.others + target.rates @ self._times
        return float(np.max(1.0 - after[below] / target.before[below], initial=0.0))


def _divided(each: SprayPass, longest_mm: float) -> SprayPass:
    """Divide the segments of a pass evenly, none longer; directions turn evenly along them."""
    lengths = np.linalg.norm(np.diff(each.tcp, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / longest_mm - 1e-9), 1).astype(np.int64)
    segment = np.repeat(np.arange(len(lengths)), counts)
    share = (np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[segment]

    def mixed(values: NDArray[np.float64], *, unit: bool) -> NDArray[np.float64]:
        between = values[segment] + share[:, None] * (values[segment + 1] - values[segment])
        between = np.concatenate([between, values[-1:]])
        return between / np.linalg.norm(between, axis=1, keepdims=True) if unit else between

    return replace(
        each,
        tcp=mixed(each.tcp, unit=False),
        approach=mixed(each.approach, unit=True),
        reference=mixed(each.reference, unit=True),
        speeds_mm_s=each.speeds_mm_s[segment],
    )


def _cut(segments: Segments, seconds: Scalars, longest_mm: float) -> tuple[Segments, Scalars]:
    """Cut long moves into equal parts: what is hidden from a segment is found a few times on each."""
    counts = np.maximum(np.ceil(segments.lengths / longest_mm - 1e-9), 1).astype(np.int64)
    whole = np.repeat(np.arange(len(counts)), counts)
    first = (np.arange(len(whole)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[whole]

    def parts(ends: NDArray[np.float64]) -> NDArray[np.float64]:
        shares = np.stack([first, first + 1.0 / counts[whole]], axis=1)[:, :, None]
        begin, end = ends[whole, :1], ends[whole, 1:]
        return begin + shares * (end - begin)

    cut = Segments(parts(segments.tcp), parts(segments.approach), parts(segments.reference))
    return cut, seconds[whole] / counts[whole]


def _segments_of(passes: Iterable[SprayPass]) -> Segments:
    ends = [
        [np.stack([values[:-1], values[1:]], axis=1) for values in (each.tcp, each.approach, each.reference)]
        for each in passes
    ]
    return Segments(*(np.concatenate([each[k] for each in ends]) for k in range(3)))


def _seconds(passes: Sequence[SprayPass]) -> Scalars:
    """(segments,) at the programmed speeds."""
    lengths = [np.linalg.norm(np.diff(each.tcp, axis=0), axis=1) / each.speeds_mm_s for each in passes]
    return np.concatenate(lengths)


def _knots(counts: Sequence[int]) -> tuple[csr_array, Indices]:
    """(segments, knots) pace in the middle of each segment from those at knots, and (c, 2) neighbouring knots."""
    rows: list[Indices] = []
    columns: list[Indices] = []
    values: list[Scalars] = []
    pairs: list[Indices] = []
    segments = knots = 0
    for count in counts:
        parts = max(1, round(count / _KNOTS))
        place = np.asarray((np.arange(count) + 0.5) / count * parts, dtype=np.float64)
        low = np.minimum(place.astype(np.int64), parts - 1)
        rows += [segments + np.arange(count)] * 2
        columns += [knots + low, knots + low + 1]
        values += [1.0 - (place - low), place - low]
        pairs.append(np.column_stack([knots + np.arange(parts), knots + np.arange(parts) + 1]))
        segments, knots = segments + count, knots + parts + 1
    places = (np.concatenate(rows), np.concatenate(columns))
    weights = csr_array((np.concatenate(values), places), shape=(segments, knots))
    return weights, np.concatenate(pairs).astype(np.int64)


def _from_end(counts: Sequence[int]) -> Scalars:
    """(knots,) how many knots each is from the nearer end of its pass."""
    parts = [max(1, round(count / _KNOTS)) for count in counts]
    each = [np.minimum(np.arange(part + 1), part - np.arange(part + 1)) for part in parts]
    return np.concatenate(each).astype(np.float64)


def _sprayed_moves(program: TimedProgram, makers: frozenset[Source]) -> tuple[Segments, Scalars]:
    """Moves of a program with the jet on that were made by some sources, and the seconds that each takes."""
    last: MoveTo | None = None
    on = False
    found: list[tuple[MoveTo, MoveTo]] = []
    for each in program.instructions:
        if isinstance(each, SetNozzle):
            on = each.spraying
        elif isinstance(each, MoveTo):
            moved = last is not None and (each.position, each.quaternion) != (last.position, last.quaternion)
            if on and last is not None and moved and each.made_by in makers:
                found.append((last, each))
            last = each
    places = np.array([[one.position, other.position] for one, other in found], dtype=np.float64)
    turns = np.array([[one.quaternion, other.quaternion] for one, other in found], dtype=np.float64)
    axes = Rotation.from_quat(turns.reshape(-1, 4), scalar_first=True).as_matrix().reshape(len(found), 2, 3, 3)
    seconds = np.array([other.time_s - one.time_s for one, other in found], dtype=np.float64)
    return Segments(places, axes[..., 2].copy(), axes[..., 0].copy()), seconds
