"""Klartext for HEIDENHAIN's TNC: tool points under FUNCTION TCPM, outputs by M functions in their block."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.gcode.axes import BLEND_MM
from programs.posts.gcode.tool_points import MCodeReader, MCodeSyntax
from programs.posts.layout import Layout
from programs.posts.reading.execution import Block, Values, refusal, skip, statements_of
from programs.posts.rebuilt import ReadBoard, ReadLine
from programs.posts.writing.driver import Routine
from programs.posts.writing.forms import NUMBER, fill, short
from programs.posts.writing.frame import WAIT_LABEL
from programs.posts.writing.vocabulary import KLARTEXT
from programs.posts.writing.wording import cut, join_lines
from programs.timing.controller import Controller

STAND = "FN 20: WAIT FOR SYNC"
TOLERANCE = ("CYCL DEF 32.0 TOLERANCE", f"CYCL DEF 32.1 T{BLEND_MM:g}", "CYCL DEF 32.2 HSC-MODE:0 TA0.25")


class Heidenhain(MCodeSyntax):
    """One program of numbered blocks; labels for its parts, Q parameters."""

    systems = tuple(str(number) for number in range(1, 10))
    controller_name = "a HEIDENHAIN TNC"
    routine_form = ('LBL "{routine}"', "LBL 0")
    m_base = 400
    m_words = "M functions"
    value_words = "FN 19 with {}"
    mark = "; "
    feed_form = "L {axes} F{feed}{has_codes: {codes}}"
    system_form = ""
    shift_forms = ("CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X{x}", "CYCL DEF 7.2 Y{y}", "CYCL DEF 7.3 Z{z}")
    points_on = ("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS",)
    points_off = ("FUNCTION RESET TCPM",)
    change_form = "TOOL CALL {tool} Z"
    rapid_form = "L {axes} R0 FMAX"
    home_form = "L {axes} R0 FMAX M91"
    call_form = 'CALL LBL "{routine}"'
    their_call_form = "CALL PGM {routine}"
    pause_forms = ("CYCL DEF 9.0 DWELL TIME", "CYCL DEF 9.1 DWELL {seconds:3}")
    value_form = "FN 19: PLC=+{output}/{value}"
    hold_forms = ("; {mount}", "STOP")
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
    last = (
        *("CYCL DEF 7.0 DATUM SHIFT", "CYCL DEF 7.1 X+0", "CYCL DEF 7.2 Y+0", "CYCL DEF 7.3 Z+0"),
        *("CYCL DEF 32.0 TOLERANCE", "CYCL DEF 32.1", "M30"),
    )
    shared = "Q50 and up, set at each start"
    vocabulary = KLARTEXT
    name_case = "upper"
    contact_form, sensor_form = "I{number} of the PLC", "W{number} of the PLC"
    indents_loops = False
    start = "Q50"
    start_words = "write its number into the block {start} = +1"
    watch_note = ": to be wired"
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
        "{fault}",
        "FN 14: ERROR={label} ; {message}",
        "LBL {ready}",
    )
    await_forms = ("LBL {label}", *wait_contact[2:4], wait_contact[5], "FN 10: IF +Q61 NE +{state} GOTO LBL {label}")
    wait_sensor = (
        *wait_contact[:5],
        "FN 18: SYSREAD Q61 = ID2000 NR70 IDX{input}",
        "Q61 = {reading}",
        "FN 9: IF +Q61 EQU {least} GOTO LBL {ready}",
        "FN 11: IF +Q61 GT {least} GOTO LBL {ready}",
        *wait_contact[7:],
    )

    def word(self, letter: str, value: str) -> str:
        """Write where an axis is, with its sign."""
        return f"{letter}{_signed(value)}"

    def operand(self, value: float, digits: int = 6) -> str:
        """Write a number with its sign."""
        return _signed(short(value, digits))

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block, and wait for its end where the machine stands there."""
        yield from super().block(line, words, share, stops=stops, turns=turns)
        if stops:
            yield STAND

    def pause(self, seconds: float) -> Iterator[str]:
        """Hold the pose."""
        yield from (fill(form, seconds=seconds) for form in self.pause_forms)

    def number(self, value: float) -> str:
        """Write the value of an output with its sign."""
        return self.operand(value)

    def select(self, system: str) -> Iterator[str]:
        """Shift the datum to the board's origin."""
        zeros = {letter.lower(): _signed(short(self.offset[self.letters.index(letter)], 4)) for letter in "XYZ"}
        yield from (fill(form, **zeros) for form in self.shift_forms)

    def setup(self) -> Iterator[Task]:
        """State what machine parameters and the PLC have to do."""
        yield Task(
            "PLC: M functions of outputs act where their block begins; FN 19 sends an output's number and its value"
        )
        errors = (f"{WAIT_LABEL + index}: {wait.shown}" for index, wait in enumerate(self.installation.waits, start=1))
        yield Task("PLC: errors of FN 14 with your texts", tuple(errors))
        valves = (f"{self.address(channel)}: {channel.name}" for channel in self.valves)
        yield Task("PLC: valves shut at stop, cancel and emergency stop; override at 100", tuple(valves))
        stop = "PLC: NC stop, valves shut, when an input leaves its state"
        yield from self.watch_tasks(stop, f"{self.contact_form} {{name}}: {{words}}".replace("number", "input"))

    def remarks(self) -> Iterator[str]:
        """State what has to hold when the program is started, and the words of its blocks."""
        shifted = f"CYCL DEF 7 shifts it to the {self.installation.workpiece}"
        yield f"Active preset: zero of the machine; {shifted}. Cycle 32 lets corners be passed"
        yield from self.legend()

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write one program: main, then its labels."""
        head = [f"; {cut(line[2:], 190)}" for line in self.heading()]
        text = [f"BEGIN PGM {self.name} MM", *head, *main.body]
        for name, body in ((self.shut_name, self.shut()), *((each.name, each.body) for each in routines)):
            text += [f'LBL "{name}"', *body, "LBL 0"]
        text.append(f"END PGM {self.name} MM")
        return {f"{self.name}.h": join_lines(f"{number} {line}" for number, line in enumerate(text))}


def _signed(number: str) -> str:
    return number if number.startswith("-") else f"+{number}"


_MAIN = "(main)"


class HeidenhainReader(MCodeReader):
    """Labels, Q parameters, modes of the machine."""

    syntax = Heidenhain
    texts: ClassVar[Mapping[str, str]] = dict.fromkeys(("scale", "offset", "least", "x", "y", "z"), rf"\+?{NUMBER}")

    def __init__(self) -> None:
        super().__init__()
        self.guards_override = None
        self.system = "datum"
        self.offsets = {self.system: {}}

    def load(self, files: ProgramFiles) -> str:
        """Sort the labels; what comes before them is the program.

        Raises:
            ProgramError: blocks are not numbered one by one, or the program does not begin and end as it has to.
        """
        ((file, text),) = files.items()
        blocks: list[str] = []
        last = -1
        for line in statements_of(file, text):
            found, _, block = line.partition(" ")
            if not line:
                continue
            if not found.isdigit() or int(found) <= last:
                raise refusal(line, f"is no block with a number after {last}")
            last = int(found)
            kept = block.partition(";")[0].strip()
            if kept:
                blocks.append(line.become(kept))
        name = file.removesuffix(".h")
        if len(blocks) < 2 or blocks.pop(0) != f"BEGIN PGM {name} MM" or blocks.pop() != f"END PGM {name} MM":
            raise ProgramError("the program does not begin and end with its name.", file=file, line=1)
        self.routines[_MAIN] = list(self.sort(blocks, Heidenhain.routine_form))
        if not self.routines[_MAIN] or self.routines[_MAIN][-1] != "M30":
            raise ProgramError("the program does not end with M30.", file=file, line=text.count("\n"))
        return _MAIN

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        yield Heidenhain.last, skip
        yield from super().blocks()
        yield Heidenhain.pause_forms, self.pause
        yield Heidenhain.shift_forms, self.shift
        yield [STAND], self.stand

    def stand(self, values: Values) -> None:
        """Stand at the end of the block before."""
        if self.steps and isinstance(last := self.steps[-1], ReadLine):
            self.steps[-1] = replace(last, stops=True, zone=0.0)

    def shift(self, values: Values) -> None:
        """Shift the datum."""
        self.offsets[self.system] = {letter: float(values[letter.lower()]) for letter in "XYZ"}
        self.steps.append(ReadBoard(None))


DIALECT = Dialect(
    title="HEIDENHAIN Klartext (TNC, TCPM)",
    notes="For a machine with two rotary axes in its head and FUNCTION TCPM (M128). The preset is the machine's zero. "
    "Outputs are M functions: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        changes_tools=True,
        timing="boundary",
        cycle_s=0.01,  # assumed: of the PLC that takes the M functions
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
    ),
    layout=Layout(";", comma=", ", single_blanks=True, leading_zero=True),
    form=FileForm(".h"),
    longest_line=220,
    most_steps=5000,  # of one program; assumed
    write=Heidenhain.write,
    rebuild=HeidenhainReader.rebuild,
    controller=Controller(blending="tolerance", rise_s=0.05, look_ahead=200, least_line_s=0.003),
    needs_joints=True,
    takes_axes=True,
    needs_tool_points=True,
)
