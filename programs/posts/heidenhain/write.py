"""Klartext for HEIDENHAIN's TNC: tool points under FUNCTION TCPM, outputs by M functions in their block."""

from collections.abc import Iterator, Sequence

from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.blocks import BLEND_MM, MCodeSyntax
from programs.posts.writing.driver import Routine
from programs.posts.writing.naming import Names
from programs.posts.writing.wording import cut, fixed, join_lines, short

STAND = "FN 20: WAIT FOR SYNC"
TOLERANCE = ("CYCL DEF 32.0 TOLERANCE", f"CYCL DEF 32.1 T{BLEND_MM:g}", "CYCL DEF 32.2 HSC-MODE:0 TA0.25")


class Heidenhain(MCodeSyntax):
    """One program of numbered blocks; labels for its parts, Q parameters."""

    systems = tuple(str(number) for number in range(1, 10))
    controller_name = "a HEIDENHAIN TNC"
    m_base = 400
    m_words = "M functions"
    value_words = "FN 19 with {}"
    mark = "; "
    points_on = ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS",)
    points_off = ("FUNCTION RESET TCPM",)
    change_form = "TOOL CALL {tool} Z"
    rapid_form = "L {axes} R0 FMAX"
    home_form = "L {axes} R0 FMAX M91"
    call_form = 'CALL LBL "{routine}"'
    their_call_form = "CALL PGM {routine}"
    pause_forms = ("CYCL DEF 9.0 DWELL TIME", "CYCL DEF 9.1 DWELL {seconds}")
    value_form = "FN 19: PLC=+{output}/{value}"
    modes = TOLERANCE
    zero_form = ""
    counter = "Q{number}"
    first_counter = 71
    comments_counting = False
    loop_begin = ("{counter} = +0", "LBL {label}", "{counter} = {counter} + 1")
    loop_end = ("FN 12: IF +{counter} LT +{count} GOTO LBL {label}",)
    sensed_end = (
        STAND,
        "FN 18: SYSREAD Q61 = ID2000 NR70 IDX{input}",
        "Q61 = {reading}",
        "FN 9: IF +Q61 EQU {least} GOTO LBL {after}",
        "FN 11: IF +Q61 GT {least} GOTO LBL {after}",
        *loop_end,
        "LBL {after}",
    )
    last = ("M30",)
    longest_name = 30
    indents_loops = False
    start = "Q50"
    start_words = "write its number into the block {start} = +1"
    watch_note = ": to be wired, see below"
    part_form = ("FN 11: IF +{start} GT +{number} GOTO LBL {label}", "{call}", "LBL {label}")
    enter_begin = ("FN 10: IF +{start} NE +{number} GOTO LBL 9{number}", "{start} = +1")
    enter_end = ("LBL 9{number}",)
    reading = "{scale} * Q61 + {offset}"
    wait_contact = (
        "Q60 = +0",
        "LBL {label}",
        "CYCL DEF 9.0 DWELL TIME",
        "CYCL DEF 9.1 DWELL 0.1",
        "Q60 = Q60 + 1",
        "FN 18: SYSREAD Q61 = ID2000 NR20 IDX{input}",
        "FN 9: IF +Q61 EQU +{state} GOTO LBL {ready}",
        "FN 12: IF +Q60 LT +{tenths} GOTO LBL {label}",
        "FN 14: ERROR={label} ; {message}",
        "LBL {ready}",
    )
    wait_sensor = (
        *wait_contact[:5],
        "FN 18: SYSREAD Q61 = ID2000 NR70 IDX{input}",
        "Q61 = {reading}",
        "FN 9: IF +Q61 EQU {least} GOTO LBL {ready}",
        "FN 11: IF +Q61 GT {least} GOTO LBL {ready}",
        *wait_contact[7:],
    )

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.name = self.name.upper()

    def make_names(self) -> Names:
        """Name labels and programs in capital letters."""
        return Names(self.longest_name, {self.name.lower(), self.shut_name}, str.upper)

    def word(self, letter: str, value: str) -> str:
        """Write where an axis is, with its sign."""
        return f"{letter}{_signed(value)}"

    def operand(self, value: float, digits: int = 6) -> str:
        """Write a number with its sign."""
        return _signed(short(value, digits))

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block, and wait for its end where the machine stands there."""
        yield " ".join(["L", words, f"F{self.tool_point_feed(line)}", *self.take_codes()])
        if stops:
            yield STAND

    def pause(self, seconds: float) -> Iterator[str]:
        """Hold the pose."""
        yield from (form.format(seconds=fixed(seconds, 3)) for form in self.pause_forms)

    def send(self, number: int, value: float) -> str:
        """Send an output's value to the PLC."""
        return self.value_form.format(output=number, value=self.operand(value))

    def select(self, system: str) -> Iterator[str]:
        """Shift the datum to the board's origin."""
        yield "CYCL DEF 7.0 DATUM SHIFT"
        for number, letter in enumerate("XYZ", start=1):
            yield f"CYCL DEF 7.{number} {self.word(letter, short(self.offset[self.letters.index(letter)], 4))}"

    def contact_words(self, number: int) -> str:
        """Give the operand of the PLC for a digital input."""
        return f"I{number} of the PLC"

    def sensor_words(self, number: int) -> str:
        """Give the operand of the PLC for an analog input."""
        return f"W{number} of the PLC"

    def setup(self) -> Iterator[str]:
        """State what machine parameters and the PLC have to do."""
        yield "active preset: zero of the machine; CYCL DEF 7 shifts it to the board. Cycle 32 lets corners be passed"
        yield "PLC: M functions of outputs act where their block begins; FN 19 sends an output's number and its value"
        yield "PLC: errors of FN 14 with your texts; valves shut at stop, cancel and emergency stop; override at 100"
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                yield f"PLC: NC stop, valves shut, when {wait.contact.name} leaves its state: {wait.words}"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one program: main, then its labels."""
        head = [f"; {cut(line[2:], 190)}" for line in self.heading(*self.legend())]
        text = [f"BEGIN PGM {self.name} MM", *head, *main.body]
        for name, body in ((self.shut_name, self.shut()), *((each.name, each.body) for each in routines)):
            text += [f'LBL "{name}"', *body, "LBL 0"]
        text.append(f"END PGM {self.name} MM")
        return {f"{self.name}.h": join_lines(f"{number} {line}" for number, line in enumerate(text))}


def _signed(number: str) -> str:
    return number if number.startswith("-") else f"+{number}"
