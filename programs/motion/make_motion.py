"""Builds the controller's steps from a timed program."""

from dataclasses import dataclass, field
from math import degrees

import numpy as np
from numpy.typing import NDArray

from programs.errors import ProgramError
from programs.motion.installation import Assignment, Installation
from programs.motion.layout import Layout, Tracking, lay_out, on_time
from programs.motion.steps import (
    RESOLUTION_MM,
    Call,
    EndRepeat,
    Line,
    MotionProgram,
    Mount,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.motion.tracks import Track, find_vertices, lines_of, pose_of
from programs.motion.valves import SwitchRequest, open_valves
from programs.playback import Timeline, build_timeline
from programs.pose import Pose, angle, distance
from programs.program import TILT_BAND, Command, MoveTo, SetNozzle, TimedProgram, Wait
from programs.soundness import TICK_S
from specs.finding import Finding, FindingRule
from specs.finding_rules import NO_CHANNEL, NO_PLACEMENT, NO_SENSOR, NO_TOOL
from specs.source import NO_SOURCE, Source


def make_motion(
    program: TimedProgram,
    installation: Installation,
    tracking: Tracking | None = None,
    *,
    switches_at_rest: bool = False,
) -> MotionProgram:
    """Turn samples into the fewest straight lines, and requests for the jet into signals for its valve.

    Every sample lies within 0.004 mm and 0.004 degrees of the lines; beside what would take less than 30 ms, within
    0.06 mm and 0.2 degrees, and where a robot divides lines into ones of less than 20 ms within 0.5 degrees.

    Args:
        program: Any sound program.
        installation: The cell it is to run in.
        tracking: How the robot carries it out; ``None`` if that is not known.
        switches_at_rest: Whether a jet that begins or ends where the robot has stopped has its signal there.

    Raises:
        ProgramError: the program has no move, or the tracking does not belong to it.
    """
    moves = sum(isinstance(item, MoveTo) for item in program.instructions)
    tracking = tracking or on_time(program)
    rows, dof = tracking.joints.shape
    if rows != moves or dof not in (0, len(installation.joints)):
        raise ProgramError(
            f"the joint motion has {rows} x {dof} numbers, the program {moves} moves and the cell "
            f"{len(installation.joints)} joints; track this program in this cell."
        )
    builder = _Builder(installation, lay_out(program, tracking, build_timeline(program)))
    builder.build()
    steps, found = open_valves(builder.steps, builder.requests, installation, at_rest=switches_at_rest)
    findings = (*builder.findings, *found)
    return MotionProgram(program.origin, program.totals.duration_s, tuple(steps), findings, tracking.is_clear)


def find_corners(program: TimedProgram, timeline: Timeline) -> NDArray[np.bool_]:
    """Find the moves (m,) of a program at which its lines end: a robot keeps to the lines between them."""
    tracking = on_time(program)
    corner = np.zeros(len(tracking.clock), dtype=np.bool_)
    for item in lay_out(program, tracking, timeline).items:
        if isinstance(item, Track):
            node = item.node[find_vertices(item).kept]
            corner[node[node % 1.0 == 0.0].astype(np.int64)] = True
    return corner


@dataclass(slots=True)
class _Builder:
    """The steps so far, and the state at their end."""

    installation: Installation
    layout: Layout
    steps: list[Step] = field(default_factory=list[Step])
    requests: list[SwitchRequest] = field(default_factory=list[SwitchRequest])
    findings: list[Finding] = field(default_factory=list[Finding])
    begins: list[float] = field(default_factory=list[float])
    """Program time at which each step begins."""
    now: float = 0.0
    pose: Pose | None = None
    joints: tuple[float, ...] = ()
    tool: int = -1
    nozzle: str = ""
    changes_tools: bool = False
    """Whether another tool than the program's first may be on the flange when it begins."""
    spraying: bool = False
    reached: bool = False
    """Whether the robot is at ``pose`` with this tool and this board."""

    def build(self) -> None:
        """Turn all items into steps."""
        self.add(UseBoard("", self.installation.T_base_board, NO_SOURCE))
        commands = [item for item in self.layout.items if isinstance(item, Command) and item.keyword == "NOZZLE"]
        tools = self.installation.tools if self.installation.tool_routine else ()
        self.changes_tools = max(len({each.arguments[2] for each in commands}), len(tools)) > 1
        for item in self.layout.items:
            match item:
                case Track():
                    self.drive(item)
                case tuple():
                    self.go(item)
                case Wait():
                    self.now = item.time_s
                    self.reach(item.made_by)
                    self.add(Pause(item.duration_s, item.made_by))
                    self.now += item.duration_s
                case SetNozzle():
                    self.request(item)
                case Command():
                    self.now = item.time_s
                    self.execute(item)

    def add(self, *steps: Step) -> None:
        """Add steps that begin now."""
        self.steps += steps
        self.begins += [self.now] * len(steps)

    def warn(self, rule: FindingRule, message: str, made_by: Source) -> None:
        """Add a finding, once."""
        if all((other.rule, other.message) != (rule, message) for other in self.findings):
            self.findings.append(Finding(rule, message, made_by))

    def carry(self, made_by: Source) -> None:
        """Use a tool if none is used yet."""
        if self.tool < 0:
            self.warn(NO_TOOL, "the program moves before its first NOZZLE; name the nozzle first.", made_by)
            self.tool = min(self.installation.tools, default=0)
            self.add(UseTool(self.tool, self.nozzle, made_by))

    def reach(self, made_by: Source) -> None:
        """Come to the pose by a joint motion if the robot is not there."""
        self.carry(made_by)
        if not self.reached and self.pose is not None:
            self.add(Reach(self.pose, self.joints, made_by))
            self.reached = True

    def drive(self, track: Track) -> None:
        """Add the lines of a track."""
        makers, several = self.layout.makers, len(track.times) > 1
        self.now = float(track.times[0])
        stands = bool(self.joints) and self.joints == tuple(track.joints[0].tolist())
        before, self.pose, self.joints = self.pose, pose_of(track, 0), tuple(track.joints[0].tolist())
        # After a command a motion may begin elsewhere, also where the cell knows no other tool or place of the board.
        self.reached &= (
            before is not None
            and distance(before, self.pose) <= RESOLUTION_MM
            and degrees(angle(before, self.pose)) <= RESOLUTION_MM
        )
        if several or not stands:  # with another tool the arm may stand where its next motion begins
            self.reach(makers[track.maker[int(several)]])
        for line in lines_of(track, makers) if several else ():
            self.now = line.time_s
            self.add(line)
        self.now = float(track.times[-1])
        self.pose, self.joints = pose_of(track, -1), tuple(track.joints[-1].tolist())

    def go(self, legs: tuple[Reach, ...]) -> None:
        """Add a joint move."""
        self.carry(legs[0].made_by)
        for leg in legs:
            self.add(leg)
            self.pose, self.joints, self.reached = leg.target, leg.joints, True
            self.now += leg.duration_s

    def request(self, switch: SetNozzle) -> None:
        """Request a switching of the jet in the step that runs at its time."""
        if switch.spraying == self.spraying:
            return
        self.spraying = switch.spraying
        step = len(self.steps)
        while step > 0 and self.begins[step - 1] > switch.time_s - 0.5 * TICK_S and self.moves(step - 1):
            step -= 1
        seconds = 0.0
        if step > 0 and (duration_s := self.duration(step - 1)) is not None:
            step -= 1
            seconds = min(max(switch.time_s - self.begins[step], 0.0), duration_s)
        self.requests.append(SwitchRequest(step, seconds, switch.spraying, self.nozzle, switch.made_by))

    def moves(self, step: int) -> bool:
        """Whether a step takes time, a joint move too: what is switched before it began comes before it."""
        each = self.steps[step]
        return self.duration(step) is not None or (isinstance(each, Reach) and bool(each.way))

    def duration(self, step: int) -> float | None:
        """Seconds that a step takes; ``None`` for what is done at rest."""
        each = self.steps[step]
        return each.duration_s if isinstance(each, Line | Pause) else None

    def execute(self, command: Command) -> None:
        """Add the steps of a command."""
        made_by, words, cell = command.made_by, command.arguments, self.installation
        match command.keyword:
            case "FUNCTION" | "SOLUTION" | "GRIP":
                outputs = {"FUNCTION": cell.functions, "SOLUTION": cell.solutions, "GRIP": cell.grips}
                self.add(Note(f"{command.keyword.lower()} {words[0]}", made_by))
                self.assign(outputs[command.keyword].get(words[0]), f"{command.keyword} {words[0]}", made_by)
            case "SET":
                self.set(words[0], words[1], made_by)
            case "NOZZLE":
                self.mount(words[0], int(words[2]), made_by)
            case "CALL":
                self.call(words[0], made_by)
            case "REPEAT":
                self.repeat(int(words[0]), words[2], float(words[4]), made_by)
            case _:
                self.add(EndRepeat(made_by))

    def assign(self, assignments: tuple[Assignment, ...] | None, what: str, made_by: Source) -> None:
        """Set the outputs that the cell gives to a word; without any it stays a comment."""
        if assignments is None:
            cell = self.installation.cell
            self.warn(NO_CHANNEL, f"{what} has no channel in cell {cell}; it is a comment in the program.", made_by)
            return
        self.add(*(Switch(each.channel, each.value, made_by, what) for each in assignments))

    def set(self, key: str, value: str, made_by: Source) -> None:
        """Set the output that carries a quantity."""
        self.add(Note(f"{key} = {value}", made_by))
        if key == TILT_BAND:  # what the robot may do, not what the cell does
            return
        setting = self.installation.settings.get(key)
        try:
            quantity = float(value)
        except ValueError:
            setting, quantity = None, 0.0
        if setting is None:
            self.assign(None, f"SET {key}", made_by)
            return
        given = round(setting.scale * quantity + setting.offset, 6)
        self.add(Switch(setting.channel, given, made_by, f"{key} = {quantity:g}"))

    def mount(self, nozzle: str, number: int, made_by: Source) -> None:
        """Use a nozzle, and its tool if it is another one; a jet that goes on is from then on that of the nozzle."""
        valves = [self.installation.valves.get(name) for name in (self.nozzle, nozzle)]
        before, after = (valve.channel if valve is not None else None for valve in valves)
        passes = self.spraying and (before != after or number != self.tool)
        if passes:
            self.requests.append(SwitchRequest(len(self.steps), 0.0, False, self.nozzle, made_by))
        self.nozzle = nozzle
        self.add(Note(f"nozzle {nozzle}, tool {number}", made_by))
        if number != self.tool:
            if number not in self.installation.tools:
                self.warn(NO_TOOL, f"cell {self.installation.cell} has no tool {number}.", made_by)
            if self.changes_tools:
                self.add(Mount(number, nozzle, made_by))
            self.tool, self.reached = number, False
            self.add(UseTool(number, nozzle, made_by))
        if passes:
            self.requests.append(SwitchRequest(len(self.steps), 0.0, True, nozzle, made_by))

    def call(self, name: str, made_by: Source) -> None:
        """Run a routine of the cell, and find the board where it puts it."""
        self.add(Call(name, made_by))
        place = self.installation.placements.get(name)
        if place is not None:
            self.reached = False
            self.add(UseBoard(name, place, made_by))
        elif name.startswith("flip"):
            message = f"the cell has no place of the board after CALL {name}; state it in its placements."
            self.warn(NO_PLACEMENT, message, made_by)

    def repeat(self, count: int, key: str, least: float, made_by: Source) -> None:
        """Begin a loop."""
        sensor = self.installation.sensors.get(key)
        if sensor is None:
            message = f"{key} has no input in cell {self.installation.cell}; the loop is done {count} times."
            self.warn(NO_SENSOR, message, made_by)
        self.add(Repeat(count, key, least, sensor, made_by))
