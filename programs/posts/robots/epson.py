"""Epson SPEL+: outputs by parallel processing, at whole percents of a move."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.installation import Installation, Wait
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Line, Reach
from programs.pose import Pose
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.layout import Layout, words_of
from programs.posts.reading.driver import Reader, read_pose
from programs.posts.reading.execution import Block, Values, refusal, statements_of
from programs.posts.rebuilt import Due, ReadSignal
from programs.posts.writing.angles import from_moving_zyx, moving_zyx
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Placed, degrees_per_s
from programs.posts.writing.driver import Routine, Syntax
from programs.posts.writing.forms import POSE, fill
from programs.posts.writing.handover import channels_of
from programs.posts.writing.vocabulary import SPEL
from programs.posts.writing.wording import join_lines, pose_words
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
    mount_forms = ('Print "Washboard: {mount}"', "Pause")
    modal = ("Speed {percent:0}", "SpeedS {speed:1}", "SpeedR {turn:1}")
    digital = "{value} {number}"
    group = "Out {number}, {value}"
    analog = "AIO_Out {number}, {value}"
    address_forms = ("output bit {number}", "output port {number}", "analog output {number}")
    contact_form, sensor_form = "input bit {number}", "analog input {number}"
    angles = ("U V W", "degrees about z, y', x''", moving_zyx)
    off_on = ("Off", "On")
    select_tool = ("Tool {slot}",)
    payload_forms = ("Weight {mass:~3}",)
    set_tool = "TLSet {slot}, {frame}"
    set_board = "Local {slot}, {frame}"
    most_frames = 15
    routine_form = ("Function {routine}{takes_text:(text$ As String)}", "Fend")
    move = "Move {point}{turns: ROT}{passes: CP}{parallel: !{outputs}!}"
    parallel = "D{percent:0}; {output}"
    trap = "Trap {event} Xqt on_fault"
    stop_body = ("{fault}", "Call shut_valves", 'Print "Washboard: ", text$', "Quit All")
    fault_body = ("{fault}", "Call shut_valves", 'Print "Washboard: fault, valves shut"', "Quit All")
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
    shared = "main, shut_valves, stop_job, on_fault, nStart: each program has a project of its own"
    last = ("Trap Error", "Trap Emergency", "Trap Abort")
    end_watch = ("Trap {index}",)
    await_contact = ("Wait Sw({input}) = {state}",)
    vocabulary, names_parts_by_program = SPEL, True
    longest_title = 29
    begin = SETTINGS

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.flags = ""
        """How the arm stands at the point to come; empty where the joints are not known."""

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write ``Move`` with its outputs, which the controller takes in the order of their percents."""
        self.flags = arm_flags(line.joints, self.installation)
        turns = line.turns_on_the_spot
        yield from self.set_modal(turn=degrees_per_s(line)) if turns else self.set_modal(speed=line.speed_mm_s)
        outputs = "; ".join(
            fill(self.parallel, percent=round(100.0 * event.share), output=self.output(event.channel, event.value))
            for event in line.events
        )
        words = {"turns": turns, "passes": line.blend_mm > 0.0, "parallel": outputs, "outputs": outputs}
        yield fill(self.move, point=self.point(line.target), **words)

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write ``Go``, and the ``Move`` that is left."""
        self.flags = arm_flags(reach.joints, self.installation)
        yield from super().reach(reach)

    def point(self, pose: Pose) -> str:
        """Write a point on the board, with how the arm stands there."""
        return f"{self.frame(pose)}{self.flags} /{self.slots.board}"

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
        if forms in (self.watch, self.end_watch):
            index = 1 + [each.name for each in self.installation.waits if each.watched].index(wait.name)
            if index > MOST_TRAPS:
                raise ProgramError(f"io.waits.{wait.name}: SPEL+ watches {MOST_TRAPS} inputs at most; watch fewer.")
        return super().wait_lines(forms, index, wait)

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up."""
        text = "preferences: outputs off at an emergency stop; a background task shuts the valves while no task runs"
        yield Task(text, tuple(self.shut()))
        yield Task("AccelS and AccelR of this arm in main")
        if any(each.kind == "analog" for each in channels_of(self.motion)):
            yield Task("the option for analog I/O")

    def remarks(self) -> Iterator[str]:
        """State what the program uses."""
        yield "Trap numbers below 5 are used; nStart, the part to start at, is kept when the controller is switched off"

    def faults(self) -> list[str]:
        """Write the functions that shut the valves."""
        stop = self.whole("stop_job", self.with_fault(self.stop_body), takes_text=True)
        return [
            *self.whole(self.shut_name, self.shut()),
            *stop,
            *self.whole("on_fault", self.with_fault(self.fault_body)),
        ]

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each function and one with main."""
        units = f"Units: mm, mm/s, deg/s; points in {self.cad_frame} (Local), U V W about z, y', x''."
        head = self.heading(units)
        texts = {each.name: self.whole(each.name, each.body) for each in routines}
        start = [*head, "Global Preserve Integer nStart", "", *self.whole("main", main.body), *self.faults()]
        if self.fits_one_file:
            return {f"{self.name}.prg": join_lines([*start, *(line for text in texts.values() for line in text)])}
        return {f"{each}.prg": join_lines(text) for each, text in {self.name: start, **texts}.items()}


def arm_flags(joints: tuple[float, ...], installation: Installation) -> str:
    """Write hand, elbow and wrist of an arm, and the turns of J4 and J6; nothing for joints that are not known.

    Where J5 is not positive, as with the tool down, the wrist is not flipped: assumed.
    """
    if installation.joint_kinds(len(joints)) != ["revolute"] * 6 or not joints:
        return ""
    branch, counted = installation.branch(joints), as_controller_counts(joints, installation)
    hand, elbow = "R" if branch.is_front else "L", "A" if branch.is_above else "B"
    fourth, fifth, sixth = counted[3:6]
    beyond = int(not -180.0 < fourth <= 180.0)
    turns = math.ceil(sixth / 180.0) - 1 if sixth > 0.0 else math.floor(-sixth / 180.0)
    return f" /{hand} /{elbow} /{'F' if fifth > 0.0 else 'NF'} /J4F{beyond} /J6F{turns}"


_XY = rf"XY\({POSE}\)"
_FLAGS = r"(?: /[RL] /[AB] /N?F /J4F[01] /J6F\d)"


class SpelReader(Reader):
    """Functions, tools and locals."""

    syntax = Spel
    handlers = frozenset({"main", "stop_job", "Error", "Emergency", "Abort"})
    texts: ClassVar[Mapping[str, str]] = {
        **{"outputs": r"D\d+; [^;]*(?:; D\d+; [^;]*)*", "event": "Error|Emergency|Abort"},
        **{"index": f"[1-{MOST_TRAPS}]", "frame": _XY, "point": rf"{_XY}{_FLAGS}? /\d+"},
    }

    def __init__(self) -> None:
        super().__init__()
        self.variables = self.declares("variable")

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give 1 for ``CP``, and the rate of a turn on the spot."""
        return Due(1.0, degrees_per_s(line) if line.turns_on_the_spot else None)

    @classmethod
    def arm_due(cls, joints: tuple[float, ...], installation: Installation) -> str | None:
        """Give the flags of the arm at joints."""
        return arm_flags(joints, installation)

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
        yield [*Spel.last], lambda values: self.acting.difference_update(("Error", "Emergency", "Abort"))
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
        self.acting.add(values["event"])

    def read_trap(self) -> None:
        """Read what traps lead to."""
        self.use_wait()
        self.expect("on_fault", Spel.fault_body)

    def read_watch(self, values: Values) -> None:
        """Begin to watch an input."""
        self.read_trap()
        if values["index"] in self.acting:
            raise ProgramError(f"trap {values['index']} is set twice.")
        super().read_watch(values)

    def move(self, values: Values) -> None:
        """Move in a line.

        Raises:
            ProgramError: its accelerations are not set.
        """
        if self.terms.acceleration_mm_s2 is None or self.terms.turn_acceleration_deg_s2 is None:
            raise ProgramError("the robot moves before AccelS and AccelR are set.")
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
        frame, *flags, local = point.split(" /")
        self.use_board(self.slots.use(("board", local)))
        self.flags = "".join(f" /{each}" for each in flags)
        return self.frame_pose(frame)

    def frame_pose(self, frame: str) -> Pose:
        """Read a pose without flags."""
        return read_pose(frame[3:-1].split(", "), from_moving_zyx)

    def set_slot(self, kind: str, values: Values) -> None:
        """Set the frame of a slot."""
        self.slots.add((kind, values["slot"]), self.frame_pose(values["frame"]), self.statement)


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
    layout=Layout(
        "'",
        comma=", ",
        equals=" = ",
        single_blanks=True,
        leading_zero=True,
        powers=True,
        words=words_of(Spel, "As CP Z Forced Global Preserve String XY A F NF L R J4F0 J4F1 J6F0 J6F1"),
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
