"""FANUC TP programs (.ls): outputs so many hundredths of a second before the end of a motion, by ``TB``."""

import math
from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.heading import sheet, short_heading
from programs.posts.writing.joint_moves import CAUTIOUS, Pace
from programs.posts.writing.lines import Placed, is_straight
from programs.posts.writing.naming import Names, table_lines
from programs.posts.writing.wording import fixed, join_lines, make_name, pose_words, split_wait

LONGEST_WAIT_S = 327.0
"""WAIT takes up to 327.67 s."""
READING = 90
_COUNTER, POSITION = 91, 91
"""Registers: R[91] and up count loops, R[90] holds a reading; PR[91] is used by the program of frames. Assumed free."""
SLOW_CORNER_S = 0.05
"""At CNT100 a corner is rounded by about the way of half the time to brake; assumed 0.1 s."""
_NOTES = (
    "The program that ends in FR enters these frames in the controller's tables; run it once, or enter your own",
    f"R[{_COUNTER}] and up count loops, R[{READING}] holds a reading, PR[{POSITION}] is used to enter the frames",
    "W, P, R turn about the fixed x, then y, then z axis; points are in the board's CAD frame",
    "Speeds are whole mm/sec, rounded down; an output's TB counts from the end of its motion, in hundredths",
)


class Tp(Syntax):
    """TP programs: numbered instructions, and positions in numbered frames."""

    mark = "!"
    longest_comment = 32
    call_form = "CALL {routine}"
    digital = "DO[{number}]={value}"
    group = "GO[{number}]={value}"
    analog = "AO[{number}]={value}"
    off_on = ("OFF", "ON")
    select_tool = "UTOOL_NUM={slot}"
    select_board = "UFRAME_NUM={slot}"
    by_joints = "J {point} {percent}% FINE"
    straight = "L {point} 100mm/sec FINE"
    counter = "R[{number}]"
    first_counter = _COUNTER
    loop_text = "until {key} >= {least}"
    loop_begin = ("{counter}=0", "LBL[{number}]", "{counter}={counter}+1")
    loop_end = ("IF {counter}<{count},JMP LBL[{number}]",)
    sensed_end = (
        f"R[{READING}]=AI[{{input}}]*{{scale}}",
        f"R[{READING}]=R[{READING}]+{{offset}}",
        f"IF {{counter}}<{{count}} AND R[{READING}]<{{least}},JMP LBL[{{number}}]",
    )
    brackets = "()"
    start = "R[89]"
    start_words = "enter its number in {start}"
    watch_note = ": the valves by itself, the robot as wired, see below"
    states = ("OFF", "ON")
    part_form = ("IF {start}<={number},{call}",)
    enter_begin = ("IF {start}<>{number},JMP LBL[99]", "{start}=1")
    enter_end = ("LBL[99]",)
    guard = (
        "R[88]=$MCR.$GENOVERRIDE",
        "IF R[88]=100,JMP LBL[88]",
        "MESSAGE[OVERRIDE IS NOT 100]",
        "ABORT",
        "LBL[88]",
    )
    wait_contact = (
        "$WAITTMOUT={hundredths}",
        "WAIT DI[{input}]={state} TIMEOUT,LBL[{label}]",
        "JMP LBL[{ready}]",
        "LBL[{label}]",
        "MESSAGE[{message}]",
        "ABORT",
        "LBL[{ready}]",
    )
    wait_sensor = (
        "R[88]=0",
        "LBL[{label}]",
        f"R[{READING}]=AI[{{input}}]*{{scale}}",
        f"R[{READING}]=R[{READING}]+{{offset}}",
        f"IF R[{READING}]>={{least}},JMP LBL[{{ready}}]",
        "WAIT .10(sec)",
        "R[88]=R[88]+1",
        "IF R[88]<{tenths},JMP LBL[{label}]",
        "MESSAGE[{message}]",
        "ABORT",
        "LBL[{ready}]",
    )
    rise_forms = (
        "UFRAME_NUM=0",
        "UTOOL_NUM={tool}",
        f"PR[{POSITION}]=LPOS",
        f"R[88]=PR[{POSITION},3]",
        "IF R[88]>={height},JMP LBL[98]",
        f"PR[{POSITION},3]={{height}}",
        f"L PR[{POSITION}] 100mm/sec FINE",
        "LBL[98]",
    )
    longest_message = 24
    longest_name = 8  # of a program on any controller; 36 on newer ones
    indents_loops = False
    numbers_points_by_routine = True

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.configuration = "N U T, 0, 0, 0"
        self.shut_name = self.own_name("SH")

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield f"BG logic (mixed logic): run {self.own_name('BG')}, it shuts the valves while no program runs (UO[3])"
        yield f"{self.start} is the part to start at, R[88] and R[{READING}] are used; after a stop run main again"
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                yield f"{wait.words}: BG logic shuts the valves; wire DI[{wait.contact.number}] to UI[2] (*HOLD) too"

    def background(self) -> Iterator[str]:
        """Write the BG logic: it shuts the valves while no program runs, or without what is watched."""
        for shut in (self.output(channel, 0.0).replace("OFF", "(OFF)") for channel in self.valves):
            yield f"IF (!UO[3]),{shut}"
            for wait in self.installation.waits:
                if wait.watched and wait.contact is not None:
                    yield f"IF (DI[{wait.contact.number}]={self.states[not wait.state]}),{shut}"

    def make_names(self) -> Names:
        """Begin the list of names; the program's leaves room for the number of a routine."""
        self.digits = max(len(str(sum(isinstance(part, Chapter) for part in self.parts))), 2)
        self.name = make_name(self.motion.origin.board, self.longest_name - 1 - self.digits).upper()
        return Names(self.longest_name, {self.name.lower()}, str.upper)

    def call_name(self, name: str) -> str:
        """Name a program of the integrator's."""
        return self.names.give("call", name, name, longest=36)

    def routine_name(self, chapter: Chapter) -> str:
        """Name a program of ours."""
        return self.own_name(f"{chapter.number:0{self.digits}d}")

    def own_name(self, end: str) -> str:
        """Give the program's name another end, unlike the integrator's names."""
        stem = self.name[: self.longest_name - 1 - len(end)].rstrip("_")
        while f"{stem}_{end}".lower() in self.names.taken:
            stem = f"{stem[: self.longest_name - 2 - len(end)]}X"
        return f"{stem}_{end}"

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a remark; a semicolon would end it."""
        return super().comment(text, longest).replace(";", ",")

    def number(self, value: float) -> str:
        """Write the value of an output; a negative one stands in brackets."""
        return self.operand(value)

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a program; its first remark is its title."""
        yield self.comment(chapter.title)
        yield from super().chapter(chapter)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a motion with at most one output."""
        if len(line.events) > 1:
            raise ProgramError(
                f"{line.made_by}: two outputs change at one moment, and FANUC times one on a motion. "
                "Give the valve a shortest pulse, or part the two."
            )
        speed = f"{round(line.speed_mm_s)}mm/sec"
        if line.turns_on_the_spot:
            speed = f"{max(math.floor(math.degrees(line.turn_rad_s) + 0.3), 1)}deg/sec"
        output = "".join(
            f" TB {_hundredths(-event.offset_s)}sec,{self.output(event.channel, event.value)}" for event in line.events
        )
        yield f"L {self.point(line.target)} {speed} {self.termination(line)}{output}"

    def termination(self, line: Line) -> str:
        """FINE stops, CNT passes: straight on, CNT100 leaves the path alone; a corner is kept as narrow as planned."""
        if line.blend_mm == 0.0:
            return "FINE"
        if is_straight(line, self.following.get(id(line))):
            return "CNT100"
        share = line.blend_mm / max(line.speed_mm_s * SLOW_CORNER_S, 0.1)
        return f"CNT{min(max(math.floor(100.0 * share), 1), 100)}"

    def pause(self, seconds: float) -> Iterator[str]:
        """Write as many waits as it takes."""
        yield from (f"WAIT {_hundredths(each)}(sec)" for each in split_wait(seconds, LONGEST_WAIT_S, 2))

    def point(self, pose: Pose) -> str:
        """Declare a position in the frames in use."""
        x, y, z, w, p, r = pose_words(pose, fixed_xyz)
        where = f"X = {x:>9}  mm,\tY = {y:>9}  mm,\tZ = {z:>9}  mm"
        turned = f"W = {w:>10} deg,\tP = {p:>10} deg,\tR = {r:>10} deg"
        return self.declare(f",\t\tCONFIG : '{self.configuration}',\n\t{where},\n\t{turned}")

    def height(self, millimetres: float) -> str:
        """Write a height; a negative one stands in brackets."""
        return self.operand(millimetres)

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Move to joint values, and declare them."""
        values = as_controller_counts(joints, self.installation)
        kinds = self.installation.joint_kinds(len(joints))
        if kinds[:3] == ["revolute"] * 3:
            self.configuration = _configuration(values)
        units = ["deg" if kind == "revolute" else " mm" for kind in kinds]
        words = [f"J{n} = {fixed(v, 4):>10} {unit}" for n, (v, unit) in enumerate(zip(values, units, strict=True), 1)]
        rows = "".join(f",\n\t{row}" for row in (",\t".join(words[at : at + 3]) for at in range(0, len(words), 3)))
        return f"J {self.declare(rows)} {pace.percent}% FINE"

    def declare(self, what: str) -> str:
        """Declare a position."""
        self.points += 1
        frames = f"UF : {self.slots.board}, UT : {self.slots.tool}"
        self.data.append(f"P[{self.points}]{{\n   GP1:\n\t{frames}{what}\n}};")
        return f"P[{self.points}]"

    def prepare(self) -> list[str]:
        """Write the header of remarks; the rest is on the page."""
        return [*map(self.comment, short_heading(self.lowered, self.installation, f"{self.name}.txt"))]

    def home(self) -> Iterator[str]:
        """Go home with the first tool."""
        if self.installation.home:
            self.slots.board, self.slots.tool = 1, next(iter(self.slots.tools), 1)
            yield f"UFRAME_NUM={self.slots.board}"
            yield f"UTOOL_NUM={self.slots.tool}"
            yield self.joint_move(self.installation.home)

    def entries(self) -> Iterator[str]:
        """Enter the cell's frames in the controller's tables; the position register is made cartesian first."""
        register = f"PR[{POSITION}"
        yield self.comment("Enter the frames of the cell")
        yield f"{register}]=LPOS"
        for kind, number, _, pose in self.slots.entries(self.installation):
            for axis, word in enumerate(pose_words(pose, fixed_xyz), start=1):
                yield f"{register},{axis}]={self.operand(float(word))}"
            yield f"{'UTOOL' if kind == 'tool' else 'UFRAME'}[{number}]={register}]"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write main, a program for each routine, one that enters the frames, and a page for the integrator."""
        files = {f"{each.name}.ls": _program(each.name, each.body, each.data) for each in (main, *routines)}
        frames = self.own_name("FR")
        files[f"{frames}.ls"] = _program(frames, list(self.entries()), [])
        files[f"{self.shut_name}.ls"] = _program(self.shut_name, self.shut(), [])
        background = self.own_name("BG")
        files[f"{background}.ls"] = _program(background, list(self.background()), [])
        notes = [*self.page_lines(), *table_lines(self.slots, self.installation, "UTOOL", "UFRAME"), *_NOTES]
        files[f"{self.name}.txt"] = sheet(self.dialect, self.lowered, self.installation, notes)
        return files


def _hundredths(seconds: float) -> str:
    """Write a time as the controller lists it: .04, but 0.00."""
    text = fixed(seconds, 2)
    return text if text == "0.00" else text.removeprefix("0")


def _configuration(degrees: Sequence[float]) -> str:
    """Wrist and turns from the joints; elbow up and toward are assumed, as no table of the arm is at hand."""
    turns = [math.floor((value + 180.0) / 360.0) for value in (degrees[0], *degrees[3:6:2])]
    flip = "F" if len(degrees) > 4 and degrees[4] > 0.0 else "N"
    return f"{flip} U T, {', '.join(str(turn) for turn in [*turns, 0, 0, 0][:3])}"


def _program(name: str, body: Sequence[str], positions: Sequence[str]) -> str:
    """Write a program."""
    lines = attributes_of(name, len(body), bool(positions))
    for number, line in enumerate(body, start=1):
        lines.append(f"{number:4d}:{'' if line.startswith(('J P', 'L P')) else '  '}{line} ;")
    return join_lines([*lines, "/POS", *positions, "/END"])


def attributes_of(name: str, instructions: int, moves: bool) -> list[str]:
    """Write what is before the instructions: it has no date, so that the same program gives the same bytes.

    Args:
        name: Of the program.
        instructions: How many there are.
        moves: Whether it has positions.
    """
    return [
        f"/PROG  {name}",
        "/ATTR",
        "OWNER\t\t= MNEDITOR;",
        'COMMENT\t\t= "Washboard";',
        "PROG_SIZE\t= 0;",
        "FILE_NAME\t= ;",
        "VERSION\t\t= 0;",
        f"LINE_COUNT\t= {instructions};",
        "MEMORY_SIZE\t= 0;",
        "PROTECT\t\t= READ_WRITE;",
        "TCD:  STACK_SIZE\t= 0,",
        "      TASK_PRIORITY\t= 50,",
        "      TIME_SLICE\t= 0,",
        "      BUSY_LAMP_OFF\t= 0,",
        "      ABORT_REQUEST\t= 0,",
        "      PAUSE_REQUEST\t= 0;",
        f"DEFAULT_GROUP\t= {'1' if moves else '*'},*,*,*,*;",
        "CONTROL_CODE\t= 00000000 00000000;",
        "/MN",
    ]
