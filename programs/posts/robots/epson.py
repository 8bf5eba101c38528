"""Epson SPEL+: outputs by parallel processing, at whole percents of a move."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.installation import Wait
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, Values, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import from_moving_zyx, moving_zyx
from programs.posts.writing.chapters import Placed, degrees_per_s
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import POSE, fill
from programs.posts.writing.wording import join_lines, make_name, pose_words
from programs.timing.controller import ARM

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
    pause_form = "Wait {seconds:3}"
    modal = ("Speed {percent:0}", "SpeedS {speed:1}", "SpeedR {turn:1}")
    digital = "{value} {number}"
    group = "Out {number}, {value}"
    analog = "AIO_Out {number}, {value}"
    off_on = ("Off", "On")
    select_tool = ("Tool {slot}",)
    set_tool = "TLSet {slot}, {frame}"
    set_board = "Local {slot}, {frame}"
    most_frames = 15
    routine_form = ("Function {routine}{takes_text:(text$ As String)}", "Fend")
    move = "Move {point}{turns: ROT}{passes: CP}{parallel: !{outputs}!}"
    parallel = "D{percent:0}; {output}"
    trap = "Trap {event} Xqt on_fault"
    stop_body = ("Call shut_valves", 'Print "Washboard: ", text$', "Quit All")
    fault_body = ("Call shut_valves", 'Print "Washboard: fault, valves shut"', "Quit All")
    declare_counter = "Integer {counter}"
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
    keeps_program_name = False
    """A file may be called like a function of another."""
    begin = SETTINGS

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write ``Move`` with its outputs, which the controller takes in the order of their percents."""
        turns = line.turns_on_the_spot
        yield from self.set_modal(turn=degrees_per_s(line)) if turns else self.set_modal(speed=line.speed_mm_s)
        outputs = "; ".join(
            fill(self.parallel, percent=round(100.0 * event.share), output=self.output(event.channel, event.value))
            for event in line.events
        )
        words = {"turns": turns, "passes": line.blend_mm > 0.0, "parallel": outputs, "outputs": outputs}
        yield fill(self.move, point=self.point(line.target), **words)

    def point(self, pose: Pose) -> str:
        """Write a point on the board."""
        return f"{self.frame(pose)} /{self.slots.board}"

    def frame(self, pose: Pose) -> str:
        """Write a pose: U, V, W turn about z, y', x''."""
        return f"XY({', '.join(pose_words(pose, moving_zyx))})"

    def shut(self) -> list[str]:
        """Shut the valves in an emergency stop too, in which outputs are not set otherwise."""
        return [f"{line}, Forced" for line in super().shut()]

    def begin_production(self) -> Iterator[str]:
        """Have the fault routine run at errors, aborts and emergency stops."""
        yield from (fill(self.trap, event=event) for event in ("Error", "Emergency", "Abort"))
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
        stop = self.whole("stop_job", self.stop_body, takes_text=True)
        return [*self.whole(self.shut_name, self.shut()), *stop, *self.whole("on_fault", self.fault_body)]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each function and one with main."""
        units = "Units: mm, mm/s, deg/s; points in the board's CAD frame (Local), U V W about z, y', x''."
        head = self.heading(units)
        texts = {each.name: self.whole(each.name, each.body) for each in routines}
        start = [*head, "Global Preserve Integer nStart", "", *self.whole("main", main.body), *self.faults()]
        name = make_name(self.motion.origin.board, self.longest_name, self.names.taken)
        if self.fits_one_file:
            return {f"{name}.prg": join_lines([*start, *(line for text in texts.values() for line in text)])}
        return {f"{each}.prg": join_lines(text) for each, text in {name: start, **texts}.items()}


_XY = rf"XY\({POSE}\)"


class SpelReader(Reader):
    """Functions, tools and locals."""

    syntax = Spel
    handlers = frozenset({"main", "stop_job", "Error", "Emergency", "Abort"})
    texts: ClassVar[Mapping[str, str]] = {
        **{"outputs": r"D\d+; [^;]*(?:; D\d+; [^;]*)*", "event": "Error|Emergency|Abort"},
        **{"index": f"[1-{MOST_TRAPS}]", "frame": _XY, "point": rf"{_XY} /\d+"},
    }

    def __init__(self) -> None:
        super().__init__()
        self.variables = self.declares("variable")
        self.traps: set[str] = set()
        """Numbers of those that watch inputs."""

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give 1 for ``CP``, and the rate of a turn on the spot."""
        return Due(1.0, degrees_per_s(line) if line.turns_on_the_spot else None)

    def load(self, files: ProgramFiles) -> str:
        """Sort the functions."""
        lines = (line for file, text in files.items() for line in statements_of(file, text, "'"))
        for line in self.sort(lines, Spel.routine_form):
            if line != "Global Preserve Integer nStart":
                raise refusal(line, "stands outside a function")
            self.variables.add("nStart", 1, line)
        return "main"

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [Spel.move], self.move
        yield from (([f"{form}, Forced"], self.read_switch) for form in self.output_forms()[:1])
        accelerate, turn, *_ = sorted(SETTINGS, key=lambda setting: setting[:6] not in ("AccelS", "AccelR"))
        yield [accelerate], lambda values: self.state(acceleration_mm_s2=ACCELERATION)
        yield [turn], lambda values: self.state(turn_acceleration_deg_s2=TURN_ACCELERATION)
        yield [Spel.trap], self.trap
        yield from super().blocks()

    def use_variable(self, name: str) -> None:
        """Use a counter, or the part to start at."""
        (self.variables if name == "nStart" else self.counters).use(name)

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""
        self.select_tool({"slot": name})

    def use_wait(self) -> None:
        """Read the function that ends the program."""
        self.expect("stop_job", Spel.stop_body)
        self.shut_by.add("stop_job")

    def trap(self, values: Values) -> None:
        """Have the fault routine run at an event."""
        self.read_trap()
        self.shut_by.add(values["event"])

    def read_trap(self) -> None:
        """Read what traps lead to."""
        self.use_wait()
        self.expect("on_fault", Spel.fault_body)

    def read_watch(self, values: Values) -> None:
        """Begin to watch an input."""
        self.read_trap()
        if values["index"] in self.traps:
            raise ProgramError(f"trap {values['index']} is set twice.")
        self.traps.add(values["index"])
        super().read_watch(values)

    def move(self, values: Values) -> None:
        """Move in a line."""
        pose, turns, passes = self.pose_of(values["point"]), "turns" in values, "passes" in values
        self.state(zone=float(passes), turn_deg_s=self.modal["turn"] if turns else None)
        outputs = values.get("outputs", "").split("; ")
        signals = tuple(
            ReadSignal(*self.output_of(output), float(place.removeprefix("D")) / 100.0, 0.0)
            for place, output in zip(outputs[::2], outputs[1::2], strict=False)
        )
        self.line(pose, not passes, 0.0 if turns else self.modal["speed"], signals)

    def place_of(self, point: str) -> Pose:
        """Read a pose, and use the local of a point."""
        frame, _, local = point.partition(" /")
        if local:
            self.use_board(self.slots.use(("board", local)))
        return read_pose(frame[3:-1].split(", "), from_moving_zyx)


DIALECT = Dialect(
    title="Epson SPEL+",
    notes="For RC+ 7 and 8; outputs as !Dn; On n! with each move. Tool and Local are set at the start; AccelS and "
    "AccelR are assumed, put the robot's own there. Analog outputs need the option board (AIO_Out).",
    capability=Capability(
        controller_class=2,
        timing="percent",
        cycle_s=0.002,  # assumed
        step_percent=1.0,
        most_events=16,  # Dn may appear 16 times in one statement (SPEL+ reference for RC800)
        step_mm_s=0.1,
    ),
    form=FileForm(".prg"),
    longest_line=240,  # RC+ takes more; assumed
    most_steps=1500,  # of a file; assumed
    write=Spel.write,
    rebuild=SpelReader.rebuild,
    controller=replace(
        ARM,
        blending="overlap",
        turn_acceleration_deg_s2=1000.0,
        most_lines=20_000,
        sources={
            "acceleration_mm_s2": "AccelS of the program's text",
            "turn_acceleration_deg_s2": "AccelR of the program's text",
        },
    ),
    maker="epson",
)
