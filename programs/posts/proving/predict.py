"""Predicts how long a controller takes for a program's text, and where its jets begin and end."""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from math import hypot, inf

import numpy as np

from geometry.arrays import Scalars
from programs.motion.installation import Installation
from programs.motion.steps import Line, MotionProgram, Reach
from programs.pose import Position, compose, inverse
from programs.posts.proving.agreement import Agreement, Firing, Match
from programs.posts.rebuilt import Axes, ReadLine, ReadPause, ReadReach, ReadStep, ReadSwitch, Rebuilt
from programs.posts.writing.angles import rotation_vector
from programs.posts.writing.axes import in_degrees_and_mm, units_of
from programs.posts.writing.joint_moves import machine_of
from programs.timing.controller import Controller
from programs.timing.drive import Drive, drive
from programs.timing.forecast import Cause, Forecast, MoveTime
from programs.timing.ways import Machine, Way
from specs.source import NO_SOURCE, Source

_PARTS = 16
"""Of a line at most, within which the rates of the joints are looked at."""
_SHORTEST = 1e-6
_STANDS = 1e-6
"""Degrees or mm: a joint motion by less is none."""
_CORNER = 0.05
"""Change of direction, about 3 degrees, that is a corner."""
_HELD = 0.5
"""Loss of speed at the ends of a line from which on those slow it down, not its ramps."""


def predict(
    rebuilt: Rebuilt,
    agreement: Agreement,
    motion: MotionProgram,
    installation: Installation,
    controller: Controller,
) -> Forecast:
    """Predict the times of a program from its text; each loop is done once, an integrator's routine takes none.

    Args:
        rebuilt: What the reader found.
        agreement: Of that with the motion, which has what the text does not: the joints along each line.
        motion: What ``make_motion`` gave.
        installation: The cell; its joints' limits count.
        controller: The model.
    """
    machine = machine_of(installation, controller)
    run = _Run(rebuilt, {match.step: match for match in agreement.matches}, installation, machine)
    run.build()
    errors = [(0.0, 0.0, NO_SOURCE), *_event_errors(run, agreement.firings, motion)]
    event_mm, _, event_by = max(errors, key=lambda error: (round(error[0], 6), round(error[1], 9)))
    event_s = max(late_s for _, late_s, _ in errors)
    return Forecast(motion.duration_s, run.now, tuple(run.moves), event_mm, event_s, event_by)


@dataclass(slots=True)
class _Run:
    """A program while it is timed."""

    rebuilt: Rebuilt
    matches: Mapping[int, Match]
    installation: Installation
    machine: Machine
    now: float = 0.0
    begins: list[float] = field(default_factory=list[float])
    """When each step that was read begins."""
    drives: dict[int, Drive] = field(default_factory=dict[int, Drive])
    """Of the lines, by step."""
    moves: list[MoveTime] = field(default_factory=list[MoveTime])
    joints: tuple[float, ...] = ()
    """Where the last motion ended, degrees and mm."""
    opened: set[str] = field(default_factory=set[str])
    """Valves that are open."""
    followed: int = 0
    """Steps whose outputs ``opened`` has."""

    def build(self) -> None:
        """Time all steps."""
        chain: list[tuple[int, Way]] = []
        for at, step in enumerate(self.rebuilt.steps):
            if isinstance(step, ReadLine) and at in self.matches:
                chain.append((at, self.way(at, step)))
            elif not isinstance(step, ReadSwitch | ReadLine):
                self.finish(chain)
                self.stand(at, step)
        self.finish(chain)
        self.begins += [self.now] * (len(self.rebuilt.steps) - len(self.begins))

    def finish(self, chain: list[tuple[int, Way]]) -> None:
        """Drive the lines that follow each other, and the outputs between them."""
        lanes = list(self.machine.lanes([way for _, way in chain]))
        driven = drive([lane for lane, _ in lanes], self.machine.controller.look_ahead)
        for number, ((at, way), done, (_, cause)) in enumerate(zip(chain, driven, lanes, strict=True)):
            self.begins += [self.now] * (at - len(self.begins))
            self.open_valves(at)
            line = self.line_at(at)
            sprays = bool(self.opened) or any(
                signal.value > 0.5 and self.is_valve(signal.channel) for signal in line.signals
            )
            around = [chain[number + by][1].direction for by in (-1, 1) if 0 <= number + by < len(chain)]
            corner = any(hypot(*np.subtract(way.direction, each)) > _CORNER for each in around)
            self.moves.append(self.move_time(at, way, done, cause, (sprays, corner)))
            for signal in line.signals:
                self.set_valve(signal.channel, signal.value)
            self.begins.append(self.now)
            self.drives[at] = done
            self.now += done.duration_s
        chain.clear()

    def open_valves(self, at: int) -> None:
        """Follow the outputs since the line before this one, also those before a wait."""
        for step in self.rebuilt.steps[self.followed : at]:
            if isinstance(step, ReadSwitch):
                self.set_valve(step.channel, step.value)
        self.followed = at

    def set_valve(self, channel: str, value: float) -> None:
        """Open or shut a valve."""
        if self.is_valve(channel):
            (self.opened.add if value > 0.5 else self.opened.discard)(channel)

    def is_valve(self, label: str) -> bool:
        """Whether an output opens a nozzle."""
        return any(valve.channel.is_called(label) for valve in self.installation.valves.values())

    def stand(self, at: int, step: ReadStep) -> None:
        """Time what is done between lines."""
        self.begins += [self.now] * (at + 1 - len(self.begins))
        match = self.matches.get(at)
        if isinstance(step, ReadPause):
            self.now += step.duration_s
        elif isinstance(step, ReadReach) and match is not None and isinstance(match.planned, Reach):
            self.reach(at, step, match.planned)

    def reach(self, at: int, step: ReadReach, planned: Reach) -> None:
        """Time a joint motion; the first one, from wherever the robot is, is before the program's time."""
        target = self.counted(planned.joints)
        if self.joints and target and len(target) == len(self.installation.joints):
            share = step.speed_share or self.machine.controller.joint_speed_share
            way = np.subtract(target, self.joints)
            moves = bool(np.any(np.abs(way) > _STANDS))
            seconds = self.machine.joint_time(way, share) if moves else 0.0
            nominal_s = float(np.max(np.abs(way) / (share * self.machine.speed), initial=0.0))
            if step.duration_s is not None:
                nominal_s = seconds = max(step.duration_s, self.machine.joint_time(way, 1.0)) if moves else 0.0
            if moves:
                seconds += self.machine.controller.settle_s
                flags = ("joint moves", False, False, planned.made_by)
                self.moves.append(MoveTime(at, nominal_s, seconds, planned.duration_s, *flags))
            self.now += seconds
        self.joints = target

    def move_time(self, at: int, way: Way, done: Drive, cause: Cause, flags: tuple[bool, bool]) -> MoveTime:
        """Compare a line as it is driven with the plan."""
        match = self.matches[at]
        line = match.planned
        planned_s, nominal_s = 0.0, way.whole_s or way.length / way.speed
        if isinstance(line, Line):
            planned_s = line.samples.second_at(match.end) - line.samples.second_at(match.begin)
            self.joints = self.counted(_joints_at(line, match.end))
        if cause == "speed" and done.duration_s > nominal_s:
            lost = 1.0 - _HELD
            slow = [speed < lost * done.peak for speed in (done.begin, done.end)]
            stops = way.stops or done.lane.leave == 0.0
            cause = "turn of the tool" if way.turns else "stops" if stops else "corners" if any(slow) else "ramps"
        return MoveTime(at, nominal_s, done.duration_s, planned_s, cause, *flags, line.made_by)

    def counted(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Give joints in degrees and mm; none where they are not known."""
        return in_degrees_and_mm(joints, self.installation) if joints else ()

    def line_at(self, at: int) -> ReadLine:
        """Give the line that is read at a step."""
        step = self.rebuilt.steps[at]
        assert isinstance(step, ReadLine)
        return step

    def way(self, at: int, read: ReadLine) -> Way:
        """Give a line as the controller sees it."""
        match, dof = self.matches[at], len(self.installation.joints)
        line = match.planned
        assert isinstance(line, Line)
        start, target = line.pose_at(match.begin), line.pose_at(match.end)
        turn = rotation_vector(compose(target, inverse(start)).quaternion)
        turning = np.degrees(turn)
        length = (match.end - match.begin) * line.length_mm
        turns = line.turns_on_the_spot
        move = np.subtract(target.position, start.position)
        if isinstance(read.target, Axes):
            slides = self.machine.revolute == 0.0
            begin, end = _joints_at(line, match.begin), _joints_at(line, match.end)
            steps = np.subtract(in_degrees_and_mm(end, self.installation), in_degrees_and_mm(begin, self.installation))
            move = np.zeros(3)
            move[: min(int(slides.sum()), 3)] = steps[slides][:3]
            length, turns = float(np.linalg.norm(move)), False
            if length <= _SHORTEST or read.turn_deg_s is not None:
                steps = np.where(slides, 0.0, steps)
                length, turns = float(np.linalg.norm(steps)), True
            rates = np.array([steps, steps])
            shares = np.array([0.0, 1.0])
        else:
            if turns:
                length = float(np.linalg.norm(turning))
            shares, rows = _rows(line, match, dof)
            rates = rows / units_of(self.installation) if dof and rows.shape[1] == dof else np.zeros((len(rows), dof))
            rates = np.diff(rates, axis=0) / np.diff(shares)[:, None]
        length = max(length, _SHORTEST)
        rates, turning = rates / length, turning / length
        bend = np.zeros(dof)
        if len(rates) > 2 and not isinstance(read.target, Axes):
            middle = 0.5 * (shares[2:] - shares[:-2]) * length
            bend = np.max(np.abs(np.diff(rates, axis=0)) / middle[:, None], axis=0)
        none = (0.0, 0.0, 0.0)
        return Way(
            length,
            turns,
            none if turns else _vector(move / length),
            _vector(turning),
            rates[0],
            rates[-1],
            np.max(np.abs(rates), axis=0),
            bend,
            self.commanded(read, length, turns),
            bool(read.stops),
            read.zone,
            inf if read.turn_deg_s is None else read.turn_deg_s,
            read.acceleration_mm_s2,
            read.turn_acceleration_deg_s2,
            read.duration_s if self.machine.controller.times_are_whole else None,
        )

    def commanded(self, read: ReadLine, length: float, turns: bool) -> float:
        """Speed of a line in its own unit, as its text states it."""
        if read.duration_s is not None:
            return length / read.duration_s
        if turns:
            return read.turn_deg_s or self.machine.controller.turn_speed_deg_s
        return read.speed_mm_s or inf


def _vector(values: Scalars) -> Position:
    x, y, z = values.tolist()
    return (x, y, z)


def _joints_at(line: Line, share: float) -> tuple[float, ...]:
    """Joints where this share of a line is done; empty if not known."""
    return tuple(float(np.interp(share, line.samples.shares, column)) for column in line.samples.joints.T)


def _rows(line: Line, match: Match, dof: int) -> tuple[Scalars, Scalars]:
    """Shares of a part of a line, from 0 to 1, and the joints there, (n,) and (n, dof); some parts apart."""
    size = match.end - match.begin
    inside = (line.samples.shares - match.begin) / size
    inside = inside[(inside > 0.5 / _PARTS) & (inside < 1.0 - 0.5 / _PARTS)]
    _, kept = np.unique(np.floor(inside * _PARTS), return_index=True)
    shares = np.concatenate(([0.0], inside[kept], [1.0]))
    columns = [np.interp(match.begin + size * shares, line.samples.shares, each) for each in line.samples.joints.T]
    return shares, np.array(columns).T.reshape(len(shares), -1)


def _event_errors(run: _Run, firings: Sequence[Firing], motion: MotionProgram) -> Iterator[tuple[float, float, Source]]:
    """Compare when each jet begins or ends with when the orifice is at its place: mm, s, and what requested it."""
    lags = {
        (valve.channel.name, value): lag
        for valve in run.installation.valves.values()
        for value, lag in ((1.0, valve.open_lag_s), (0.0, valve.close_lag_s))
    }
    lines, clock, parts = motion.lines, _Clock.of(run), defaultdict[int, list[Match]](list)
    for match in run.matches.values():
        parts[id(match.planned)].append(match)
    times = np.array([line.time_s for line in lines])
    for firing in firings:
        event = firing.event
        lag_s = lags.get((event.channel.name, event.value), 0.0)
        jet_s = firing.line.time_s + event.signal_s + lag_s
        line = lines[max(int(np.searchsorted(times, jet_s, side="right")) - 1, 0)]
        share = line.samples.share_at(jet_s - line.time_s)
        passed = parts[id(line)]
        match = next((each for each in passed if share <= each.end), passed[-1] if passed else None)
        if match is None:
            continue
        inside = (share - match.begin) / (match.end - match.begin)
        due_s = run.begins[match.step] + run.drives[match.step].second_at(inside)
        leaves_s = run.begins[firing.step] + firing.signal.offset_s
        if firing.step in run.drives:
            leaves_s += run.drives[firing.step].second_at(firing.signal.share)
        begins_s = leaves_s + lag_s
        yield abs(clock.way_at(begins_s) - clock.way_at(due_s)), abs(begins_s - due_s), event.made_by


@dataclass(frozen=True, slots=True)
class _Clock:
    """How far the orifice is at a time."""

    drives: tuple[Drive, ...]
    begins: tuple[float, ...]
    """When each begins."""
    ways: tuple[float, ...]
    """mm until then."""

    @classmethod
    def of(cls, run: _Run) -> "_Clock":
        """Add up the ways of a program."""
        drives = tuple(run.drives.values())
        ways = accumulate((_millimetres(each, each.lane.length) for each in drives), initial=0.0)
        return cls(drives, tuple(run.begins[step] for step in run.drives), tuple(ways)[:-1])

    def way_at(self, seconds: float) -> float:
        """Way of the orifice by then, mm."""
        at = max(bisect_right(self.begins, seconds) - 1, 0)
        return self.ways[at] + _millimetres(self.drives[at], self.drives[at].way_at(seconds - self.begins[at]))


def _millimetres(drive: Drive, way: float) -> float:
    """Way of the orifice; none in a turn on the spot."""
    return 0.0 if drive.lane.turns else way
