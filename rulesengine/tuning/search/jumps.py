"""Moves that jump to other paths, heights, tilts and pressures, where small changes no longer shorten a recipe.

How much lands along another path, from another height, or under another tilt, no forecast knows. So a jump is analysed
as it is, and from that outcome the linear programs forecast what speeds it needs: it is taken if the whole is shorter.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import partial

from rulesengine.tuning.changes.candidate_changes import replaced_paths, variables_of
from rulesengine.tuning.search.moves import Move, TuningContext
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.variables.design_variables import ChangeKind, DesignVariable
from rulesengine.tuning.variables.recipe_edits import Edits

_KIND = "jumps"
_NEARER = 0.7
"""Of a height: the ring of a hollow cone becomes narrower by as much, and hits a half harder."""
_TILT_DEG = 15.0
_VALUES: dict[ChangeKind, Callable[[DesignVariable, int], float]] = {
    "heights": lambda each, way: each.value * _NEARER**way,
    "tilts": lambda each, way: each.value - way * _TILT_DEG,
    "pressure": lambda each, way: (each.value * each.upper) ** 0.5 if way > 0 else each.value,
}
"""Values to jump to: 1 nearer, flatter, or with more pressure, and -1 back."""
_MOST_FAILURES = 2
"""Jumps in a row that save nothing before those of their kind end."""
_LEAST_SHARE = 0.05
"""Of the spraying time that a template takes: what takes less cannot save much."""
_MOST_LONGER = 1.5
"""Times the program that a jump may take before its speeds are adapted."""


@dataclass(frozen=True, slots=True)
class Jump:
    """Another path, or other values of one or several variables at once."""

    name: str
    """What changes, the same from one recipe to the next."""
    way: int
    """1 or -1, and 0 where there is no way back."""
    what: tuple[str, ...]
    edits: Edits


@dataclass(slots=True)
class Jumping:
    """Which jumps of one kind were tried."""

    context: TuningContext
    jumps: Callable[[TuningContext, Outcome], Iterator[Jump]]
    tried: set[tuple[str, int]] = field(default_factory=set[tuple[str, int]])
    """By name and way."""
    failures: int = 0
    """In a row."""

    def propose(self, now: Outcome) -> Move | None:
        """The next jump, until several in a row save nothing."""
        self.context.ended.pop(_KIND, None)
        for jump in self.jumps(self.context, now) if self.failures < _MOST_FAILURES else ():
            if (jump.name, jump.way) not in self.tried:
                self.tried.add((jump.name, jump.way))
                candidate = self.context.runner.candidate(now.text, jump.edits)
                if candidate is not None and candidate.seconds <= _MOST_LONGER * now.seconds:
                    return Move(jump.what, candidate, partial(self._learn, jump), by_speeds=True)
        least = self.context.request.worth.saving
        self.context.ended[_KIND] = f"No other path, height, tilt or pressure that was tried saves {least:.1%}."
        return None

    def _learn(self, jump: Jump, after: Outcome | None, accepted: bool) -> None:
        if accepted:
            self.tried = (self.tried - {(jump.name, jump.way)}) | {(jump.name, -jump.way)}
        self.failures = 0 if accepted else self.failures + (after is not None)


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
                found.append((candidate.seconds, Jump(change.what, 0, (change.what,), change.edits)))
    yield from (jump for _, jump in sorted(found, key=lambda each: each[0]))


def jumps_of_values(context: TuningContext, outcome: Outcome) -> Iterator[Jump]:
    """Jumps that are allowed: of all heights together, of pressures, then template by template, the longest first."""
    drying = frozenset(step.made_by for step in outcome.steps if step.use == "dry")
    variables = [
        each
        for each in variables_of(outcome)
        if each.kind in _VALUES
        and not each.component_class
        and not drying & frozenset(each.steps)
        and context.request.allowed.permits(each.kind, each.edit(each.value))
    ]
    shares = _shares(outcome)
    longest = sorted((name for name, share in shares.items() if share >= _LEAST_SHARE), key=lambda name: -shares[name])
    heights = [each for each in variables if each.kind == "heights" and each.template in shares]
    groups = [("all heights", heights)] if len(heights) > 1 else []
    groups += [(str(each.path), [each]) for each in variables if each.kind == "pressure"]
    groups += [(str(each.path), [each]) for name in longest for each in variables if each.template == name]
    for name, group in groups:
        for way in (1, -1):
            values = [(each, each.rounded(_VALUES[each.kind](each, way))) for each in group]
            changed = [(each, value) for each, value in values if value != each.value]
            if changed:
                what = tuple(each.describe(value) for each, value in changed)
                yield Jump(name, way, what, tuple(edit for each, value in changed for edit in each.edit(value)))


def _shares(outcome: Outcome) -> dict[str, float]:
    """Share of the spraying time of each template, without drying."""
    seconds: dict[str, float] = {}
    for each in outcome.deposits.each:
        if outcome.use_of(each.step) != "dry":
            seconds[each.template] = seconds.get(each.template, 0.0) + each.seconds
    total = sum(seconds.values())
    return {template: each / total for template, each in seconds.items()} if total > 0 else {}
