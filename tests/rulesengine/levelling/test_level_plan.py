"""Levelled speeds: the same way, no place worse off and less time; or an even film, by proof and after timing."""

from pathlib import Path

import judge
import numpy as np
import pytest
from command import washboard

import boards
from boards.load import load_board
from programs import native
from programs.plan import SprayPass
from recipes.errors import RecipeError
from recipes.load import parse_recipe
from rulesengine.levelling.level_plan import level_plan
from rulesengine.planning.fit_recipe import spray_times
from rulesengine.planning.pipeline import run
from rulesengine.timing.time_plan import time_plan

TINY = Path(boards.__path__[0]) / "library" / "tiny.tri"
COAT = """recipe: coat
functions: {coat: {solution: saponifier-15, temperature_c: 25, pressure_bar: 3.0, max_speed_mm_s: 120}}
nozzles: {gun: {pattern: radial, radius_mm: 8, at_mm: 40, flow_lpm: 0.9, at_bar: 3.0}}
classes: {other: {}}
templates:
  sweep: {path: raster, height_mm: 40, speed_mm_s: 60, overlap: 0.5, margin_mm: 10}
  edge: {path: board_perimeter, height_mm: 40, speed_mm_s: 60}
limits: {acceleration_mm_s2: 3000}
sequence: [{function: coat, nozzle: gun, paths: [PATHS]}]
"""


def planned(paths="sweep"):
    board = load_board(TINY)
    return run(parse_recipe(COAT.replace("PATHS", paths), file="coat.yaml"), board)


@pytest.fixture(scope="module")
def done():
    return planned()


@pytest.fixture(scope="module", params=["least-time", "even-film"])
def levelled(request, done):
    return level_plan(done.plan, done.board, done.fitted, request.param)


def passes(plan):
    return [each for each in plan.items if isinstance(each, SprayPass)]


@pytest.mark.slow
def test_the_way_stays_and_speeds_keep_to_the_maximum(done, levelled) -> None:
    plan, _ = levelled
    for one, other in zip(passes(done.plan), passes(plan), strict=True):
        assert (one.tcp[0] == other.tcp[0]).all()
        assert (one.tcp[-1] == other.tcp[-1]).all()
        ways = [np.linalg.norm(np.diff(each.tcp, axis=0), axis=1).sum() for each in (one, other)]
        assert ways[0] == pytest.approx(ways[1])
        assert len(other.speeds_mm_s) == len(other.tcp) - 1
        assert other.speeds_mm_s.max() <= 120
    track = judge.read_track(native.render(time_plan(plan, done.fitted.limits)))
    assert judge.too_sharp(track, 3000, time_rounding_s=0.0) == []


def test_the_optimum_is_proved(levelled) -> None:
    (step,) = levelled[1].steps
    assert step.gap < 2e-3
    assert step.after.planned.cells < step.after.finer.cells


def test_least_time_keeps_the_film_and_takes_less(done) -> None:
    shares: list[float] = []
    _, report = level_plan(
        done.plan, done.board, done.fitted, "least-time", progress=lambda _, share: shares.append(share)
    )
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    (step,) = report.steps
    assert step.spray_after_s < 0.985 * step.spray_before_s
    assert report.after.litres < report.before.litres
    assert step.surfaces > 3
    assert step.after.planned.deviation < 1e-4
    assert step.timed.planned.deviation < 2e-3
    assert step.timed.finer.deviation < 0.15
    assert step.below < 0.1 * step.after.finer.cells


@pytest.mark.slow
def test_the_least_time_of_a_step_is_kept(done) -> None:
    (before,) = spray_times(done.fitted, done.program).values()
    step = done.fitted.sequence[0].model_copy(update={"least_time_s": before - 1e-3})
    recipe = done.fitted.model_copy(update={"sequence": [step]})
    plan, report = level_plan(done.plan, done.board, recipe, "least-time")
    assert report.steps[0].kept_s > 0.0
    assert spray_times(recipe, time_plan(plan, recipe.limits))[0] >= step.least_time_s


@pytest.mark.slow
def test_even_film_is_more_even_on_both_sets_of_cells_and_after_timing(done) -> None:
    _, report = level_plan(done.plan, done.board, done.fitted, "even-film")
    (step,) = report.steps
    assert step.after.planned.deviation < step.before.planned.deviation
    assert step.after.finer.deviation < step.before.finer.deviation
    assert step.timed.finer.deviation < step.before.finer.deviation
    assert step.timed.planned.deviation < step.after.planned.deviation + 0.02, "programs after timing take ramps in"


@pytest.mark.slow
def test_what_other_paths_of_the_step_lay_counts() -> None:
    done = planned("sweep, edge")
    _, report = level_plan(done.plan, done.board, done.fitted, "least-time", film_um=1e-3)
    (step,) = report.steps
    programmed = sum(
        float(np.linalg.norm(np.diff(each.tcp, axis=0), axis=1).sum()) / 60
        for each in passes(done.plan)
        if each.made_by.template == "sweep"
    )
    assert step.planned_s == pytest.approx(programmed * 60 / 120, rel=0.1), "as fast as ramps allow"


def test_without_a_raster_or_flush_there_is_nothing_to_level() -> None:
    done = planned("edge")
    with pytest.raises(RecipeError, match="nothing to level"):
        level_plan(done.plan, done.board, done.fitted, "least-time")


@pytest.mark.slow
def test_the_command_writes_the_program_and_prints_the_gain(tmp_path: Path) -> None:
    recipe, output = tmp_path / "coat.yaml", tmp_path / "coat.wash"
    recipe.write_text(COAT.replace("PATHS", "sweep"), "utf-8")
    result = washboard("level", "tiny", recipe, "-o", output)
    assert (result.code, result.err) == (0, "")
    assert "duality gap" in result.out
    assert "equal deposit on" in result.out
    assert washboard("show", output).code == 0


def test_a_part_without_a_film_is_refused_with_what_serves_it() -> None:
    done = washboard("level", "f-bracket", "part-degrease")
    assert (done.code, done.out) == (2, "")
    assert "no path of part-degrease states a film (film: thickness_um): there is nothing to level" in done.err
