"""SINUMERIK 840D programs: tool points under TRAORI, outputs by synchronized actions."""

from collections.abc import Iterator, Sequence

from programs.errors import ProgramError
from programs.motion.installation import Channel
from programs.motion.steps import Line
from programs.posts.dialect import ProgramFiles
from programs.posts.writing.blocks import BLEND_MM, ToolPointSyntax
from programs.posts.writing.driver import Routine
from programs.posts.writing.frame import INTERRUPT
from programs.posts.writing.naming import Names
from programs.posts.writing.wording import join_lines, short

SYSTEMS = ("G54", "G55", "G56", "G57", "G505", "G506", "G507", "G508", "G509")
WORDS = {"digital": "$A_OUT", "group": "$A_DBB", "analog": "$A_OUTA"}
"""Variables of outputs; those of the PLC's bytes count from 0, all others from 1."""
ALARM = 65000
"""User alarms begin here."""
_LONGEST_NAME = 24
_RESERVED = frozenset({
    "shut_valves", "and", "axis", "bool", "call", "cancel", "case", "char", "def", "default", "define", "div", "do",
    "else", "endfor", "endif", "endloop", "endproc", "endwhile", "every", "extern", "for", "frame", "from", "goto",
    "gotob", "gotof", "ids", "if", "int", "loop", "mod", "not", "of", "or", "proc", "real", "repeat", "ret", "setal",
    "stopre", "string", "to", "trafoof", "traori", "until", "var", "when", "whenever", "while", "xor",
})  # fmt: skip
"""Words of the language, and the program that every main program has."""


class Sinumerik(ToolPointSyntax):
    """A main program and a subprogram for each part."""

    systems = SYSTEMS
    controller_name = "SINUMERIK"
    mark = "; "
    points_on = ("D1", "TRAORI", "ORIMKS ORIAXES", f"CTOL={BLEND_MM:g} OTOL=0.25")
    points_off = ("TRAFOOF",)
    home_form = "G0 SUPA D0 {axes}"
    call_form = "{routine}"
    pause_form = "G4 F{seconds}"
    zero_form = "$P_UIFR[{number}]=CTRANS({axes})"
    modes = ("G17 G40 G90 G94 G710",)
    brackets = "()"
    contact_base = sensor_base = 1
    last = ("M30",)
    longest_name = _LONGEST_NAME
    reserved = _RESERVED
    longest_title = 16
    start = "R100"
    start_words = "write its number into the block {start}=1"
    part_form = ("IF {start}<={number}", "  {call}", "ENDIF")
    enter_begin = ("IF {start}=={number}", "  {start}=1")
    enter_end = ("ENDIF",)
    guard = ("STOPRE", "IF $AC_TOTAL_OVR<>100", f'  SETAL({ALARM},"override is not 100 percent")', "  M30", "ENDIF")
    counter = "R{number}"
    first_counter = 111
    loop_begin = ("{counter}=0", "REPEAT", "  {counter}={counter}+1")
    loop_end = ("  STOPRE", "UNTIL {condition}")
    counted = "{counter}>={count}"
    sensed = "({counter}>={count}) OR ({reading}>={least})"
    reading = "{scale}*$A_INA[{input}]+{offset}"
    wait_contact = (
        "$AC_TIMER[1]=0",
        "WAIT_{index}:",
        "STOPRE",
        "IF $A_IN[{input}]=={state} GOTOF READY_{index}",
        "IF $AC_TIMER[1]<{seconds} GOTOB WAIT_{index}",
        'SETAL(65{label},"{message}")',
        "M30",
        "READY_{index}:",
    )
    wait_sensor = (*wait_contact[:3], "IF {reading}>={least} GOTOF READY_{index}", *wait_contact[4:])
    watch = ("IDS={interrupt} EVERY $A_IN[{input}]=={other} DO SETAL(650{interrupt})",)

    def make_names(self) -> Names:
        """Begin the list of names; that of a program begins with two letters."""
        if not self.name[:2].isalpha():
            self.name = f"WB{self.name}"[:_LONGEST_NAME]
        return super().make_names()

    def call_name(self, name: str) -> str:
        """Name a program of the integrator's.

        Raises:
            ProgramError: it cannot have that name.
        """
        given = super().call_name(name)
        if not given[:2].isalpha():
            raise ProgramError(
                f"CALL {name}: names of SINUMERIK's programs begin with two letters; rename the routine."
            )
        return given

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block; F counts for X, Y and Z, or for B and C where the tool turns on the spot."""
        way = "X,Y,Z" if set(words) & set("XYZ") else "B,C"
        yield from self.mode("group", f"FGROUP({way})")
        yield " ".join([*self.mode("path", "G60" if stops else "G642"), "G1", words, f"F{self.tool_point_feed(line)}"])

    def output(self, channel: Channel, value: float, when: str = "immediate") -> str:
        """Set an output, with the next motion by an action that is synchronized to it."""
        name = address(channel)
        word = short(self.dialect.capability.analog.count(channel, value), 6)
        if channel.kind != "analog":
            word = short(value, 6)
        return f"{name}={word}" if when == "immediate" else f"WHEN TRUE DO {name}={word}"

    def prepare(self) -> Iterator[str]:
        """Set the modes, the zero of each coordinate system, and what shuts the valves at a fault."""
        yield from super().prepare()
        actions = " ".join(self.output(channel, 0.0) for channel in self.valves)
        yield f"IDS=1 EVERY $AC_STAT<>2 DO {actions}" if actions else "CANCEL(1)"

    def zero_words(self, offset: Sequence[float]) -> str:
        """Write the axes of a zero."""
        return ",".join(f"{letter},{short(value, 4)}" for letter, value in zip("XYZ", offset, strict=False))

    def output_words(self, channel: Channel) -> str:
        """Give the variable of an output."""
        return address(channel)

    def contact_words(self, number: int) -> str:
        """Give the variable of a digital input."""
        return f"$A_IN[{number + 1}]"

    def sensor_words(self, number: int) -> str:
        """Give the variable of an analog input."""
        return f"$A_INA[{number + 1}]"

    def setup(self) -> Iterator[str]:
        """State what machine data and the PLC have to do."""
        yield "MD: B and C no modulo axes; fast inputs and outputs as below, analog ones in mV; corners within CTOL"
        yield f"alarms {ALARM} to {ALARM + 999} with your texts, which stop the channel; $A_DBB is for the PLC to copy"
        yield "PLC: valves shut at emergency stop too, as IDS=1 does while no program runs"
        if any(wait.watched for wait in self.installation.waits):
            yield f"IDS={INTERRUPT + 1} and up raise an alarm that stops the channel; IDS=1 then shuts the valves"

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write a main program, and a subprogram for each part."""
        files = {f"{self.name}.mpf": join_lines([*self.heading(*self.legend()), *main.body])}
        bodies = {self.shut_name: self.shut(), **{each.name: each.body for each in routines}}
        return files | {f"{name}.spf": join_lines([*body, "M17"]) for name, body in bodies.items()}


def address(channel: Channel) -> str:
    """Give the variable of an output.

    Raises:
        ProgramError: there is none of its number.
    """
    if channel.number < 0:
        raise ProgramError(f"{channel.name} is {channel.kind} output {channel.number}; SINUMERIK has 0 and up.")
    return f"{WORDS[channel.kind]}[{channel.number + (channel.kind != 'group')}]"
