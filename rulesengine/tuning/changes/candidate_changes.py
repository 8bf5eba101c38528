"""Changes that may take away what is wanting, each with what it is believed to gain."""

from collections.abc import Iterator, Sequence
from math import ceil

from cleaning.verdicts.rules import DAMAGE_RISK, PROCESS_WINDOW, RESIDUE_LEFT
from rulesengine.tuning.changes.change import Move
from rulesengine.tuning.changes.expected_effect import helps, need, steps_for
from rulesengine.tuning.changes.new_paths import added_paths
from rulesengine.tuning.trial.lower_bound import key_of
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.request import Allowed
from rulesengine.tuning.trial.requirements import Want
from rulesengine.tuning.variables.design_variables import Kind, Knob, knobs_of
from specs.yaml.located import spell_path

_NEARER = 0.8
_HARDER = 1.25
_WARMER_C = 5.0
_LEAN_DEG = 10.0
_LEAST_DWELL_S = 0.3
_TAKES_TIME: frozenset[Kind] = frozenset({"speeds", "passes", "dwells", "wash_time"})


def moves_of(outcome: Outcome, wants: Sequence[Want], allowed: Allowed) -> tuple[Move, ...]:
    """List what may help against some wants, the most believed gain first; equals in the order of the recipe."""
    found = [move for knob in knobs_for(outcome) for move in _turned(knob, outcome, wants)]
    found += added_paths(outcome, wants)
    return tuple(
        sorted((move for move in found if allowed.may(move.kind, move.edits)), key=lambda move: -round(move.most, 6))
    )


def knobs_for(outcome: Outcome) -> tuple[Knob, ...]:
    """List the knobs of an outcome's recipe."""
    windows = {step.function: step.window_c for step in outcome.steps if step.window_c is not None}
    asked = frozenset(name for part, name in outcome.classes.items() if part not in outcome.left_out)
    return knobs_of(outcome.recipe, asked, windows)


def _turned(knob: Knob, outcome: Outcome, wants: Sequence[Want]) -> Iterator[Move]:
    helped = [(want, share) for want in wants if (share := helps(knob, want, outcome)) > 0]
    away = [each for each in helped if each[0].judgement.rule == DAMAGE_RISK]
    toward = [each for each in helped if each[0].judgement.rule != DAMAGE_RISK]
    if away:
        yield from _move(knob, _backed(knob), away)
    if toward:
        factor = max(need(want) for want, _ in toward)
        for value in _values(knob, factor, toward):
            yield from _move(knob, value, toward, _soak_s(outcome, toward))


def _soak_s(outcome: Outcome, helped: list[tuple[Want, float]]) -> float:
    """How much longer washing would have to be for residue to go by time alone."""
    longest = 0.0
    for want, _ in helped:
        if want.judgement.rule == RESIDUE_LEFT:
            longest = max(longest, (need(want) - 1.0) * outcome.seconds_in(steps_for(want, outcome)))
    return longest


def _move(knob: Knob, value: float, helped: list[tuple[Want, float]], soak_s: float = 0.0) -> Iterator[Move]:
    new = knob.moved(value)
    if new == knob.value:
        return
    by_time = knob.kind in _TAKES_TIME and soak_s > 0
    soak = sum(want.weight * share for want, share in helped if by_time and want.judgement.rule == RESIDUE_LEFT)
    gain = sum(want.weight * share for want, share in helped) - soak
    key = (knob.kind, f"{knob.template or spell_path(knob.path)} {knob.of_class}")
    aims = frozenset(key_of(want) for want, _ in helped)
    yield Move(knob.kind, knob.told(new), knob.edit(new), gain, key, knob.steps, soak, soak_s, aims)


def _backed(knob: Knob) -> float:
    return knob.value / _NEARER if knob.kind == "heights" else knob.value / _HARDER


def _values(knob: Knob, factor: float, helped: list[tuple[Want, float]]) -> list[float]:
    """Values to try: one, or for a tilt one on either side."""
    match knob.kind:
        case "speeds":
            return [knob.value / factor]
        case "passes" | "wash_time":
            return [float(max(knob.value + 1, ceil(knob.value * factor - 0.25)))]
        case "dwells":
            return [max(knob.value * factor, knob.value + _LEAST_DWELL_S)]
        case "tilts":
            return [knob.value + _LEAN_DEG, knob.value - _LEAN_DEG]
        case "heights":
            return [knob.value * _NEARER]
        case "pressure":
            return [knob.value * _HARDER]
        case "temperature":
            return [_warmth(knob, helped)]
        case "sides":
            return []


def _warmth(knob: Knob, helped: list[tuple[Want, float]]) -> float:
    """A limit that is broken, or a little more."""
    limits = [want.judgement.numbers[0].limit for want, _ in helped if want.judgement.rule == PROCESS_WINDOW]
    return next((limit for limit in limits if limit is not None), knob.value + _WARMER_C)
