"""Compares what a program's text does with the motion it was made from."""

import math
import re
from dataclasses import dataclass, field
from itertools import zip_longest
from math import degrees
from typing import TypeAlias

import numpy as np

from programs.motion.installation import Channel, Installation
from programs.motion.lower import COARSE_MM, Capability, lower
from programs.motion.steps import (
    LEAST_S,
    RESOLUTION_MM,
    Call,
    EndRepeat,
    Event,
    Line,
    Moment,
    MotionProgram,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose, angle, between, distance
from programs.posts.reading.joint_moves import compare_joint_moves
from programs.posts.reading.production import compare_frame, same_joints
from programs.posts.reading.terms import compare_terms
from programs.posts.rebuilt import (
    Axes,
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadSignal,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
    TextPlace,
)
from programs.posts.writing.axes import allowed_on, in_degrees_and_mm, place_on, units_of
from programs.posts.writing.wording import make_name
from specs.source import NO_SOURCE, Source

_POSE_MM, _POSE_DEG = 0.01, 0.01
_EVENT_S = 0.002
_DIGIT = 2e-3
"""mm and degrees that written digits may shift a pose by."""
_JOINT = 0.001
"""mm and degrees, of a joint."""
_TICK_S = 2e-4
"""Twice the last digit of a time in a table."""
_PAUSE_S = 6e-4
"""Half of the last digit, or of the language's step where that is more."""
_TURN_DEG_S = 0.01
"""Of a turn on the spot, in blocks of the axes."""
_SPEED_SHARE = 0.01
"""Where the text states times instead of speeds."""
_SHARE = 1.1e-4
"""Of a line: nearer to each other it is not divided."""
_MOST_DIFFERENCES = 20

_Fired: TypeAlias = tuple[ReadSignal, float, float, int]
"""A signal, from where to where on the planned line the line that carries it goes, and the step that was read."""


@dataclass(frozen=True, slots=True)
class Match:
    """A motion that was read, and the part of a planned one that it is."""

    step: int
    """Of those that were read."""
    planned: Line | Reach
    begin: float
    end: float
    """Shares of the planned line at its ends; 0 and 1 of a joint motion."""


@dataclass(frozen=True, slots=True)
class Firing:
    """A signal that was read, and the planned one that it is."""

    step: int
    """Of those that were read: the line that carries it, or the output before one."""
    signal: ReadSignal
    line: Line
    event: Event


@dataclass(frozen=True, slots=True)
class Difference:
    """What a text does otherwise than planned."""

    message: str
    place: TextPlace | None
    """Statement that does it, where that is known."""
    made_by: Source
    """What was planned there."""

    def __str__(self) -> str:
        """Place in the text, place in the recipe, message."""
        place = f"{self.place.file}:{self.place.line}: " if self.place else ""
        return f"{place}{self.made_by or 'program'}: {self.message}"


@dataclass(frozen=True, slots=True)
class Agreement:
    """How closely a program that was read back does what was planned."""

    differences: tuple[Difference, ...]
    """Beyond the tolerances of ``measure``; some twenty at most."""
    place_mm: float = 0.0
    """Largest distance of the orifice from its planned place at the ends and in the middle of lines."""
    turn_deg: float = 0.0
    """Largest angle from the planned orientation there."""
    event_s: float = 0.0
    """Largest time between a signal and the planned one."""
    matches: tuple[Match, ...] = ()
    """Motions that were read, in order."""
    firings: tuple[Firing, ...] = ()
    """Signals on lines that were read, in order."""

    def describe(self) -> str:
        """State the worst values in words."""
        return (
            f"places within {self.place_mm:.4f} mm and {self.turn_deg:.4f} deg, "
            f"signals within {1e3 * self.event_s:.2f} ms of the plan"
        )


def compare(rebuilt: Rebuilt, motion: MotionProgram, installation: Installation) -> tuple[Difference, ...]:
    """List where a program that was read back differs from the motion it was made from, as ``measure`` finds it."""
    return measure(rebuilt, motion, installation).differences


def measure(rebuilt: Rebuilt, motion: MotionProgram, installation: Installation) -> Agreement:
    """Compare a program that was read back with the motion it was made from.

    Poses are to agree within 0.01 mm and 0.01 degrees at the end and in the middle of every line that was read, and
    signals to leave within 2 ms, or half of the language's step where that is more. Speeds are to be the planned ones
    as the language rounds them, and so are zones and the rates of turns. Where the text gives axes instead of poses
    they are to lie on the planned joint motion within 0.004 mm and 0.002 degrees, at those ends and middles.

    Args:
        rebuilt: What the reader found.
        motion: What ``make_motion`` gave, before it was lowered.
        installation: The cell.
    """
    comparison = _Comparison(installation, rebuilt)
    steps = [step for step in motion.steps if not isinstance(step, Note)]
    for step, after in zip_longest(steps, steps[1:]):
        comparison.match_step(step, after)
        if len(comparison.differences) >= _MOST_DIFFERENCES:
            return comparison.agreement()
    if comparison.next() is not None:
        surplus = rebuilt.steps[comparison.at :]
        comparison.differ(f"{len(surplus)} steps too many, the first {surplus[0]}", NO_SOURCE, comparison.at)
    lowered = lower(motion, rebuilt.capability).motion
    reaches = {match.step: match.planned for match in comparison.matches if isinstance(match.planned, Reach)}
    if not comparison.differences:
        moves = compare_joint_moves(rebuilt, reaches, motion, installation)
        for wrong in (*compare_terms(rebuilt, lowered), *moves):
            comparison.differ(*wrong)
    for message in compare_frame(rebuilt, lowered, installation):
        comparison.differences.append(Difference(message, None, NO_SOURCE))
    return comparison.agreement()


@dataclass(slots=True)
class _Comparison:
    """Two programs side by side."""

    installation: Installation
    rebuilt: Rebuilt
    at: int = 0
    """The next step that was read."""
    read_tool: ReadTool | None = None
    read_board: ReadBoard | None = None
    planned_tool: UseTool | None = None
    planned_board: UseBoard | None = None
    axes: Axes | None = None
    """Where the last motion that was read as axes ended."""
    tools: dict[int, str] = field(default_factory=dict[int, str])
    matched: tuple[UseTool | None, UseBoard | None, ReadTool | None, ReadBoard | None] | None = None
    """Tools and boards that were compared last."""
    line_read: Line | None = None
    line_s: float = 0.0
    """The line of which rows of a table were read last, and how much of its time has passed."""
    differences: list[Difference] = field(default_factory=list[Difference])
    place_mm: float = 0.0
    turn_deg: float = 0.0
    event_s: float = 0.0
    """The worst so far."""
    matches: list[Match] = field(default_factory=list[Match])
    firings: list[Firing] = field(default_factory=list[Firing])

    @property
    def capability(self) -> Capability:
        """What the language can time, and its steps."""
        return self.rebuilt.capability

    @property
    def read(self) -> tuple[ReadStep, ...]:
        """Steps that were read."""
        return self.rebuilt.steps

    def agreement(self) -> Agreement:
        """Give what was found."""
        return Agreement(
            tuple(self.differences),
            self.place_mm,
            self.turn_deg,
            self.event_s,
            tuple(self.matches),
            tuple(self.firings),
        )

    def differ(self, message: str, made_by: Source, step: int | None = None) -> None:
        """Add a difference at a step that was read; at the last one if that is not given."""
        at = max(self.at - 1, 0) if step is None else step
        self.differences.append(Difference(message, self.rebuilt.place(at), made_by))

    def is_same_pose(self, planned: Pose, read: Pose) -> bool:
        """Whether poses agree; keeps how far they are apart."""
        apart_mm, apart_deg = distance(planned, read), degrees(angle(planned, read))
        self.place_mm, self.turn_deg = max(self.place_mm, apart_mm), max(self.turn_deg, apart_deg)
        return apart_mm <= _POSE_MM and apart_deg <= _POSE_DEG

    def next(self) -> ReadStep | None:
        """Give the next step that was read, past tools and boards, which are used from then on."""
        while self.at < len(self.read) and isinstance(found := self.read[self.at], ReadTool | ReadBoard):
            if isinstance(found, ReadTool):
                self.read_tool = found
            else:
                self.read_board = found
            self.at += 1
        return self.read[self.at] if self.at < len(self.read) else None

    def match_step(self, step: Step, after: Step | None) -> None:
        """Match one step of the plan; a line after it may be what the next lines that were read belong to."""
        match step:
            case UseTool():
                self.planned_tool = step
            case UseBoard():
                self.planned_board = step
            case Line():
                self.match_line(step, isinstance(after, Line))
            case _:
                found = self.next()
                self.at += 1
                if isinstance(found, ReadReach) and isinstance(found.target, Axes):
                    self.axes = found.target
                if not self.is_same(step, found):
                    self.differ(f"planned {step}, read {found}", step.made_by)
                if isinstance(step, Reach):
                    self.matches.append(Match(self.at - 1, step, 0.0, 1.0))
                    self.match_frames(step.made_by)

    def is_same(self, step: Step, found: ReadStep | None) -> bool:
        """Whether a step other than a line was read as planned."""
        match step, found:
            case Reach(), ReadReach(target=Axes(values=axes)):
                return _same_joints(in_degrees_and_mm(step.joints, self.installation), axes)
            case Reach(), ReadReach(target=Pose() as target):
                reached = self.is_reached(step, found.joints) and self.is_way(step, found.way)
                return self.is_same_pose(step.target, target) and reached
            case Pause(), ReadPause():
                return abs(step.duration_s - found.duration_s) <= max(_PAUSE_S, 0.51 * self.capability.step_s)
            case Switch(), ReadSwitch():
                return self.is_output(step.channel, step.value, found.channel, found.value)
            case Call(), ReadCall():
                return _is_name_of(found.label, step.name)
            case Repeat(), ReadRepeat():
                return step.count == found.count and self.is_condition(step, found)
            case EndRepeat(), ReadEndRepeat():
                return True
            case _:
                return False

    def is_reached(self, step: Reach, counted: tuple[float, ...]) -> bool:
        """Whether joint values that were read are the planned ones when they are counted as the cell does."""
        if not step.joints or not self.rebuilt.has_joints:
            return not counted  # some languages have no joint values, but none has them where none are known
        return same_joints(step.joints, counted, self.installation)

    def is_way(self, step: Reach, way: tuple[ReadLine, ...]) -> bool:
        """Whether the small steps of a joint motion, where the text has them, are the planned ones."""
        if not way:
            return True
        seconds = np.cumsum([each.duration_s or 0.0 for each in way])
        planned = step.way or (Moment(0.0, step.target, step.joints),)
        return len(planned) == len(way) and all(
            abs(due.seconds - at) <= _TICK_S
            and isinstance(each.target, Pose)
            and self.is_same_pose(due.pose, each.target)
            and each.axes is not None
            and _same_joints(in_degrees_and_mm(due.joints, self.installation), each.axes.values)
            for due, each, at in zip(planned, way, seconds, strict=True)
        )

    def is_output(self, channel: Channel, planned: float, label: str, read: float) -> bool:
        """Whether an output is the planned one and gets the planned value; an analog one as volts at its terminal."""
        if label not in (channel.name, f"{channel.kind} {channel.number}"):
            return False
        if channel.kind != "analog":
            return abs(planned - read) <= 1e-6
        return abs(planned - self.capability.analog.value(channel, read)) <= self.capability.analog.tolerance(channel)

    def is_condition(self, step: Repeat, found: ReadRepeat) -> bool:
        """Whether a loop that reads an input ends at the same volts."""
        if step.sensor is None or not self.capability.reads_sensors:
            return found.least is None or found.reading is None
        if found.least is None or found.channel not in ("", step.sensor.name, str(step.sensor.number)):
            return False
        pairs = [(found.least, step.least)]
        if found.reading is not None:
            pairs += zip(found.reading, self.capability.analog.reading(step.sensor), strict=True)
        return all(abs(read - planned) <= 1e-6 * max(1.0, abs(planned)) for read, planned in pairs)

    def match_frames(self, made_by: Source) -> None:
        """Compare tool and board of a motion: the tool by where its orifice is, and by its name wherever it is used."""
        tool, board = self.planned_tool, self.planned_board
        if (in_use := (tool, board, self.read_tool, self.read_board)) == self.matched:
            return
        self.matched = in_use
        if tool is not None and self.read_tool is not None:
            label, place = self.read_tool.label, self.read_tool.T_flange_tcp
            known = self.tools.setdefault(tool.number, label) == label
            if not known or (place is None and len(set(self.tools.values())) < len(self.tools)):
                self.differ(f"tool {label} is used for another tool than before", made_by)
            planned = self.installation.tool(tool.number).T_flange_tcp
            if place is not None and not _same_pose(place, planned):
                self.differ(f"tool {label} is at {place}, planned {planned}", made_by)
        place = self.read_board.T_base_board if self.read_board is not None else None
        if place is not None and board is not None and not _same_pose(place, board.T_base_board):
            self.differ(f"the board is at {place}, planned {board.T_base_board}", made_by)

    def match_line(self, line: Line, another: bool) -> None:
        """Match one line with the lines that it was divided into; another one may come right after it."""
        done, begin, fired, stops = 0.0, line.start, list[_Fired](), None
        while done < 1.0 or self.ends_again(line, len(line.events) - len(fired)):
            if done == 1.0 and another and (line.blend_mm > 0.0 or stops is not False):
                break  # it is that other one
            found = self.next()
            if isinstance(found, ReadSwitch) and len(fired) < len(line.events):
                fired.append((ReadSignal(found.channel, found.value, 0.0, 0.0), done, done, self.at))
            elif isinstance(found, ReadLine):
                if done == 1.0 and found.target == begin and (not line.events or (stops and line.blend_mm == 0.0)):
                    break  # it goes nowhere, and no division for an output is due
                if isinstance(found.target, Axes) and found.target == self.axes and _goes_on(line):
                    self.differ(f"block {found} goes nowhere", line.made_by, self.at)
                target, end = self.locate(line, found.target, done)
                self.match_frames(line.made_by)
                self.match_part(line, found, (begin, done, target, end))
                self.matches.append(Match(self.at, line, done, end))
                fired += [(signal, done, end, self.at) for signal in found.signals]
                done, begin, stops = end, target, found.stops
            else:
                self.differ(f"planned a line, read {found}", line.made_by, self.at)
                return
            self.at += 1
        while isinstance(found := self.next(), ReadSwitch) and len(fired) < len(line.events):
            fired.append((ReadSignal(found.channel, found.value, 0.0, 0.0), 1.0, 1.0, self.at))
            self.at += 1
        if stops is not None and stops != (line.blend_mm == 0.0):
            self.differ(f"the line {'stops' if stops else 'does not stop'}", line.made_by)
        self.match_signals(line, fired)

    def ends_again(self, line: Line, due: int) -> bool:
        """Whether what is read next ends where a planned line does: it may be divided as near to its end as that.

        Args:
            line: What is planned.
            due: Outputs that have yet to change on it.
        """
        target = self.target_after(0) if due or not isinstance(self.next(), ReadSwitch) else None
        if isinstance(target, Axes):
            units = units_of(self.installation)
            allowed = allowed_on(units, self.installation)
            share, off = place_on(line.samples, units, target.values, 0.0, allowed)
            return share == 1.0 and off <= 1.0
        return target is not None and _same_pose(target, line.target)

    def target_after(self, steps: int) -> Pose | Axes | None:
        """End of a line that is read so many steps from here, or past an output from there."""
        after = (step for step in self.read[self.at + steps : self.at + steps + 2] if not isinstance(step, ReadSwitch))
        return found.target if isinstance(found := next(after, None), ReadLine) else None

    def locate(self, line: Line, target: Pose | Axes, done: float) -> tuple[Pose, float]:
        """Find how far along a planned line a target is; axes have to lie on the planned motion, half way too."""
        if isinstance(target, Pose):
            # A division may lie so near to the end that it counts as the end; the line after it then ends nearer.
            after = self.target_after(1)
            nearer = isinstance(after, Pose) and _apart(after, line.target) + _DIGIT < _apart(target, line.target)
            reached = _same_pose(target, line.target) and not nearer
            return target, 1.0 if reached else _share_of(line, target, done)
        units = units_of(self.installation)
        allowed = allowed_on(units, self.installation)
        share, off = place_on(line.samples, units, target.values, done, allowed)
        before = self.axes.values if self.axes is not None else target.values
        half_way = tuple(0.5 * (a + b) for a, b in zip(before, target.values, strict=True))
        middle, off_there = place_on(line.samples, units, half_way, done, allowed)
        on_line, off = (middle, share), max(off, off_there)
        most_mm, most_deg = (
            float(allowed[units == 1.0].max(initial=0.0)),
            float(allowed[units != 1.0].max(initial=0.0)),
        )
        if off > 1.0:
            message = f"the axes are {off:.1f} times {most_mm:g} mm or {most_deg:g} degrees off the planned motion"
            self.differ(f"{message} at {target}", line.made_by, self.at)
        turn_deg = off * most_deg
        if self.installation.tool_point is not None:  # C may be far off where the jet is steep
            turn_deg = max(
                self.jet_angle(line, at, row) for at, row in zip(on_line, (half_way, target.values), strict=True)
            )
        self.place_mm, self.turn_deg = max(self.place_mm, off * most_mm), max(self.turn_deg, turn_deg)
        self.axes = target
        return line.pose_at(share), share

    def jet_angle(self, line: Line, share: float, axes: tuple[float, ...]) -> float:
        """Give the angle of the jet from the planned one there, degrees, on a machine that takes tool points."""
        machine, units = self.installation.tool_point, units_of(self.installation)
        assert machine is not None
        planned = np.array([np.interp(share, line.samples.shares, column) for column in line.samples.joints.T])
        return degrees(machine.jet_angle(planned, np.array(axes) * units))

    def match_part(self, line: Line, found: ReadLine, way: tuple[Pose, float, Pose, float]) -> None:
        """Compare the end and the middle of a line that was read, and its speed."""
        begin, first, target, last = way
        for what, planned, actual in (
            ("ends", line.pose_at(last), target),
            ("is half way", line.pose_at(0.5 * (first + last)), between(begin, target, 0.5)),
        ):
            if not self.is_same_pose(planned, actual):
                self.differ(f"the line {what} at {actual}, planned {planned}", line.made_by, self.at)
        if found.axes is not None:
            if not self.is_moment(line, found, last):
                self.differ(f"the joints are at {found.axes} after {self.line_s:g} s", line.made_by, self.at)
            return
        # Of a way hardly longer than the rounding of its ends a language gives the speed of the turn, or none.
        has_speed = distance(begin, target) > RESOLUTION_MM + _DIGIT
        planned_mm_s, speed_mm_s = line.speed_mm_s if has_speed else 0.0, found.speed_mm_s
        if self.capability.least_part_s:
            planned_mm_s = self.even_speed(line, (first, last), planned_mm_s, speed_mm_s)
        digits = 0.3 if planned_mm_s == line.speed_mm_s else 1.0  # an even speed depends on the digits of the ends
        planned_mm_s = _rounded(planned_mm_s, self.capability.step_mm_s)
        allowed = (digits + 1e-3) * self.capability.step_mm_s + 1e-6 * planned_mm_s
        if found.duration_s is not None:
            speed_mm_s = (last - first) * line.length_mm / found.duration_s
            allowed = max(1.0, _SPEED_SHARE * planned_mm_s)
        if not planned_mm_s and line.turns_on_the_spot and isinstance(found.target, Axes):
            self.match_turn(line, found, last - first)
        if planned_mm_s and speed_mm_s is not None and abs(speed_mm_s - planned_mm_s) > allowed:
            self.differ(f"speed {speed_mm_s:g}, planned {planned_mm_s:g} mm/s", line.made_by, self.at)

    def even_speed(self, line: Line, ends: tuple[float, float], planned: float, found: float | None) -> float:
        """Give the speed of a part of a line that is commanded no faster than evenly in 21 ms, if it takes as long."""
        first, last = ends
        lasts_s = line.samples.second_at(last) - line.samples.second_at(first)
        even = min(planned, (last - first) * line.length_mm / LEAST_S)
        if found is not None and abs(lasts_s - LEAST_S) <= _EVENT_S:  # the digits of its ends decide
            return min(even, planned, key=lambda speed: abs(found - speed))
        return even if lasts_s > LEAST_S else planned

    def match_turn(self, line: Line, found: ReadLine, share: float) -> None:
        """Compare the rate of a turn on the spot that was read as a block of the axes."""
        rate, planned = found.turn_deg_s or found.speed_mm_s, degrees(line.turn_rad_s)
        if found.duration_s is not None:
            rate = share * degrees(line.angle_rad) / found.duration_s
        if planned and rate is not None and abs(rate - planned) > max(_TURN_DEG_S, _SPEED_SHARE * planned):
            self.differ(f"the tool turns at {rate:g} deg/s, planned {planned:g}", line.made_by, self.at)

    def is_moment(self, line: Line, found: ReadLine, last: float) -> bool:
        """Whether a row of a table is a moment of the planned motion: its time, the share done and its joints."""
        self.line_s = found.duration_s + (self.line_s if self.line_read is line else 0.0) if found.duration_s else 0.0
        self.line_read = line
        samples, moments = line.samples, self.line_s + np.array([-_TICK_S, 0.0, _TICK_S])
        shares = np.interp(moments, samples.seconds, samples.shares)
        slack = max(_POSE_MM / max(line.length_mm, _POSE_MM), _SHARE) if line.length_mm else 1.0
        rows = np.array([np.interp(moments, samples.seconds, column) for column in samples.joints.T])
        if found.axes is None or len(found.axes.values) != len(rows):
            return False
        axes = np.array(found.axes.values) * units_of(self.installation)
        if not shares[0] - slack <= last <= shares[2] + slack:
            return False
        allowed = _JOINT * units_of(self.installation)
        return bool(np.all((axes >= rows.min(axis=1) - allowed) & (axes <= rows.max(axis=1) + allowed)))

    def match_signals(self, line: Line, fired: list[_Fired]) -> None:
        """Compare what switches on a line, and when."""
        if len(fired) != len(line.events):
            self.differ(f"{len(fired)} signals on the line, planned {len(line.events)}", line.made_by)
            return
        for (signal, first, last, step), event in zip(fired, line.events, strict=True):
            self.firings.append(Firing(step, signal, line, event))
            if not self.is_output(event.channel, event.value, signal.channel, signal.value):
                self.differ(f"signal {signal}, planned {event}", event.made_by)
            place = first + signal.share * (last - first)
            late_s = line.samples.second_at(place) + signal.offset_s - event.signal_s
            self.event_s = max(self.event_s, abs(late_s))
            beyond = (self.capability.step_mm + _DIGIT) / max((last - first) * line.length_mm, RESOLUTION_MM)
            if not -beyond <= signal.share <= 1.0 + beyond:
                self.differ(f"signal {signal} leaves where the line is not", event.made_by)
            if not self.is_in_time(line, event, event.signal_s + late_s):
                late_mm = late_s * event.speed_mm_s
                self.differ(f"signal {1e3 * late_s:.1f} ms late, {late_mm:.2f} mm", event.made_by)

    def is_in_time(self, line: Line, event: Event, leaves_s: float) -> bool:
        """Whether a signal leaves within 2 ms of its moment, or half of the language's step where that is more.

        Where it leaves on the line it may be a digit off, in mm, or as near as whole percents are.
        """
        capability, signal_s, speed_mm_s = self.capability, event.signal_s, event.speed_mm_s
        late_s = abs(leaves_s - signal_s)
        if late_s <= max(_EVENT_S, 0.51 * capability.step_s if capability.timing == "time" else 0.0) + 1e-6:
            return True
        is_moved = late_s <= 0.5 * capability.least_part_s + _EVENT_S and late_s * speed_mm_s <= COARSE_MM
        if is_moved and capability.timing in ("boundary", "percent"):  # so that no short part is left
            return True
        is_on_line = -_EVENT_S <= leaves_s <= line.duration_s + _EVENT_S
        off = abs(line.samples.share_at(leaves_s) - line.samples.share_at(signal_s))
        nearest = 0.005 * capability.step_percent if capability.timing == "percent" else 0.0
        return is_on_line and (off <= nearest + _SHARE or off * line.length_mm <= capability.step_mm + _DIGIT)


def _rounded(speed_mm_s: float, step_mm_s: float) -> float:
    """Give a speed as languages round it: down, unless it is nearly the next step, and to one step at least."""
    return max(math.floor(speed_mm_s / step_mm_s + 0.3), 1) * step_mm_s if speed_mm_s else 0.0


def _goes_on(line: Line) -> bool:
    return line.length_mm + degrees(line.angle_rad) > _POSE_MM


def _is_name_of(label: str, name: str) -> bool:
    """Whether a label is what a language makes of a name: its letters and digits, cut or numbered."""
    plain_label, plain_name = (re.sub(r"[^a-z0-9]", "", make_name(each, 200).lower()) for each in (label, name))
    stem = re.sub(r"\d+$", "", plain_label)
    return bool(stem) and (plain_name.startswith(plain_label) or plain_name.startswith(stem))


def _share_of(line: Line, target: Pose, done: float) -> float:
    """How far along a planned line a pose is; 1 unless the line was divided there."""
    way, turn = line.length_mm, line.angle_rad
    goes = way > degrees(turn)  # whichever is the finer measure of how much is done
    share = distance(line.start, target) / way if goes else angle(line.start, target) / max(turn, 1e-9)
    return share if done < share < 1.0 else 1.0


def _apart(one: Pose, other: Pose) -> float:
    """Millimetres or degrees between two poses, whichever are more."""
    return max(distance(one, other), degrees(angle(one, other)))


def _same_joints(planned: tuple[float, ...], read: tuple[float, ...]) -> bool:
    """Whether joint values in degrees and mm are the same to the digits that languages write."""
    return len(planned) == len(read) and all(abs(a - b) <= _JOINT for a, b in zip(planned, read, strict=True))


def _same_pose(one: Pose, other: Pose) -> bool:
    return distance(one, other) <= _POSE_MM and degrees(angle(one, other)) <= _POSE_DEG
