"""What a controller's model predicts of a program's text."""

from collections import Counter
from dataclasses import dataclass
from typing import Literal, TypeAlias

from specs.source import NO_SOURCE, Source

Cause: TypeAlias = Literal[
    "speed", "ramps", "stops", "corners", "short lines", "look-ahead", "turn of the tool", "joint limits", "joint moves"
]
"""What a move's time depends on: ``speed`` is the commanded one."""
_NO_TIME_S = 1e-6
_STROKE_S = 0.25
"""A line with a jet on for so long is a stroke; shorter ones belong to that of their source beside them."""
SHORT_S = 0.02
"""A move that takes less at its commanded speed is one that controllers do not drive evenly."""


@dataclass(frozen=True, slots=True)
class MoveTime:
    """One move of a program's text over time."""

    step: int
    """Of the program that was read."""
    nominal_s: float
    """At its commanded speed from one end to the other; 0 if it has none."""
    predicted_s: float
    planned_s: float
    cause: Cause
    spraying: bool
    """Whether a jet is on somewhere on it."""
    at_corner: bool
    """Whether the direction changes at one of its ends."""
    made_by: Source
    jet_s: float = 0.0
    """Of the predicted time, with a jet on."""
    jet_planned_s: float = 0.0
    """Planned time with a jet on."""
    line_s: float = -1.0
    """When its line begins in the plan: moves of one line have the same."""


@dataclass(frozen=True, slots=True)
class StrokeTime:
    """Time of the jet on a stroke: a line, or short ones of one source that follow each other."""

    jet_s: float
    jet_planned_s: float
    longest: MoveTime
    """Whose time is farthest from the plan."""

    @property
    def late_s(self) -> float:
        """Seconds that the jet is on longer than planned; negative for shorter."""
        return self.jet_s - self.jet_planned_s


@dataclass(frozen=True, slots=True)
class Forecast:
    """Duration of a program, and accuracy of its jets, by the model of its controller; each loop once."""

    planned_s: float
    predicted_s: float
    moves: tuple[MoveTime, ...]
    event_mm: float = 0.0
    """Largest distance of a jet's begin or end from its place at the predicted speeds."""
    event_s: float = 0.0
    """Largest time by which one begins or ends early or late there, also of others."""
    event_by: Source = NO_SOURCE
    """What requested the jet with the largest distance."""

    @property
    def ratio(self) -> float:
        """Predicted over planned time; 1 for a program without duration."""
        return self.predicted_s / self.planned_s if self.planned_s > 0.0 else 1.0

    @property
    def short(self) -> tuple[MoveTime, ...]:
        """Moves that take less than 20 ms while spraying."""
        return tuple(move for move in self.moves if move.spraying and 0.0 < move.nominal_s < SHORT_S)

    def strokes(self) -> list[StrokeTime]:
        """Give the strokes with a jet on, in order."""
        groups: list[list[MoveTime]] = []
        for move in self.moves:
            if move.jet_planned_s <= _NO_TIME_S:
                groups.append([])
            elif (
                groups
                and groups[-1]
                and move.made_by == groups[-1][-1].made_by
                and (
                    move.line_s == groups[-1][-1].line_s
                    or min(move.jet_planned_s, sum(each.jet_planned_s for each in groups[-1])) < _STROKE_S
                )
            ):
                groups[-1].append(move)
            else:
                groups.append([move])
        return [
            StrokeTime(
                sum(move.jet_s for move in group),
                sum(move.jet_planned_s for move in group),
                max(group, key=lambda move: abs(move.jet_s - move.jet_planned_s)),
            )
            for group in groups
            if group
        ]

    def losses(self) -> list[tuple[Cause, float, int, MoveTime]]:
        """Give what takes longer than planned: cause, seconds, how many moves, and the worst of them; most first."""
        lost, count, worst = Counter[Cause](), Counter[Cause](), dict[Cause, MoveTime]()
        for move in self.moves:
            late_s = move.predicted_s - move.planned_s
            lost[move.cause] += late_s  # pyright: ignore[reportArgumentType]
            count[move.cause] += 1
            if move.cause not in worst or late_s > worst[move.cause].predicted_s - worst[move.cause].planned_s:
                worst[move.cause] = move
        return [(cause, lost[cause], count[cause], worst[cause]) for cause, _ in lost.most_common()]

    def describe(self) -> str:
        """State the predicted time and its ratio to the plan in words."""
        return f"{self.predicted_s:.1f} s by this controller's model, {self.ratio:.2f} x planned"
