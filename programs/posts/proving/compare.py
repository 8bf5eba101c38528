"""Compares what a program's text does with the motion it was made from."""

from dataclasses import dataclass, field
from itertools import zip_longest
from math import degrees

from programs.errors import ProgramError
from programs.motion.handshake import with_handshake
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.steps import Line, MotionProgram, Mount, Note, Reach, Step, UseBoard, UseTool
from programs.pose import Pose, angle, distance
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.proving.agreement import POSE_MM, Agreement, Difference, Match, is_same_pose
from programs.posts.proving.lines import DIGIT, Fired, LineRecord
from programs.posts.proving.production import compare_frame, compare_joint_moves
from programs.posts.proving.steps import TICK_S, is_same_step
from programs.posts.proving.terms import compare_arms, compare_terms
from programs.posts.rebuilt import (
    Axes,
    ReadBoard,
    ReadLine,
    ReadReach,
    ReadSignal,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.writing.axes import place_on
from specs.source import NO_SOURCE, Source

_MOST_DIFFERENCES = 20
_LOAD = 6e-3
"""kg and mm that a load may be off by its last digit."""


def compare(rebuilt: Rebuilt, motion: MotionProgram, installation: Installation) -> tuple[Difference, ...]:
    """List where a program that was read back differs from the motion it was made from, as ``measure`` finds it."""
    return measure(rebuilt, motion, installation).differences


def measure(
    rebuilt: Rebuilt, motion: MotionProgram, installation: Installation, lowered: MotionProgram | None = None
) -> Agreement:
    """Compare a program that was read back with the motion it was made from.

    Poses are to agree within 0.01 mm and 0.01 degrees at the end and in the middle of every line that was read, and
    signals to leave within 2 ms, or half of the language's step where that is more. Speeds are to be the planned ones
    as the language rounds them, and so are zones and the rates of turns. Where the text gives axes instead of poses
    they are to lie on the planned joint motion within 0.004 mm and 0.002 degrees, at those ends and middles.

    Args:
        rebuilt: What the reader found.
        motion: What ``make_motion`` gave, before it was lowered.
        installation: The cell.
        lowered: The same in the controller's terms, where it is at hand.
    """
    comparison = _Comparison(installation, rebuilt)
    if (other := _other_axes(rebuilt, len(installation.joints))) is not None:
        comparison.differ(f"{rebuilt.steps[other]} is not of the axes of {installation.robot}", NO_SOURCE, other)
        return comparison.agreement()
    silent = (Note, Mount) if rebuilt.capability.changes_tools else Note
    steps = [step for step in motion.steps if not isinstance(step, silent)]
    if rebuilt.frame is not None:
        steps = with_handshake(steps, installation)
    for step, after in zip_longest(steps, steps[1:]):
        comparison.match_step(step, after)
        if len(comparison.differences) >= _MOST_DIFFERENCES:
            return comparison.agreement()
    if comparison.next() is not None:
        surplus = rebuilt.steps[comparison.at :]
        comparison.differ(f"{len(surplus)} steps too many, the first {surplus[0]}", NO_SOURCE, comparison.at)
    lowered = lowered or lower(motion, rebuilt.capability).motion
    reaches = {match.step: match.planned for match in comparison.matches if isinstance(match.planned, Reach)}
    if not comparison.differences:
        moves = compare_joint_moves(rebuilt, reaches, motion, installation)
        arms = compare_arms(rebuilt, comparison.matches, installation)
        for wrong in (*compare_terms(rebuilt, lowered), *arms, *moves):
            comparison.differ(*wrong)
    for message in compare_frame(rebuilt, lowered, installation):
        comparison.differences.append(Difference(message, None, NO_SOURCE))
    return comparison.agreement()


@dataclass(slots=True)
class _Comparison(LineRecord):
    """Two programs side by side."""

    read_tool: ReadTool | None = None
    read_board: ReadBoard | None = None
    planned_tool: UseTool | None = None
    planned_board: UseBoard | None = None
    axes: Axes | None = None
    """Where the last motion that was read as axes ended."""
    tools: dict[int, str] = field(default_factory=dict[int, str])
    matched: tuple[UseTool | None, UseBoard | None, ReadTool | None, ReadBoard | None] | None = None
    """Tools and boards that were compared last."""

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
                if not is_same_step(step, found, self):
                    self.differ(f"planned {step}, read {found}", step.made_by)
                if isinstance(step, Reach):
                    self.matches.append(Match(self.at - 1, step, 0.0, 1.0))
                    self.match_frames(step.made_by)

    def match_frames(self, made_by: Source) -> None:
        """Compare tool and board of a motion: the tool by where its orifice is, and by its name wherever it is used."""
        tool, board = self.planned_tool, self.planned_board
        if (in_use := (tool, board, self.read_tool, self.read_board)) == self.matched:
            return
        self.matched = in_use
        if tool is not None and self.read_tool is None and self.capability.changes_tools:
            self.differ(f"tool {tool.number} is not mounted", made_by)
        if tool is not None and self.read_tool is not None:
            label, place = self.read_tool.label, self.read_tool.T_flange_tcp
            known = self.tools.setdefault(tool.number, label) == label
            if not known or (place is None and len(set(self.tools.values())) < len(self.tools)):
                self.differ(f"tool {label} is used for another tool than before", made_by)
            planned = self.installation.tool(tool.number).T_flange_tcp
            if place is not None and not is_same_pose(place, planned):
                self.differ(f"tool {label} is at {place}, planned {planned}", made_by)
        self.match_load(tool, made_by)
        place = self.read_board.T_base_board if self.read_board is not None else None
        if place is not None and board is not None and not is_same_pose(place, board.T_base_board):
            self.differ(f"the board is at {place}, planned {board.T_base_board}", made_by)

    def match_load(self, tool: UseTool | None, made_by: Source) -> None:
        """Compare what the text states that a tool weighs with what the cell does."""
        if tool is None or self.read_tool is None or not self.rebuilt.states_loads:
            return
        planned, load = self.installation.tool(tool.number), self.read_tool.load
        due = (planned.payload.mass_kg, *planned.centre_mm)
        is_same = all(abs(a - b) <= _LOAD for a, b in zip(load, due, strict=False))
        if not is_same or (planned.payload.is_stated and not load):
            self.differ(f"tool {self.read_tool.label} weighs {load}, planned {due}", made_by)

    def match_line(self, line: Line, another: bool) -> None:
        """Match one line with the lines that it was divided into; another one may come right after it."""
        done, begin, fired, stops = 0.0, line.start, list[Fired](), None
        while done < 1.0 or self.ends_again(line, len(line.events) - len(fired)):
            found = self.next()
            if done == 1.0 and not self.is_before_end(line):
                if another and (line.blend_mm > 0.0 or stops is not False):
                    break  # it is that other one
                if (
                    isinstance(found, ReadLine)
                    and found.target == begin
                    and (not line.events or (stops and not line.blend_mm))
                ):
                    break  # it goes nowhere, and no division for an output is due
            if isinstance(found, ReadSwitch) and len(fired) < len(line.events):
                fired.append((ReadSignal(found.channel, found.value, 0.0, 0.0), done, done, self.at))
            elif isinstance(found, ReadLine):
                if (
                    isinstance(found.target, Axes)
                    and found.target == self.axes
                    and line.length_mm + degrees(line.angle_rad) > POSE_MM
                ):
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

    def is_before_end(self, line: Line) -> bool:
        """Whether the next row of a table is of the same line by its time, though the line is at its end already."""
        found = self.line_after(0)
        lasts = found.duration_s if found is not None and found.axes is not None else None
        return lasts is not None and self.line_read is line and self.line_s + lasts < line.duration_s + TICK_S

    def ends_again(self, line: Line, due: int) -> bool:
        """Whether what is read next ends where a planned line does: it may be divided as near to its end as that.

        Args:
            line: What is planned.
            due: Outputs that have yet to change on it.
        """
        target = self.target_after(0) if due or not isinstance(self.next(), ReadSwitch) else None
        if isinstance(target, Axes):
            share, off = place_on(line.samples, self.units, target.values, 0.0, self.allowed)
            return share == 1.0 and off <= 1.0
        return target is not None and is_same_pose(target, line.target)

    def target_after(self, steps: int) -> Pose | Axes | None:
        """End of a line that is read so many steps from here, or past an output from there."""
        return found.target if (found := self.line_after(steps)) is not None else None

    def line_after(self, steps: int) -> ReadLine | None:
        """Line that is read so many steps from here, or past an output from there."""
        after = (step for step in self.read[self.at + steps : self.at + steps + 2] if not isinstance(step, ReadSwitch))
        return found if isinstance(found := next(after, None), ReadLine) else None

    def locate(self, line: Line, target: Pose | Axes, done: float) -> tuple[Pose, float]:
        """Find how far along a planned line a target is; axes have to lie on the planned motion, half way too."""
        if isinstance(target, Pose):
            # A division may lie so near to the end that it counts as the end; the line after it then ends nearer.
            reached = is_same_pose(target, line.target)
            after = self.target_after(1) if reached else None
            nearer = (
                isinstance(after, Pose)
                and is_same_pose(after, line.target)
                and _apart(after, line.target) + DIGIT < _apart(target, line.target)
            )
            return target, 1.0 if reached and not nearer else _share_of(line, target, done)
        before = self.axes.values if self.axes is not None else target.values
        key = ("axes", self.most, self.installation.tool_point, before, target.values, done)
        if (found := line.samples.memo.get(key)) is None:
            found = line.samples.memo[key] = self.place(line, before, target.values, done)
        share, off, turn_deg = found
        most_mm, most_deg = self.most
        if off > 1.0:
            message = f"the axes are {off:.1f} times {most_mm:g} mm or {most_deg:g} degrees off the planned motion"
            self.differ(f"{message} at {target}", line.made_by, self.at)
        self.place_mm, self.turn_deg = max(self.place_mm, off * most_mm), max(self.turn_deg, turn_deg)
        self.axes = target
        return line.pose_at(share), share

    def place(
        self, line: Line, before: tuple[float, ...], axes: tuple[float, ...], done: float
    ) -> tuple[float, float, float]:
        """Give the share of a line at axes, how far they are off it, half way to them too, and degrees of the jet.

        How far is in units of what is allowed.
        """
        half_way = tuple(0.5 * (a + b) for a, b in zip(before, axes, strict=True))
        share, off = place_on(line.samples, self.units, axes, done, self.allowed)
        middle, off_there = place_on(line.samples, self.units, half_way, done, self.allowed)
        off, machine = max(off, off_there), self.installation.tool_point
        if machine is None:
            return share, off, off * self.most[1]
        units, samples = self.units.tolist(), line.samples  # C may be far off where the jet is steep
        turns = (
            machine.jet_angle(samples.joints_at(at), [a * unit for a, unit in zip(row, units, strict=True)])
            for at, row in ((middle, half_way), (share, axes))
        )
        return share, off, degrees(max(turns))


def _other_axes(rebuilt: Rebuilt, count: int) -> int | None:
    """Give the first step that states another number of axes than there are."""
    targets = ((at, step.target) for at, step in enumerate(rebuilt.steps) if isinstance(step, ReadLine | ReadReach))
    return next((at for at, target in targets if isinstance(target, Axes) and len(target.values) != count), None)


def _share_of(line: Line, target: Pose, done: float) -> float:
    """How far along a planned line a pose is; 1 unless the line was divided there."""
    way, turn = line.length_mm, line.angle_rad
    goes = way > degrees(turn)  # whichever is the finer measure of how much is done
    share = distance(line.start, target) / way if goes else angle(line.start, target) / max(turn, 1e-9)
    # A signal right after a moment of the motion has a row at the same place.
    if way + degrees(turn) > POSE_MM and share < 1.0 and abs(share - done) * max(way, degrees(turn)) <= DIGIT:
        return done
    return share if done < share < 1.0 else 1.0


def _apart(one: Pose, other: Pose) -> float:
    """Millimetres or degrees between two poses, whichever are more."""
    return max(distance(one, other), degrees(angle(one, other)))


def prove(
    dialect: Dialect, files: ProgramFiles, motion: MotionProgram, installation: Installation, lowered: MotionProgram
) -> tuple[Rebuilt, Agreement]:
    """Read a program back, compare it with the motion it was made from, and give both.

    Args:
        dialect: Its language.
        files: As they were written.
        motion: What ``make_motion`` gave, before it was lowered.
        installation: The cell.
        lowered: The motion in the controller's terms.

    Raises:
        ProgramError: the text cannot be read, or does something else; the message names the place in the text and what
            was planned there.
    """
    remedy = f"The {dialect.title} writer is at fault: nothing was written. Choose another dialect, and report this."
    try:
        rebuilt = dialect.read(files)
        agreement = measure(rebuilt, motion, installation, lowered)
    except ProgramError as refused:
        raise ProgramError(f"{refused} The text cannot be read back. {remedy}") from None
    if agreement.differences:
        first, count = agreement.differences[0], len(agreement.differences)
        counted = "" if count == 1 else f" (first of {count} differences)"
        message = (
            f"the text does not do what was planned at {first.made_by or 'the program'}: {first.message}{counted}."
        )
        place = first.place
        raise ProgramError(f"{message} {remedy}", file=place and place.file, line=place and place.line)
    return rebuilt, agreement
