"""Films on parts: planned evenly, levelled within their tolerance, judged by what the program lays."""

import numpy as np
import pytest
from command import washboard
from curved_parts import grid
from each_workpiece import write_obj
from small_parts import part_of

from programs.plan import SprayPass
from recipes.errors import RecipeError
from recipes.load import parse_recipe
from rulesengine.levelling.film_run import fit_films, lay_films, level_run, run_levelled
from washboard.cleaned import judge_part

RECIPE = """recipe: film
functions: {coat: {solution: paint, pressure_bar: 3.0, max_speed_mm_s: 150}}
nozzles: {gun: {pattern: radial, radius_mm: 20, at_mm: 60, flow_lpm: 0.003, at_bar: 3.0}}
classes: {}
templates: {passes: {path: slices, standoff_mm: 60, film: {thickness_um: 40, tolerance_um: 2}}}
limits: {acceleration_mm_s2: 2000, clearance_mm: 2, park_height_mm: 60}
sequence: [{function: coat, nozzle: gun, paths: [passes]}]
"""


def saddle(x, y):
    return np.column_stack([x, y, ((x - 50) ** 2 - (y - 30) ** 2) / 600])


PATCHES = grid(saddle, np.linspace(0, 100, 26), np.linspace(0, 60, 16))


@pytest.fixture(scope="module")
def levelled():
    laid = lay_films(parse_recipe(RECIPE), part_of(PATCHES))
    return laid, *level_run(laid)


@pytest.mark.slow
def test_a_film_is_within_its_tolerance_and_no_less_even_than_at_one_speed(levelled) -> None:
    _, done, report = levelled
    (step,) = report.steps
    assert step.target_um == 40
    assert step.timed.finer.deviation <= 0.02
    assert step.timed.planned.deviation <= step.before.planned.deviation + 1e-9
    rules = {each.rule.id for each in done.findings}
    assert "film-levelled" in rules
    assert "film-uneven" not in rules


@pytest.mark.slow
def test_analysis_adds_up_the_same_film_and_twice_the_flow_is_too_thick(levelled) -> None:
    _, done, report = levelled
    found = judge_part(done.program, done.workpiece, done.recipe)
    (verdict,) = found.verdicts
    assert verdict.verdict == "clean"
    assert verdict.film is not None
    assert verdict.film.deviation == pytest.approx(report.steps[0].timed.finer.deviation, abs=0.004)
    more = parse_recipe(RECIPE.replace("flow_lpm: 0.003", "flow_lpm: 0.006"))
    (wet,) = judge_part(done.program, done.workpiece, more, before=found).verdicts
    assert wet.verdict == "dirty"
    assert wet.film is not None
    assert wet.film.mean_um == pytest.approx(2 * verdict.film.mean_um, rel=1e-6)
    assert wet.film.thick_mm2 > 0.99 * wet.area_mm2
    assert wet.film.thin_mm2 == 0


@pytest.mark.slow
def test_passes_begin_outside_the_rim_and_are_equally_far_apart(levelled) -> None:
    laid, done, _ = levelled
    spec = laid.fitted.templates["passes"]
    passes = [each for each in done.plan.items if isinstance(each, SprayPass)]
    targets = [each.tcp + 60 * each.approach for each in passes]
    rows = sorted(float(each[len(each) // 2, 1]) for each in targets)
    assert rows[0] < 0
    assert rows[-1] > 60
    for each in targets:
        assert each[:, 0].min() < -20
        assert each[:, 0].max() > 120
    middle = [each[np.argmin(abs(each[:, 0] - 50))] for each in targets]
    middle.sort(key=lambda place: place[1])
    ways = np.linalg.norm(np.diff(middle, axis=0), axis=1)
    np.testing.assert_allclose(ways, spec.spacing_mm, rtol=0.02)


@pytest.mark.slow
def test_the_same_recipe_gives_the_same_program_and_its_own_name(levelled) -> None:
    _, done, _ = levelled
    again = run_levelled(parse_recipe(RECIPE), part_of(PATCHES))
    assert again.program.instructions == done.program.instructions
    assert again.recipe == parse_recipe(RECIPE)


def test_repeats_lay_the_thickness_together() -> None:
    once, twice = (
        fit_films(parse_recipe(RECIPE.replace("paths: [passes]", f"paths: [passes], repeat: {count}")))
        for count in (1, 2)
    )
    speeds = [each.templates["passes"].film.speed_mm_s / 1 for each in (once, twice)]
    spacings = [each.templates["passes"].spacing_mm for each in (once, twice)]
    assert speeds[1] * spacings[1] == pytest.approx(2 * speeds[0] * spacings[0], rel=0.03)


def test_a_film_that_no_allowed_speed_lays_is_refused() -> None:
    slow = parse_recipe(RECIPE.replace("max_speed_mm_s: 150", "max_speed_mm_s: 10"))
    with pytest.raises(RecipeError, match="no even spacing of passes lays 40 µm at 10 mm/s or less"):
        fit_films(slow)


@pytest.mark.slow
def test_level_shows_the_film_of_a_part_and_refuses_what_is_for_boards(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    write_obj(tmp_path / "saddle.obj", PATCHES)
    (tmp_path / "film.yaml").write_text(RECIPE, "utf-8")
    done = washboard("level", "saddle.obj", "film.yaml", "-o", "film.wash")
    assert done.code == 0, done.err
    assert "even 40 µm" in done.out
    assert (tmp_path / "film.wash").exists()
    for words in (("--for", "least-time"), ("--film-um", "30")):
        refused = washboard("level", "saddle.obj", "film.yaml", *words)
        assert refused.code == 2
        assert "is for boards, and saddle is a part" in refused.err
