"""Levelling a plan: speeds along its passes that lay an even film, or what is required in the least time.

The path stays as it is. Passes are divided into short segments; the pace (seconds per mm) is linear between knots, so
that speeds change smoothly; a linear program finds the paces (``geometry.coverage.dwell``). What other passes of the
step lay is counted. Films are those of timed programs, with all ramps, before and after; where the timed program falls
short of the film, more is required and the program solved again. It is compared on a finer set of cells too.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TypeAlias

import numpy as np
from scipy.sparse import csr_array

from boards.board import Board, Part, Side, Workpiece, scene_of
from cleaning.exposure.segment_rates import cut, joined, segment_rates, sprayed_moves
from cleaning.jet.compiled_jet import JetForm
from cleaning.jet.jet import form_of
from cleaning.parameters.load import load_parameters
from cleaning.surface.facets import build_scene
from geometry.arrays import Scalars
from geometry.coverage.dwell import Unknowns, even_film, keep_acceleration, least_time
from geometry.rays import RayScene
from programs.plan import Plan, SprayPass
from programs.program import TimedProgram
from recipes.errors import RecipeError
from recipes.footprint import footprint
from recipes.nozzles import Nozzle
from recipes.paths import FinalFlush, OverFaces, Raster
from recipes.recipe import Recipe, film_in, film_of
from rulesengine.levelling.report import Amounts, FilmOf, Goal, LevelledStep, LevelReport
from rulesengine.levelling.segments import (
    SeenCells,
    Target,
    aim,
    cells_of_faces,
    cells_of_side,
    divided,
    exposed_cells,
    from_end,
    knots_of,
    seconds_on,
    segments_of,
)
from rulesengine.planning.fit_recipe import spray_times
from rulesengine.timing.time_plan import ACCELERATION_SHARE, time_plan
from specs.progress import Progress, no_progress
from specs.source import Source

_LEVELLED = (Raster, FinalFlush)
_SEGMENTS = 5.0
"""Segments in the radius of the spray."""
_KNOTS: dict[Goal, int] = {"least-time": 1, "even-film": 4}
"""Segments from knot to knot. With more knots the speeds of an even film swing more than motions follow."""
_JOINED = 10.0
"""Lengths to which timed moves are joined, in the same radius."""
_CELLS = 14.0
"""Cells in the radius of the spray."""
_EVEN_SHARE = 0.5
"""Of the acceleration, that an even film may use: speeds that swing less are carried out more exactly."""
_FILM_SPEEDS = 0.4, 1.5
"""Slowest and fastest speed of a film's passes, in shares of that before levelling."""
_FINER, _SHIFT = 0.61, 0.37
"""Pitch of the finer cells, and their shift in shares of it."""
_SLOWEST = 0.05
"""Slowest speed, as a share of the function's maximum."""
_TANGENTS, _BETTER = 4, 2e-3
"""Programs with tangents to the accelerations, at most, and by how much each is to be better than the last."""
_SHORT = 1e-3
"""Of the film, that may be missing after timing before more is required."""
_CORRECTIONS = 4
"""Programs of an even film after timing, at most."""
_ROUNDS = 5
"""Of solving and timing, at most."""
_Grounds: TypeAlias = "Callable[[Sequence[SprayPass]], Ground]"
"""What the passes of a step spray."""


def is_levelled(each: SprayPass, recipe: Recipe) -> bool:
    """Whether a pass is of a raster or a flush, or lays a film on a part."""
    spec = recipe.templates.get(each.made_by.template)
    return isinstance(spec, _LEVELLED) or film_in(spec) is not None


@dataclass(frozen=True, slots=True, eq=False)
class Ground:
    """What the levelled passes of a step spray."""

    scene: RayScene
    """Of all bodies."""
    radius_mm: float
    """Of the spray on the surface."""
    seen: Callable[[float, float], SeenCells]
    """Places about a pitch apart, mm, and shifted by a share of it."""
    exposed: Callable[[float], SeenCells]
    """Places of each surface that the step may reach, 1 for those of the model's size, less for smaller ones."""


def _ground_of_board(board: Board, scene: RayScene, recipe: Recipe, exposed: Callable[[float], SeenCells]) -> _Grounds:
    """Give the side of a board that passes spray."""

    def ground(passes: Sequence[SprayPass]) -> Ground:
        side: Side = "top" if float(passes[0].approach[0, 2]) < 0.0 else "bottom"
        height = float(np.mean([abs(each.tcp[:, 2] - board.surface_z_mm(side)).mean() for each in passes]))
        radius = _radius_mm(recipe.nozzles[passes[0].jet.nozzle], height)
        return Ground(scene, radius, partial(cells_of_side, board, side, scene), exposed)

    return ground


def _grounds_of_part(part: Part, recipe: Recipe) -> _Grounds:
    """Give the served faces of a part."""

    def ground(passes: Sequence[SprayPass]) -> Ground:
        standoffs = [
            spec.standoff_mm
            for each in passes
            if isinstance(spec := recipe.templates[each.made_by.template], OverFaces)
        ]
        radius = _radius_mm(recipe.nozzles[passes[0].jet.nozzle], float(np.mean(standoffs)))
        seen = partial(cells_of_faces, part)
        return Ground(scene_of(part), radius, seen, lambda finer: seen(finer * radius / _CELLS, 0.5 * finer))

    return ground


def _radius_mm(nozzle: Nozzle, height_mm: float) -> float:
    down, along = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    return float(np.linalg.norm(footprint(nozzle, height_mm, down, along), axis=1).min())


class StepLeveller:
    """Levels the passes of one step: ``aim``, ``solve`` and ``correct`` until nothing is wrong, ``report``."""

    def __init__(self, grounds: _Grounds, recipe: Recipe, goal: Goal, passes: Sequence[tuple[int, SprayPass]]) -> None:
        self._goal: Goal = goal
        _, first = passes[0]
        self.step = first.made_by.step or 0
        self._least_time_s = recipe.sequence[self.step].least_time_s
        nozzle = recipe.nozzles[first.jet.nozzle]
        self.film = film_of(recipe, self.step)
        deposited = 1.0 if self.film is None else self.film.deposited
        self._form: JetForm = form_of(nozzle, first.jet.flow_lpm * deposited, load_parameters("default").spray)
        self._ground = grounds([each for _, each in passes])
        self._scene, self._radius_mm = self._ground.scene, self._ground.radius_mm
        self._fastest = recipe.functions[first.jet.function].max_speed_mm_s
        if self.film is not None and self.film.max_speed_mm_s != "auto":
            self._fastest = min(self._fastest, self.film.max_speed_mm_s)
        self._acceleration = ACCELERATION_SHARE * recipe.limits.acceleration_mm_s2
        self._chosen = [
            (at, divided(each, self._radius_mm / _SEGMENTS)) for at, each in passes if is_levelled(each, recipe)
        ]
        self._mine = frozenset(each.made_by for _, each in self._chosen)
        self._all = frozenset(each.made_by for _, each in passes)
        self._segments = segments_of([each for _, each in self._chosen])
        self._mixed = 0.0
        self.levelled: list[tuple[int, SprayPass]] = []
        self._best: tuple[float, list[tuple[int, SprayPass]], Scalars] | None = None

    def aim(self, before: TimedProgram, film_um: float | None) -> None:
        """Find what each cell is to have, from the timed program as it is.

        Args:
            before: The timed program.
            film_um: To be reached; ``None`` as for ``level_plan``.
        """
        if film_um is None and self.film is not None:
            film_um = self.film.thickness_um
        self._spent_before = self._seconds_in(before)
        pitch = self._radius_mm / _CELLS
        if self._goal == "least-time" and film_um is None:
            cells, finer = self._ground.exposed(1.0), self._ground.exposed(_FINER)
        else:
            cells = self._ground.seen(pitch, 0.5)
            finer = self._ground.seen(pitch * _FINER, _SHIFT)
        self._target = self._aimed(cells, before, film_um)
        self._finer = self._aimed(finer, before, self._target.film_um)
        self._factors = np.ones(int(self._target.surface.max(initial=0)) + 1)
        self._set_up()

    def _set_up(self) -> None:
        """Lay the knots, with the bounds of their paces."""
        counts, lengths = [len(each.speeds_mm_s) for _, each in self._chosen], self._segments.lengths
        apart = _KNOTS[self._goal]
        if apart > 1:  # passes may have shorter segments already
            apart = max(apart, round(apart * self._radius_mm / _SEGMENTS / float(lengths.mean())))
        self._weights, self._pairs = knots_of(counts, apart)
        seconds = csr_array(self._weights.multiply(lengths[:, None]))
        self._knot_mm = apart * float(lengths.mean())
        # A pass begins and ends at rest: nearer to its ends than a ramp no speed above the ramp's is had.
        ramp_mm = np.maximum(from_end(counts, apart), 0.5) * self._knot_mm
        least = 1.0 / np.minimum(np.sqrt(2.0 * self._acceleration * ramp_mm), self._fastest)
        self._unknowns = Unknowns(
            seconds=np.asarray(seconds.sum(axis=0)).ravel(),
            least=least,
            most=np.maximum(least, 1.0 / (_SLOWEST * self._fastest)),
            pairs=np.empty((0, 2), dtype=np.int64),
            slope=np.empty(0),
            change=np.empty(0),
        )
        if self.film is not None:
            slow, fast = (share * float(np.mean(self._chosen[0][1].speeds_mm_s)) for share in _FILM_SPEEDS)
            least = np.maximum(self._unknowns.least, 1.0 / fast)
            self._unknowns = replace(self._unknowns, least=least, most=np.maximum(least, 1.0 / slow))
        self._rates = csr_array(self._target.rates @ seconds)
        own = np.concatenate([1.0 / each.speeds_mm_s for _, each in self._chosen])
        shares = np.asarray(self._weights.sum(axis=0)).ravel()
        self._first = np.clip(
            (self._weights.T @ own) / np.maximum(shares, 1e-12), self._unknowns.least, self._unknowns.most
        )
        self._paces = self._first
        self._laid, self._corrections = np.ones(len(self._target.others)), 0

    def _aimed(self, cells: SeenCells, before: TimedProgram, film_um: float | None) -> Target:
        rates = segment_rates(self._form, self._segments, cells.points, cells.normals, self._scene)
        moves = sprayed_moves(before, lambda source: source in self._all and source not in self._mine)
        joint = joined(*moves, self._radius_mm / _JOINED)
        moves, seconds = cut(*joint, self._radius_mm / _SEGMENTS)
        others = segment_rates(self._form, moves, cells.points, cells.normals, self._scene) @ seconds
        return aim(cells, rates, (rates @ self._spent_before, others), self._goal, film_um)

    def _seconds_in(self, program: TimedProgram) -> Scalars:
        """(segments,) in a timed program."""
        moves = sprayed_moves(program, self._mine.__contains__)
        return seconds_on(self._segments, *moves)

    def solve(self) -> None:
        """Find the speeds: linear programs, each with the tangents to the accelerations at the last one's paces."""
        required, others = self._target.required(self._goal, self._factors), self._target.others
        last = np.inf
        acceleration = self._acceleration * (_EVEN_SHARE if self._goal == "even-film" else 1.0)
        for _ in range(_TANGENTS):
            ways = np.full(len(self._pairs), self._knot_mm)
            near = keep_acceleration(self._unknowns, self._paces, self._pairs, ways, acceleration)
            if self._goal == "least-time":
                self._found = least_time(self._rates, np.maximum(required - others, 0.0), near)
            else:
                self._found = even_film(csr_array(self._rates * self._laid[:, None]), required, near, others)
            self._paces = self._found.values
            if self._found.value > last * (1.0 - _BETTER):
                break
            last = self._found.value
        counts = [len(each.speeds_mm_s) for _, each in self._chosen]
        mixed = self._mixed * self._first + (1.0 - self._mixed) * self._paces
        paces = np.asarray(self._weights @ mixed, dtype=np.float64)
        self._times = self._segments.lengths * paces
        if not self._corrections:
            self._planned = self._times
        speeds = np.minimum(1.0 / paces, self._fastest)
        self.levelled = [
            (at, replace(each, speeds_mm_s=speeds[end - count : end]))
            for (at, each), end, count in zip(self._chosen, np.cumsum(counts).tolist(), counts, strict=True)
        ]

    def correct(self, after: TimedProgram, before_s: float | None, after_s: float | None) -> bool:
        """Require more where the timed program lays less than it is to keep, and keep the least time of the step.

        Args:
            after: The timed program with the levelled passes.
            before_s: Time with the jet on that counts for the step's least time, without levelling.
            after_s: With it.

        Returns:
            Whether anything was wrong, so that ``solve`` finds other speeds.
        """
        self._spent = self._seconds_in(after)
        wrong = False
        if self._target.film_um is None:
            shares = self._target.shares(self._target.others + self._target.rates @ self._spent)
            wrong = bool((shares < 1.0 - _SHORT).any())
            self._factors = self._factors / np.minimum(shares, 1.0)
        if self._goal == "even-film":
            # What the timed program lays on each cell stands for what the linear program lays there.
            target, own = self._target, self._target.rates @ self._spent
            off = target.spread(target.others + own, self._goal).deviation
            if self._best is None or off < self._best[0]:
                self._best = off, self.levelled, self._spent
            wrong = self._corrections < _CORRECTIONS and off >= self._found.value + _SHORT
            if wrong:
                self._corrections += 1
                self._laid = own / np.maximum(target.rates @ self._times, 1e-9)
        least = self._least_time_s
        if least is not None and before_s is not None and after_s is not None and after_s < least <= before_s:
            more = (least - after_s) / (before_s - after_s)
            self._mixed = min(1.0, self._mixed + (1.0 - self._mixed) * 1.05 * more + 0.01)
            wrong = True
        return wrong

    def settle(self) -> bool:
        """Take the speeds whose timed film was the most even, or leave the step as it was where that is no worse.

        Returns:
            Whether they are others than those of the last ``solve``.
        """
        last = self.levelled
        if self._best is not None:
            _, self.levelled, self._spent = self._best
        if self._is_no_better:
            self.levelled, self._spent = [], self._spent_before
        return self.levelled is not last

    @property
    def _is_no_better(self) -> bool:
        """Whether ramps took back all that least time was to save, or made the film more uneven than one speed does."""
        if self._goal == "least-time":
            return float(self._spent.sum()) >= float(self._spent_before.sum())
        finer = self._finer
        films = (finer.others + finer.rates @ self._spent, finer.before)
        levelled, before = (finer.spread(film, self._goal).deviation for film in films)
        return levelled >= before

    def report(self) -> LevelledStep:
        """What was changed."""
        both, goal = (self._target, self._finer), self._goal
        planned = self._planned if goal == "even-film" else self._times
        before = [each.spread(each.before, goal) for each in both]
        after = [each.spread(each.others + each.rates @ planned, goal) for each in both]
        timed = [each.spread(each.others + each.rates @ self._spent, goal) for each in both]
        finer = self._finer
        film = finer.others + finer.rates @ self._spent
        below = (finer.before < finer.least) & (film < finer.before)
        _, first = self._chosen[0]
        found = self._found
        return LevelledStep(
            levelled=bool(self.levelled),
            made_by=Source(first.made_by.step),
            function=first.jet.function,
            nozzle=first.jet.nozzle,
            target_um=self._target.film_um,
            surfaces=len(self._factors) if self._target.film_um is None else 0,
            before=FilmOf(*before),
            after=FilmOf(*after),
            timed=FilmOf(*timed),
            spray_before_s=float(self._spent_before.sum()),
            spray_after_s=float(self._spent.sum()),
            planned_s=float(planned.sum()),
            bound_s=found.bound,
            gap=found.gap,
            segments=len(self._times),
            knots=len(self._paces),
            rows=found.rows,
            rounds=found.rounds,
            short=len(found.short),
            below=int(below.sum()),
            below_lose=float(np.max(1.0 - film[below] / finer.before[below], initial=0.0)),
            kept_s=float(self._unknowns.seconds @ (self._first - self._paces)) * self._mixed,
        )


def level_plan(
    plan: Plan,
    workpiece: Workpiece,
    recipe: Recipe,
    goal: Goal,
    film_um: float | None = None,
    progress: Progress = no_progress,
) -> tuple[Plan, LevelReport]:
    """Level rasters and flushes of a plan over a board, slices over a part, step by step; gas is left aside.

    Args:
        plan: Of the recipe on the workpiece.
        workpiece: Whose surface is sprayed.
        recipe: As it was planned.
        goal: ``least-time`` keeps ``film_um`` wherever it is now; what has less, mostly in the shadow of components, is
            for other paths, and the report states what it loses. ``even-film`` makes the greatest deviation from
            ``film_um`` least.
        film_um: Left out: the thickness that the template states. Without one: on each component, on the bare board,
            or on each face, what nine tenths of the cells that the step reaches have now (least time); the mean (even
            film).
        progress: Receives the stage and the share done.

    Raises:
        RecipeError: no raster, flush or slices spray a liquid.
    """
    passes = [(at, each) for at, each in enumerate(plan.items) if isinstance(each, SprayPass) and each.jet.liquid]
    steps = dict.fromkeys(each.made_by.step for _, each in passes if is_levelled(each, recipe))
    if not steps:
        which = "slices with a film spray" if workpiece.faces else "raster or final_flush sprays"
        raise RecipeError(f"no {which} a liquid, so there is nothing to level", path="templates")
    if workpiece.faces:
        grounds = _grounds_of_part(workpiece.require_part("levelling of faces"), recipe)
    else:
        board = workpiece.require_board("levelling")
        grounds = _ground_of_board(board, build_scene(board), recipe, cache(partial(exposed_cells, board)))
    before = time_plan(plan, recipe.limits)
    levellers: list[StepLeveller] = []
    for done, step in enumerate(steps):
        progress("measuring what is laid", 0.4 * done / len(steps))
        mine = [(at, each) for at, each in passes if each.made_by.step == step]
        leveller = StepLeveller(grounds, recipe, goal, mine)
        leveller.aim(before, film_um)
        levellers.append(leveller)
    after, program = plan, before
    for number in range(_ROUNDS):
        progress("levelling", 0.4 + 0.5 * number / _ROUNDS)
        for each in levellers:
            each.solve()
        after, program = _levelled(plan, recipe, levellers)
        times = [spray_times(recipe, timed) for timed in (before, program)]
        wrong = [each.correct(program, *(timed.get(each.step) for timed in times)) for each in levellers]
        if not any(wrong):
            break
    settled = [each.settle() for each in levellers]  # all of them
    if any(settled):
        after, program = _levelled(plan, recipe, levellers)
    reports = tuple(each.report() for each in levellers)
    progress("done", 1.0)
    return after, LevelReport(goal, reports, _amounts(before), _amounts(program))


def _levelled(plan: Plan, recipe: Recipe, levellers: Sequence[StepLeveller]) -> tuple[Plan, TimedProgram]:
    items = list(plan.items)
    for at, each in (pair for leveller in levellers for pair in leveller.levelled):
        items[at] = each
    after = replace(plan, items=tuple(items))
    return after, time_plan(after, recipe.limits)


def _amounts(program: TimedProgram) -> Amounts:
    totals = program.totals
    return Amounts(totals.duration_s, totals.spray_s, sum(litres for _, litres in totals.liquid_l))
