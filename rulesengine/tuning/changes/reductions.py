"""Changes that save time: faster, fewer, shorter, or a path less."""

from collections.abc import Mapping
from dataclasses import dataclass

from rulesengine.tuning.changes.candidate_changes import knobs_for
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Allowed
from rulesengine.tuning.variables.design_variables import Kind, Knob
from rulesengine.tuning.variables.recipe_edits import Edits, is_kept
from specs.yaml.located import YamlPath, spell_path

_SAVING: frozenset[Kind] = frozenset({"speeds", "passes", "dwells", "wash_time"})
_FASTER = 4.0
"""A speed is raised by no more than this at once."""


@dataclass(frozen=True, slots=True)
class Cut:
    """One way to save time: a knob that is turned towards ``end``, or a path that is left out."""

    name: str
    """The same from one recipe to the next."""
    end: float = 0.0
    knob: Knob | None = None
    edits: Edits = ()
    """Of a path that is left out."""

    steps: tuple[str, ...] = ()
    template: str = ""
    """Of which it takes something away; empty: of the whole steps."""

    @property
    def begin(self) -> float:
        """Value of the knob as it is."""
        return self.end if self.knob is None else self.knob.value

    def part(self, share: float) -> float | None:
        """Give the value that is a share of the way to the end; ``None`` where that is nothing."""
        if self.knob is None or share >= 1:
            return self.end
        begin = self.knob.value
        if self.knob.kind == "speeds":  # time goes with the inverse of speed
            value = self.knob.moved(1.0 / (1.0 / begin + share * (1.0 / self.end - 1.0 / begin)))
        else:
            value = self.knob.moved(begin + share * (self.end - begin))
        return None if value == begin else value

    def at(self, value: float) -> tuple[str, Edits]:
        """Say and write what it changes, the knob being set to a value."""
        if self.knob is None:
            return self.name, self.edits
        return self.knob.told(value), self.knob.edit(value)

    def halfway(self, good: float, bad: float) -> float | None:
        """Give the value between one that holds and one that does not; ``None`` where there is none."""
        if self.knob is None:
            return None
        middle = (good * bad) ** 0.5 if self.knob.kind == "speeds" else 0.5 * (good + bad)
        value = self.knob.moved(middle)
        return None if value in (good, bad) else value


def cuts_of(outcome: Outcome, began: Mapping[YamlPath, float], allowed: Allowed) -> dict[str, Cut]:
    """List ways to save time by name.

    What acts in drying is made no shorter than it was to begin with: no rule asks how long drying takes.

    Args:
        outcome: Of the recipe to be shortened.
        began: Values of the knobs of the recipe that tuning began with.
        allowed: What may be changed.
    """
    drying = frozenset(step.made_by for step in outcome.steps if step.use == "dry")
    found: dict[str, Cut] = {}
    for knob in knobs_for(outcome):
        if knob.kind not in _SAVING or knob.kind not in allowed.kinds or is_kept(knob.path, allowed.kept):
            continue
        end = _end(knob)
        if drying & frozenset(knob.steps):
            first = began.get(knob.path, began.get(knob.path[:-1], knob.value))
            end = min(end, first) if knob.kind == "speeds" else max(end, first)
        if knob.gain * (knob.value - end) > 0:
            name = f"{spell_path(knob.path)} {knob.of_class}"
            found[name] = Cut(name, end, knob, steps=knob.steps, template=knob.template)
    if "passes" in allowed.kinds:
        found |= {cut.name: cut for cut in _left_out(outcome, drying, allowed)}
    return found


def _end(knob: Knob) -> float:
    if knob.kind == "speeds":
        return knob.moved(min(knob.most, _FASTER * knob.value))
    return max(knob.least, 0.0 if knob.of_class or knob.kind == "dwells" else 1.0)


def _left_out(outcome: Outcome, drying: frozenset[str], allowed: Allowed) -> list[Cut]:
    cuts: list[Cut] = []
    for at, step in enumerate(outcome.recipe.sequence):
        path: YamlPath = ("sequence", at, "paths")
        fixed = not step.enabled or f"sequence[{at}]" in drying or len(step.paths) < 2
        if fixed or is_kept(path, allowed.kept):
            continue
        for place, name in enumerate(step.paths):
            rest = [*step.paths[:place], *step.paths[place + 1 :]]
            what = f"{spell_path(path)}: - {name}"
            cuts.append(Cut(what, edits=((path, rest),), steps=(f"sequence[{at}]",), template=name))
    return cuts
