"""Findings on a program's text: it takes longer than planned, or is longer than the controller takes."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

from programs.posts.dialect import ProgramFiles
from programs.posts.rebuilt import ReadLine, ReadReach, Rebuilt
from programs.timing.controller import Controller
from programs.timing.forecast import Cause, Forecast, StrokeTime
from specs.finding import Finding
from specs.finding_rules import DOSE_DIFFERS, SHORT_MOVES, SLOWER_ON_CONTROLLER, TOO_MANY_POINTS
from specs.source import NO_SOURCE

MOST_RATIO = 1.10
"""Predicted over planned time from which on a finding states why."""
LEAST_DOSE, MOST_DOSE = 0.97, 1.03
"""Time with the jet on over the planned one, of a stroke."""
_LEAST_OFF_S = 2e-3
"""Differences that are no matter: the digits of the text."""
_LEAST_SHARE = 0.1
"""Of the time lost, that a cause has to have to be named."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """What takes the time, and what helps."""

    what: str
    remedy: str


REMEDIES: dict[Cause, Remedy] = {
    "speed": Remedy("at the commanded speed", "the plan is faster there than the text: report this"),
    "ramps": Remedy("speeding up and slowing down", "state the controller's acceleration, or plan with less"),
    "stops": Remedy("stopping", "let the recipe stop less often"),
    "corners": Remedy("slowed by a corner at one end", "plan with less speed or acceleration"),
    "short lines": Remedy("too short for their speed", "plan with less speed, or wider corners"),
    "look-ahead": Remedy("too short for the lines that are planned ahead", "plan with less speed, or wider corners"),
    "turn of the tool": Remedy(
        "turning the tool", "plan with a lower rotation speed and acceleration, or state the controller's own"
    ),
    "joint limits": Remedy("at the limits of the joints", "plan with the cell (plan --cell), or lower the limits"),
    "joint moves": Remedy("joint motions at their stated speed", "raise that speed once the program has been run"),
}


def check_time(forecast: Forecast, controller: Controller) -> Iterator[Finding]:
    """Report where and why a controller takes more than 1.10 times the planned time."""
    if forecast.ratio <= MOST_RATIO:
        return
    losses = [loss for loss in forecast.losses() if loss[1] > 0.0]
    whole = sum(lost_s for _, lost_s, _, _ in losses)
    named = [loss for loss in losses if loss[1] >= _LEAST_SHARE * whole] or losses[:1]
    reasons = "; ".join(
        f"{lost_s:.1f} s on {count} moves {REMEDIES[cause].what} (worst: {worst.made_by or 'program'}, "
        f"{worst.predicted_s:.2f} s for {worst.planned_s:.2f} s)"
        for cause, lost_s, count, worst in named
    )
    message = (
        f"the controller is predicted to take {forecast.predicted_s:.1f} s for {forecast.planned_s:.1f} s planned, "
        f"{forecast.ratio:.2f} times: {reasons}."
    )
    if named:
        message += f" Remedy: {REMEDIES[named[0][0]].remedy}."
    yield Finding(SLOWER_ON_CONTROLLER, message, named[0][3].made_by if named else NO_SOURCE)


def strokes_off(forecast: Forecast) -> list[StrokeTime]:
    """Give the strokes on which the jet is on for another time than planned, in order."""
    return [
        each
        for each in forecast.strokes()
        if not LEAST_DOSE <= each.jet_s / each.jet_planned_s <= MOST_DOSE and abs(each.late_s) > _LEAST_OFF_S
    ]


def check_dose(forecast: Forecast) -> Iterator[Finding]:
    """Report strokes on which the jet is on for another time than planned, in both directions, and why."""
    strokes, off = forecast.strokes(), strokes_off(forecast)
    if not off:
        return
    longer = sum(each.late_s for each in off if each.late_s > 0.0)
    shorter = -sum(each.late_s for each in off if each.late_s < 0.0)
    jets_s, planned_s = sum(each.jet_s for each in strokes), sum(each.jet_planned_s for each in strokes)
    worst = max(off, key=lambda each: abs(each.late_s))
    cause = REMEDIES[worst.longest.cause]
    message = (
        f"{len(off)} of {len(strokes)} strokes do not take the planned time with the jet on: {longer:.2f} s more and "
        f"{shorter:.2f} s less, of {planned_s:.1f} s in all ({jets_s / planned_s:.3f} times); worst "
        f"{worst.longest.made_by or 'program'}, {worst.jet_s:.2f} s for {worst.jet_planned_s:.2f} s, {cause.what}. "
        f"Remedy: {cause.remedy}."
    )
    yield Finding(DOSE_DIFFERS, message, worst.longest.made_by)


def check_short(forecast: Forecast) -> Iterator[Finding]:
    """Report moves that take less than 20 ms while a jet is on, and the entries of the recipe that they come from."""
    if not forecast.short:
        return
    shortest = min(forecast.short, key=lambda move: move.nominal_s)
    elsewhere = sum(not move.at_corner for move in forecast.short)
    where = Counter(str(replace(move.made_by, components=())) or "program" for move in forecast.short)
    listed = ", ".join(f"{count} of {source}" for source, count in where.most_common())
    message = (
        f"{len(forecast.short)} of {len(forecast.moves)} moves take less than 20 ms with a jet on, "
        f"{f'{elsewhere} of them not at a corner' if elsewhere else 'all at corners'}: {listed}; the shortest "
        f"{1e3 * shortest.nominal_s:.1f} ms. Controllers drive them unevenly: plan wider corners or less speed there."
    )
    yield Finding(SHORT_MOVES, message, shortest.made_by, override="warning" if elsewhere else None)


def check_routines(stops: int, most_steps: int) -> Iterator[Finding]:
    """Report that the robot stops on its way because a routine of the language holds no more."""
    if stops:
        yield Finding(
            TOO_MANY_POINTS,
            f"the robot stops {stops} times on its way for the next routine, as one holds {most_steps} steps: the jet "
            "stays longer there. Let the recipe rest more often, or state most_positions under controller of the cell.",
        )


def check_size(files: ProgramFiles, rebuilt: Rebuilt, controller: Controller) -> Iterator[Finding]:
    """Report files that are longer than their controller is known to take, once for each of its limits."""
    positions = Counter(
        place.file
        for step, place in zip(rebuilt.steps, rebuilt.places, strict=True)
        if isinstance(step, ReadLine | ReadReach) and place is not None
    )
    for word, what, sizes in (
        ("most_positions", "positions", dict(positions)),
        ("most_lines", "lines", {name: text.count("\n") for name, text in files.items()}),
        ("most_bytes", "bytes", {name: len(text) for name, text in files.items()}),
    ):
        most = getattr(controller, word)
        over = {name: size for name, size in sizes.items() if size > most > 0}
        if over:
            name, size = max(over.items(), key=lambda each: each[1])
            others = f", and {len(over) - 1} files more" if len(over) > 1 else ""
            message = (
                f"{name} has {size} {what}{others}; the controller is known to take {most} in one "
                f"({controller.source(word)}). State {word} under controller of the cell if it takes more, or wash "
                "fewer parts in one program."
            )
            yield Finding(TOO_MANY_POINTS, message)
