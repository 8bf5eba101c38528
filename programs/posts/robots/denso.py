"""Denso PacScript: outputs where a move has done so many percent, by ``Next`` and ``Arrive``."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.motion.steps import Line, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.layout import Layout, words_of
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, Values, refusal, skip, statements_of
from programs.posts.rebuilt import Due, ReadBoard, ReadLine, ReadSignal, ReadSwitch
from programs.posts.writing.angles import fixed_xyz, from_fixed_xyz
from programs.posts.writing.chapters import Chapter, Placed, degrees_per_s
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import POSE, fill
from programs.posts.writing.frame import under_each
from programs.posts.writing.vocabulary import PACSCRIPT
from programs.posts.writing.wording import join_lines, pose_words
from programs.timing.controller import ARM

SPEEDS = (
    "#Define PER_MM_S 0.1 ' percent of Speed for 1 mm/s, assumed: 100 / greatest CP speed of this arm",
    "#Define PER_DEG_S 0.2 ' percent of Speed for 1 deg/s, assumed: 100 / greatest turn of this arm",
)


class PacScript(Syntax):
    """PacScript: subprograms of moves to positions in a work."""

    mark = "' "
    longest_comment = longest_heading = 120
    call_form = "Call {routine}"
    digital = "{value} IO[{number}]"
    group = "IOB[{number}] = {value}"
    analog = "IOW[{number}] = {value}"
    address_forms = ("IO[{number}]", "IOB[{number}]", "IOW[{number}]")
    contact_form, sensor_form = "IO[{number}]", "IOW[{number}]"
    off_on = ("Reset", "Set")
    pause_form = "Delay {ms:0}"
    mount_forms = ('Hold "{mount}"',)
    select_tool = ("ChangeTool {slot}",)
    select_board = ("ChangeWork {slot}",)
    set_tool = "Tool {slot}, {frame}"
    set_board = "Work {slot}, {frame}"
    load_place = "internal load condition of the arm with tool {tool}"
    most_frames = 63
    routine_form = ("Sub {routine}", "End Sub")
    move = "Move L, @{passing:0} {point}, Speed = {speed:1} * {unit}{goes_on:, Next}"
    wait_percent = "Arrive {percent:0}"
    wait_end = "WaitMotion 4, 0"
    """Until 0 ms before the end of a move: what follows is done at rest."""
    declare_counter = "Dim {counter} As Integer"
    begin = ("On Error GoTo *Fault", "TakeArm Keep = 0", "Speed 100", "Accel 100, 100")
    to_joints = "Move P, @0 J({joints}), Speed = {percent}"
    by_joints = "Move P, @0 {point}, Speed = {percent}"
    straight = "Move L, @0 {point}, Speed = 10"
    home_comment = " ' home"
    start = "I[99]"
    start_words = "enter its number in {start}"
    watch_note = ": to be wired"
    states = ("Off", "On")
    part_form = ("If {start} <= {number} Then {call}",)
    enter_begin = ("If {start} = {number} Then", "  {start} = 1")
    enter_end = ("End If",)
    guard = (
        "If CurExtSpd <> 100 Then {fault}",
        'If CurExtSpd <> 100 Then Halt "speed is not 100 percent"',
    )
    wait_contact, wait_sensor = under_each(
        ("Wait {condition}, {ms}, I[98]", "If I[98] = 0 Then {fault}", 'If I[98] = 0 Then Halt "{message}"'),
        "IO[{input}] = {state}",
        "{reading} >= {least}",
    )
    await_forms = ("Wait IO[{input}] = {state}",)
    rise_forms = (
        "Dim pStart As Position",
        "ChangeWork 0",
        "ChangeTool {tool}",
        "pStart = CurPos",
        "If PosZ(pStart) < {height} Then",
        "  LetZ pStart = {height}",
        "  Move L, @0 pStart, Speed = 10",
        "End If",
    )
    loop_begin = ("For {counter} = 1 To {count}",)
    loop_end = ("{condition}", "Next {counter}")
    sensed = "  If {reading} >= {least} Then Exit For"
    reading = "{scale} * IOW[{input}] + {offset}"
    last = ("GiveArm", "Exit Sub", "*Fault:", "Call shut_valves", 'Halt "fault, valves shut"')
    rounds_groups = True
    shared = "I[98] and I[99]; Tool and Work by number are set at each start"
    vocabulary, names_parts_by_program = PACSCRIPT, True
    longest_title = 29

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Select the tool, then the board."""
        return (chapter.tool, chapter.board)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a line; with ``Next`` the program goes on while the robot moves, to wait for the outputs' percents."""
        turns = line.turns_on_the_spot
        yield fill(
            self.move,
            passing=max(int(line.blend_mm), 1) if line.blend_mm else 0,
            point=self.point(line.target),
            speed=degrees_per_s(line) if turns else line.speed_mm_s,
            unit="PER_DEG_S" if turns else "PER_MM_S",
            goes_on=placed.begins or placed.inside,
        )
        yield from (self.output(event.channel, event.value) for event in placed.begins)
        for event in placed.inside:
            yield fill(self.wait_percent, percent=round(100.0 * event.share))
            yield self.output(event.channel, event.value)
        if (placed.begins or placed.inside) and line.blend_mm == 0.0:
            yield self.wait_end
        yield from (self.output(event.channel, event.value) for event in placed.ends)

    def point(self, pose: Pose) -> str:
        """Write a position of the arm; figure -1 keeps the one it has."""
        return f"{self.frame(pose)[:-1]}, -1)"

    def frame(self, pose: Pose) -> str:
        """Write a pose without an arm's figure."""
        return f"P({', '.join(pose_words(pose, fixed_xyz))})"

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        text = "supervisory task or PLC: shut the valves while no program runs; a stop keeps outputs"
        watched = self.watched_lines("IO[{input}] {name}: stop the robot too: {words}")
        yield Task(text, (*(f"{self.address(channel)} {channel.name}" for channel in self.valves), *watched))
        yield Task("PER_MM_S and PER_DEG_S at the top: 100 divided by the arm's greatest speeds, mm/s and deg/s")

    def remarks(self) -> Iterator[str]:
        """State what the program uses, and what has to hold when it is started."""
        yield "I[98] and I[99] are used; I[99] is the part to start at; ExtSpeed 100"
        yield "Tool and Work are set by Main under the numbers there: compare them with yours"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each subprogram and one that calls them."""
        units = f"Units: mm, degrees; positions in {self.cad_frame} (Work), RX RY RZ about the fixed x, y, z."
        subs = [*self.whole("Main", main.body), *self.whole(self.shut_name, self.shut())]
        top = [_title(self.name), *self.heading(units), *SPEEDS, "", *subs]
        if self.fits_one_file:
            inside = [line for each in routines for line in self.whole(each.name, each.body)]
            return {f"{self.name}.pcs": join_lines([*top, *inside])}
        files = {f"{self.name}.pcs": join_lines(top)}
        for each in routines:
            files[f"{each.name}.pcs"] = join_lines([_title(each.name), *SPEEDS, "", *self.whole("Main", each.body)])
        return files


def _title(name: str) -> str:
    return f'\'!TITLE "{name}"'


class PacScriptReader(Reader):
    """Subprograms, tools and works, and the move that goes on while the program does."""

    syntax = PacScript
    handlers = frozenset({"main", "On Error"})
    watches_inputs = False
    texts: ClassVar[Mapping[str, str]] = {
        "point": rf"P\({POSE}, -1\)",
        "frame": rf"P\({POSE}\)",
        "unit": "PER_MM_S|PER_DEG_S",
    }

    def __init__(self) -> None:
        super().__init__()
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
            for line in self.sort(named, PacScript.routine_form):
                if line not in {each.partition("'")[0].strip() for each in SPEEDS}:
                    raise refusal(line, "stands outside a subprogram")
        return main

    def blocks(self) -> Iterator[Block]:
        """List the statements."""
        yield [PacScript.move], self.move
        yield [PacScript.wait_percent], self.wait_for_percent
        yield [PacScript.wait_end], self.stand
        yield [PacScript.begin[0]], self.read_fault
        yield [PacScript.last[0]], skip
        yield [PacScript.last[1]], self.leave
        yield from super().blocks()

    def execute(self, statement: str) -> None:
        """Wait for the move before all but outputs and the waits for them."""
        if not statement.startswith(("Move L", "Set ", "Reset ", "IO", "Arrive ")):
            self.moving = False
        super().execute(statement)

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
        self.moving, self.percent = "goes_on" in values, 0

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

    def place_of(self, point: str) -> Pose:
        """Read a position."""
        return read_pose(point.removeprefix("P(").rstrip(")").split(", ")[:6], from_fixed_xyz)


DIALECT = Dialect(
    title="Denso PacScript",
    notes="For RC8 and newer; outputs by Next and Arrive. Speeds are percents: put 100 divided by the arm's greatest "
    "speeds into PER_MM_S and PER_DEG_S, and run at ExtSpeed 100. Corners are passed from 1 mm before them or more. "
    "Groups are IOB, analog channels IOW, 10000 at full scale.",
    capability=Capability(
        controller_class=2,
        timing="percent",
        cycle_s=0.008,  # assumed: Arrive looks at the encoders, and a task runs every few milliseconds
        step_percent=1.0,
        most_events=8,  # assumed
        step_mm_s=0.1,
        # Words of 16 bits; 10,000 at full scale is assumed: the module and its configuration decide.
        analog=Counting(full=10_000.0, step=1.0),
    ),
    layout=Layout(
        "'",
        comma=", ",
        equals=" = ",
        single_blanks=True,
        leading_zero=True,
        powers=True,
        words=words_of(PacScript, "Define Main PER_MM_S PER_DEG_S P I J L As Set Then To Tool"),
    ),
    form=FileForm(".pcs"),
    longest_line=200,  # assumed
    most_steps=1000,  # of a program; assumed
    write=PacScript.write,
    rebuild=PacScriptReader.rebuild,
    controller=replace(ARM, most_lines=10_000),
    maker="denso",
    without_joints="Stand the arm in the figure that it is to keep: positions keep the one that it has (-1).",
)
