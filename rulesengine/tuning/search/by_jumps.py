"""Jumps of paths, heights, tilts and pressures, which shorten a recipe that small changes no longer shorten.

How much lands along another path, from another height, or under another tilt, no forecast knows. So a jump is analysed
as it is, and from that outcome the linear programs forecast what speeds it needs: it is taken if the whole is shorter.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from rulesengine.tuning.changes.candidate_changes import variables_of
from rulesengine.tuning.changes.new_paths import replaced_paths
from rulesengine.tuning.search.acceptance import Acceptance, acceptance_of
from rulesengine.tuning.search.by_linear_program import shorten_by_linear_program, shorten_from
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.trial_runner import TuningContext
from rulesengine.tuning.variables.design_variables import ChangeKind, DesignVariable
from rulesengine.tuning.variables.recipe_edits import Edits

_STAGE = "jumps"
_KINDS: tuple[ChangeKind, ...] = ("heights", "tilts", "pressure")
_NEARER = 0.7
"""Of a height: the ring of a hollow cone becomes narrower by as much, and hits a half harder."""
_TILT_DEG = 15.0
_MOST_FAILURES = 2
"""Jumps in a row that save nothing before those of their kind end."""
_LEAST_SHARE = 0.05
"""Of the spraying time that a template takes: what takes less cannot save much."""
_MOST_LONGER = 1.5
"""Times the program that a jump may take before its speeds are adapted."""


@dataclass(frozen=True, slots=True)
class Jump:
    """Other values of one or several variables at once."""

    name: str
    """The same from one recipe to the next."""
    opposite: str
    """Name of the jump back."""
    what: tuple[str, ...]
    edits: Edits


_Jumps: TypeAlias = Callable[[TuningContext, Outcome], Iterator[Jump]]


def shorten_by_jumps(context: TuningContext, acceptance: Acceptance) -> Outcome:
    """Shorten a recipe by jumps to other paths, then to other values, until several in a row save nothing."""
    context.ended.pop(_STAGE, None)
    for jumps in (jumps_of_paths, jumps_of_values):
        acceptance = _shorten(context, acceptance, jumps)
    if context.runner.left > 0:
        least = context.request.worth.saving
        context.ended[_STAGE] = f"No other path, height, tilt or pressure that was tried saves {least:.1%}."
    return acceptance.reference


def _shorten(context: TuningContext, acceptance: Acceptance, jumps: _Jumps) -> Acceptance:
    """Make jumps of one kind; the acceptance against the recipe that they lead to."""
    failures, left_out = 0, set[str]()
    while context.runner.left > 0 and failures < _MOST_FAILURES:
        now = acceptance.reference
        jump = next((each for each in jumps(context, now) if each.name not in left_out), None)
        if jump is None:
            break
        after, what = _try_jump(context, acceptance, jump)
        if not what:
            left_out.add(jump.name)
            failures += after is not now
            continue
        context.accept(what, now, after)
        left_out.add(jump.opposite)
        failures = 0
        acceptance = acceptance_of(context, shorten_by_linear_program(context, acceptance_of(context, after)))
    return acceptance


def _try_jump(context: TuningContext, acceptance: Acceptance, jump: Jump) -> tuple[Outcome, Sequence[str]]:
    """Analyse a jump and adapt its speeds; the outcome and what changed, or nothing where that is not accepted."""
    now = acceptance.reference
    candidate = context.runner.candidate(now.text, jump.edits)
    if candidate is None or candidate.seconds > _MOST_LONGER * now.seconds:
        return now, ()
    landed = context.runner.outcome(candidate.text)
    if landed is None:
        return now, ()
    worth = context.request.worth
    saves = worth.saved(now, landed) >= worth.saving and landed.litres <= now.litres
    if saves and context.excess(landed) <= context.excess(now) and acceptance.accepts(landed):
        return landed, jump.what
    after, what = shorten_from(context, acceptance, landed)
    if not what or context.excess(after) > context.excess(now):
        return landed, ()
    return after, (*jump.what, *what)


def jumps_of_paths(context: TuningContext, outcome: Outcome) -> Iterator[Jump]:
    """Jumps to another path in the place of one, if the program becomes shorter by it; the shortest first."""
    found: list[tuple[float, Jump]] = []
    for template, share in _shares(outcome).items():
        for change in replaced_paths(outcome, template) if share >= _LEAST_SHARE else ():
            candidate = context.runner.candidate(outcome.text, change.edits)
            if (
                candidate is not None
                and candidate.seconds < outcome.seconds
                and context.request.allowed.permits(change.kind, change.edits)
            ):
                found.append((candidate.seconds, Jump(change.what, "", (change.what,), change.edits)))
    yield from (jump for _, jump in sorted(found, key=lambda each: each[0]))


def jumps_of_values(context: TuningContext, outcome: Outcome) -> Iterator[Jump]:
    """Jumps that are allowed: of all heights together, of pressures, then template by template, the longest first."""
    drying = frozenset(step.made_by for step in outcome.steps if step.use == "dry")
    variables = [
        each
        for each in variables_of(outcome)
        if each.kind in _KINDS
        and not each.component_class
        and not drying & frozenset(each.steps)
        and context.request.allowed.permits(each.kind, each.edit(each.value))
    ]
    shares = _shares(outcome)
    heights = [each for each in variables if each.kind == "heights" and each.template in shares]
    if len(heights) > 1:
        yield from _of_heights("all heights", heights)
    for each in variables:
        if each.kind == "pressure":
            yield from _jump(str(each.path), "", [(each, (each.value * each.upper) ** 0.5)])
    for template, share in sorted(shares.items(), key=lambda pair: -pair[1]):
        own = [each for each in variables if each.template == template] if share >= _LEAST_SHARE else []
        for each in own:
            if each.kind == "heights":
                yield from _of_heights(str(each.path), [each])
            else:
                for name, opposite, by in (("flatter", "steeper", -_TILT_DEG), ("steeper", "flatter", _TILT_DEG)):
                    yield from _jump(f"{each.path} {name}", f"{each.path} {opposite}", [(each, each.value + by)])


def _of_heights(name: str, heights: Sequence[DesignVariable]) -> Iterator[Jump]:
    for way, back, factor in (("nearer", "farther", _NEARER), ("farther", "nearer", 1.0 / _NEARER)):
        yield from _jump(f"{name} {way}", f"{name} {back}", [(each, factor * each.value) for each in heights])


def _jump(name: str, opposite: str, values: Sequence[tuple[DesignVariable, float]]) -> Iterator[Jump]:
    changed = [
        (variable, variable.rounded(value)) for variable, value in values if variable.rounded(value) != variable.value
    ]
    if changed:
        what = tuple(variable.describe(value) for variable, value in changed)
        yield Jump(name, opposite, what, tuple(edit for variable, value in changed for edit in variable.edit(value)))


def _shares(outcome: Outcome) -> dict[str, float]:
    """Share of the spraying time of each template, without drying."""
    seconds: dict[str, float] = {}
    for each in outcome.deposits.each:
        if outcome.use_of(each.step) != "dry":
            seconds[each.template] = seconds.get(each.template, 0.0) + each.seconds
    total = sum(seconds.values())
    return {template: each / total for template, each in seconds.items()} if total > 0 else {}
