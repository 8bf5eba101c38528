from dataclasses import fields, replace
from itertools import pairwise, product
from pathlib import Path

import numpy as np
import pytest

from boards.load import load_board
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from recipes.load import parse_recipe, recipe_library
from rulesengine.planning.pipeline import run
from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.report import AnalysedRecipe, describe_end, explain, predict, suggest, tuning_report
from rulesengine.tuning.search.moves import TuningContext
from rulesengine.tuning.search.shortening import jumps_of_paths, jumps_of_values
from rulesengine.tuning.trial import trial_runner
from rulesengine.tuning.trial.outcome import Outcome, StepSummary, outcome_of
from rulesengine.tuning.trial.record import MemoryStore
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest, Worth, pareto_front
from rulesengine.tuning.trial.trial_runner import TrialRunner
from rulesengine.tuning.tune import ignore, tune
from rulesengine.tuning.variables import CHANGE_KINDS

FILE = recipe_library()["smt-aqueous"].with_name("own.yaml")
POOR = """recipe: poor
extends: smt-aqueous
templates:
  sweep: {speed_mm_s: 120}         # in a hurry
sequence:
  - {function: clean, nozzle: ring60, paths: [sweep]}
  - {function: rinse, nozzle: ring60, paths: [sweep]}
"""
# A washing that needs little: chemistry of its own would make any board clean.
EASY = load_parameters().model_copy(
    update={
        "soil": load_parameters().soil.model_copy(update={"k1_per_s": 10.0, "k_m_per_s": 10.0}),
        "limits": load_parameters().limits.model_copy(
            update={"wash_volume_mm": 1e-6, "rinse_volume_mm": 1e-6, "exchanges": 1e-6}
        ),
    }
)
USUAL = frozenset({"speeds", "tilts", "passes", "dwells", "heights", "sides", "wash_time"})


@pytest.fixture(scope="module")
def board():
    return load_board(Path("tiny"))


@pytest.fixture(scope="module")
def prepared(board):
    return prepare(board, load_parameters(), lambda *_: None)


def tuned_with(prepared, text, analyses, limits=None, kinds=USUAL, kept=(), **more):
    runner = TrialRunner(FILE, prepared, "clean", analyses)
    if "store" in more:
        runner.keep_in(more["store"])
    allowed, worth = AllowedChanges(kinds, kept), more.get("worth", Worth())
    request = TuningRequest("clean", limits or ProgramLimits(), allowed, analyses, worth)
    return tune(runner, text, request, more.get("observe", ignore))


@pytest.fixture(scope="module")
def store():
    """Records of the trials of ``tuned``."""
    return MemoryStore()


@pytest.fixture(scope="module")
def on_the_way():
    """Results that ``tuned`` gave on the way."""
    return []


@pytest.fixture(scope="module")
def tuned(prepared, store, on_the_way):
    return tuned_with(prepared, POOR, 4, store=store, observe=on_the_way.append)


def anew(prepared, text):
    from cleaning.analyse import analyse_on

    planned = run(parse_recipe(text, file=FILE), prepared.board)
    return outcome_of(planned, analyse_on(prepared, planned.program, planned.recipe, "fast"), "clean", text)


@pytest.mark.slow
def test_a_poor_recipe_becomes_better_with_few_analyses(tuned):
    assert tuned.used == 4
    assert tuned.last.shortfall < 0.6 * tuned.first.shortfall
    assert tuned.changes[0].before == tuned.first.figures
    assert tuned.changes[-1].after == tuned.last.figures
    for change, following in zip(tuned.changes, tuned.changes[1:], strict=False):
        assert change.after == following.before


@pytest.mark.slow
def test_what_is_predicted_comes_out_when_planned_and_analysed_anew(prepared, tuned):
    again = anew(prepared, tuned.last.text)
    assert again.figures == tuned.last.figures
    assert again.residues == tuned.last.residues
    assert again.unmet == tuned.last.unmet


class InterruptedTrialError(Exception):
    """Ends an analysis."""


@pytest.fixture
def analyses(monkeypatch):
    """Count the analyses, and end one of them."""
    made, ends = [], []
    analyse_on = trial_runner.analyse_on

    def analyse(*args, **options):
        if len(made) in ends:
            raise InterruptedTrialError
        made.append(args)
        return analyse_on(*args, **options)

    monkeypatch.setattr(trial_runner, "analyse_on", analyse)
    return made, ends


@pytest.mark.slow
def test_a_tuning_that_was_interrupted_ends_like_any_other_and_repeats_no_analysis(prepared, tuned, analyses):
    made, ends = analyses
    store = MemoryStore()
    ends.append(2)
    with pytest.raises(InterruptedTrialError):
        tuned_with(prepared, POOR, 4, store=store)
    ends.clear()
    again = tuned_with(prepared, POOR, 4, store=store)
    assert len(made) == 4
    assert again.last.text == tuned.last.text
    reports = [tuning_report(each, explain(each), "") for each in (tuned, again)]
    assert reports[0] == reports[1]


@pytest.mark.slow
def test_all_that_the_search_uses_of_an_outcome_is_restored_from_its_record(prepared, tuned, store, analyses):
    runner = TrialRunner(FILE, prepared, "clean", 4)
    runner.keep_in(store)
    runner.first(POOR)
    restored = runner.outcome(tuned.last.text)
    assert analyses[0] == []
    for field in fields(Outcome):
        if field.name != "deposits":
            assert getattr(restored, field.name) == getattr(tuned.last, field.name), field.name
    for mine, theirs in zip(restored.deposits.each, tuned.last.deposits.each, strict=True):
        assert (mine.step, mine.template, mine.seconds) == (theirs.step, theirs.template, theirs.seconds)
        np.testing.assert_array_equal(mine.volume_mm, theirs.volume_mm)
    assert list(restored.deposits.cells) == list(tuned.last.deposits.cells)
    for key, cells in restored.deposits.cells.items():
        np.testing.assert_array_equal(cells, tuned.last.deposits.cells[key])


@pytest.mark.slow
def test_the_best_so_far_is_at_hand_from_the_first_analysis_on(tuned, on_the_way):
    assert on_the_way[0].last.text == POOR
    assert on_the_way[0].used == 1
    assert [each.last.figures for each in on_the_way[1:]] == [change.after for change in tuned.changes]
    assert all(after.last.shortfall < before.last.shortfall for before, after in pairwise(on_the_way))
    assert on_the_way[-1].last.text == tuned.last.text


@pytest.mark.slow
def test_tuning_stops_where_a_requirement_costs_more_than_it_is_worth(prepared, store):
    tuned = tuned_with(prepared, POOR, 4, worth=Worth(requirement_s=1.0), store=store)
    assert not tuned.last.clean
    for change in tuned.changes:
        gained = change.before.open_requirements - change.after.open_requirements
        assert change.after.seconds - change.before.seconds <= 20.0 * max(gained, 1)
    assert tuned.last.seconds < 60.0


@pytest.mark.slow
def test_every_analysed_recipe_is_listed_and_those_of_the_front_do_what_is_predicted(prepared, tuned):
    assert len(tuned.trials) == tuned.used
    assert tuned.trials[0].figures == tuned.first.figures
    front = pareto_front(tuned.trials)
    assert POOR in [each.text for each in front]  # nothing is quicker
    assert anew(prepared, front[-1].text).figures == front[-1].figures
    assert all((each.margin >= 1.0) == (not each.figures.open_requirements) for each in tuned.trials)


@pytest.mark.slow
def test_comments_and_order_stay(tuned):
    assert "# in a hurry" in tuned.last.text
    kept = [line for line in POOR.splitlines() if "paths:" not in line and "sweep" not in line]
    assert [line for line in tuned.last.text.splitlines() if line in kept] == kept


@pytest.mark.slow
def test_open_requirements_are_explained(tuned):
    reasons = {reason.component: reason for reason in explain(tuned)}
    assert set(reasons) == {unmet.component for unmet in tuned.last.unmet}
    for reason in reasons.values():
        assert reason.rule in {unmet.judgement.rule for unmet in tuned.last.unmet}
        assert reason.because
        assert "The 4 analyses were spent." in reason.why
        assert "--" not in reason.why  # what allows more is called differently on a page


@pytest.mark.slow
def test_limits_are_kept(prepared):
    tuned = tuned_with(prepared, POOR, 3, ProgramLimits(seconds=20.0))
    assert tuned.within_limits
    assert tuned.last.seconds <= 20.0
    assert tuned.last.shortfall < tuned.first.shortfall


@pytest.mark.slow
def test_a_recipe_beyond_its_limits_is_brought_within_them(prepared, tuned):
    slow = tuned_with(prepared, POOR.replace("120", "5"), 4, ProgramLimits(seconds=0.8 * tuned.first.seconds + 2.0))
    assert slow.first.seconds > slow.last.seconds
    assert slow.within_limits


@pytest.mark.slow
def test_what_is_not_allowed_stays_and_is_named(prepared):
    tuned = tuned_with(prepared, POOR, 4, kinds=frozenset({"speeds"}), kept=(("templates", "sweep", "speed_mm_s"),))
    assert tuned.last.text == POOR
    assert tuned.changes == ()
    reports = " ".join(reason.why for reason in explain(tuned))
    assert "Not allowed, though it may help: " in reports
    assert "Kept, though it may help: templates.sweep.speed_mm_s." in reports


@pytest.mark.slow
def test_a_recipe_that_is_clean_never_becomes_longer(board):
    easy = prepare(board, EASY, lambda *_: None)
    slow = "recipe: own\nextends: smt-aqueous\n" + _thorough()
    kept = MemoryStore()
    tuned = tuned_with(easy, slow, 3, store=kept)
    assert tuned.first.clean, [unmet.judgement.because for unmet in tuned.first.unmet]
    assert tuned.last.clean
    assert tuned.last.seconds < tuned.first.seconds
    assert tuned.last.litres <= tuned.first.litres
    assert all(change.after.seconds <= change.before.seconds for change in tuned.changes)
    assert tuned.last.recipe.sequence[2] == parse_recipe(slow).sequence[2]
    assert tuned.last.recipe.templates["flush"].speed_mm_s == 50  # the drying uses it too
    content = tuned_with(easy, slow, 3, store=kept, kinds=frozenset({"speeds"}), worth=Worth(saving=0.95))
    assert content.used == 1
    assert content.last.text == slow
    assert "an analysis is worth 95.0%" in describe_end(content)


def _thorough():
    return """templates:
  edge: {tilt_deg: 30, repeats: 2}
  slanted: {path: raster, height_mm: 40, speed_mm_s: 10, direction_deg: across_longest_edge, tilt_deg: 25}
sequence:
  - {function: clean, nozzle: ring60, paths: [edge, sweep, around, slanted]}
  - {function: rinse, nozzle: ring60, paths: [edge, sweep, around, slanted, flush]}
  - {function: dry, nozzle: knife, paths: [flush]}
"""


@pytest.mark.slow
def test_a_suggestion_does_what_is_predicted_of_it(prepared):
    from cleaning.analyse import analyse_on

    planned = run(parse_recipe(POOR, file=FILE), prepared.board)
    report = analyse_on(prepared, planned.program, planned.recipe, "fast")
    first = suggest(planned, report)[0]
    effect = predict(first, AnalysedRecipe(FILE, POOR, planned, report, prepared))
    assert anew(prepared, effect.text).figures == effect.after
    assert effect.before == outcome_of(planned, report, "clean").figures
    assert effect.after.seconds > effect.before.seconds


@pytest.mark.slow
def test_jumps_stay_within_bounds_leave_drying_alone_and_lead_back(prepared, tuned):
    dried = f"{tuned.last.text}  - {{function: dry, nozzle: knife, paths: [flush]}}\n"
    outcome = replace(tuned.last, recipe=parse_recipe(dried, file=FILE))
    outcome = replace(outcome, steps=(*outcome.steps, StepSummary("sequence[2]", "dry", "dry", 5.0, None)))
    runner = TrialRunner(FILE, prepared, "clean", 4)

    def found(kinds, kept=()):
        request = TuningRequest("clean", ProgramLimits(), AllowedChanges(frozenset(kinds), kept), 4)
        return list(jumps_of_values(TuningContext(runner, request, outcome, lambda _: None), outcome))

    usual = found(USUAL)
    heights = next(each for each in usual if (each.name, each.way) == ("all heights", 1))
    assert {path[-1] for path, _ in heights.edits} == {"height_mm"}
    assert len({path[1] for path, _ in heights.edits}) == len(heights.edits) > 1
    variables = {each.path: each for each in variables_of(outcome)}
    for each in found(CHANGE_KINDS):
        assert each.what
        for path, value in each.edits:
            assert variables[path].lower <= value <= variables[path].upper
            assert value != variables[path].value
            assert "sequence[2]" not in variables[path].steps
    ways = {(each.name, each.way) for each in usual}
    assert ways >= {(each.name, -each.way) for each in usual if "height" in each.name}
    assert all(path[0] == "templates" for each in usual for path, _ in each.edits)
    assert any(path[-1] == "pressure_bar" for each in found(["pressure"]) for path, _ in each.edits)
    assert found(["speeds"]) == []
    assert not any("sweep" in path for each in found(USUAL, (("templates", "sweep"),)) for path, _ in each.edits)


@pytest.mark.slow
def test_jumps_to_other_paths_are_shorter_and_put_one_in_the_place_of_another(prepared, tuned):
    runner = TrialRunner(FILE, prepared, "clean", 4)
    runner.first(tuned.last.text)

    def found(kinds):
        request = TuningRequest("clean", ProgramLimits(), AllowedChanges(frozenset(kinds), ()), 4)
        return list(jumps_of_paths(TuningContext(runner, request, tuned.last, lambda _: None), tuned.last))

    jumps = found(USUAL)
    assert jumps
    seconds: list[float] = []
    for each in jumps:
        candidate = runner.candidate(tuned.last.text, each.edits)
        assert candidate is not None
        seconds.append(candidate.seconds)
        before, after = (
            [name for step in recipe.sequence for name in step.paths]
            for recipe in (tuned.last.recipe, parse_recipe(candidate.text, file=FILE))
        )
        assert len(before) == len(after)
        assert before != after
    assert seconds == sorted(seconds)
    assert seconds[-1] < tuned.last.seconds
    assert found(["speeds"]) == []


@pytest.mark.slow
@pytest.mark.long
def test_tuning_beats_a_grid_of_the_same_design_variables(prepared):
    tuned = tuned_with(prepared, POOR, 14)
    grid = TrialRunner(FILE, prepared, "clean", 60)
    grid.first(POOR)
    points = list(product((10, 20, 40), (1, 2), (2, 4, 8), (1,)))
    assert tuned.last.clean
    assert tuned.used < len(points)
    quicker = [text for text in (_gridded(*point) for point in points) if _seconds(grid, text) < tuned.last.seconds]
    assert quicker
    assert [text for text in quicker if grid.outcome(text).clean] == []


def _seconds(runner, text):
    candidate = runner.candidate(text)
    assert candidate is not None
    return candidate.seconds


def _gridded(speed, passes, wash, rinse):
    around = f"path: component_perimeter, height_mm: 40, speed_mm_s: {speed}, tilt_deg: 39, passes: {passes}"
    return f"""recipe: poor
extends: smt-aqueous
templates:
  rim: {{path: board_perimeter, height_mm: 40, speed_mm_s: 40, offset_mm: 5, tilt_deg: 20}}
  parts: {{{around}}}
  slanted: {{path: raster, height_mm: 40, speed_mm_s: 40, direction_deg: across_longest_edge, tilt_deg: 25}}
sequence:
  - {{function: clean, nozzle: ring60, paths: [rim, slanted, parts], repeat: {wash}}}
  - {{function: rinse, nozzle: ring60, paths: [rim, slanted, parts], repeat: {rinse}}}
"""
