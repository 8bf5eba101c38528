"""Compares a line with the plan: ends, middles and speeds of the parts that were read of it, and its signals."""

import math
from dataclasses import dataclass
from math import degrees
from typing import TypeAlias

import numpy as np

from geometry.arrays import Scalars
from geometry.compiled import compiled
from programs.motion.lower import COARSE_MM
from programs.motion.steps import LEAST_S, RESOLUTION_MM, Event, Line
from programs.pose import Pose, between, distance
from programs.posts.proving.agreement import POSE_MM, Firing, Record
from programs.posts.proving.steps import JOINT, TICK_S, is_same_output
from programs.posts.rebuilt import Axes, ReadLine, ReadSignal
from programs.timing.forecast import SHORT_S

DIGIT = 2e-3
"""mm and degrees that written digits may shift a pose by."""
_EVENT_S = 0.002
_TURN_DEG_S = 0.01
"""Of a turn on the spot, in blocks of the axes."""
_SPEED_SHARE = 0.01
"""Where the text states times instead of speeds."""
_SHARE = 1.1e-4
"""Of a line: nearer to each other it is not divided."""

Fired: TypeAlias = tuple[ReadSignal, float, float, int]
"""A signal, from where to where on the planned line the line that carries it goes, and the step that was read."""


@compiled
def _lie_between(axes: Scalars, rows: Scalars, allowed: Scalars) -> bool:
    """Whether axes (dof,) are between those of rows (n, dof), or as near as is allowed."""
    for axis in range(len(axes)):
        column = rows[:, axis]
        if axes[axis] < column.min() - allowed[axis] or axes[axis] > column.max() + allowed[axis]:
            return False
    return True


@dataclass(slots=True)
class LineRecord(Record):
    """A record that compares the parts which were read of planned lines, one after the other."""

    line_read: Line | None = None
    line_s: float = 0.0
    """The line of which rows of a table were read last, and how much of its time has passed."""

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
        has_speed = distance(begin, target) > RESOLUTION_MM + DIGIT
        planned_mm_s, speed_mm_s = line.speed_mm_s if has_speed else 0.0, found.speed_mm_s
        if self.capability.least_part_s:
            planned_mm_s = self.even_speed(line, (first, last), planned_mm_s, speed_mm_s)
        digits = 0.5 if planned_mm_s == line.speed_mm_s else 1.0  # an even speed depends on the digits of the ends
        planned_mm_s = self.stepped(planned_mm_s, (last - first) * line.length_mm, speed_mm_s)
        allowed = (digits + 1e-3) * self.capability.step_mm_s + 1e-6 * planned_mm_s
        if digits == 1.0 and has_speed:
            allowed += planned_mm_s * min(1.0, DIGIT / ((last - first) * line.length_mm))
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
        way_mm = (last - first) * line.length_mm
        even = min(planned, way_mm / LEAST_S)
        # Where the digits of its ends decide, it is either.
        unsure_s = min(_EVENT_S, 2.0 * DIGIT * lasts_s / way_mm) if way_mm > 0.0 else _EVENT_S
        if found is not None and abs(lasts_s - LEAST_S) <= unsure_s:
            return min(even, planned, key=lambda speed: abs(found - speed))
        return even if lasts_s > LEAST_S else planned

    def stepped(self, planned: float, way_mm: float, found: float | None) -> float:
        """Give a speed as languages round it: down, unless it is nearly the next step.

        Of a part that is short at the next step it is either: a line that is short as a whole is rounded down.
        """
        if not planned:
            return 0.0
        step = self.capability.step_mm_s
        down, near = (max(math.floor(planned / step + spare), 1) * step for spare in (1e-6, 0.5))
        if found is not None and way_mm <= SHORT_S * near + 2.0 * DIGIT:
            return min(down, near, key=lambda speed: abs(found - speed))
        return near

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
        samples, length_mm = line.samples, line.length_mm
        if found.axes is None or len(found.axes.values) != samples.joints.shape[1]:
            return False
        slack = max(POSE_MM / max(length_mm, POSE_MM), _SHARE) if length_mm else 1.0
        if not samples.share_at(self.line_s - TICK_S) - slack <= last <= samples.share_at(self.line_s + TICK_S) + slack:
            return False
        rows = samples.joints_when(self.line_s + np.array([-TICK_S, 0.0, TICK_S]))
        return _lie_between(np.array(found.axes.values) * self.units, rows, JOINT * self.units)

    def match_signals(self, line: Line, fired: list[Fired]) -> None:
        """Compare what switches on a line, and when."""
        if len(fired) != len(line.events):
            self.differ(f"{len(fired)} signals on the line, planned {len(line.events)}", line.made_by)
            return
        for (signal, first, last, step), event in zip(fired, line.events, strict=True):
            self.firings.append(Firing(step, signal, line, event))
            if not is_same_output(event.channel, event.value, (signal.channel, signal.value), self.capability):
                self.differ(f"signal {signal}, planned {event}", event.made_by)
            place = first + signal.share * (last - first)
            late_s = line.samples.second_at(place) + signal.offset_s - event.signal_s
            self.event_s = max(self.event_s, abs(late_s))
            beyond = (self.capability.step_mm + DIGIT) / max((last - first) * line.length_mm, RESOLUTION_MM)
            if not -beyond <= signal.share <= 1.0 + beyond:
                self.differ(f"signal {signal} leaves where the line is not", event.made_by)
            if not self.is_in_time(line, event, event.signal_s + late_s):
                late_mm = late_s * event.speed_mm_s
                self.differ(f"signal {1e3 * late_s:.1f} ms late, {late_mm:.2f} mm", event.made_by)

    def is_in_time(self, line: Line, event: Event, leaves_s: float) -> bool:
        """Whether a signal leaves within 2 ms of its moment, or half of the language's step where that is more.

        Where it leaves on the line it may be a digit off, in mm, or as near as whole percents are; where lines are
        divided for signals, as near as places agree: a shorter part has the same axes at both ends, and is not written.
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
        near_mm = POSE_MM if capability.timing == "boundary" else capability.step_mm + DIGIT
        return is_on_line and (off <= nearest + _SHARE or off * line.length_mm <= near_mm)
