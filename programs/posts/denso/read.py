"""Reads PacScript back, as a controller would execute it."""

import re
from dataclasses import replace

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.denso.write import SPEEDS
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import NUMBER, N, U, refusal, statements_of
from programs.posts.rebuilt import Due, ReadBoard, ReadLine, ReadPause, ReadSignal, ReadSwitch
from programs.posts.writing.angles import from_fixed_xyz
from programs.posts.writing.lines import degrees_per_s

_POSE = rf"P\(((?:{NUMBER}, ){{5}}{NUMBER})"
_EXIT = rf"If {N} \* IOW\[(\d+)\] \+ {N} >= {N} Then Exit For"


class PacScriptReader(Reader):
    """Subprograms, tools and works, and the move that goes on while the program does."""

    handlers = frozenset({"main", "On Error"})
    watches_inputs = False

    def __init__(self) -> None:
        super().__init__()
        self.frames = self.declares("frame")
        self.counter_names = self.declares("counter")
        self.moving = False
        """Whether the last move goes on while the program does."""
        self.percent = 0
        """Of the last move that the program has waited for."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give the zone in whole millimetres, one at least, and the rate of a turn on the spot."""
        return Due(max(float(int(line.blend_mm)), 1.0), degrees_per_s(line) if line.turns_on_the_spot else None)

    def load(self, files: ProgramFiles) -> str:
        """Sort the subprograms; the Main of another file than the first goes by the name of its file."""
        main = next(iter(files), "").removesuffix(".pcs")
        for file, text in files.items():
            name = file.removesuffix(".pcs")
            lines = statements_of(file, text, "'")
            named = (line.become(f"Sub {name}") if line == "Sub Main" else line for line in lines)
            for line in self.sort(named, r"Sub (\w+)", "End Sub"):
                if line not in {each.partition("'")[0].strip() for each in SPEEDS}:
                    raise refusal(line, "stands outside a subprogram")
        return main

    def grammar(self) -> dict[str, Action]:
        """List the statements."""
        return {
            rf"Move L, @(\d+) {_POSE}, -1\), Speed = {U} \* (PER_MM_S|PER_DEG_S)(, Next)?": self.move,
            rf"(?:(Set|Reset) IO\[(\d+)\]|(IOB|IOW)\[(\d+)\] = {N})": self.set_output,
            r"Arrive (\d+)": self.wait_for_percent,
            r"WaitMotion 4, 0": self.stand,
            rf"Move (P), @0 {_POSE}, -1\), Speed = (\d+)|Move L, @0 {_POSE}, -1\), Speed = 10": self.reach_pose,
            rf"Move P, @0 J\(({NUMBER}(?:, {NUMBER})*)\), Speed = (\d+)": self.move_joints,
            r"Delay (\d+)": self.delay,
            r"Call shut_valves": self.shut("main"),
            r"If I\[99\] <= (\d+) Then Call (\w+)": lambda match: self.call_part(match[1], match[2]),
            r"If I\[99\] = (\d+) Then": lambda match: self.enter(match[1], "End If"),
            r'If CurExtSpd <> 100 Then Halt "[^"]*"': self.guard,
            r"Wait IO\[(\d+)\] = (On|Off), (\d+), I\[98\]": self.wait_contact,
            rf"Wait {N} \* IOW\[(\d+)\] \+ {N} >= {N}, (\d+), I\[98\]": self.wait_sensor,
            r"Dim pStart As Position": self.rise_from,
            r"On Error GoTo \*Fault": self.read_fault,
            r"Exit Sub": self.leave,
            r"End If|I\[99\] = 1": skip,
            r"Call (\w+)": self.call,
            r"For (nLoop\d+) = 1 To (\d+)": self.begin_loop,
            r"Next (nLoop\d+)": self.end_loop,
            _EXIT: self.leave_loop,
            r"Dim (nLoop\d+) As Integer": lambda match: self.counter_names.add(match[1], 0),
            rf"(Tool|Work) (\d+), {_POSE}\)": self.set_frame,
            r"Change(Tool|Work) (\d+)": self.use_frame,
            r"TakeArm Keep = 0|GiveArm|Speed 100|Accel 100, 100": skip,
        }

    def execute(self, statement: str) -> None:
        """Wait for the move before all but outputs and the waits for them."""
        if not statement.startswith(("Move L", "Set ", "Reset ", "IO", "Arrive ")):
            self.moving = False
        super().execute(statement)

    def wait_contact(self, match: re.Match[str]) -> None:
        """Wait for an input, and halt where that takes too long."""
        self.pass_on(r'If I\[98\] = 0 Then Halt "[^"]*"')
        self.wait_for(match[1], match[2] == "On", float(match[3]) / 1000.0)

    def wait_sensor(self, match: re.Match[str]) -> None:
        """Wait for a quantity, and halt where that takes too long."""
        self.pass_on(r'If I\[98\] = 0 Then Halt "[^"]*"')
        scale, sensor, offset, least, milliseconds = match.groups()
        self.wait_least(sensor, (scale, offset, least), float(milliseconds) / 1000.0)

    def rise_from(self, match: re.Match[str]) -> None:
        """Raise the orifice from wherever it is."""
        _, tool, _ = self.pass_on("ChangeWork 0", r"ChangeTool (\d+)", "pStart = CurPos")
        self.frames.use(("Tool", tool[1]))
        self.rise(rf"If PosZ\(pStart\) < {N} Then", rf"LetZ pStart = {N}")
        self.pass_on("Move L, @0 pStart, Speed = 10", "End If")

    def read_fault(self, match: re.Match[str]) -> None:
        """Read where errors lead: the end of Main, which shuts the valves."""
        if self.routines[self.routine][-4:-1] != ["Exit Sub", "*Fault:", "Call shut_valves"]:
            raise ProgramError("errors do not lead to what shuts the valves.")
        self.shut_by.add("On Error")

    def leave(self, match: re.Match[str]) -> None:
        """Leave Main; what errors lead to follows."""
        self.at = len(self.routines[self.routine]) - 1

    def move(self, match: re.Match[str]) -> None:
        """Move in a line."""
        passing, values, speed, unit, goes_on = match.groups()
        turns = unit == "PER_DEG_S"
        self.state(zone=float(passing), turn_deg_s=float(speed) if turns else None)
        self.line(_pose(values), passing == "0", 0.0 if turns else float(speed))
        self.moving, self.percent = goes_on is not None, 0

    def wait_for_percent(self, match: re.Match[str]) -> None:
        """Wait until the move has done so many percent."""
        if not self.moving:
            raise ProgramError(f"{match[0]} does not follow a move with Next.")
        self.percent = int(match[1])

    def stand(self, match: re.Match[str]) -> None:
        """Wait for the end of the move."""
        self.moving = False

    def set_output(self, match: re.Match[str]) -> None:
        """Set an output: while the last move goes on, at the percent that was waited for."""
        word, bit, group, number, count = match.groups()
        channel, value = f"digital {bit}", float(word == "Set")
        if group:
            channel, value = f"{'analog' if group == 'IOW' else 'group'} {number}", float(count)
        last = self.steps[-1] if self.steps else None
        if not self.moving or not isinstance(last, ReadLine):
            self.switch(channel, value)
        elif self.percent == 0:
            self.steps.insert(-1, ReadSwitch(channel, value))
        else:
            signal = ReadSignal(channel, value, self.percent / 100.0, 0.0)
            self.steps[-1] = replace(last, signals=(*last.signals, signal))

    def reach_pose(self, match: re.Match[str]) -> None:
        """Come to a pose by joints, or straight after joint values."""
        self.board = self.board or ReadBoard(None)
        if match[1]:
            self.set_share(match[3])
            self.reach(_pose(match[2]))
        else:
            self.line(_pose(match[4]), True, 0.0)

    def delay(self, match: re.Match[str]) -> None:
        """Hold the pose for so many milliseconds."""
        self.steps.append(ReadPause(float(match[1]) / 1e3))

    def begin_loop(self, match: re.Match[str]) -> None:
        """Find how a loop ends: its Next, and the statement before it."""
        lines = self.routines[self.routine]
        end = next((at for at in range(self.at, len(lines)) if lines[at] == f"Next {match[1]}"), 0)
        if not end:
            raise ProgramError(f"{match[0]} has no Next.")
        looks = re.fullmatch(_EXIT, lines[end - 1])
        self.counter_names.use(match[1])
        self.counters[match[1]] = 0
        self.repeat(match[2], looks.groups() if looks else (), match[1])
        self.counters[match[1]] = 1  # it counts by itself

    def leave_loop(self, match: re.Match[str]) -> None:
        """Leave a loop by its input, right before it ends."""
        lines = self.routines[self.routine]
        if not self.loops or self.at + 1 == len(lines) or lines[self.at + 1] != f"Next {self.loops[-1]}":
            raise ProgramError(f"{match[0]!r} does not stand at the end of a loop.")

    def end_loop(self, match: re.Match[str]) -> None:
        """End the loop of a counter."""
        if self.loops[-1:] != [match[1]]:
            raise ProgramError(f"{match[0]!r} ends another loop than the innermost.")
        self.end_repeat(match)

    def set_frame(self, match: re.Match[str]) -> None:
        """Set a tool or a work."""
        self.frames.add((match[1], match[2]), _pose(match[3]))

    def use_frame(self, match: re.Match[str]) -> None:
        """Use another tool or work from now on."""
        pose = self.frames.use((match[1], match[2]))
        if match[1] == "Tool":
            self.use_tool(match[0], pose)
        else:
            self.use_board(pose)


def _pose(values: str) -> Pose:
    return read_pose(values.split(", "), from_fixed_xyz)
