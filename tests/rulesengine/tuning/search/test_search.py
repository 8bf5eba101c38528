"""The loop of the search, and the moves that need no forecast, on outcomes that are made up."""

from types import SimpleNamespace

import pytest

from cleaning.verdicts.results import Judgement
from cleaning.verdicts.rules import RESIDUE_LEFT
from rulesengine.tuning.changes.reductions import Reduction
from rulesengine.tuning.search.improving import Reducing
from rulesengine.tuning.search.moves import Acceptance, Move
from rulesengine.tuning.search.shortening import Jump, Jumping
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest
from rulesengine.tuning.trial.requirements import UnmetRequirement, total_shortfall
from rulesengine.tuning.trial.trial_runner import Candidate
from rulesengine.tuning.tune import first_of, search
from rulesengine.tuning.variables import DesignVariable

OPEN = UnmetRequirement("U1", Judgement(rule=RESIDUE_LEFT, verdict="dirty", because="because", advice="advice"), 0.5)
SECONDS, STEPS = 10.0, ("sequence[0]",)


def outcome(text, seconds, *unmet, litres=1.0):
    return SimpleNamespace(
        text=text, seconds=seconds, litres=litres, unmet=unmet, attainable=unmet, met=(), figures=text,
        shortfall=total_shortfall(unmet), deposits=SimpleNamespace(each=()),
    )  # fmt: skip


class MadeUpContext:
    """A tuning whose recipes are numbers: what its edits write is the text, and a second takes a second."""

    def __init__(self, first, outcomes=(), left=10, limits=None, reductions=()):
        self.best = first
        self.request = TuningRequest("clean", limits or ProgramLimits(), AllowedChanges(frozenset()), 40)
        self.runner = SimpleNamespace(left=left, outcome=self._outcome, candidate=self._candidate)
        self.taken, self.analysed, self.ended = [], [], {}
        self._outcomes = {each.text: each for each in outcomes}
        self._reductions = {each.name: each for each in reductions}

    @property
    def acceptance(self):
        return Acceptance(self.request, self.best, frozenset())

    def reductions(self, _of):
        return self._reductions

    def accept(self, what, after):
        self.taken.append((*what, after.text))
        self.best = after

    def _outcome(self, text):
        self.runner.left -= 1
        self.analysed.append(text)
        return self._outcomes.get(text)

    def _candidate(self, _text, edits):
        ((path, value),) = edits
        if value is None:
            return None
        return Candidate(f"{path[0]} {value}", SECONDS * value, 1.0)


def moves(*texts):
    """Moves to some recipes, one after the other, and what each learnt."""
    left, learnt = list(texts), []

    def propose(_now):
        if not left:
            return None
        text = left.pop(0)
        return Move((text,), Candidate(text, 0.0, 0.0), lambda after, accepted: learnt.append((after, accepted)))

    return propose, learnt


def test_each_better_recipe_is_taken_and_each_move_learns() -> None:
    better, longer = outcome("better", 90.0), outcome("longer", 101.0)
    context = MadeUpContext(outcome("first", 100.0), (better, longer))
    propose, learnt = moves("longer", "nothing", "better")
    search(context, propose)
    assert context.taken == [("better", "better")]
    assert learnt == [(longer, False), (None, False), (better, True)]


@pytest.mark.parametrize(("left", "reserve", "analysed"), [(10, 0, 3), (3, 0, 3), (3, 1, 2), (3, 3, 0), (0, 0, 0)])
def test_the_reserve_of_analyses_is_left(left, reserve, analysed) -> None:
    context = MadeUpContext(outcome("first", 100.0), left=left)
    search(context, moves("a", "b", "c")[0], reserve)
    assert len(context.analysed) == analysed
    assert context.runner.left == left - analysed


def test_the_first_that_has_a_move_gives_it() -> None:
    one, other = moves("a"), moves("b", "c")
    propose = first_of(one[0], other[0])
    found = [propose(None) for _ in range(4)]
    assert [each and each.what for each in found] == [("a",), ("b",), ("c",), None]


def test_a_jump_that_saves_enough_is_taken_as_it_is() -> None:
    context = MadeUpContext(outcome("first", 100.0), (outcome("x 1", 90.0),))
    jumps = Jumping(context, lambda _, now: iter([jump("x", 1)] if now.text == "first" else []))
    search(context, jumps.propose)
    assert context.taken == [("x 1", "x 1")]
    assert "No other path" in context.ended["jumps"]


def jump(name, way, value=1):
    return Jump(name, way, (f"{name} {way}",), (((name,), value),))


def test_after_two_jumps_in_a_row_that_fail_no_more_are_made_and_one_that_helps_begins_anew() -> None:
    context = MadeUpContext(outcome("first", 100.0))
    jumps = Jumping(context, lambda *_: iter([jump("a", 1), jump("b", 1), jump("c", 1), jump("d", 1)]))
    lost, won = outcome("lost", 120.0), outcome("won", 90.0)
    for after, accepted in ((lost, False), (won, True), (lost, False), (lost, False)):
        move = jumps.propose(context.best)
        assert move is not None
        move.learn(after, accepted)
    assert jumps.propose(context.best) is None


def test_a_jump_that_helped_may_go_on_but_not_back_and_one_that_failed_is_not_repeated() -> None:
    context = MadeUpContext(outcome("first", 100.0))
    jumps = Jumping(context, lambda *_: iter([jump("a", 1), jump("a", -1), jump("b", 1)]))
    for name, accepted in (("a", True), ("a", False), ("b", False)):
        move = jumps.propose(context.best)
        assert move is not None
        assert move.what == (f"{name} 1",)
        move.learn(outcome("x", 1.0), accepted)


def test_a_jump_that_is_much_longer_or_cannot_be_planned_is_passed_over_and_no_failure() -> None:
    context = MadeUpContext(outcome("first", 100.0))
    jumps = Jumping(context, lambda *_: iter([jump("a", 1, 15.1), jump("b", 1, None), jump("c", 1, 15.0)]))
    move = jumps.propose(context.best)
    assert move is not None
    assert move.what == ("c 1",)
    assert jumps.failures == 0


def test_with_no_analysis_left_for_its_speeds_a_jump_is_not_taken() -> None:
    context = MadeUpContext(outcome("first", 100.0), (outcome("x 1", 99.9),), left=1)
    search(context, Jumping(context, lambda *_: iter([jump("x", 1)])).propose)
    assert context.taken == []


def reduction(name, value, kind="dwells", end=0.0, *, resolution=1.0, path="", component_class=""):
    variable = DesignVariable(kind, (path or name,), value, 0.0, 100.0, resolution, 1.0, STEPS, name, component_class)
    return Reduction(name, end, variable, steps=STEPS, template=name)


def test_where_no_number_is_left_nothing_is_reduced() -> None:
    context = MadeUpContext(outcome("first", 100.0))
    assert Reducing(context).propose(context.best) is None
    assert Reducing(context).relieve(context.best) is None


@pytest.mark.parametrize(
    ("kind", "path", "component_class", "unknown"),
    [
        ("dwells", "delay_s", "", True),
        ("passes", "repeats", "", False),
        ("passes", "passes", "small", True),
        ("wash_time", "repeat", "", False),
        ("wash_time", "least_time_s", "", True),
        ("speeds", "speed_mm_s", "", False),
        ("speeds", "speed_mm_s", "small", True),
    ],
)
def test_what_linear_programs_know_is_left_to_them(kind, path, component_class, unknown) -> None:
    one = reduction("a", 9.0, kind, 1.0, path=path, component_class=component_class)
    assert one.is_unknown == unknown
    context = MadeUpContext(outcome("first", 100.0), reductions=[one])
    assert (Reducing(context).propose(context.best) is not None) == unknown


def test_the_reduction_that_saves_most_comes_first_and_after_failures_it_goes_half_as_far() -> None:
    context = MadeUpContext(outcome("first", 100.0), reductions=[reduction("a", 9.0, end=5.0), reduction("b", 8.0)])
    reducing = Reducing(context)
    seen = []
    while (move := reducing.propose(context.best)) is not None:
        seen.append(move.what[0])
        move.learn(outcome("x", 1.0), False)
    assert seen == ["b: 8 -> 0", "b: 8 -> 4", "a: 9 -> 5", "b: 8 -> 6", "a: 9 -> 7", "a: 9 -> 8"]


def test_a_reduction_that_hardly_saves_is_not_analysed() -> None:
    first = outcome("first", 100.0)
    for end, worth_it in ((9.98, True), (9.995, False)):  # 0.1 % is a tenth of what is worth an analysis
        one = reduction("a", 10.0, end=end, resolution=0.001)
        assert (Reducing(MadeUpContext(first, reductions=[one])).propose(first) is not None) == worth_it


def test_beyond_the_limits_the_least_that_keeps_them_is_taken_whatever_it_is() -> None:
    one = reduction("a", 10.0, "passes", 1.0)
    context = MadeUpContext(
        outcome("first", 100.0), (outcome("a 7", 70.0, OPEN),), limits=ProgramLimits(seconds=75.0), reductions=[one]
    )
    reducing = Reducing(context)
    search(context, reducing.relieve)
    assert context.taken == [("a: 10 -> 7", "a 7")]
    assert reducing.relieve(context.best) is None


def test_where_nothing_keeps_the_limits_what_leads_nearest_is_taken() -> None:
    found = [reduction("a", 10.0, end=6.0), reduction("b", 10.0, end=4.0), reduction("c", 10.0, end=10.0)]
    context = MadeUpContext(outcome("first", 100.0), limits=ProgramLimits(seconds=20.0), reductions=found)
    move = Reducing(context).relieve(context.best)
    assert move is not None
    assert move.what == ("b: 10 -> 4",)
