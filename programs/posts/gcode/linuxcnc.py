"""G-code for LinuxCNC: a gantry's axes from its joint motion, outputs in step with the motion by ``M62`` to ``M67``.

The machine has trivial kinematics: each axis is a joint. The orifice follows its line because blocks are short enough,
and keeps its speed because a block takes the time that the orifice needs: where only X, Y and Z move that is ``F`` in
mm/min, else inverse time (``G93``), whatever the turning axes do to the length of the way.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.installation import Channel
from programs.motion.lower import Capability
from programs.motion.steps import Line, Step, UseBoard, UseTool
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.gcode.axes import BLEND_MM, SPOT_LINE, AxisReader, AxisSyntax
from programs.posts.layout import Layout, words_of
from programs.posts.reading.execution import Block, Values, differing, located, skip, statements_of
from programs.posts.rebuilt import ReadLine, ReadPart
from programs.posts.writing.axes import one_row
from programs.posts.writing.chapters import Placed
from programs.posts.writing.driver import Routine
from programs.posts.writing.forms import fill, short
from programs.posts.writing.vocabulary import LINUXCNC
from programs.posts.writing.wording import cut, join_lines
from programs.timing.controller import Controller

GROUP_BASE = 32
"""Groups are whole numbers on the analog outputs from this one on: LinuxCNC has no groups."""
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")
_MOST_OUTPUTS = 64
_AT_ONCE = ("M64 ", "M65 ", "M68 ")
_FIRST_WORD = 100
"""O-words of loops are numbered from the next."""
WATCHDOG = (
    "loadrt watchdog num_inputs=1",
    "addf watchdog.set-timeouts servo-thread",
    "addf watchdog.process servo-thread",
    "loadusr -W ./task_alive.py",
    "setp watchdog.timeout-0 0.5",
    "net task-beat task_alive.beat => watchdog.input-0",
    "setp watchdog.enable-in 1",
    "net task-lives watchdog.ok-out => motion.enable",
)
"""HAL lines that stop the machine where the task controller is gone; ``task_alive.py`` is in docs/robot-programs.md."""


class GCode(AxisSyntax):
    """G-code of LinuxCNC: subroutines of blocks in the machine's axes."""

    systems = SYSTEMS
    controller_name = "LinuxCNC"
    call_form = "o<{routine}> call"
    pause_form = "G4 P{seconds:3}"
    feed_form = "{path}{feed_mode}G1 {axes} F{feed}"
    path_words = (f"G64 P{BLEND_MM:g} Q0", "G61.1")
    routine_form = ("o<{routine}> sub", "o<{routine}> endsub")
    digital_forms = (("M65 P{number}", "M64 P{number}"), ("M63 P{number}", "M62 P{number}"))
    analog_forms = ("M68 E{number} Q{value}", "M67 E{number} Q{value}")
    """At once, and with the next motion."""
    settle_form = "G4 P0.001"
    """Before what is set at once: the task controller may run ahead of the last motion, and waits for its end here."""
    hold_forms = ("(MSG, {mount})", "M0")
    modes = ("G21 G90 G17 G40 G49 G80",)
    zero_form = "G10 L2 P{number} {zero} R0"
    last = ("M2",)
    vocabulary, names_parts_by_program = LINUXCNC, True
    name_case = "lower"  # as files of subroutines are looked up
    contact_form, sensor_form = "motion.digital-in-{number:02d}", "motion.analog-in-{number:02d}"
    start = "#<_start>"
    start_words = "write its number into the block {start} = 1"
    watch_note = ": to be wired"
    part_form = ("o{label} if [{start} LE {number}]", "  {call}", "o{label} endif")
    enter_begin = ("o90 if [{start} EQ {number}]", "  {start} = 1")
    enter_end = ("o90 endif",)
    guard = ("M49",)
    shared = "shut_valves.ngc, the same in each; G54 and up are set at each start"
    states = ("L4", "L3")
    counter = "#<loop{number}>"
    first_counter = _FIRST_WORD + 1
    loop_label = _FIRST_WORD
    loop_text = "until {key} >= {least}: {count} times at most"
    comments_counting = False
    loop_begin = ("o{label} repeat [{count}]",)
    loop_end = ("o{label} endrepeat",)
    sensed_begin = ("{counter} = 0", "o{label} do", "  {counter} = [{counter} + 1]")
    sensed_end = (
        "  M66 E{input} L0",
        "o{label} while [[{counter} LT {count}] AND [[{reading}] LT {least}]]",
    )
    reading = "{scale} * #5399 + {offset}"
    wait_contact = (
        "M66 P{input} {state} Q{seconds}",
        "o{label} if [#5399 LT 0]",
        "  {fault}",
        "  (ABORT,{message})",
        "o{label} endif",
    )
    await_forms = ("o{label} do", "  M66 P{input} {state} Q60", "o{label} while [#5399 LT 0]")
    fault_form = "M64 P{fault}"
    wait_sensor = (
        "#<waited> = 0",
        "o{label} do",
        "  G4 P0.1",
        "  #<waited> = [#<waited> + 1]",
        "  M66 E{input} L0",
        "o{label} while [[#<waited> LT {tenths}] AND [[{reading}] LT {least}]]",
        "o{label}1 if [[{reading}] LT {least}]",
        "  {fault}",
        "  (ABORT,{message})",
        "o{label}1 endif",
    )

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment, and none that is taken for (MSG,...) or (ABORT,...)."""
        inside = cut(text, longest or self.longest_comment).replace("(", "[").replace(")", "]")
        return "(" + re.sub(r"^( *[A-Za-z]+ *),", r"\1;", inside) + ")"

    def statements(self, step: Step, placed: Placed) -> Iterator[str]:
        """Write one step; what is set at once waits for the end of the motion before."""
        for text in super().statements(step, placed):
            if text.startswith(_AT_ONCE):
                yield from self.set("settled", self.settle_form)
            else:
                self.settings.pop("settled", None)
            yield text

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block with the modes that change."""
        mode, feed = self.feed(line, share, turns=turns)
        path, mode = self.path(stops), "".join(f"{word} " for word in self.set("feed", mode))
        yield fill(self.feed_form, path=path, feed_mode=mode, axes=words, feed=feed)

    def feed(self, line: Line, share: float, *, turns: bool) -> tuple[str, str]:
        """Give the feed mode and ``F`` of a block that does this share of a line."""
        if self.machine is not None or (line.speed_mm_s > 0.0 and self.slides and not turns):
            return "G94", self.tool_point_feed(line)
        whole_s = line.duration_s
        if line.speed_mm_s > 0.0:
            whole_s = line.length_mm / line.speed_mm_s
        elif line.turn_rad_s > 0.0:
            whole_s = line.angle_rad / line.turn_rad_s
        return "G93", short(60.0 / (share * whole_s), 4)

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Change the tool, or select the coordinate system of a placement."""
        if isinstance(step, UseTool):
            yield self.change_form.format(tool=step.number)
            return
        system, self.offset = self.offsets[step.placement]
        self.written = ()
        yield system

    def output(self, channel: Channel, value: float, when: str = "immediate") -> str:
        """Set an output with the next motion, or at once."""
        number = _number(channel)
        if not 0 <= number < _MOST_OUTPUTS:
            raise ProgramError(
                f"{channel.name} is {channel.kind} output {channel.number}; LinuxCNC has P0 to P63 and E0 to E63, "
                f"of which groups take E{GROUP_BASE} and up. Give it another number in the cell."
            )
        if channel.kind == "digital":
            return fill(self.digital_forms[when != "immediate"][value > 0.5], number=number)
        return fill(self.analog_forms[when != "immediate"], number=number, value=short(value, 6))

    def zero_note(self) -> str:
        """Describe the zero of a coordinate system."""
        return super().zero_note() if self.slides else "joint zero"

    def rise(self) -> list[str]:
        """Raise Z to that of home before any other axis moves, where no line is higher."""
        if self.rising_z() is None:
            return []
        (block,) = self.home()
        self.written = ()
        return [self.home_form.format(axes=next(word for word in block.split() if word[0] == "Z"))]

    def home(self) -> Iterator[str]:
        """Go home in machine coordinates."""
        if self.installation.home:
            self.offset, self.written = (), ()
            home = self.installation.home
            axes = self.axes(home if self.machine is None else one_row(self.machine, home))
            yield self.home_form.format(axes=axes)

    def remarks(self) -> Iterator[str]:
        """Describe the words of a block."""
        yield from self.axis_lines()
        if self.machine is None:
            speed = "G94 F: mm/min of the orifice; G93 F: 1/min of the block where turning axes move"
            yield f"Joint values; each tool's offset is in them. {speed}"
        else:
            pivot = f"pivot-length {short(self.machine.pivot_mm, 4)} with every tool, W at 0, G49"
            yield f"Tool points: KINEMATICS = 5axiskins; {pivot}"
            yield "Machine zero: X Y Z of the cell's joints where B is 0. F: mm/min of the orifice, deg/min on the spot"
            yield from self.sign_lines()
            yield SPOT_LINE

    def address(self, channel: Channel) -> str:
        """Give the HAL pin of an output."""
        pin = f"motion.{'digital' if channel.kind == 'digital' else 'analog'}-out-{_number(channel):02d}"
        return pin + (" (a whole number)" if channel.kind == "group" else "")

    def setup(self) -> Iterator[Task]:
        """State what HAL and INI have to do, as G-code has no interrupts."""
        pins = [each.address.split()[0] for each in self.signal_table()]
        most = {kind: [int(pin[-2:]) for pin in pins if f".{kind}-" in pin] for kind in ("digital", "analog")}
        counts = (
            f"{word}={max(most[kind], default=0) + 1}" for word, kind in (("num_dio", "digital"), ("num_aio", "analog"))
        )
        yield Task(f"HAL: motmod {' '.join(counts)}, or more; the INI's axes as the words of the blocks")
        call = f"ON_ABORT_COMMAND = O <{self.shut_name}> call"
        text = f"INI: {call}, or an abort leaves the valves as they are; {self.shut_name}.ngc in SUBROUTINE_PATH"
        yield Task(text, ("[RS274NGC]", call, "SUBROUTINE_PATH = folder of these files"))
        gates = {f"valve-{channel.number}": self.address(channel) for channel in self.valves}
        text = (
            "HAL: and2 of each valve's pin with motion.motion-enabled, for an emergency stop; the valve is on its out"
        )
        lines = [f"loadrt and2 names={','.join(gates)}", *(f"addf {gate} servo-thread" for gate in gates)]
        lines += [f"net may-spray motion.motion-enabled => {' '.join(f'{gate}.in1' for gate in gates)}"]
        yield Task(text, (*lines, *(f"net {gate}-signal {pin} => {gate}.in0" for gate, pin in gates.items())))
        text = "HAL: a watchdog of milltask to motion.enable, for the case that it is killed: docs/robot-programs.md"
        yield Task(text, WATCHDOG)
        stop = "HAL: to halui.program.stop when it leaves its state, what is watched"
        yield from self.watch_tasks(stop, "{name}, motion.digital-in-{input:02d}: {words}")

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file, or a file for each subroutine and one that calls them; what shuts the valves has its own."""
        named = {self.shut_name: self.shut(), **{each.name: each.body for each in routines}}
        bodies = {name: [f"o<{name}> sub", *body, f"o<{name}> endsub", ""] for name, body in named.items()}
        inside = [line for each in routines for line in bodies.pop(each.name)] if self.fits_one_file else []
        files = {f"{self.name}.ngc": join_lines([*self.heading(), *inside, *main.body])}
        return files | {f"{name}.ngc": join_lines([*body, "M2"]) for name, body in bodies.items()}


def _number(channel: Channel) -> int:
    """Number of an output among the digital or the analog ones."""
    return channel.number + (GROUP_BASE if channel.kind == "group" else 0)


_MAIN = "(main)"


class GCodeReader(AxisReader):
    """Subroutines, coordinate systems, and the modes of the machine."""

    syntax = GCode
    texts: ClassVar[Mapping[str, str]] = {"feed_mode": "(?:G9[34] )?", "part": r"o\d+"}

    def __init__(self) -> None:
        super().__init__()
        self.inverse = False
        self.conditions: list[str] = []
        """Ends of the parts that run and have other statements than their calls."""

    def load(self, files: ProgramFiles) -> str:
        """Keep the subroutines; what else the first file holds is the program."""
        for file in files:
            blocks = (
                line
                for line in statements_of(file, files[file])
                if line.startswith(("(ABORT,", "(MSG,"))
                or not (line.startswith(";") or (line.startswith("(") and line.endswith(")")))
            )
            outside = list(self.sort(blocks, GCode.routine_form))
            if _MAIN not in self.routines:
                self.routines[_MAIN] = outside
            elif outside != ["M2"]:
                raise located("a subroutine's file holds more than the subroutine.", differing(outside, ["M2"]))
        return _MAIN

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        for before in ((), (GCode.settle_form,)):
            for off, on in GCode.digital_forms:
                yield [*before, off], lambda values: self.switch(f"digital {values['number']}", 0.0)
                yield [*before, on], lambda values: self.switch(f"digital {values['number']}", 1.0)
            yield from (([*before, form], self.set_analog) for form in GCode.analog_forms)
        yield ["{part} if [#<_start> LE {number}]"], self.begin_part
        yield ["{part} endif"], self.end_part
        yield [GCode.last[0]], skip
        yield from super().blocks()

    def begin_part(self, values: Values) -> None:
        """Begin a part that has other statements than its call, unless the start is at a later one."""
        self.parts.append(ReadPart(int(values["number"]), len(self.steps)))
        if self.start <= int(values["number"]):
            self.conditions.append(values["part"])
        else:
            self.at = self.pass_to(f"{values['part']} endif")

    def end_part(self, values: Values) -> None:
        """End such a part.

        Raises:
            ProgramError: it is not the innermost.
        """
        if not self.conditions or self.conditions.pop() != values["part"]:
            raise ProgramError(f"{values['part']} ends another condition than the innermost.")

    def feed(self, values: Values) -> None:
        """Move in a straight line of the axes, in inverse time too."""
        self.inverse = values["feed_mode"] == "G93 " if values["feed_mode"] else self.inverse
        super().feed(values)
        line = self.steps[-1]
        if self.inverse and isinstance(line, ReadLine):
            duration_s = 60.0 / float(values["feed"])
            self.steps[-1] = replace(line, speed_mm_s=None, turn_deg_s=None, duration_s=duration_s)

    def set_analog(self, values: Values) -> None:
        """Set an analog output, or a group."""
        number = int(values["number"])
        channel = f"group {number - GROUP_BASE}" if number >= GROUP_BASE else f"analog {number}"
        self.switch(channel, float(values["value"]))


DIALECT = Dialect(
    title="LinuxCNC G-code",
    notes="For gantries with trivial kinematics, where joint values are the axes, or 5axiskins, where tool points are: "
    "the cell's kinematics states which. No tool lengths are used (G49); G54 is the work's origin. The header lists "
    "the outputs to wire; num_dio and num_aio may be few.",
    capability=Capability(
        least_part_s=0.0,  # jets at their places come before blocks of 20 ms
        controller_class=3,
        changes_tools=True,
        timing="boundary",
        cycle_s=0.001,  # the servo thread of the sample configurations
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # a block of 40 ms before a stop would slow others down; its own ramp is not the plan's
    ),
    layout=Layout(
        "; (", equals=" = ", single_blanks=True, leading_zero=True, words=words_of(GCode, "AND"), addresses="o"
    ),
    form=FileForm(".ngc", several=(".ngc",)),
    longest_line=200,  # the interpreter takes 255 characters (LINELEN)
    most_steps=5000,  # of a subroutine; assumed, for previews: the interpreter itself reads from disk, line by line
    write=GCode.write,
    rebuild=GCodeReader.rebuild,
    controller=Controller(
        blending="tolerance",
        look_ahead=50,
        least_line_s=0.001,
        blend_acceleration_share=0.5,
        stops_in_turning_line=True,
        sources={
            "look_ahead": "ARC_BLEND_OPTIMIZATION_DEPTH of the INI file, 50",
            "least_line_s": "SERVO_PERIOD, 1 ms",
            "blend_acceleration_share": "tp.c: parabolic blends have half the acceleration",
            "stops_in_turning_line": "tp.c: no look-ahead over lines with turning axes",
        },
    ),
    needs_joints=True,
    takes_axes=True,
)
