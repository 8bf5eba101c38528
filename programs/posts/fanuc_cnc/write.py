"""G-code for FANUC's CNC 30i: tool points under G43.4, outputs by M codes in the block with which they change."""

from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Sensor, Wait
from programs.motion.steps import Line
from programs.posts.dialect import ProgramFiles
from programs.posts.writing.blocks import MCodeSyntax
from programs.posts.writing.chapters import Chapter
from programs.posts.writing.driver import Routine
from programs.posts.writing.naming import Names
from programs.posts.writing.wording import cut, join_lines, short

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
    zero_form = "G10 L2 P{number} {axes}"
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
    pause_form = "G4 X{seconds}"
    last = ("M30",)
    longest_name = 30
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

    def make_names(self) -> Names:
        """Name the integrator's programs in capital letters."""
        return Names(self.longest_name, {self.name.lower()}, str.upper)

    def routine_name(self, chapter: Chapter) -> str:
        """Give the number of a part's program."""
        return str(MAIN + chapter.number)

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment."""
        return "(" + cut(text, longest or self.longest_comment).replace("(", "[").replace(")", "]") + ")"

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block with the modes that change."""
        mode = self.mode("path", "G61" if stops else "G64")
        yield " ".join([*self.take_codes(), *mode, "G1", words, f"F{self.tool_point_feed(line)}"])

    def send(self, number: int, value: float) -> str:
        """Set an output by the integrator's macro."""
        return self.value_form.format(output=number, value=short(value, 6))

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

    def contact_words(self, number: int) -> str:
        """Give the variable of a digital input."""
        return f"#{1000 + number}"

    def sensor_words(self, number: int) -> str:
        """Give the variable of an analog input."""
        return f"#{600 + number}"

    def setup(self) -> Iterator[str]:
        """State what parameters and ladder have to do."""
        yield "parameters: G43.4 alone moves nothing (TOS), G0 interpolates (LRP), G5.1 keeps within 0.05 mm"
        yield "M codes of outputs: finished at once (high-speed interface), not buffered where they stand alone"
        yield f"O{OUTPUT_MACRO}: your macro, sets output A to value V; the PMC copies analog inputs to #600 and up"
        yield f"PMC: shut the valves at reset, alarm and emergency stop, as O{SHUT} does"
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                yield f"PMC: feed hold, valves shut, when {wait.contact.name} leaves its state: {wait.words}"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one file of programs."""
        head = self.heading(*self.legend())
        text = ["%", f"O{MAIN}{self.comment(self.name)}", *head, *main.body]
        for name, body in ((str(SHUT), self.shut()), *((each.name, each.body) for each in routines)):
            text += [f"O{name}", *body, "M99"]
        return {f"{self.name}.nc": join_lines([*text, "%"])}
