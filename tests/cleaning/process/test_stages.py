from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from small_sprays import downward, samples_of, stage_of

from boards.load import load_board
from cleaning.errors import CleaningError
from cleaning.parameters.load import load_parameters
from cleaning.process.stages import stages_of
from programs.playback import playback
from programs.program import Command
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run


@cache
def planned():
    return run(load_recipe("smt-aqueous"), load_board(Path("tiny")))


def staged(longest_mm=3.0, **changes):
    done = planned()
    recipe = done.recipe.model_copy(update=changes)
    return stages_of(done.program, recipe, load_parameters(), longest_mm)


def test_the_stages_are_those_of_the_sequence():
    stages = staged().stages
    assert [(str(stage.made_by), stage.function, stage.use) for stage in stages] == [
        ("sequence[0]", "clean", "wash"),
        ("sequence[1]", "rinse", "rinse"),
        ("sequence[2]", "dry", "dry"),
    ]
    assert stages[0].pressure_pa == pytest.approx(3.5e5)
    assert stages[2].temperature_c == 80.0
    assert stages[1].nozzle_name == "ring60"


def test_the_samples_stand_for_all_of_the_spraying():
    stages = staged().stages
    assert sum(stage.spray_s for stage in stages) == pytest.approx(planned().program.totals.spray_s)
    for stage in stages:
        assert np.all(stage.samples.seconds > 0)
        assert np.all(np.diff(stage.samples.times) > 0)
        assert stage.begin_s <= stage.samples.times[0]
        assert stage.samples.times[-1] <= stage.end_s


@pytest.mark.slow
@pytest.mark.parametrize("longest_mm", [1.0, 3.0, 7.0])
def test_a_sample_stands_for_no_more_than_asked(longest_mm):
    for stage in staged(longest_mm).stages:
        begin = playback(planned().program, stage.samples.times - 0.5 * stage.samples.seconds)
        end = playback(planned().program, stage.samples.times + 0.5 * stage.samples.seconds)
        assert np.linalg.norm(end.tcp - begin.tcp, axis=1).max() <= longest_mm + 1e-6
        assert stage.samples.seconds.max() <= 1.0 + 1e-9
        assert np.all(playback(planned().program, stage.samples.times).spraying)


def test_the_jet_is_where_playback_says():
    for stage in staged().stages:
        states = playback(planned().program, stage.samples.times)
        np.testing.assert_allclose(stage.samples.tcp, states.tcp)
        np.testing.assert_allclose(stage.samples.axes[:, :, 2], states.approach, atol=1e-12)


def test_a_loop_is_said_to_count_once():
    assert [finding.rule.id for finding in staged().findings] == ["loop-once"]


def test_an_unknown_liquid_is_taken_for_one_of_its_use_and_said():
    functions = dict(planned().recipe.functions)
    functions["rinse"] = functions["rinse"].model_copy(update={"solution": "tap"})
    functions["clean"] = functions["clean"].model_copy(update={"solution": "magic"})
    found = staged(functions=functions)
    assert [stage.use for stage in found.stages] == ["wash", "rinse", "dry"]
    said = [finding.message for finding in found.findings if finding.rule.id == "liquid-unknown"]
    assert len(said) == 2
    assert "magic" in said[0]
    assert "saponifier-15" in said[0]
    assert "di-water" in said[1]


def test_a_nozzle_that_the_recipe_does_not_have_is_named():
    nozzles = {"other": planned().recipe.nozzles["ring60"]}
    with pytest.raises(CleaningError, match="nozzle ring60"):
        staged(nozzles=nozzles)


@pytest.mark.parametrize(
    ("key", "value"),
    [("pressure_bar", "0"), ("pressure_bar", "-1"), ("pressure_bar", "high"), ("temperature_c", "-300")],
)
def test_a_setting_that_cannot_be_is_refused_with_its_place(key, value):
    """A program may have been edited by hand: what it sets is not what the recipe's checks let through."""
    program = planned().program
    edited = tuple(
        replace(item, arguments=(key, value)) if isinstance(item, Command) and item.arguments[:1] == (key,) else item
        for item in program.instructions
    )
    with pytest.raises(CleaningError, match=rf"sequence\[0\] sets {key} to {value}, which must be a number above"):
        stages_of(replace(program, instructions=edited), planned().recipe, load_parameters())


def test_a_stage_sprays_the_side_at_which_its_jet_points_for_most_of_the_time():
    assert [stage.side for stage in staged().stages] == ["top", "top", "top"]
    up = np.diag([1.0, -1.0, -1.0]) @ downward(30.0)
    axes = np.array([downward(30.0), up, up])
    for seconds, side in (((1.0, 0.4, 0.4), "top"), ((1.0, 0.6, 0.6), "bottom")):
        assert stage_of(samples_of(np.zeros((3, 3)), axes, seconds)).side == side


def with_commands(program, at, *commands):
    """A program with more commands before one of its FUNCTION instructions, -1 being its end."""
    items = list(program.instructions)
    begins = [row for row, item in enumerate(items) if isinstance(item, Command) and item.keyword == "FUNCTION"]
    row = len(items) if at < 0 else begins[at]
    time_s, made_by = items[row - 1].time_s, items[begins[0]].made_by
    items[row:row] = [Command(time_s, keyword, arguments, made_by) for keyword, arguments in commands]
    return replace(program, instructions=tuple(items))


@pytest.mark.parametrize("until", [1, 2, -1])
def test_the_first_command_of_a_stretch_holds_for_it(until):
    """A later one of the same kind, before the next FUNCTION or the end, changes nothing."""
    done = planned()
    late = [("SET", ("temperature_c", "99")), ("SET", ("pressure_bar", "1"))]
    late += [("NOZZLE", ("ring60" if until == -1 else "knife",))]
    late += [("REPEAT", ("9",))] * (until == 2)  # the rinse has one
    changed = stages_of(with_commands(done.program, until, *late), done.recipe, load_parameters()).stages
    kept = ("function", "use", "nozzle_name", "solution", "pressure_pa", "temperature_c", "repeats", "begin_s", "end_s")
    for before, after in zip(staged().stages, changed, strict=True):
        assert [getattr(after, name) for name in kept] == [getattr(before, name) for name in kept]
    assert [stage.repeats for stage in changed] == [1, 4, 1]


@pytest.mark.parametrize(("at", "seconds"), [(1, 335.7595), (2, 344.015)])
def test_a_stage_ends_where_the_next_begins(at, seconds):
    stages = staged().stages
    assert stages[at - 1].end_s == stages[at].begin_s == seconds
    assert stages[0].begin_s == 0.0
    assert stages[-1].end_s == planned().program.instructions[-1].time_s


def test_without_a_setting_the_recipe_decides():
    done = planned()
    bare = tuple(
        item
        for item in done.program.instructions
        if not (isinstance(item, Command) and item.keyword in ("SET", "REPEAT"))
    )
    functions = dict(done.recipe.functions)
    functions["clean"] = functions["clean"].model_copy(update={"pressure_bar": 2.0, "temperature_c": 41.0})
    functions["dry"] = functions["dry"].model_copy(update={"temperature_c": None})
    recipe = done.recipe.model_copy(update={"functions": functions})
    first, second, third = stages_of(replace(done.program, instructions=bare), recipe, load_parameters()).stages
    assert (first.pressure_pa, first.temperature_c) == (pytest.approx(2e5), 41.0)
    assert (second.repeats, third.temperature_c) == (1, 20.0)
