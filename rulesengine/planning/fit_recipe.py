"""What a recipe leaves to the board: the sides with components, heights by its size, repeats by a least time."""

import math
from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Mapping

import numpy as np

from boards.board import Board
from programs.program import SetNozzle, TimedProgram
from recipes.footprint import core_footprint
from recipes.nozzles import Nozzle
from recipes.paths import PathSpec
from recipes.recipe import Recipe, Step
from specs.finding import Finding
from specs.finding_rules import LEAST_TIME_MISSED
from specs.source import Source

_LOWEST_MM = 20.0
_HIGHEST_MM = 60.0
_SHARE_OF_WIDTH = 0.8
"""Of the board's mean width that the footprint takes at an automatic height: about half of a line's spray lands then,
and what does not is on the lines beside the rim."""
_SAME_MM = 1e-6
_TRIED = 2
"""Repeats of a path from which the time for one of them is taken: the first begins elsewhere than the others."""
_MOST_AGAIN = 1000
_SAME_S = 1e-6


def fit_recipe(recipe: Recipe, board: Board) -> Recipe:
    """Put numbers for the automatic heights of a recipe, and disable the steps that are for the other side alone.

    Args:
        recipe: As it was written.
        board: Whose outline and components; of a panel the heights are those of its single board.

    Returns:
        The recipe with its steps at their places. A template that no step follows keeps ``auto``; the recipe is the
        same object where it leaves nothing to the board.
    """
    sides = {component.side for component in board.components}
    steps = [
        step.model_copy(update={"enabled": False})
        if step.enabled and step.only_with_parts and sides and step.side not in sides
        else step
        for step in recipe.sequence
    ]
    single = board.instances[0].board if board.instances else board
    templates = {name: _at_height(name, spec, recipe, single) for name, spec in recipe.templates.items()}
    if steps == recipe.sequence and templates == recipe.templates:
        return recipe
    return recipe.model_copy(update={"sequence": steps, "templates": templates})


def left_out(recipe: Recipe, fitted: Recipe) -> tuple[int, ...]:
    """Indices of the steps that a fitted recipe leaves out."""
    pairs = zip(recipe.sequence, fitted.sequence, strict=True)
    return tuple(index for index, (own, now) in enumerate(pairs) if own.enabled and not now.enabled)


def fitted_heights(recipe: Recipe, fitted: Recipe) -> dict[str, float]:
    """Heights by template, mm, that a fitted recipe has where ``auto`` stood."""
    pairs = ((name, getattr(fitted.templates[name], "height_mm", None)) for name in recipe.templates)
    return {
        name: float(height)
        for name, height in pairs
        if isinstance(height, float) and getattr(recipe.templates[name], "height_mm", None) == "auto"
    }


def mean_width_mm(board: Board) -> float:
    """Mean width of a board: the area of its outline by its greatest extent along or across its longest edge."""
    points = np.array(board.outline.exterior.coords)
    along = np.array(board.axis)
    extents = (float(np.ptp(points @ axis)) for axis in (along, np.array([-along[1], along[0]])))
    return board.outline.area / max(extents)


def _at_height(name: str, spec: PathSpec, recipe: Recipe, board: Board) -> PathSpec:
    if getattr(spec, "height_mm", None) != "auto":
        return spec
    nozzles = {step.nozzle: recipe.nozzles[step.nozzle] for step in recipe.sequence if name in step.paths}
    if not nozzles:
        return spec
    width = _SHARE_OF_WIDTH * mean_width_mm(board)
    height = min(_greatest_height(nozzle, width) for nozzle in nozzles.values())
    above_clearance = math.floor(recipe.limits.clearance_mm) + 1.0
    return spec.model_copy(update={"height_mm": max(height, above_clearance)})


def _greatest_height(nozzle: Nozzle, width_mm: float) -> float:
    """Greatest height in whole mm at which the footprint is no wider; the least there is if it is wider at all."""
    down, reference = np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0])
    heights = np.arange(_LOWEST_MM, _HIGHEST_MM + 0.5).tolist()

    def width_at(height_mm: float) -> float:
        return float(np.ptp(core_footprint(nozzle, height_mm, down, reference), axis=0).max())

    narrow = bisect_right(heights, width_mm + _SAME_MM, key=width_at)  # a footprint grows with its height
    return heights[max(narrow - 1, 0)]


def repeats_for_least_times(
    recipe: Recipe, sprayed_s: Callable[[Mapping[int, int]], Mapping[int | None, float]]
) -> tuple[Mapping[int, int], tuple[Finding, ...]]:
    """Find how often the last path of each step is done again so that it sprays for at least ``least_time_s``.

    The time for a path is taken from two plans, without and with two more of it, so that what the limits of the
    motion cost is in it.

    Args:
        recipe: Fitted.
        sprayed_s: Gives the seconds with the jet on in each step of the plan with some repeats by the step's index.

    Returns:
        Repeats by the index of the step, and a finding for each step that stays shorter: no repeat of its last path
        makes it longer, or more than 1,000 would be needed.
    """
    least = {index: step.least_time_s for index, step in enumerate(recipe.sequence) if step.enabled}
    required = {index: seconds for index, seconds in least.items() if seconds is not None}
    if not required:
        return {}, ()
    begun = _with_steps_before(recipe, sprayed_s({}))
    short = [index for index, seconds in required.items() if begun[index] < seconds]
    if not short:
        return {}, ()
    tried = _with_steps_before(recipe, sprayed_s(dict.fromkeys(short, _TRIED)))
    each = {index: (tried[index] - begun[index]) / _TRIED for index in short}
    more = {
        index: min(math.ceil((required[index] - begun[index]) / each[index]), _MOST_AGAIN)
        for index in short
        if each[index] > _SAME_S
    }
    # The first repeat may take a little more than the next ones, where it begins farther away.
    while more:
        lasts = _with_steps_before(recipe, sprayed_s(more))
        late = [index for index, times in more.items() if lasts[index] < required[index] and times < _MOST_AGAIN]
        if not late:
            break
        more |= {index: more[index] + 1 for index in late}
    lasts = _with_steps_before(recipe, sprayed_s(more))
    missed: list[Finding] = []
    for index in short:
        step = recipe.sequence[index]
        if lasts[index] < required[index]:
            message = (
                f"{step.function} sprays for {lasts[index]:.0f} s, and repeating {step.paths[-1]} does not make it the "
                f"{step.least_time_s:g} s of least_time_s. End the step with a path across the board, such as a raster."
            )
            missed.append(Finding(LEAST_TIME_MISSED, message, Source(index)))
    return more, tuple(missed)


def spray_times(recipe: Recipe, program: TimedProgram) -> dict[int, float]:
    """Seconds with the jet on in each enabled step, by its index.

    The steps right before that have the same function and side count with it: their liquid stays on the board. With the
    jet off a board cools, and nothing renews the liquid, so that transfers do not count.
    """
    sprayed = defaultdict[int | None, float](float)
    begun = 0.0
    for each in program.instructions:
        if isinstance(each, SetNozzle):
            if each.spraying:
                begun = each.time_s
            else:
                sprayed[each.made_by.step] += each.time_s - begun
    return _with_steps_before(recipe, sprayed)


def _with_steps_before(recipe: Recipe, sprayed_s: Mapping[int | None, float]) -> dict[int, float]:
    """Seconds of each enabled step and of those right before it that count with it."""
    times: dict[int, float] = {}
    before: Step | None = None
    for index, step in enumerate(recipe.sequence):
        if not step.enabled:
            continue
        goes_on = before is not None and (before.function, before.side) == (step.function, step.side)
        times[index] = sprayed_s.get(index, 0.0) + (next(reversed(times.values())) if goes_on else 0.0)
        before = step
    return times
