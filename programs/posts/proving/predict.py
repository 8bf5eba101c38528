"""Predicts how long a controller takes for a program's text, and where its jets begin and end."""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import accumulate
from math import dist, inf
from typing import TypeAlias

import numpy as np

from geometry.arrays import Scalars
from programs.motion.installation import Channel, Installation
from programs.motion.steps import Line, MotionProgram, Pause, Reach, Switch
from programs.pose import Position, compose, inverse
from programs.posts.proving.agreement import Agreement, Firing, Match
from programs.posts.rebuilt import Axes, ReadLine, ReadPause, ReadReach, ReadStep, ReadSwitch, Rebuilt
from programs.posts.writing.angles import rotation_vector
from programs.posts.writing.axes import in_degrees_and_mm, units_of
from programs.posts.writing.joint_moves import machine_of
from programs.timing.controller import Controller
from programs.timing.drive import Drive, drive
from programs.timing.fitting import time_between
from programs.timing.forecast import Cause, Forecast, MoveTime
from programs.timing.ways import Machine, Way
from specs.source import NO_SOURCE

Shares: TypeAlias = tuple[tuple[float, float], ...]
_Geometry: TypeAlias = tuple[float, bool, Position, Position, Scalars, Scalars, Scalars, Scalars]
"""The first attributes of a way, which its speed does not change."""
_PARTS = 16
"""Of a line at most, within which the rates of the joints are looked at."""
_SHORTEST = 1e-6
_STANDS = 1e-6
"""Degrees or mm: a joint motion by less is none."""
_CORNER = 0.05
"""Change of direction, about 3 degrees, that is a corner."""
_HELD = 0.5
"""Loss of speed at the ends of a line from which on those slow it down, not its ramps."""


def predict(run: "TextRun") -> Forecast:
    """Predict the times of a program from its text; each loop is done once, an integrator's routine takes none."""
    run.build()
    errors = [(off_mm, abs(late_s), firing.event.made_by) for firing, off_mm, late_s in run.event_errors]
    event_mm, _, event_by = max(
        errors, key=lambda error: (round(error[0], 6), round(error[1], 9)), default=(0.0, 0.0, NO_SOURCE)
    )
    event_s = max((late_s for _, late_s, _ in errors), default=0.0)
    return Forecast(
        run.motion.duration_s,
        run.now,
        tuple(run.moves),
        event_mm,
        event_s,
        event_by,
    )


def driven_times(run: "TextRun") -> tuple[list[tuple[float, float]], list[tuple[float, bool]]]:
    """Give times of the program and when the controller is there, and when each jet begins and ends.

    No time decreases; the lags of valves are in those of the jets.
    """
    run.build()
    return _clock(run, run.motion.duration_s), list(_jets(run))


def run_of(
    rebuilt: Rebuilt,
    agreement: Agreement,
    motion: MotionProgram,
    installation: Installation,
    controller: Controller,
) -> "TextRun":
    """Begin to time a text, once for all that needs its times.

    Args:
        rebuilt: What the reader found.
        agreement: Of that with the motion, which has what the text does not: the joints along each line.
        motion: What was written: that of ``make_motion``, at the speeds that are commanded.
        installation: The cell; its joints' limits count.
        controller: The model.
    """
    matches, jets = {match.step: match for match in agreement.matches}, _jets_on(motion, installation)
    rests = dict(_jets_at_rest(motion, installation))
    machine = machine_of(installation, controller)
    return TextRun(rebuilt, agreement, motion, matches, installation, machine, jets, rests)


def _jets_on(motion: MotionProgram, installation: Installation) -> dict[int, Shares]:
    """Find between which shares of each line a jet is requested, by the line's identity (``id``)."""
    channels = {valve.channel for valve in installation.valves.values()}
    opened: set[Channel] = set()
    found: dict[int, Shares] = {}
    for step in motion.steps:
        if isinstance(step, Switch) and step.channel in channels:
            (opened.add if step.value > 0.5 else opened.discard)(step.channel)
        elif isinstance(step, Line):
            shares: list[tuple[float, float]] = []
            begin = 0.0
            for event in sorted(step.events, key=lambda each: each.share):
                shares += [(begin, event.share)] if opened and event.share > begin else []
                begin = event.share
                (opened.add if event.value > 0.5 else opened.discard)(event.channel)
            found[id(step)] = (*shares, *([(begin, 1.0)] if opened and begin < 1.0 else []))
    return found


def _jets_at_rest(motion: MotionProgram, installation: Installation) -> Iterator[tuple[int, float]]:
    """Find how long a jet that has its signal where the robot has stopped goes on, by the identity of the line before.

    The robot waits for the valve where it is planned to have shut as the robot comes there.
    """
    lags = {valve.channel: valve.close_lag_s for valve in installation.valves.values()}
    for line, switch, pause in zip(motion.steps, motion.steps[1:], motion.steps[2:], strict=False):
        if isinstance(line, Line) and isinstance(switch, Switch) and isinstance(pause, Pause) and switch.value <= 0.5:
            yield id(line), min(lags.get(switch.channel, 0.0), pause.duration_s)


@dataclass
class TextRun:
    """A program while it is timed."""

    rebuilt: Rebuilt
    agreement: Agreement
    motion: MotionProgram
    matches: Mapping[int, Match]
    """Of the agreement, by the step that was read."""
    installation: Installation
    machine: Machine
    jets: Mapping[int, Shares]
    """Between which shares a jet is on, of each planned line by its identity (``id``)."""
    rests: Mapping[int, float]
    """Seconds for which a jet goes on at the end of some of them, where the robot has stopped."""
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
    units: tuple[float, ...] = field(init=False)
    """From ``units_of``."""

    def __post_init__(self) -> None:
        """Keep what all lines have in common."""
        self.units = tuple(units_of(self.installation).tolist())

    def build(self) -> None:
        """Time all steps, once."""
        if self.begins:
            return
        done = 0
        for chain in [*self.chains, []]:
            end = chain[0][0] if chain else len(self.rebuilt.steps)
            for at, step in enumerate(self.rebuilt.steps[done:end], done):
                if not isinstance(step, ReadSwitch | ReadLine):
                    self.stand(at, step)
            if chain:
                self.finish(chain)
                done = chain[-1][0] + 1
        self.begins += [self.now] * (len(self.rebuilt.steps) - len(self.begins))

    @cached_property
    def chains(self) -> list[list[tuple[int, Way]]]:
        """The lines that follow each other, with the steps at which they were read."""
        chains: list[list[tuple[int, Way]]] = []
        chain: list[tuple[int, Way]] = []
        for at, step in enumerate((*self.rebuilt.steps, None)):
            if isinstance(step, ReadLine) and at in self.matches:
                chain.append((at, self.way(at, step)))
            elif chain and not isinstance(step, ReadSwitch | ReadLine):
                chains.append(chain)
                chain = []
        return chains

    @cached_property
    def event_errors(self) -> list[tuple[Firing, float, float]]:
        """What begins or ends a jet, how far from its place, mm, and how late, s; all steps are timed already."""
        return list(_event_errors(self))

    def finish(self, chain: list[tuple[int, Way]]) -> None:
        """Drive the lines that follow each other, and the outputs between them."""
        lanes = self.machine.lanes([way for _, way in chain])
        driven = drive([lane for lane, _ in lanes], self.machine.controller.look_ahead)
        for number, ((at, way), done, (_, cause)) in enumerate(zip(chain, driven, lanes, strict=True)):
            self.begins += [self.now] * (at - len(self.begins))
            self.open_valves(at)
            line = self.line_at(at)
            sprays = bool(self.opened) or any(
                signal.value > 0.5 and self.is_valve(signal.channel) for signal in line.signals
            )
            around = [chain[number + by][1].direction for by in (-1, 1) if 0 <= number + by < len(chain)]
            corner = any(dist(way.direction, each) > _CORNER for each in around)
            self.moves.append(self.move_time(at, way, done, cause, (sprays, corner)))
            for signal in line.signals:
                self.set_valve(signal.channel, signal.value)
            self.begins.append(self.now)
            self.drives[at] = done
            self.now += done.duration_s
        last = self.matches[chain[-1][0]]
        self.joints = self.counted(self.planned_line(last.step).samples.joints_at(last.end))

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
        line = self.planned_line(at)
        planned_s, nominal_s = self.planned_s(at, (0.0, 1.0)), way.whole_s or way.length / way.speed
        shares = self.jet_shares(at)
        jet = (
            sum(time_between(done, *each) for each in shares) + self.rest_s(at),
            sum(self.planned_s(at, each) for each in shares),
        )
        if cause == "speed" and done.duration_s > nominal_s:
            lost = 1.0 - _HELD
            slow = [speed < lost * done.peak for speed in (done.begin, done.end)]
            stops = way.stops or done.lane.leave == 0.0
            cause = "turn of the tool" if way.turns else "stops" if stops else "corners" if any(slow) else "ramps"
        return MoveTime(at, nominal_s, done.duration_s, planned_s, cause, *flags, line.made_by, *jet, line.time_s)

    def jet_shares(self, at: int) -> Shares:
        """Between which shares of the line that is read at a step a jet is on."""
        match = self.matches[at]
        inside = ((max(a, match.begin), min(b, match.end)) for a, b in self.jets.get(id(match.planned), ()))
        return tuple((match.inside(a), match.inside(b)) for a, b in inside if b > a + _SHORTEST)

    def rest_s(self, at: int) -> float:
        """Seconds for which a jet goes on after the line that is read at a step."""
        match = self.matches[at]
        return self.rests.get(id(match.planned), 0.0) if match.end >= 1.0 - _SHORTEST else 0.0

    def planned_s(self, at: int, shares: tuple[float, float]) -> float:
        """Planned time between two shares of the line that is read at a step."""
        match, samples = self.matches[at], self.planned_line(at).samples
        begin, end = (samples.second_at(match.begin + each * (match.end - match.begin)) for each in shares)
        return end - begin

    def counted(self, joints: tuple[float, ...]) -> tuple[float, ...]:
        """Give joints in degrees and mm; none where they are not known."""
        return in_degrees_and_mm(joints, self.installation) if joints else ()

    def planned_line(self, at: int) -> Line:
        """Give the line of the plan that is read at a step."""
        line = self.matches[at].planned
        assert isinstance(line, Line)
        return line

    def line_at(self, at: int) -> ReadLine:
        """Give the line that is read at a step."""
        step = self.rebuilt.steps[at]
        assert isinstance(step, ReadLine)
        return step

    def way(self, at: int, read: ReadLine) -> Way:
        """Give a line as the controller sees it; of a line that was read before only its speed may be another."""
        match, line = self.matches[at], self.planned_line(at)
        turns, axes = read.turn_deg_s is not None, isinstance(read.target, Axes)
        key = ("way", self.units, match.begin, match.end, axes, turns, line.start, line.target)
        memo = line.samples.memo
        geometry: _Geometry | None = memo.get(key)
        if geometry is None:
            geometry = memo[key] = self.geometry(line, match, read)
        length, turns_on_the_spot, direction, turning, first, last, fastest, bend = geometry
        return Way(
            length,
            turns_on_the_spot,
            direction,
            turning,
            first,
            last,
            fastest,
            bend,
            speed=self.commanded(read, length, turns_on_the_spot),
            stops=bool(read.stops),
            zone=read.zone,
            turn_deg_s=inf if read.turn_deg_s is None else read.turn_deg_s,
            acceleration_mm_s2=read.acceleration_mm_s2,
            turn_acceleration_deg_s2=read.turn_acceleration_deg_s2,
            whole_s=read.duration_s if self.machine.controller.times_are_whole else None,
        )

    def geometry(self, line: Line, match: Match, read: ReadLine) -> _Geometry:
        """Give what of a way does not depend on its speed: length, whether it turns on the spot, directions, rates."""
        dof = len(self.installation.joints)
        start, target = line.pose_at(match.begin), line.pose_at(match.end)
        turning = np.degrees(rotation_vector(compose(target, inverse(start)).quaternion))
        length = (match.end - match.begin) * line.length_mm
        turns = line.turns_on_the_spot
        move = np.subtract(target.position, start.position)
        if isinstance(read.target, Axes):
            slides = self.machine.revolute == 0.0
            begin, end = (line.samples.joints_at(each) for each in (match.begin, match.end))
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
            shares, rows = _rows(line, match)
            rates = rows / units_of(self.installation) if dof and rows.shape[1] == dof else np.zeros((len(rows), dof))
            rates = np.diff(rates, axis=0) / np.diff(shares)[:, None]
        length = max(length, _SHORTEST)
        rates, turning = rates / length, turning / length
        bend = np.zeros(dof)
        if len(rates) > 2 and not isinstance(read.target, Axes):
            middle = 0.5 * (shares[2:] - shares[:-2]) * length
            bend = np.max(np.abs(np.diff(rates, axis=0)) / middle[:, None], axis=0)
        direction = (0.0, 0.0, 0.0) if turns else _vector(move / length)
        fastest = np.max(np.abs(rates), axis=0)
        return length, turns, direction, _vector(turning), rates[0], rates[-1], fastest, bend

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


def _rows(line: Line, match: Match) -> tuple[Scalars, Scalars]:
    """Shares of a part of a line, from 0 to 1, and the joints there, (n,) and (n, dof); some parts apart."""
    size, within = match.end - match.begin, line.samples.shares
    inside = (within[(within > match.begin) & (within < match.end)] - match.begin) / size
    inside = inside[(inside > 0.5 / _PARTS) & (inside < 1.0 - 0.5 / _PARTS)]
    _, kept = np.unique(np.floor(inside * _PARTS), return_index=True)
    shares = np.concatenate(([0.0], inside[kept], [1.0]))
    return shares, line.samples.joints_at_each(match.begin + size * shares)


def _event_errors(run: TextRun) -> Iterator[tuple[Firing, float, float]]:
    """Compare when each jet begins or ends with when the orifice is at its place: mm apart, and s late.

    The program is timed already (``build``).
    """
    lags = {
        (valve.channel.name, value): lag
        for valve in run.installation.valves.values()
        for value, lag in ((1.0, valve.open_lag_s), (0.0, valve.close_lag_s))
    }
    lines, clock, parts = run.motion.lines, _Clock.of(run), defaultdict[int, list[Match]](list)
    for match in run.matches.values():
        parts[id(match.planned)].append(match)
    times = np.array([line.time_s for line in lines])
    for firing in run.agreement.firings:
        event = firing.event
        lag_s = lags.get((event.channel.name, event.value), 0.0)
        jet_s = firing.line.time_s + event.signal_s + event.early_s + lag_s
        line = lines[max(int(np.searchsorted(times, jet_s, side="right")) - 1, 0)]
        share = line.samples.share_at(jet_s - line.time_s)
        passed = parts[id(line)]
        match = next((each for each in passed if share <= each.end), passed[-1] if passed else None)
        if match is None:
            continue
        due_s = run.begins[match.step] + run.drives[match.step].second_at(match.inside(share))
        leaves_s = run.begins[firing.step] + firing.signal.offset_s
        if firing.step in run.drives:
            leaves_s += run.drives[firing.step].second_at(firing.signal.share)
        begins_s = leaves_s + lag_s
        yield firing, abs(clock.way_at(begins_s) - clock.way_at(due_s)), begins_s - due_s


def _clock(run: TextRun, planned_s: float) -> list[tuple[float, float]]:
    """Give when the controller is where the program is at a time: at the samples of lines, and at the ends of pauses.

    What the program has no time for, such as a wait for a valve, is where it ends at once.
    """
    knots, now = [(0.0, 0.0)], 0.0
    for at, step in enumerate(run.rebuilt.steps):
        begin_s, match = run.begins[at], run.matches.get(at)
        if at in run.drives and match is not None and isinstance(match.planned, Line):
            line, done = match.planned, run.drives[at]
            inner = line.samples.shares[(line.samples.shares > match.begin) & (line.samples.shares < match.end)]
            shares = {match.begin + each * (match.end - match.begin) for each in done.borders} | set(inner.tolist())
            for share in sorted(shares):
                now = line.time_s + line.samples.second_at(share)
                knots.append((now, begin_s + done.second_at(match.inside(share))))
            knots.append((now, begin_s + done.duration_s))
        elif isinstance(step, ReadPause | ReadReach):
            planned = step.duration_s if isinstance(step, ReadPause) else 0.0
            if match is not None and isinstance(match.planned, Reach):
                planned = match.planned.duration_s
            after_s = run.begins[at + 1] if at + 1 < len(run.begins) else run.now
            knots += [(now, begin_s), (now + planned, after_s)]
            now += planned
    knots.append((max(planned_s, now), run.now))
    planned = np.minimum.accumulate([each for each, _ in reversed(knots)])[::-1].tolist()
    return list(zip(planned, np.maximum.accumulate([each for _, each in knots]).tolist(), strict=True))


def _jets(run: TextRun) -> Iterator[tuple[float, bool]]:
    """Give when each jet begins and ends, of the outputs of valves that the text switches."""
    moments: list[tuple[float, str, float]] = []
    for at, step in enumerate(run.rebuilt.steps):
        if isinstance(step, ReadSwitch):
            moments.append((run.begins[at], step.channel, step.value))
        elif isinstance(step, ReadLine) and at in run.drives:
            done = run.drives[at]
            moments += [
                (run.begins[at] + done.second_at(each.share) + each.offset_s, each.channel, each.value)
                for each in step.signals
            ]
    opened: set[str] = set()
    for seconds, label, value in sorted(moments, key=lambda each: each[0]):
        valve = next((each for each in run.installation.valves.values() if each.channel.is_called(label)), None)
        on = value > 0.5
        if valve is None or (valve.channel.name in opened) == on:
            continue
        (opened.add if on else opened.discard)(valve.channel.name)
        if len(opened) == on:  # the first that opens, and the last that shuts
            yield seconds + (valve.open_lag_s if on else valve.close_lag_s), on


@dataclass(frozen=True, slots=True)
class _Clock:
    """How far the orifice is at a time."""

    drives: tuple[Drive, ...]
    begins: tuple[float, ...]
    """When each begins."""
    ways: tuple[float, ...]
    """mm until then."""

    @classmethod
    def of(cls, run: TextRun) -> "_Clock":
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
