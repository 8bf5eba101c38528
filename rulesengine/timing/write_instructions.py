"""The program told in order: moves, waits and commands with their times, the jet's moments, and the sums."""

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
"""Commands that do not ask for the jet to be off."""

Place = tuple[float, float, float]
Turn = tuple[float, float, float, float]


@dataclass(frozen=True, slots=True)
class _Track:
    """The poses of a program, the first one its start, and which of them each item of the plan brings."""

    ticks: Sequence[int]
    places: Sequence[Place]
    turns: Sequence[Turn]
    speeds: Sequence[float]
    """Mean speed of the segment that ends at each pose, mm/s, as the file prints it."""
    travel_mm: float
    first: Sequence[int]
    """Item i brings the poses first[i] up to first[i + 1]."""


@dataclass(slots=True)
class _Narrator:
    """What has been told so far, and the state of the nozzle at the end of it."""

    track: _Track
    told: list[Instruction] = field(default_factory=list[Instruction])
    now: int = 0
    pose: int = -1
    """Which pose of the track the nozzle has; -1 before the start is told."""
    pose_since: int = 0
    jet: Jet | None = None
    jet_by: Source = NO_SOURCE
    jet_since: int = 0
    sprayed: dict[Jet, int] = field(default_factory=dict[Jet, int])
    """Ticks of each jet."""

    def move(self, item: SprayPass | Transfer, number: int) -> None:
        """Tell the moves of an item; one that does not move is not told at all."""
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
        self.told += [
            MoveTo((begin + tick) / _TICKS_PER_S, place, turn, speed, made_by)
            for tick, place, turn, speed in zip(
                track.ticks[poses], track.places[poses], track.turns[poses], track.speeds[poses], strict=True
            )
        ]
        self.pose, self.now = last - 1, begin + track.ticks[last - 1]
        self.pose_since = self.now

    def hold_pose(self, made_by: Source) -> None:
        """Say where the nozzle is if that was not just said: at the start, and after it was held."""
        if self.pose < 0 or self.pose_since != self.now:
            self.pose, self.pose_since = max(self.pose, 0), self.now
            place, turn = self.track.places[self.pose], self.track.turns[self.pose]
            self.told.append(MoveTo(_seconds(self.now), place, turn, 0.0, made_by))

    def dwell(self, item: Dwell) -> None:
        """Hold the pose with the jet on."""
        ticks = int(np.ceil(item.duration_s / TICK_S - 1e-6))
        if self.pose < 0 and self.track.places:
            self.hold_pose(item.made_by)
        self.open(item.jet, item.made_by)
        if ticks > 0:
            self.told.append(Wait(_seconds(self.now), _seconds(ticks), item.made_by))
            self.now += ticks

    def command(self, item: PlanCommand) -> None:
        """Tell a command, with the jet off unless it may go on."""
        if item.keyword not in _JET_GOES_ON:
            self.close()
        self.told.append(Command(_seconds(self.now), item.keyword, item.arguments, item.made_by))

    def open(self, jet: Jet, made_by: Source) -> None:
        """Want this jet from now on."""
        if self.jet != jet:
            self.close()
            self.told.append(SetNozzle(_seconds(self.now), True, made_by))
            self.jet, self.jet_since = jet, self.now
            self.sprayed.setdefault(jet, 0)
        self.jet_by = made_by

    def close(self) -> None:
        """Want no jet any more."""
        if self.jet is not None:
            self.told.append(SetNozzle(_seconds(self.now), False, self.jet_by))
            self.sprayed[self.jet] += self.now - self.jet_since
            self.jet = None


def narrate(plan: Plan, samples: Samples) -> tuple[tuple[Instruction, ...], Totals]:
    """Tell the plan's items in order with the poses they bring."""
    narrator = _Narrator(_track(plan, samples))
    for number, item in enumerate(plan.items):
        match item:
            case SprayPass() | Transfer():
                narrator.move(item, number)
            case Dwell():
                narrator.dwell(item)
            case PlanCommand():
                narrator.command(item)
    narrator.close()
    return tuple(narrator.told), _totals(narrator)


def _track(plan: Plan, samples: Samples) -> _Track:
    numbers = np.arange(len(plan.items) + 1)
    steps = np.linalg.norm(np.diff(samples.position, axis=0), axis=1)
    speeds = np.round(steps / np.diff(samples.tick) * _TICKS_PER_S, 3)
    return _Track(
        ticks=samples.tick.tolist(),
        places=list(zip(*samples.position.T.tolist(), strict=True)),
        turns=list(zip(*samples.quaternion.T.tolist(), strict=True)),
        speeds=[0.0, *speeds.tolist()],
        travel_mm=float(steps.sum()),
        first=(1 + np.searchsorted(samples.item[1:], numbers)).tolist(),
    )


def _totals(narrator: _Narrator) -> Totals:
    """Sum up; litres go by function, in the order of first use."""
    litres: dict[str, float] = {}
    for jet, ticks in narrator.sprayed.items():
        if jet.liquid:
            litres[jet.function] = litres.get(jet.function, 0.0) + ticks * TICK_S / 60.0 * jet.flow_lpm
    return Totals(
        duration_s=_seconds(narrator.now),
        spray_s=_seconds(sum(narrator.sprayed.values())),
        travel_mm=round(narrator.track.travel_mm, 3),
        moves=sum(isinstance(instruction, MoveTo) for instruction in narrator.told),
        liquid_l=tuple((function, round(amount, 3)) for function, amount in litres.items()),
    )


def _seconds(ticks: int) -> float:
    """Ticks as the seconds that the file prints: the nearest number to a decimal with four places."""
    return ticks / _TICKS_PER_S
