"""SINUMERIK 840D programs: tool points under TRAORI, outputs by synchronized actions."""

import re
from collections.abc import Iterator, Mapping, Sequence

from programs.errors import ProgramError
from programs.motion.analog import Counting
from programs.motion.installation import Channel
from programs.motion.lower import Capability
from programs.motion.steps import Line
from programs.posts.dialect import Dialect, FileForm, ProgramFiles, Task
from programs.posts.gcode.axes import BLEND_MM
from programs.posts.gcode.tool_points import ToolPointReader, ToolPointSyntax
from programs.posts.layout import Layout, words_of
from programs.posts.reading.execution import Block, Values, statements_of
from programs.posts.rebuilt import ReadSwitch
from programs.posts.writing import vocabulary as vocabularies
from programs.posts.writing.driver import Routine
from programs.posts.writing.forms import NUMBER, fill, short
from programs.posts.writing.frame import INTERRUPT, WAIT_LABEL
from programs.posts.writing.wording import join_lines, name_program
from programs.timing.controller import Controller

SYSTEMS = ("G54", "G55", "G56", "G57", "G505", "G506", "G507", "G508", "G509")
WORDS = {"digital": "$A_OUT", "group": "$A_DBB", "analog": "$A_OUTA"}
"""Variables of outputs; those of the PLC's bytes count from 0, all others from 1."""
ALARM = 65000
"""User alarms begin here."""


class Sinumerik(ToolPointSyntax):
    """A main program and a subprogram for each part."""

    systems = SYSTEMS
    controller_name = "SINUMERIK"
    mark = "; "
    points_on = ("D1", "TRAORI", "ORIMKS ORIAXES", f"CTOL={BLEND_MM:g} OTOL=0.25")
    points_off = ("TRAFOOF",)
    home_form = "G0 SUPA D0 {axes}"
    call_form = "{routine}"
    pause_form = "G4 F{seconds:3}"
    path_words = ("G642", "G60")
    group_form = "FGROUP({group})"
    """Axes for which F counts."""
    output_forms = ("{word}[{number}]={value}", "WHEN TRUE DO {word}[{number}]={value}")
    """At once, and with the next motion."""
    shut_form = f"ID={INTERRUPT} EVERY $AC_STAT<>2 DO {{actions}}"
    """Shuts the valves where the program stands; it ends with the program, as static actions (IDS) do not."""
    end_watch, last = ("CANCEL({interrupt})",), (f"CANCEL({INTERRUPT})", "M30")
    hold_forms = ('MSG("{mount}")', "M0", "MSG()")
    zero_form = "$P_UIFR[{number}]=CTRANS({zero})"
    modes = ("G17 G40 G90 G94 G710",)
    brackets = "()"
    contact_base = sensor_base = 1
    contact_form, sensor_form = "$A_IN[{number}]", "$A_INA[{number}]"
    shared = "shut_valves.spf, the same in each; R100 and up; the frames of G54 and up are set at each start"
    vocabulary, names_parts_by_program = vocabularies.SINUMERIK, True
    longest_title = 16
    start = "R100"
    start_words = "write its number into the block {start}=1"
    part_form = ("IF {start}<={number}", "  {call}", "ENDIF")
    enter_begin = ("IF {start}=={number}", "  {start}=1")
    enter_end = ("ENDIF",)
    guard = (
        *("STOPRE", "IF $AC_TOTAL_OVR<>100", "  {fault}", f'  SETAL({ALARM},"override is not 100 percent")'),
        *(f"  CANCEL({INTERRUPT})", "  M30", "ENDIF"),
    )
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
        "{fault}",
        'SETAL(65{label},"{message}")',
        f"CANCEL({INTERRUPT})",
        "M30",
        "READY_{index}:",
    )
    wait_sensor = (*wait_contact[:3], "IF {reading}>={least} GOTOF READY_{index}", *wait_contact[4:])
    await_forms = ("WAIT_{index}:", "STOPRE", "IF $A_IN[{input}]=={other} GOTOB WAIT_{index}")
    fault_form = "$A_OUT[{fault}]=1"
    watch = ("ID={interrupt} EVERY $A_IN[{input}]=={other} DO SETAL(650{interrupt})",)

    def name_program(self, longest: int) -> str:
        """Name the program; it begins with two letters."""
        name, origin = super().name_program(longest), self.motion.origin
        return name if name[:2].isalpha() else name_program(f"WB{origin.board}", origin.recipe, longest)

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
        yield from self.set("group", fill(self.group_form, group=way))
        yield from super().block(line, words, share, stops=stops, turns=turns)

    def output(self, channel: Channel, value: float, when: str = "immediate") -> str:
        """Set an output, with the next motion by an action that is synchronized to it."""
        count = self.dialect.capability.analog.count(channel, value) if channel.kind == "analog" else value
        return f"{'' if when == 'immediate' else 'WHEN TRUE DO '}{address(channel)}={short(count, 6)}"

    def prepare(self) -> Iterator[str]:
        """Set the modes, the zero of each coordinate system, and what shuts the valves at a fault."""
        yield from super().prepare()
        if actions := " ".join(self.shut()):
            yield fill(self.shut_form, actions=actions)

    def zero_words(self, offset: Sequence[float]) -> str:
        """Write the axes of a zero."""
        return ",".join(f"{letter},{short(value, 4)}" for letter, value in zip("XYZ", offset, strict=False))

    def address(self, channel: Channel) -> str:
        """Give the variable of an output."""
        return address(channel)

    def setup(self) -> Iterator[Task]:
        """State what machine data and the PLC have to do."""
        yield Task(
            "MD: B and C no modulo axes; fast inputs and outputs as below, analog ones in mV; corners within CTOL"
        )
        waits = enumerate(self.installation.waits, start=1)
        texts = [f"{ALARM + WAIT_LABEL + index}: {wait.shown}" for index, wait in waits]
        watches = ((ALARM + INTERRUPT + index, wait) for index, wait in enumerate(self.installation.waits, start=1))
        texts += [f"{number}: no {wait.words} any more" for number, wait in watches if wait.watched]
        yield Task(f"alarms {ALARM} to {ALARM + 999} with your texts, which stop the channel", tuple(texts))
        text = (
            f"PLC: valves shut at reset and emergency stop too; ID={INTERRUPT} does that where the program is stopped"
        )
        yield Task(text, tuple(f"{self.address(channel)} {channel.name}" for channel in self.valves))

    def remarks(self) -> Iterator[str]:
        """State what the program uses, and the words of its blocks."""
        yield f"Actions ID={INTERRUPT} and up are used; all of them end with the program; $A_DBB is for the PLC to copy"
        if any(wait.watched for wait in self.installation.waits):
            yield f"ID={INTERRUPT + 1} and up raise an alarm, which stops the channel: ID={INTERRUPT} shuts the valves"
        yield from self.legend()

    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Write a main program, and a subprogram for each part."""
        files = {f"{self.name}.mpf": join_lines([*self.heading(), *main.body])}
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


_KINDS = {word: kind for kind, word in WORDS.items()}


class SinumerikReader(ToolPointReader):
    """A main program and its subprograms."""

    syntax = Sinumerik
    handlers = frozenset({"main", "ID"})
    watches_inputs = True

    def __init__(self) -> None:
        super().__init__()
        self.at_fault: list[str] = []
        """Outputs that a synchronized action shuts."""
        self.group = ""
        """Axes for which F counts."""

    def fault_label(self, word: str) -> str:
        """Give the output of a variable's number."""
        return f"digital {int(word) - 1}"

    def load(self, files: ProgramFiles) -> str:
        """Sort the programs by their files.

        Raises:
            ProgramError: one does not end.
        """
        main = ""
        for file in files:
            name, _, suffix = file.rpartition(".")
            lines = [line for line in statements_of(file, files[file], ";") if line]
            last = "M30" if suffix == "mpf" else "M17"
            if not lines or lines.pop() != last:
                line = files[file].count("\n")
                raise ProgramError(f"the program does not end with {last}.", file=file, line=line)
            self.routines[name] = lines
            main = name if suffix == "mpf" else main
        return main

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        words = {"routine": r"[A-Za-z]{2}\w*", "group": "X,Y,Z|B,C", "word": "|".join(map(re.escape, _KINDS))}
        zero = rf"X,{NUMBER},Y,{NUMBER},Z,{NUMBER}"
        return {**super().fields(), **words, "zero": zero, "value": NUMBER, "actions": ".*"}

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        yield [Sinumerik.group_form], self.set_group
        yield from (([form], self.set_output) for form in Sinumerik.output_forms)
        yield [Sinumerik.shut_form], self.shut_at_fault
        yield [Sinumerik.last[0]], self.cancel
        yield from super().blocks()

    def feed(self, values: Values) -> None:
        """Go straight to a tool point.

        Raises:
            ProgramError: F counts for other axes than those that move.
        """
        if self.group != ("X,Y,Z" if set(values["axes"]) & set("XYZ") else "B,C"):
            raise ProgramError(f"F counts for {self.group or 'no axes'}, and others move.")
        super().feed(values)

    def set_group(self, values: Values) -> None:
        """Let F count for some axes."""
        self.group = values["group"]

    def set_output(self, values: Values) -> None:
        """Set an output; those of the PLC's bytes count from 0, all others from 1."""
        kind = _KINDS[values["word"]]
        self.switch(f"{kind} {int(values['number']) - (kind != 'group')}", float(values["value"]))

    def shut_at_fault(self, values: Values) -> None:
        """Shut outputs where the program stands."""
        before = len(self.steps)
        for action in values["actions"].split(" "):
            self.execute(action)
        shut, self.steps = self.steps[before:], self.steps[:before]
        if not all(isinstance(step, ReadSwitch) and not step.value for step in shut):
            raise ProgramError(f"{values['actions']} shuts no valve.")
        self.at_fault += [step.channel for step in shut if isinstance(step, ReadSwitch)]
        self.acting.add(str(INTERRUPT))

    def cancel(self, values: Values) -> None:
        """End the action that shuts the valves."""
        self.acting.discard(str(INTERRUPT))
        self.shut("ID")(values)

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts.

        Raises:
            ProgramError: the static action shuts others.
        """
        shut = super().read_shut()
        if list(shut) != self.at_fault:
            raise ProgramError(f"ID={INTERRUPT} shuts {self.at_fault}, and {self.shut_name} {list(shut)}.")
        return shut

    def read_part(self, values: Values) -> None:
        """Do a part of main.

        Raises:
            ProgramError: it calls another one.
        """
        if not re.fullmatch(rf"\w+_0*{values['number']}(?:_\d+)?", values["routine"]):
            raise ProgramError(f"part {values['number']} calls {values['routine']}.")
        super().read_part(values)

    def call(self, name: str) -> None:
        """Call a program of the integrator's.

        Raises:
            ProgramError: it is one of the program's own, which only its part calls.
        """
        if name in self.routines:
            raise ProgramError(f"{name} is called outside its part.")
        super().call(name)


DIALECT = Dialect(
    title="SINUMERIK 840D (TRAORI)",
    notes="For a machine with two rotary axes in its head and TRAORI. G54 is the work's origin. Inputs and outputs "
    "count from 1: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        changes_tools=True,
        timing="boundary",
        cycle_s=0.004,  # assumed: of interpolation
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
        analog=Counting(full=10000.0, step=1.0),  # millivolts, assumed
    ),
    layout=Layout(
        ";",
        comma=",",
        equals="=",
        single_blanks=True,
        leading_zero=True,
        words=words_of(Sinumerik, "M17 $A_DBB $A_OUTA X Y Z A B C U V W UNTIL WAIT_# READY_#"),
        addresses="-",
    ),
    form=FileForm(".mpf", several=(".mpf", ".spf")),
    longest_line=200,
    most_steps=5000,  # of one program; assumed
    write=Sinumerik.write,
    rebuild=SinumerikReader.rebuild,
    controller=Controller(blending="tolerance", rise_s=0.05, look_ahead=150, least_line_s=0.002),
    needs_joints=True,
    takes_axes=True,
    needs_tool_points=True,
)
