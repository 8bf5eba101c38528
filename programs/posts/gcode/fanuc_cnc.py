"""G-code for FANUC's CNC 30i: tool points under G43.4, outputs by M codes in the block with which they change."""

import re
from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Sensor, Wait
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm, ProgramFiles
from programs.posts.gcode.tool_points import MCodeReader, MCodeSyntax
from programs.posts.reading.execution import Block, Values, statements_of
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.driver import Routine
from programs.posts.writing.wording import cut, join_lines
from programs.timing.controller import Controller

SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59")
MAIN, SHUT, OUTPUT_MACRO = 7000, 7990, 7991
"""Program numbers: main, its parts after it; what shuts the valves; the integrator's macro for outputs with a value."""
_MOST_INPUT, _MOST_SENSOR = 31, 99


class FanucCnc(MCodeSyntax):
    """Programs by O-numbers, macro variables, M codes."""

    systems = SYSTEMS
    controller_name = "a FANUC CNC"
    m_base = 200
    value_words = f"A{{}} of macro O{OUTPUT_MACRO}"
    points_on = ("G5.1 Q1", "G43.4 H{tool}")
    points_off = ("G49", "G5.1 Q0")
    call_form = "M98 P{routine}"
    their_call_form = "M98 <{routine}>"
    modes = ("G21 G90 G17 G40 G49 G80 G94",)
    zero_form = "G10 L2 P{number} {zero}"
    value_form = f"G65 P{OUTPUT_MACRO} A{{output}} V{{value}}"
    brackets = "[]"
    contact_base, sensor_base = 1000, 600
    counter = "#{number}"
    first_counter = 111
    comments_counting = False
    loop_begin = ("{counter}=0", "N{label}", "{counter}={counter}+1")
    loop_end = ("IF[{condition}]GOTO{label}",)
    counted = "{counter}LT{count}"
    sensed = "[{counter}LT{count}]AND[[{reading}]LT{least}]"
    pause_form = "G4 X{seconds:3}"
    feed_form = "{has_codes:{codes} }{path}G1 {axes} F{feed}"
    path_words = ("G64", "G61")
    last = ("M30",)
    longest_name = 30
    name_case = "upper"
    contact_form = sensor_form = "#{number}"
    longest_message = 26
    indents_loops = False
    start = "#100"
    start_words = "write its number into the block {start}=1"
    watch_note = ": to be wired, see below"
    shut_name = str(SHUT)
    part_form = ("IF[{start}GT{number}]GOTO{label}", "{call}", "N{label}")
    enter_begin = ("IF[{start}NE{number}]GOTO9{number}", "{start}=1")
    enter_end = ("N9{number}",)
    guard = ("#3004=2",)
    reading = "[{scale}*#{input}]+{offset}"
    wait_contact = (
        "#3001=0",
        "N{label}",
        "IF[#{input}EQ{state}]GOTO{ready}",
        "IF[#3001LT{ms}]GOTO{label}",
        "#3000={index}({message})",
        "N{ready}",
    )
    wait_sensor = ("#3001=0", "N{label}", "IF[{reading}GE{least}]GOTO{ready}", *wait_contact[3:])

    def routine_name(self, chapter: Chapter) -> str:
        """Give the number of a part's program."""
        return str(MAIN + chapter.number)

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment."""
        return "(" + cut(text, longest or self.longest_comment).replace("(", "[").replace(")", "]") + ")"

    def quantity(self, sensor: Sensor) -> str:
        """Write the quantity that the PMC leaves in a variable."""
        if not 0 <= sensor.number <= _MOST_SENSOR:
            raise ProgramError(f"{sensor.name} is analog input {sensor.number}; variables are assigned to 0 to 99.")
        return super().quantity(sensor)

    def wait_lines(self, forms: Sequence[str], index: int, wait: Wait) -> list[str]:
        """Fill in the forms of a wait; digital inputs are #1000 and up."""
        if wait.contact is not None and not 0 <= wait.contact.number <= _MOST_INPUT:
            raise ProgramError(f"{wait.contact.name} is input {wait.contact.number}; macros read 0 to {_MOST_INPUT}.")
        return super().wait_lines(forms, index, wait)

    def setup(self) -> Iterator[str]:
        """State what parameters and ladder have to do."""
        yield "parameters: G43.4 alone moves nothing (TOS), G0 interpolates (LRP), G5.1 keeps within 0.05 mm"
        yield "M codes of outputs: finished at once (high-speed interface), not buffered where they stand alone"
        yield f"O{OUTPUT_MACRO}: your macro, sets output A to value V; the PMC copies analog inputs to #600 and up"
        yield f"PMC: shut the valves at reset, alarm and emergency stop, as O{SHUT} does"
        yield from self.watched_lines("PMC: feed hold, valves shut, when {name} leaves its state: {words}")

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file of programs."""
        head = self.heading(*self.legend())
        text = ["%", f"O{MAIN}{self.comment(self.name)}", *head, *main.body]
        for name, body in ((str(SHUT), self.shut()), *((each.name, each.body) for each in routines)):
            text += [f"O{name}", *body, "M99"]
        return {f"{self.name}.nc": join_lines([*text, "%"])}


class FanucCncReader(MCodeReader):
    """Programs by O-numbers."""

    syntax = FanucCnc
    shut_name = str(SHUT)

    def __init__(self) -> None:
        super().__init__()
        self.mounted = ""
        """Number of the tool in the spindle."""
        self.contour_control = False

    def load(self, files: ProgramFiles) -> str:
        """Sort the programs.

        Raises:
            ProgramError: the file has no program, or one does not end.
        """
        ((file, text),) = files.items()
        programs: dict[str, list[str]] = {}
        current: list[str] = []
        for line in statements_of(file, text):
            if match := re.fullmatch(r"O(\d+)(?:\(.*\))?", line):
                if match[1] in programs:
                    raise ProgramError(f"O{match[1]} is there twice.")
                current = programs[match[1]] = []
            elif line != "%" and not re.fullmatch(r"\(.*\)|", line):
                current.append(line)
        for name, lines in programs.items():
            last = "M30" if name == str(MAIN) else "M99"
            if not lines or lines.pop() != last:
                raise ProgramError(f"O{name} does not end with {last}.")
        self.routines |= programs
        return str(MAIN)

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms; those of the control of contours stand by themselves."""
        contour, points = FanucCnc.points_on
        yield [contour], lambda values: self.control(True)
        yield [points], self.take_points
        yield [FanucCnc.points_off[0]], self.take_axes
        yield [FanucCnc.points_off[1]], lambda values: self.control(False)
        yield from (each for each in super().blocks() if each[0] not in (FanucCnc.points_on, FanucCnc.points_off))

    def take_points(self, values: Values) -> None:
        """Take tool points with the length of the tool that is in the spindle.

        Raises:
            ProgramError: another tool is.
        """
        if values["tool"] != self.mounted or not self.contour_control:
            raise ProgramError("tool points need the length of the tool in the spindle, and G5.1 Q1 before.")
        super().take_points(values)

    def control(self, contours: bool) -> None:
        """Begin or end the control of contours."""
        self.contour_control = contours

    def change_tool(self, values: Values) -> None:
        """Change the tool."""
        super().change_tool(values)
        self.mounted = values["tool"]

    def read_part(self, values: Values) -> None:
        """Do a part of main.

        Raises:
            ProgramError: it calls another one.
        """
        if int(values["routine"]) != MAIN + int(values["number"]):
            raise ProgramError(f"part {values['number']} calls O{values['routine']}.")
        super().read_part(values)


DIALECT = Dialect(
    title="FANUC CNC G-code (30i, G43.4)",
    notes="For a machine with two rotary axes in its head and tool center point control (G43.4). G54 is the board's "
    "origin. Outputs are M codes: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        timing="boundary",
        cycle_s=0.008,  # assumed: of the ladder that takes the M codes
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
    ),
    form=FileForm(".nc"),
    longest_line=200,
    most_steps=5000,  # of one program; assumed
    write=FanucCnc.write,
    rebuild=FanucCncReader.rebuild,
    controller=Controller(blending="tolerance", rise_s=0.05, look_ahead=200, least_line_s=0.001),
    needs_joints=True,
    takes_axes=True,
    needs_tool_points=True,
)
