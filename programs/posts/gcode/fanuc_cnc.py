"""G-code for FANUC's CNC 30i: tool points under G43.4, outputs by M codes in the block with which they change."""

import re
from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Installation, Sensor, Wait
from programs.motion.lower import Capability, Lowered
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.gcode.tool_points import MCodeReader, MCodeSyntax
from programs.posts.layout import Layout
from programs.posts.reading.execution import Block, Values, located, refusal, skip, statements_of
from programs.posts.writing.driver import Routine
from programs.posts.writing.vocabulary import FANUC_CNC
from programs.posts.writing.wording import cut, join_lines
from programs.timing.controller import Controller

SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59")
OUTPUT_MACRO = 7991
"""Number of the integrator's macro for outputs with a value."""
_MOST_INPUT, _MOST_SENSOR = 31, 99


class FanucCnc(MCodeSyntax):
    """Programs by O-numbers, macro variables, M codes."""

    systems = SYSTEMS
    controller_name = "a FANUC CNC"
    m_base = 200
    value_words = f"A{{}} of macro O{OUTPUT_MACRO}"
    points_on = ("G5.1 Q1", "G43.4 H{tool}")
    points_off = ("G49", "G5.1 Q0")
    call_form = "M98 <{routine}>"
    routine_form = ("<{routine}>", "M99")
    modes = ("G21 G90 G17 G40 G49 G80 G94",)
    hold_forms = ("#3006=1({mount})",)
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
    last = ("#3004=0", "M30")
    vocabulary, names_parts_by_program = FANUC_CNC, True
    name_case = "upper"
    contact_form = sensor_form = "#{number}"
    longest_message = 26
    indents_loops = False
    start = "#100"
    start_words = "write its number into the block {start}=1"
    watch_note = ": to be wired"
    part_form = ("IF[{start}GT{number}]GOTO{label}", "{call}", "N{label}")
    enter_begin = ("IF[{start}NE{number}]GOTO9{number}", "{start}=1")
    enter_end = ("N9{number}",)
    guard = ("#3004=2",)
    shared = f"macro O{OUTPUT_MACRO}; variables; G54 and up are set at each start"
    reading = "[{scale}*#{input}]+{offset}"
    wait_contact = (
        "#3001=0",
        "N{label}",
        "IF[#{input}EQ{state}]GOTO{ready}",
        "IF[#3001LT{ms}]GOTO{label}",
        "{fault}",
        "#3000={index}({message})",
        "N{ready}",
    )
    await_forms = ("N{label}", "IF[#{input}EQ{other}]GOTO{label}")
    wait_sensor = ("#3001=0", "N{label}", "IF[{reading}GE{least}]GOTO{ready}", *wait_contact[3:])

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.shut_name = self.names.give("shut", 0, f"{self.name}_SH")

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment."""
        inside = cut(text, longest or self.longest_comment).replace("(", "[").replace(")", "]")
        return f"({inside.replace(';', ',').replace('%', 'pct')})"  # which end a block and a file

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

    def setup(self) -> Iterator[Task]:
        """State what parameters and ladder have to do."""
        yield Task("parameters: G43.4 alone moves nothing (TOS), G0 interpolates (LRP), G5.1 keeps within 0.05 mm")
        yield Task("M codes of outputs: finished at once (high-speed interface), not buffered where they stand alone")
        yield Task(
            f"O{OUTPUT_MACRO}: your macro, sets output A to value V; the PMC copies analog inputs to #600 and up"
        )
        valves = tuple(f"{self.address(channel)}: {channel.name}" for channel in self.valves)
        yield Task(f"PMC: shut the valves at reset, alarm and emergency stop, as {self.shut_name} does", valves)
        yield from self.watch_tasks("PMC: feed hold, valves shut, when an input leaves its state", "{name}: {words}")

    def remarks(self) -> Iterator[str]:
        """Describe the words of the blocks."""
        return self.legend()

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file of programs."""
        head = self.heading()
        text = ["%", f"<{self.name}>", *head, *main.body]
        for name, body in ((self.shut_name, self.shut()), *((each.name, each.body) for each in routines)):
            text += [f"<{name}>", *body, "M99"]
        return {f"{self.name}.nc": join_lines([*text, "%"])}


class FanucCncReader(MCodeReader):
    """Programs by O-numbers."""

    syntax = FanucCnc

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
            if match := re.fullmatch(r"<(\w+)>", line):
                if match[1] in programs:
                    raise refusal(line, "is there twice")
                current = programs[match[1]] = []
            elif line != "%" and not re.fullmatch(r"\(.*\)|", line):
                current.append(line)
        main = next(iter(programs), "")
        for name, lines in programs.items():
            last = "M30" if name == main else "M99"
            end = lines.pop() if lines else ""
            if end != last:
                raise located(f"{name} does not end with {last}.", end)
        self.routines |= programs
        self.shut_name = next((name for name in programs if name.startswith(f"{main}_SH")), self.shut_name)
        return main

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms; those of the control of contours stand by themselves."""
        contour, points = FanucCnc.points_on
        yield [FanucCnc.last[0]], skip
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
        if not re.fullmatch(rf"\w+_0*{values['number']}(?:_\d+)?", values["routine"]):
            raise ProgramError(f"part {values['number']} calls {values['routine']}.")
        super().read_part(values)


DIALECT = Dialect(
    title="FANUC CNC G-code (30i, G43.4)",
    notes="For a machine with two rotary axes in its head and tool center point control (G43.4). G54 is the work's "
    "origin. Outputs are M codes: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        changes_tools=True,
        timing="boundary",
        cycle_s=0.008,  # assumed: of the ladder that takes the M codes
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
    ),
    layout=Layout("(", equals="=", single_blanks=True, leading_zero=True),
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
