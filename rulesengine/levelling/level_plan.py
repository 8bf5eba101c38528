"""Levelling a plan: speeds along its passes that lay an even film, or what is required in the least time.

The path stays as it is. Passes are divided into short segments; the pace (seconds per mm) is linear between knots, so
that speeds change smoothly; a linear program finds the paces (``geometry.coverage.dwell``). What other passes of the
step lay is counted. Films are those of timed programs, with all ramps, before and after; where the timed program falls
short of the film, more is required and the program solved again. It is compared on a finer set of cells too.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache, partial

from boards.board import Board
from cleaning.surface.facets import build_scene
from programs.plan import Plan, SprayPass
from programs.program import TimedProgram
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from rulesengine.levelling.report import Amounts, Goal, LevelReport
from rulesengine.levelling.seen_cells import exposed_cells
from rulesengine.levelling.step_leveller import StepLeveller, is_levelled
from rulesengine.planning.fit_recipe import spray_times
from rulesengine.timing.time_plan import time_plan
from specs.progress import Progress, no_progress

_ROUNDS = 5
"""Of solving and timing, at most."""


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
        film_um: Left out: on each component, and on the bare board, what nine tenths of the cells that the step
            reaches have now (least time); the mean (even film).
        progress: Receives the stage and the share done.

    Raises:
        RecipeError: no raster or flush sprays a liquid.
    """
    passes = [(at, each) for at, each in enumerate(plan.items) if isinstance(each, SprayPass) and each.jet.liquid]
    steps = dict.fromkeys(each.made_by.step for _, each in passes if is_levelled(each, recipe))
    if not steps:
        raise RecipeError("no raster or final_flush sprays a liquid, so there is nothing to level", path="templates")
    scene = build_scene(board)
    exposed = cache(partial(exposed_cells, board))
    before = time_plan(plan, recipe.limits)
    levellers: list[StepLeveller] = []
    for done, step in enumerate(steps):
        progress("measuring what is laid", 0.4 * done / len(steps))
        mine = [(at, each) for at, each in passes if each.made_by.step == step]
        leveller = StepLeveller(board, scene, recipe, goal, mine)
        leveller.aim(before, film_um, exposed)
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
    longer = [each for each in levellers if each.is_longer]
    if longer:
        for each in longer:
            each.keep()
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
