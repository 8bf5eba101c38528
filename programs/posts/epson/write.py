"""Epson SPEL+: outputs by parallel processing, at whole percents of a move."""

from collections.abc import Iterable, Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Wait
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import ProgramFiles
from programs.posts.writing.angles import moving_zyx
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.joint_moves import Pace
from programs.posts.writing.lines import Placed, degrees_per_s
from programs.posts.writing.naming import Names
from programs.posts.writing.wording import fixed, indent, join_lines, make_name, pose_words

MOST_TRAPS = 4
"""Conditions that the controller watches, by the numbers of their traps from 1."""
ACCELERATION, TURN_ACCELERATION = 2000, 1000
"""mm/s2 and degrees/s2; assumed."""
SETTINGS = (
    *("Motor On", "Power High", "Accel 100, 100"),
    *(
        "SpeedS 100",
        f"AccelS {ACCELERATION}, {ACCELERATION}",
        "SpeedR 90",
        f"AccelR {TURN_ACCELERATION}, {TURN_ACCELERATION}",
    ),
)
"""Power, and speeds and accelerations to begin with."""


class Spel(Syntax):
    """SPEL+: functions of moves to points of a local."""

    mark = "' "
    longest_comment = longest_heading = 120
    call_form = "Call {routine}"
    pause_form = "Wait {seconds}"
    digital = "{value} {number}"
    group = "Out {number}, {value}"
    analog = "AIO_Out {number}, {value}"
    off_on = ("Off", "On")
    select_tool = "Tool {slot}"
    set_tool = "TLSet {slot}, {frame}"
    set_board = "Local {slot}, {frame}"
    most_frames = 15
    move = "Move {point}{turns}{passes}{parallel}"
    declare = "Integer {counter}"
    to_joints = "Go JA({joints})"
    by_joints = "Go {point}"
    straight = "Move {point}"
    home_comment = " ' home"
    states = ("Off", "On")
    part_form = ("If {start} <= {number} Then {call}",)
    enter_begin = ("If {start} = {number} Then", "  {start} = 1")
    enter_end = ("EndIf",)
    guard = ('If SpeedFactor <> 100 Then Call stop_job("speed factor is not 100")',)
    wait_contact = ("Wait Sw({input}) = {state}, {seconds}", 'If TW = True Then Call stop_job("{message}")')
    wait_sensor = (
        "TmReset 0",
        "Do While {reading} < {least} And Tmr(0) < {seconds}",
        "  Wait 0.1",
        "Loop",
        'If {reading} < {least} Then Call stop_job("{message}")',
    )
    watch = ("Trap {index}, Sw({input}) = {other} Xqt on_fault",)
    rise_forms = ("Tool {tool}", "If CZ(Here) < {height} Then Move Here :Z({height})")
    loop_begin = ("{counter} = 0", "Do", "  {counter} = {counter} + 1")
    loop_end = ("Loop While {condition}",)
    counted = "{counter} < {count}"
    sensed = "{counter} < {count} And {reading} < {least}"
    reading = "{scale} * AIO_In({input}) + {offset}"
    reading_digits = 6
    rounds_groups = True
    reserved = frozenset({
        "main", "function", "fend", "tool", "local", "home", "move", "go", "wait", "call", "do", "loop", "start",
        "reset", "shut_valves", "stop_job", "on_fault", "nstart",
    })  # fmt: skip
    longest_name = 32
    longest_title = 29

    def make_names(self) -> Names:
        """Begin the list of names; a file may be called like a function of another."""
        return Names(self.longest_name, set(self.reserved))

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write ``Move`` with its outputs, which the controller takes in the order of their percents."""
        turns = line.turns_on_the_spot
        yield from self.set("SpeedR", fixed(degrees_per_s(line), 1)) if turns else ()
        yield from () if turns else self.set("SpeedS", fixed(line.speed_mm_s, 1))
        outputs = [f"D{round(100.0 * event.share)}; {self.output(event.channel, event.value)}" for event in line.events]
        parallel = f" !{'; '.join(outputs)}!" if outputs else ""
        passes = " CP" * (line.blend_mm > 0.0)
        point = self.point(line.target)
        yield self.move.format(point=point, turns=" ROT" * turns, passes=passes, parallel=parallel)

    def slow_down(self, pace: Pace) -> Iterable[str]:
        """Set the speed of ``Go``."""
        return self.set("Speed", str(pace.percent))

    def point(self, pose: Pose) -> str:
        """Write a point on the board."""
        return f"{self.frame(pose)} /{self.slots.board}"

    def frame(self, pose: Pose) -> str:
        """Write a pose: U, V, W turn about z, y', x''."""
        return f"XY({', '.join(pose_words(pose, moving_zyx))})"

    def prepare(self) -> Iterator[str]:
        """Set speeds and accelerations, tools and locals."""
        yield from (self.declare.format(counter=self.counter.format(number=number)) for number in self.loops)
        yield from SETTINGS
        yield from self.slot_lines()

    def shut(self) -> list[str]:
        """Shut the valves in an emergency stop too, in which outputs are not set otherwise."""
        return [f"{line}, Forced" for line in super().shut()]

    def begin_production(self) -> Iterator[str]:
        """Have the fault routine run at errors, aborts and emergency stops."""
        yield from (f"Trap {event} Xqt on_fault" for event in ("Error", "Emergency", "Abort"))
        yield from super().begin_production()

    def wait_lines(self, forms: Sequence[str], index: int, wait: Wait) -> list[str]:
        """Fill in the forms of a wait; traps are numbered by the inputs that are watched.

        Raises:
            ProgramError: there are more of those than traps.
        """
        if forms is self.watch:
            index = 1 + [each.name for each in self.installation.waits if each.watched].index(wait.name)
            if index > MOST_TRAPS:
                raise ProgramError(f"io.waits.{wait.name}: SPEL+ watches {MOST_TRAPS} inputs at most; watch fewer.")
        return super().wait_lines(forms, index, wait)

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up."""
        yield "preferences: outputs off at an emergency stop; a background task shuts the valves while no task runs"
        yield "trap numbers below 5 are free; nStart, the part to start at, is kept when the controller is switched off"
        yield "AccelS and AccelR of this arm in main; the option for analog I/O where it is used"

    def faults(self) -> list[str]:
        """Write the functions that shut the valves."""
        shut = f"Call {self.shut_name}"
        stop = indent([shut, 'Print "Washboard: ", text$', "Quit All"])
        fault = [shut, 'Print "Washboard: fault, valves shut"', "Quit All"]
        stopping = ["Function stop_job(text$ As String)", *stop, "Fend", ""]
        return [*_function(self.shut_name, self.shut()), *stopping, *_function("on_fault", fault)]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each function and one with main."""
        units = "Units: mm, mm/s, deg/s; points in the board's CAD frame (Local), U V W about z, y', x''."
        head = self.heading(units)
        texts = {each.name: _function(each.name, each.body) for each in routines}
        start = [*head, "Global Preserve Integer nStart", "", *_function("main", main.body), *self.faults()]
        name = make_name(self.motion.origin.board, self.longest_name, self.names.taken)
        if self.fits_one_file:
            return {f"{name}.prg": join_lines([*start, *(line for text in texts.values() for line in text)])}
        return {f"{each}.prg": join_lines(text) for each, text in {name: start, **texts}.items()}


def _function(name: str, body: Iterable[str]) -> list[str]:
    return [f"Function {name}", *indent(body), "Fend", ""]
