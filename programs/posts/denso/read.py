"""Reads PacScript back, as a controller would execute it."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.denso.write import SPEEDS, PacScript
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import skip
from programs.posts.reading.forms import Block, Values
from programs.posts.reading.statements import NUMBER, refusal, statements_of
from programs.posts.rebuilt import Due, ReadBoard, ReadLine, ReadPause, ReadSignal, ReadSwitch
from programs.posts.writing.angles import from_fixed_xyz
from programs.posts.writing.lines import degrees_per_s


class PacScriptReader(Reader):
    """Subprograms, tools and works, and the move that goes on while the program does."""

    syntax = PacScript
    handlers = frozenset({"main", "On Error"})
    watches_inputs = False

    def __init__(self) -> None:
        super().__init__()
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

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        frame = rf"P\((?:{NUMBER}, ){{5}}{NUMBER}"
        moves = {"point": rf"{frame}, -1\)", "frame": rf"{frame}\)", "passing": r"\d+", "speed": r"\d+(?:\.\d+)?"}
        return {**super().fields(), **moves, "unit": "PER_MM_S|PER_DEG_S", "goes_on": "(?:, Next)?"}

    def blocks(self) -> Iterator[Block]:
        """List the statements."""
        yield [PacScript.move], self.move
        yield from super().blocks()
        yield [PacScript.wait_percent], self.wait_for_percent
        yield [PacScript.wait_end], self.stand
        yield [PacScript.declare], lambda values: self.counter_names.add(values["counter"], 0)
        yield [PacScript.begin[0]], self.read_fault
        yield from (([form], skip) for form in (*PacScript.begin[1:], PacScript.last[0]))
        yield [PacScript.last[1]], self.leave

    def execute(self, statement: str) -> None:
        """Wait for the move before all but outputs and the waits for them."""
        if not statement.startswith(("Move L", "Set ", "Reset ", "IO", "Arrive ")):
            self.moving = False
        super().execute(statement)

    def use_variable(self, name: str) -> None:
        """Use a counter."""
        if name.startswith("nLoop"):
            self.counter_names.use(name)

    def read_fault(self, values: Values) -> None:
        """Read where errors lead: the end of Main, which shuts the valves."""
        if self.routines[self.routine][-4:-1] != list(PacScript.last[1:4]):
            raise ProgramError("errors do not lead to what shuts the valves.")
        self.shut_by.add("On Error")

    def leave(self, values: Values) -> None:
        """Leave Main; what errors lead to follows."""
        self.at = len(self.routines[self.routine]) - 1

    def move(self, values: Values) -> None:
        """Move in a line."""
        passing, speed, turns = values["passing"], float(values["speed"]), values["unit"] == "PER_DEG_S"
        self.state(zone=float(passing), turn_deg_s=speed if turns else None)
        self.line(self.pose_of(values["point"]), passing == "0", 0.0 if turns else speed)
        self.moving, self.percent = values["goes_on"] != "", 0

    def wait_for_percent(self, values: Values) -> None:
        """Wait until the move has done so many percent."""
        if not self.moving:
            raise ProgramError(f"Arrive {values['percent']} does not follow a move with Next.")
        self.percent = int(values["percent"])

    def stand(self, values: Values) -> None:
        """Wait for the end of the move."""
        self.moving = False

    def read_switch(self, values: Values) -> None:
        """Set an output: while the last move goes on, at the percent that was waited for."""
        channel, value = self.switched(values)
        last = self.steps[-1] if self.steps else None
        if not self.moving or not isinstance(last, ReadLine):
            self.switch(channel, value)
        elif self.percent == 0:
            self.steps.insert(-1, ReadSwitch(channel, value))
        else:
            signal = ReadSignal(channel, value, self.percent / 100.0, 0.0)
            self.steps[-1] = replace(last, signals=(*last.signals, signal))

    def reach(self, pose: Pose, counted: tuple[float, ...] = ()) -> None:
        """Come to a pose by a joint motion, in work 0 where none was selected."""
        self.board = self.board or ReadBoard(None)
        super().reach(pose, counted)

    def pause(self, values: Values) -> None:
        """Hold the pose for so many milliseconds."""
        self.steps.append(ReadPause(float(values["ms"]) / 1e3))

    def pose_of(self, point: str) -> Pose:
        """Read a position."""
        return read_pose(point.removeprefix("P(").rstrip(")").split(", ")[:6], from_fixed_xyz)
