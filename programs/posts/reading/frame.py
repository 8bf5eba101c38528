"""Reads the production frame around a program: guard, waits, faults, loops, and the parts that it may start at."""

import re
from abc import ABC
from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from typing import ClassVar

from programs.errors import ProgramError
from programs.posts.reading.execution import Block, EnteredError, Execution, FormAction, StatementBlock, Values, skip
from programs.posts.rebuilt import (
    ReadAwait,
    ReadEndRepeat,
    ReadFrame,
    ReadPart,
    ReadRepeat,
    ReadStep,
    ReadSwitch,
    ReadWait,
)
from programs.posts.writing.driver import Syntax
from programs.posts.writing.forms import NUMBER, pattern_of

_WHOLE = (
    *("number", "input", "index", "label", "ready", "after", "interrupt", "error", "count"),
    *("hundredths", "tenths", "ms", "percent", "slot"),
)
"""Fields that hold whole numbers."""
_CONDITION = ("scale", "offset", "least")
_LOOP_KEYS = ("counter", "number", "label")
"""Fields by which the end of a loop is that of its beginning."""
_IN_A_SECOND = {"seconds": 1.0, "tenths": 10.0, "hundredths": 100.0, "ms": 1000.0}


class FrameReader(Execution, ABC):
    """A controller that keeps what belongs to the frame apart from the steps of the plan."""

    syntax: ClassVar[type[Syntax]]
    """The writer, whose forms are read."""
    height_unit_mm: ClassVar[float] = 1.0
    shut_name: str = "shut_valves"
    """The fault routine; it is called before the first motion too."""
    reads_sensors: ClassVar[bool] = True
    """Whether the language can wait for a quantity."""
    watches_inputs: bool = True
    """Whether the program can watch inputs while it runs."""
    handlers: ClassVar[AbstractSet[str]] = frozenset()
    """What has to call the fault routine, by the names that ``shut`` is given; none in languages without a frame."""

    def __init__(self) -> None:
        super().__init__()
        self.start = 1
        """The part to start at."""
        self.parts: list[ReadPart] = []
        self.waits: list[ReadWait] = []
        self.watched: list[tuple[str, bool]] = []
        self.shut_by: set[str] = set()
        self.loops: list[Values] = []
        """Counter, number and label of the loops that run, as far as they have them."""
        self.acting: set[str] = set()
        """Interrupts, traps and actions that go on until the program ends them, by name or number."""
        self.suspended: set[str] = set()
        """What is watched no longer, until it is again."""
        self.guards_override: bool | None = False
        self.faults: set[str] = set()
        self.counters = self.declares("counter")

    def finish(self) -> None:
        """Make sure at the end that nothing is left over.

        Raises:
            ProgramError: a loop has no end, a routine was never called, a declaration was not used, or something goes
                on after the program.
        """
        if self.loops:
            raise ProgramError("a loop has no end.")
        if self.acting:
            raise ProgramError(f"interrupt, trap or action {min(self.acting)} goes on after the program.")
        super().finish()

    def read_frame(self) -> ReadFrame | None:
        """Give the frame of a program that was executed; ``None`` in languages without one.

        Raises:
            ProgramError: it cannot start at one of its parts, or its fault routine does not do what it has to.
        """
        if not self.handlers:
            return None
        parts = tuple(replace(part, entry=self.enter_at(part.number)) for part in self.parts)
        shut = self.read_shut()  # some languages watch inputs where they shut the valves
        waits, watched = tuple(self.waits), tuple(self.watched) if self.watches_inputs else None
        guard, faults = self.guards_override, frozenset(self.faults)
        return ReadFrame(waits, watched, parts, shut, guard, self.reads_sensors, faults)

    def enter_at(self, part: int) -> tuple[ReadStep, ...]:
        """Execute a program that starts at a part, as far as that part's own steps; what it uses counts as used."""
        if part == 1:
            return ()
        reader = self.reloaded()
        reader.start = part
        try:
            reader.run(reader.main)
        except EnteredError:
            self.called |= reader.called
            for own, there in zip(self.declared, reader.declared, strict=True):
                own.used |= there.used
            return tuple(reader.steps)
        raise ProgramError(f"the program cannot start at part {part}.")

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts.

        Raises:
            ProgramError: something does not call it, or it does something else too.
        """
        if missing := sorted(self.handlers - self.shut_by):
            raise ProgramError(f"the valves are not shut by {', '.join(missing)}.")
        self.steps, self.places = [], []
        self.run(self.shut_name)
        if any(not isinstance(step, ReadSwitch) or step.value for step in self.steps):
            raise ProgramError(f"{self.shut_name} does more than to shut valves.")
        return tuple(step.channel for step in self.steps if isinstance(step, ReadSwitch))

    def shut(self, by: str) -> Callable[[object], None]:
        """Give the action of a statement that calls the fault routine, by what has it called."""

        def note(found: object) -> None:
            self.shut_by.add(by)

        return note

    # Forms of the frame

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        syntax = self.syntax
        opened, closed = (re.escape(each) for each in syntax.brackets or ("", ""))
        operand = f"{opened}?{NUMBER}{closed}?" if syntax.brackets else NUMBER
        states = "|".join(map(re.escape, syntax.states))
        return {
            **dict.fromkeys(_WHOLE, r"\d+"),
            **dict.fromkeys(("scale", "offset", "least", "height"), operand),
            **dict.fromkeys(("name", "tool", "routine"), r"\w+"),
            **dict.fromkeys(("state", "other"), states),
            "seconds": r"\d+(?:\.\d+)?",
            "joints": rf"{NUMBER}(?:, ?{NUMBER})*",
            "message": ".*",
            "fault": r"\w+",
            "mount": r"(?:mount tool (?P<mounted>\d+)(?: .*)?|first run step \d+)",
            "shut": re.escape(self.shut_name),
            "start": re.escape(syntax.start),
            "counter": re.sub(r"\\\{number.*?\\\}", r"\\d+", re.escape(syntax.counter)),
        }

    def nested(self, forms: Sequence[str], condition: str = "") -> list[str]:
        """Give forms with those that stand in their fields, without comments and what is left empty."""
        syntax = self.syntax
        inner = {"condition": condition, "call": syntax.call_form, "reading": syntax.reading}
        found: list[str] = []
        for form in forms:
            for name, each in inner.items():
                form = form.replace(f"{{{name}}}", each)
            kept = (f" {form}".partition(f" {syntax.mark}")[0] if syntax.mark else form).strip()
            if kept:
                found.append(kept)
        return found

    def blocks(self) -> Iterator[Block]:
        """Give the forms of the frame, and of loops."""
        syntax = self.syntax
        frame: list[tuple[Sequence[str], FormAction]] = [
            (syntax.guard, self.guard),
            (syntax.wait_contact, self.read_contact),
            (syntax.wait_sensor, self.read_sensor),
            (syntax.watch, self.read_watch),
            (syntax.end_watch, self.read_end_watch),
            (syntax.await_contact, self.read_await),
            (syntax.await_forms, self.read_await),
            (syntax.rise_forms, self.read_rise),
            (syntax.enter_begin[:1], self.enter),
            (syntax.enter_begin[1:], skip),
            (syntax.part_form if syntax.enter_begin else (), self.read_part),
            ((syntax.call_form.replace("routine", "shut"),) if syntax.enter_begin else (), self.shut("main")),
        ]
        for forms, action in frame:
            noted = self.noting(action) if any("{fault}" in form for form in forms) else action
            yield from ((self.nested(each), noted) for each in self.variants(forms) if each)
        for begin, end in self.loop_forms():
            yield begin, self.begin_loop
            yield end, self.end_loop

    def variants(self, forms: Sequence[str]) -> list[list[str]]:
        """Give forms without what sets the output of a fault, and with it where they have a place for it."""
        syntax, without = self.syntax, [form for form in forms if "{fault}" not in form]
        sets = syntax.digital.replace("{name}", "{number}").replace("{value}", syntax.off_on[1])
        sets = syntax.fault_form or sets.replace("{number}", "{fault}")
        return [without, [form.replace("{fault}", sets) for form in forms]] if len(without) < len(forms) else [without]

    def expect(self, routine: str, forms: Sequence[str]) -> None:
        """Make sure of the statements of a routine that is not run, with or without the output of a fault."""
        without, *more = self.variants(forms)
        statements, fields = self.routines.get(routine, []), self.fields()
        chosen = next((each for each in more if len(each) == len(statements)), without)
        super().expect(routine, chosen)
        if more:
            places = zip(chosen, statements, strict=True)
            found = [
                match.groupdict() for form, text in places if (match := re.fullmatch(pattern_of(form, fields), text))
            ]
            self.note_fault(next((values for values in found if "fault" in values), {}))

    def noting(self, action: FormAction) -> FormAction:
        """Give an action that notes first which output shows that the program stops itself there."""

        def note(values: Values) -> None:
            self.note_fault(values)
            action(values)

        return note

    def note_fault(self, values: Values) -> None:
        """Note which output shows that the program stops itself here."""
        number = values.get("fault", "")
        self.faults.add(self.fault_label(number) if number else "")

    def fault_label(self, word: str) -> str:
        """Give the output that a fault sets by its name, or kind and number."""
        return word if not word.isdigit() else f"digital {word}"

    def number(self, operand: str) -> str:
        """Give a number without the brackets around a negative one."""
        return operand.strip(self.syntax.brackets)

    def guard(self, values: Values) -> None:
        """Refuse to start where the speed override is not 100 %."""
        self.guards_override = True

    def read_contact(self, values: Values) -> None:
        """Wait for a contact, and stop where that takes too long."""
        self.use_wait()
        state = values["state"] == self.syntax.states[1]
        self.waits.append(ReadWait(self.input_of(values, self.syntax.contact_base), state, seconds_of(values)))

    def read_sensor(self, values: Values) -> None:
        """Wait for a quantity, and stop where that takes too long."""
        self.use_wait()
        scale, offset, least = (float(self.number(values[name])) for name in ("scale", "offset", "least"))
        channel = self.input_of(values, self.syntax.sensor_base)
        self.waits.append(ReadWait(channel, None, seconds_of(values), (scale, offset, least)))

    def use_wait(self) -> None:
        """Use what a wait needs beside its statements."""

    def input_of(self, values: Values, base: int) -> str:
        """Give the name or the number of an input."""
        return values.get("name") or str(int(values["input"]) - base)

    def read_watch(self, values: Values) -> None:
        """Begin to watch an input."""
        self.begin_watch(self.input_of(values, self.syntax.contact_base), values["other"] == self.syntax.states[0])
        if self.syntax.end_watch:
            self.acting.add(values.get("interrupt") or values["index"])
            self.suspended.discard(values.get("interrupt") or values["index"])

    def begin_watch(self, channel: str, state: bool) -> None:
        """Watch an input, for the first time or again."""
        if (channel, state) not in self.watched:
            self.watched.append((channel, state))

    def read_end_watch(self, values: Values) -> None:
        """End what watches an input."""
        self.acting.discard(values.get("interrupt") or values["index"])
        self.suspended.add(values.get("interrupt") or values["index"])

    def read_await(self, values: Values) -> None:
        """Wait for an input: again for one that is watched, or by the handshake with the line."""
        channel, states = self.input_of(values, self.syntax.contact_base), self.syntax.states
        state = values["state"] == states[1] if "state" in values else values["other"] == states[0]
        if (channel, state) not in self.watched:
            self.steps.append(ReadAwait(channel, state))

    def check_watched(self) -> None:
        """Make sure before a motion that what is watched is watched again.

        Raises:
            ProgramError: it is not.
        """
        if self.suspended:
            raise ProgramError(f"the robot moves while {min(self.suspended)} does not watch.")

    def read_rise(self, values: Values) -> None:
        """Raise the orifice, of a tool where the statements name one, before anything else moves."""
        self.use_first_tool(values.get("tool", ""))
        self.raise_to(self.height_unit_mm * float(self.number(values["height"])))

    def use_first_tool(self, name: str) -> None:
        """Use the tool whose orifice is raised."""

    def raise_to(self, height_mm: float) -> None:
        """Raise the orifice to a height."""
        raise NotImplementedError

    def use_variable(self, name: str) -> None:
        """Use a variable, in languages that declare it: a counter, or the part to start at."""
        if self.syntax.declare_counter and name not in ("", self.syntax.start):
            self.counters.use(name)

    def read_part(self, values: Values) -> None:
        """Do a part of main, unless the start is at a later one."""
        self.use_variable(values.get("start", ""))
        self.parts.append(ReadPart(int(values["number"]), len(self.steps)))
        if self.start <= int(values["number"]):
            self.run(values["routine"])

    def enter(self, values: Values) -> None:
        """Begin what a part does first if the program starts there; pass over it otherwise.

        Raises:
            ProgramError: it is part 1, where a program starts anyway.
        """
        if int(values["number"]) == 1:
            raise ProgramError("a program that starts at part 1 has no way to it first.")
        self.use_variable(values.get("start", ""))
        end = self.pass_to(pattern_of(self.syntax.enter_end[0], {**self.fields(), "number": values["number"]}))
        if self.start == int(values["number"]):
            self.start, self.entry_end = 1, (self.routine, end)
        else:
            self.at = end

    # Loops

    def loop_forms(self) -> list[tuple[list[str], list[str]]]:
        """Give the forms around a loop that reads an input, and around one that only counts."""
        syntax = self.syntax
        begin, end = syntax.sensed_begin or syntax.loop_begin, syntax.sensed_end or syntax.loop_end
        sensed = self.nested(begin, syntax.sensed), self.nested(end, syntax.sensed)
        counted = self.nested(syntax.loop_begin, syntax.counted), self.nested(syntax.loop_end, syntax.counted)
        return [sensed, counted] if syntax.sensed or syntax.sensed_end else [counted]

    def begin_loop(self, values: Values) -> None:
        """Begin a loop, by what stands there and at its end.

        Raises:
            ProgramError: it has no end.
        """
        values = {**values, **self.find_end(values)}
        condition = {name: self.number(values[name]) for name in _CONDITION if name in values}
        self.loops.append({name: values[name] for name in _LOOP_KEYS if name in values})
        self.use_variable(values.get("counter", ""))
        if not condition:
            self.steps.append(ReadRepeat(int(values["count"]), None))
            return
        scale, offset, least = map(float, condition.values())
        channel = self.input_of(values, self.syntax.sensor_base)
        self.steps.append(ReadRepeat(int(values["count"]), least, (scale, offset), channel))

    def find_end(self, begin: Values) -> Values:
        """Find the end of a loop, of its counter or label; nothing where that has no more than the beginning.

        Raises:
            ProgramError: there is none.
        """
        fields, statements = self.fields(), self.routines[self.routine]
        ends = [StatementBlock(end, fields, self.end_loop) for _, end in self.loop_forms()]
        if not any(f"{{{name}" in form for _, end in self.loop_forms() for form in end for name in _LOOP_KEYS):
            return {}
        for at in range(self.at + 1, len(statements)):
            for block in ends:
                values = block.follow(statements[at : at + len(block.patterns)])
                if isinstance(values, dict) and _is_same_loop(begin, values):
                    return values
        raise ProgramError(f"the loop at {statements[self.at]!r} has no end.")

    def end_loop(self, values: Values) -> None:
        """End the innermost loop.

        Raises:
            ProgramError: there is none, or it is another one.
        """
        if not self.loops or not _is_same_loop(self.loops.pop(), values):
            raise ProgramError(f"{self.routines[self.routine][self.at]!r} ends no loop, or not the innermost.")
        self.steps.append(ReadEndRepeat())


def _is_same_loop(begin: Values, end: Values) -> bool:
    return all(begin[name] == end[name] for name in _LOOP_KEYS if name in begin and name in end)


def seconds_of(values: Values) -> float:
    """Give the time of a wait."""
    return next(float(values[unit]) / count for unit, count in _IN_A_SECOND.items() if unit in values)
