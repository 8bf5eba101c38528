"""Instructions of a program in order: moves, waits and commands with their times, nozzle switching, and totals."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from programs.plan import Command as PlanCommand
from programs.plan import Dwell, Jet, Plan, SprayPass, Transfer
from programs.program import Command, Instruction, MoveTo, SetNozzle, Totals, Wait
from rulesengine.timing.sampling import TICK_S, Samples
from specs.source import NO_SOURCE, Source

_TICKS_PER_S = round(1.0 / TICK_S)
_JET_GOES_ON = frozenset({"SET"})
"""Commands during which the jet may stay on."""

Place = tuple[float, float, float]
Turn = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class _Track:
    """Poses of a program, the first one its start, and those that belong to each item of the plan."""

    ticks: Sequence[int]
    places: Sequence[Place]
    turns: Sequence[Turn]
    speeds: Sequence[float]
    """Mean speed of the segment that ends at each pose, mm/s, as the file prints it."""
    first: Sequence[int]
    """Item i has the poses first[i] up to first[i + 1]."""


@dataclass(slots=True)
class _Writer:
    """Instructions so far, and the state of the nozzle at the end of them."""

    track: _Track
    written: list[Instruction] = field(default_factory=list[Instruction])
    poses: list[int] = field(default_factory=list[int])
    """Of each move that is written."""
    now: int = 0
    pose: int = -1
    """Index of the present pose; -1 before the start is written."""
    pose_since: int = 0
    jet: Jet | None = None
    jet_by: Source = NO_SOURCE
    jet_since: int = 0
    sprayed: dict[Jet, int] = field(default_factory=dict[Jet, int])
    """Ticks of each jet."""

    def move(self, item: SprayPass | Transfer, number: int) -> None:
        """Write the moves of an item, if it moves."""
        first, last = self.track.first[number], self.track.first[number + 1]
        if first == last:
            return
        if isinstance(item, SprayPass):
            self.hold_pose(item.made_by)
            self.open(item.jet, item.made_by)
        else:
            self.close()
            self.hold_pose(item.made_by)
        track, begin, made_by = self.track, self.now - self.track.ticks[first - 1], item.made_by
        poses = slice(first, last)
        self.written += [
            MoveTo((begin + tick) / _TICKS_PER_S, place, turn, speed, made_by)
            for tick, place, turn, speed in zip(
                track.ticks[poses], track.places[poses], track.turns[poses], track.speeds[poses], strict=True
            )
        ]
        self.poses += range(first, last)
        self.pose, self.now = last - 1, begin + track.ticks[last - 1]
        self.pose_since = self.now

    def hold_pose(self, made_by: Source) -> None:
        """Write the present pose unless it was just written: at the start, and after a pause."""
        if self.pose < 0 or self.pose_since != self.now:
            self.pose, self.pose_since = max(self.pose, 0), self.now
            place, turn = self.track.places[self.pose], self.track.turns[self.pose]
            self.written.append(MoveTo(_seconds(self.now), place, turn, 0.0, made_by))
            self.poses.append(self.pose)

    def dwell(self, item: Dwell) -> None:
        """Hold the pose with the jet on."""
        ticks = dwell_ticks(item)
        if self.pose < 0 and self.track.places:
            self.hold_pose(item.made_by)
        self.open(item.jet, item.made_by)
        if ticks > 0:
            self.written.append(Wait(_seconds(self.now), _seconds(ticks), item.made_by))
            self.now += ticks

    def command(self, item: PlanCommand) -> None:
        """Write a command, with the jet off unless it may stay on."""
        if item.keyword not in _JET_GOES_ON:
            self.close()
        self.written.append(Command(_seconds(self.now), item.keyword, item.arguments, item.made_by))

    def open(self, jet: Jet, made_by: Source) -> None:
        """Switch this jet on."""
        if self.jet != jet:
            self.close()
            self.written.append(SetNozzle(_seconds(self.now), True, made_by))
            self.jet, self.jet_since = jet, self.now
            self.sprayed.setdefault(jet, 0)
        self.jet_by = made_by

    def close(self) -> None:
        """Switch the jet off."""
        if self.jet is not None:
            self.written.append(SetNozzle(_seconds(self.now), False, self.jet_by))
            self.sprayed[self.jet] += self.now - self.jet_since
            self.jet = None


@dataclass(frozen=True, slots=True, eq=False)
class Written:
    """Instructions of a program, and their totals."""

    instructions: tuple[Instruction, ...]
    totals: Totals
    poses: Sequence[int]
    """(moves,) sample of each ``MoveTo``."""


def write_instructions(plan: Plan, samples: Samples) -> Written:
    """Write the plan's items in order with their poses; litres go by function, in the order of first use."""
    numbers = np.arange(len(plan.items) + 1)
    steps = np.linalg.norm(np.diff(samples.position, axis=0), axis=1)
    speeds = np.round(steps / np.diff(samples.tick) * _TICKS_PER_S, 3)
    track = _Track(
        ticks=samples.tick.tolist(),
        places=list(zip(*samples.position.T.tolist(), strict=True)),
        turns=list(zip(*samples.quaternion.T.tolist(), strict=True)),
        speeds=[0.0, *speeds.tolist()],
        first=(1 + np.searchsorted(samples.item[1:], numbers)).tolist(),
    )
    writer = _Writer(track)
    for number, item in enumerate(plan.items):
        match item:
            case SprayPass() | Transfer():
                writer.move(item, number)
            case Dwell():
                writer.dwell(item)
            case PlanCommand():
                writer.command(item)
    writer.close()
    litres: dict[str, float] = {}
    for jet, ticks in writer.sprayed.items():
        if jet.liquid:
            litres[jet.function] = litres.get(jet.function, 0.0) + ticks * TICK_S / 60.0 * jet.flow_lpm
    totals = Totals(
        duration_s=_seconds(writer.now),
        spray_s=_seconds(sum(writer.sprayed.values())),
        travel_mm=round(float(steps.sum()), 3),
        moves=len(writer.poses),
        liquid_l=tuple((function, round(amount, 3)) for function, amount in litres.items()),
    )
    return Written(tuple(writer.written), totals, writer.poses)


def dwell_ticks(item: Dwell) -> int:
    """How long the file dwells, in ticks."""
    return int(np.ceil(item.duration_s / TICK_S - 1e-6))


def _seconds(ticks: int) -> float:
    """Ticks as the seconds that the file prints: the nearest number to a decimal with four places."""
    return ticks / _TICKS_PER_S
