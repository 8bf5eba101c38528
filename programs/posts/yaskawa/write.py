"""Yaskawa INFORM jobs (.JBI): outputs so many hundredths of a second before the end of a motion, by ``ENWAIT``."""

import math
from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, Reach
from programs.pose import Pose
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.angles import fixed_xyz
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Part, part_at_boards
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.heading import sheet, short_heading
from programs.posts.writing.lines import Placed, is_straight
from programs.posts.writing.naming import Names, table_lines
from programs.posts.writing.wording import fixed, join_lines, pose_words, split_wait

LONGEST_WAIT_S = 655.0
"""TIMER takes up to 655.35 s."""
PASSING_MM = 0.3
"""Greatest S1CxG033, which PL=1 passes by."""
_NARROWEST_CR_MM = 1.0
"""CR takes no smaller corner radius."""
_NOTES = (
    "Rx, Ry, Rz turn about the fixed x, then y, then z axis; points are in the board's CAD frame, as user frame",
    "Positions are RECTAN, as the pulses of a degree differ from robot to robot",
    f"V in mm/s, VR in degrees/s; PL=0 stops, PL=1 passes: let parameter S1CxG033 be {PASSING_MM} mm or less",
    "I090 and up count loops; ENWAIT T counts from the end of its motion, in s",
    "P010, D010 and D011 raise the tool first: select the program's first TOOL before the start",
)


class Inform(Syntax):
    """INFORM: relative jobs, with their positions before the instructions."""

    mark = "'"
    longest_comment = 32
    call_form = "CALL JOB:{routine}"
    digital = "DOUT OT#({number}) {value}"
    group = "DOUT OG#({number}) {value}"
    analog = "AOUT AO#({number}) {value}"
    off_on = ("OFF", "ON")
    counter = "I{number:03d}"
    first_counter = 90  # assumed free
    start = "I089"
    start_words = "enter its number in {start}"
    watch_note = ": to be wired, see below"
    states = ("OFF", "ON")
    part_form = ("{call} IF {start}<={number}",)
    enter_begin = ("JUMP *RUN IF {start}<>{number}", "SET {start} 1")
    enter_end = ("*RUN",)
    wait_contact = (
        "WAIT IN#({input})={state} T={seconds}",
        "JUMP *GO{index} IF IN#({input})={state}",
        'MSG "{message}"',
        "ABORT",
        "*GO{index}",
    )
    rise_forms = (
        "GETS PX010 $PX001",
        "GETE D010 P010 (3)",
        "SET D011 {height}",
        "JUMP *HIGH IF D010>=D011",
        "SETE P010 (3) D011",
        "MOVL P010 V=100.0 PL=0",
        "*HIGH",
    )
    longest_message = 32
    loop_text = "until {key} >= {least}"
    loop_begin = ("SET {counter} 0", "*LOOP{number}", "INC {counter}")
    loop_end = ("JUMP *LOOP{number} IF {counter}<{count}",)
    longest_name = 32
    longest_program_name = 28
    indents_loops = False
    numbers_points_by_routine = True

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.heads: list[str] = []
        """Headings of positions that are in force."""
        self.turns = "0,0,0"
        self.shut_name = self.fault_name()
        for wait in installation.waits:
            if wait.timeout_s > LONGEST_WAIT_S:
                raise ProgramError(f"io.waits.{wait.name}: INFORM waits {LONGEST_WAIT_S:g} s at most; lower timeout_s.")

    def fault_name(self) -> str:
        """Name the job that shuts the valves, unlike the integrator's."""
        name = f"{self.name}_SH"
        return name if name.lower() not in self.names.taken else f"{self.name[:-1]}X_SH"

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield "concurrent I/O (ladder): shut the valves' outputs while the robot is not in operation: a stop"
        yield "keeps outputs, and no job changes that; likewise without what is to be watched"
        yield "play mode at 100 %, no speed limit, no dry run: a job cannot read the speed override"
        yield f"parameter S2C714 for ENWAIT; {self.start} is the part to start at; relative jobs are allowed"

    def divide(self) -> tuple[Part, ...]:
        """Divide where the board is put elsewhere too: a relative job has one user frame."""
        return part_at_boards(super().divide())

    def make_names(self) -> Names:
        """Begin the list of names: capital letters."""
        self.name = self.name.upper()
        return Names(self.longest_name, {self.name.lower()}, str.upper)

    def routine_name(self, chapter: Chapter) -> str:
        """Name a job of ours, unlike the integrator's."""
        name = f"{self.name}_{chapter.number:02d}"
        return name if name.lower() not in self.names.taken else f"{self.name[:-1]}X_{chapter.number:02d}"

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a job; its first position has all headings."""
        self.heads = []
        return super().chapter(chapter)

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write a motion; an output that belongs to its end goes ahead by ENWAIT, the instruction after it."""
        if len(line.events) > 1:
            raise ProgramError(
                f"{line.made_by}: two outputs change at one moment, and INFORM times one on a motion. "
                "Give the valve a shortest pulse, or part the two."
            )
        speed = f"V={fixed(line.speed_mm_s, 1)}"
        if line.turns_on_the_spot:
            speed = f"VR={fixed(max(math.degrees(line.turn_rad_s), 0.1), 1)}"
        ahead = "".join(f" ENWAIT T={fixed(-event.offset_s, 2)}" for event in line.events)
        yield f"MOVL {self.position(line.target, line.joints)} {speed} {self.level(line)}{ahead}"
        yield from (self.output(event.channel, event.value) for event in line.events)

    def level(self, line: Line) -> str:
        """PL=0 stops, PL=1 passes; a corner of 1 mm and more has a radius of its own."""
        if line.blend_mm == 0.0:
            return "PL=0"
        if line.blend_mm < _NARROWEST_CR_MM or is_straight(line, self.following.get(id(line))):
            return "PL=1"
        return f"CR={fixed(math.floor(10.0 * line.blend_mm) / 10.0, 1)}"

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``MOVJ``."""
        pace = self.pace(reach)
        yield f"MOVJ {self.position(reach.target, reach.joints)} VJ={pace.percent}.00 PL=0"

    def height(self, millimetres: float) -> str:
        """Write a height in 0.001 mm, as elements of positions count."""
        return str(round(1000.0 * millimetres))

    def home(self) -> tuple[str, ...]:
        """Go nowhere: the first motion is a ``MOVJ`` from where the robot is."""
        return ()

    def pause(self, seconds: float) -> Iterator[str]:
        """Write as many timers as it takes."""
        yield from (f"TIMER T={fixed(each, 2)}" for each in split_wait(seconds, LONGEST_WAIT_S, 2))

    def position(self, pose: Pose, joints: tuple[float, ...]) -> str:
        """Declare a position under the headings it needs."""
        kinds = self.installation.joint_kinds(len(joints))
        if joints:  # of R, T and S: whether they are beyond half a turn
            counted = as_controller_counts(joints, self.installation)
            beyond = ("1" if not -180.0 < counted[at] <= 180.0 else "0" for at in (3, 5, 0))
            self.turns = ",".join(beyond) if kinds == ["revolute"] * 6 else "0,0,0"
        frames = [f"///USER {self.slots.board}", f"///TOOL {self.slots.tool}"]
        heads = [*frames, "///POSTYPE USER", "///RECTAN", f"///RCONF 1,0,0,{self.turns},0,0"]
        if heads != self.heads:
            self.data += heads
            self.heads = heads
        self.points += 1
        self.data.append(f"C{self.points - 1:05d}={','.join(pose_words(pose, fixed_xyz))}")
        return f"C{self.points - 1:05d}"

    def prepare(self) -> list[str]:
        """Write the header of remarks; the rest is on the page."""
        return [*map(self.comment, short_heading(self.lowered, self.installation, f"{self.name}.TXT"))]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write main, a job for each routine, and a page for the integrator."""
        files = {f"{each.name}.JBI": _job(each) for each in (main, *routines)}
        files[f"{self.shut_name}.JBI"] = _job(Routine(self.shut_name, 0, self.shut(), []))
        notes = [*self.page_lines(), *table_lines(self.slots, self.installation, "TOOL", "USER"), *_NOTES]
        files[f"{self.name}.TXT"] = sheet(self.dialect, self.lowered, self.installation, notes)
        return files


def _job(routine: Routine) -> str:
    """Write a job; the date is always the same, so that the same program gives the same bytes."""
    count = sum(line.startswith("C") for line in routine.data)
    frame = next((line.split()[1] for line in routine.data if line.startswith("///USER")), "")
    relative = ["///ATTR SC,RW,RJ", f"////FRAME USER {frame}"] if routine.data else ["///ATTR SC,RW"]
    positions = [f"///NPOS {count},0,0,0,0,0", *routine.data]
    attributes = ["///DATE 2000/01/01 00:00", "///COMM Washboard", *relative, "///GROUP1 RB1"]
    head = ["/JOB", f"//NAME {routine.name}", "//POS", *positions, "//INST", *attributes]
    return join_lines([*head, "NOP", *routine.body, "END"])
