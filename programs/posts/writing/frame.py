"""The production frame around a program: guard, waits and faults before the first motion, and where it may start."""

from collections.abc import Iterator, Mapping, Sequence
from typing import ClassVar

from programs.motion.installation import USUAL_WAITS, Channel, Installation, Sensor, Wait
from programs.motion.steps import Call, MotionProgram, UseTool
from programs.posts.dialect import Dialect
from programs.posts.writing.chapters import Chapter, Part
from programs.posts.writing.entries import Entry
from programs.posts.writing.forms import short
from programs.posts.writing.heading import channels_of
from programs.posts.writing.wording import cut

_UNITS = {"bar": "bar", "c": "deg C", "mohm_cm": "MOhm cm", "us_cm": "uS/cm", "l_min": "l/min", "percent": "%"}
"""Units of quantities by the end of their key."""
PART_LABEL, WAIT_LABEL, READY_LABEL, INTERRUPT, ERROR = 200, 300, 400, 21, 9100
"""Labels of parts, of waits and of what follows them, interrupts and errors begin after these."""


def under_each(forms: Sequence[str], *conditions: str) -> Iterator[tuple[str, ...]]:
    """Give forms for each ``condition`` in them, as for that of a contact and of a quantity."""
    return (tuple(form.replace("{condition}", condition) for form in forms) for condition in conditions)


TOOLS_CHANGED = "the program moves to the place of the change and goes on at once"


class ProductionFrame:
    """Forms of the frame in one language, and what is filled into them; ``Syntax`` is made of it.

    Forms are lines of text; empty ones are left out. A language without a form does not have what it is for, and its
    ``setup`` states what the integrator has to provide in its place.
    """

    dialect: Dialect
    installation: Installation
    motion: MotionProgram
    parts: tuple[Part, ...]
    part_entries: Mapping[int, Entry]
    """What a part other than the first does if the program starts there."""

    start: str = "nStart"
    """Variable that names the part to start at; 0 or 1 for the whole program."""
    shut_name: str = "shut_valves"
    """Routine that shuts every valve which the program opens."""
    part_form: ClassVar[tuple[str, ...]] = ("{call}",)
    """Of a part in main, of ``number``, ``label``, ``call`` and ``start``: done unless that is a later one."""
    enter_begin: ClassVar[tuple[str, ...]] = ()
    enter_end: ClassVar[tuple[str, ...]] = ()
    """Around what a part does first if the program starts there, of its ``number`` and of ``start``."""
    guard: ClassVar[tuple[str, ...]] = ()
    """Refuses to start unless the speed override is 100 %."""
    brackets: ClassVar[str] = ""
    """Both brackets around a negative number in an expression; empty where it has none."""
    contact_base: ClassVar[int] = 0
    sensor_base: ClassVar[int] = 0
    """Added to the numbers of digital and of analog inputs."""
    contact_form: ClassVar[str] = "digital {number}"
    sensor_form: ClassVar[str] = "analog {number}"
    """What an input is in the controller."""
    states: ClassVar[tuple[str, str]] = ("0", "1")
    wait_contact: ClassVar[tuple[str, ...]] = ()
    wait_sensor: ClassVar[tuple[str, ...]] = ()
    """Wait with a time-out for a contact, of ``input``, ``name``, ``state`` and ``other`` state, or for a quantity, of
    ``reading`` and ``least``; of ``index`` from 1, a ``label``, ``seconds``, ``tenths``, ``ms`` and ``message`` too."""
    watch: ClassVar[tuple[str, ...]] = ()
    """Begins to watch a contact while the program runs, with the words of its wait."""
    longest_message: ClassVar[int] = 60
    watch_note: ClassVar[str] = ""
    """What of a watched input the program leaves to the integrator."""
    start_words: ClassVar[str] = "set {start} to its number"
    """How the operator chooses the part to start at."""

    def operand(self, value: float, digits: int = 6) -> str:
        """Write a number in an expression; a negative one stands in brackets where the language requires it."""
        text = short(value, digits)
        return f"{self.brackets[0]}{text}{self.brackets[1]}" if self.brackets and text.startswith("-") else text

    def quantity(self, sensor: Sensor) -> str:
        """Write the quantity that an input shows."""
        raise NotImplementedError

    def call_name(self, name: str) -> str:
        """Name in the language of a routine that a ``CALL`` names."""
        raise NotImplementedError

    # What main does

    def wait_lines(self, forms: Sequence[str], index: int, wait: Wait) -> list[str]:
        """Fill in the forms of a wait."""
        words = {
            "index": str(index),
            "label": str(WAIT_LABEL + index),
            "ready": str(READY_LABEL + index),
            "hundredths": short(100.0 * wait.timeout_s, 0),
            "interrupt": str(INTERRUPT + index),
            "error": str(ERROR + index),
            "seconds": short(wait.timeout_s, 1),
            "tenths": short(10.0 * wait.timeout_s, 0),
            "ms": short(1000.0 * wait.timeout_s, 0),
            "message": self.message(wait.shown),
            "words": self.message(wait.words),
        }
        if wait.contact is not None:
            words |= {"input": str(wait.contact.number + self.contact_base), "name": wait.contact.name}
            words |= {"state": self.states[wait.state], "other": self.states[not wait.state]}
        if wait.sensor is not None:
            words |= {"reading": self.quantity(wait.sensor), "least": self.operand(wait.least)}
            words |= {"input": str(wait.sensor.number + self.sensor_base), "name": wait.sensor.name}
            scale, offset = self.dialect.capability.analog.reading(wait.sensor)
            words |= {"scale": self.operand(scale, 9), "offset": self.operand(offset, 9)}
        return [line for form in forms if (line := form.format(**words))]

    def message(self, text: str) -> str:
        """Give a message that stands in a string of any language."""
        return cut("".join(letter if letter not in "\"'();:,{}[]!\\" else " " for letter in text), self.longest_message)

    def waits(self) -> Iterator[str]:
        """Write the waits, then begin to watch."""
        numbered = list(enumerate(self.installation.waits, start=1))
        for index, wait in numbered:
            yield from self.wait_lines(self.wait_contact if wait.contact else self.wait_sensor, index, wait)
        for index, wait in numbered:
            if wait.watched:
                yield from self.wait_lines(self.watch, index, wait)

    def watched_lines(self, *forms: str) -> Iterator[str]:
        """Fill in forms for each watched contact, by ``input``, ``name``, ``words``, ``state`` and ``other``."""
        for wait in self.installation.waits:
            if wait.watched and wait.contact is not None:
                words = {"input": wait.contact.number, "name": wait.contact.name, "words": wait.words}
                words |= {"state": self.states[wait.state], "other": self.states[not wait.state]}
                yield from (form.format(**words, message=self.message(wait.shown)) for form in forms)

    # What the header states

    @property
    def valves(self) -> list[Channel]:
        """Outputs of valves that the program uses, by their numbers."""
        valves = {valve.channel for valve in self.installation.valves.values()}
        return [channel for channel in channels_of(self.motion) if channel in valves]

    @property
    def chapters(self) -> list[Chapter]:
        """Parts of main without its loops."""
        return [part for part in self.parts if isinstance(part, Chapter)]

    def frame_lines(self) -> Iterator[str]:
        """State what is waited for and what is not, where the program may start, and what has to be set up."""
        names = dict.fromkeys(step.name for step in self.motion.steps if isinstance(step, Call))
        yield from (f"You provide {self.call_name(name)}: it returns when {_purpose(name)}" for name in names)
        tools = {str(step.number): step.nozzle for step in self.motion.steps if isinstance(step, UseTool)}
        if len(tools) > 1:
            yield f"You change the tools, {name_tools(tools)}: {TOOLS_CHANGED}"
        if not self.enter_begin:
            return
        waits = [wait for wait in self.installation.waits if wait.contact or self.wait_sensor]
        known = {wait.name for wait in self.installation.waits}
        if unread := [wait.words for wait in self.installation.waits if wait not in waits]:
            yield f"Does not wait for {', '.join(unread)}: this language reads no analog input"
        if waits:
            yield f"Waits for {', '.join(map(_describe, waits))}"
        if lacking := [name.replace("_", " ") for name in USUAL_WAITS if name not in known]:
            yield f"Does not wait for {', '.join(lacking)}: the cell maps no such input"
        if watched := [wait.words for wait in waits if wait.watched]:
            yield f"Stops, valves shut, without {', '.join(watched)}{self.watch_note}"
        yield f"Parts: {', '.join(f'{part.number} {part.title}' for part in self.chapters)}"
        if (last := len(self.chapters)) > 1:
            chosen = self.start_words.format(start=self.start)
            yield f"To finish a stopped board from part 2 to {last}: {chosen}{self.ways_from_home()}"
        yield from (f"Set up: {line}" for line in self.setup())

    def ways_from_home(self) -> str:
        """State which of the joint motions from home to a later part are clear."""
        if all(entry.is_clear is None for entry in self.part_entries.values()):
            return "; its way from home was not checked"
        blocked = [str(number) for number, entry in self.part_entries.items() if entry.is_clear is False]
        clear = "; the ways from home were checked"
        return clear if not blocked else f"{clear}, and none is clear to part {', '.join(blocked)}: do not start there"

    def setup(self) -> Iterator[str]:
        """State what the integrator has to set up in the controller."""
        return iter(())

    def page_lines(self) -> Iterator[str]:
        """Give the lines of the frame, and the inputs, for a page beside the program."""
        yield from self.frame_lines()
        yield from (line for line in self.signal_lines() if line.startswith("Input "))

    def signal_lines(self) -> Iterator[str]:
        """List outputs and inputs by name and number, with what they are for."""
        for channel in channels_of(self.motion):
            yield f"Output {channel.name}: {self.output_words(channel)}"
        for wait in self.installation.waits:
            for each, form, base in (
                (wait.contact, self.contact_form, self.contact_base),
                (wait.sensor, self.sensor_form, self.sensor_base),
            ):
                if each is not None:
                    yield f"Input {each.name}: {form.format(number=each.number + base)}, {wait.words}"

    def output_words(self, channel: Channel) -> str:
        """Give what an output is in the controller: here its kind, its number, and the nozzle that it opens."""
        nozzles = {valve.channel: nozzle for nozzle, valve in self.installation.valves.items()}
        opens = f", opens {nozzles[channel]}" if channel in nozzles else ""
        return f"{channel.kind} {channel.number}{opens}"


def name_tools(tools: Mapping[str, str]) -> str:
    """Name tools by their numbers, with the nozzle that each has."""
    return " and ".join(f"{number} ({nozzle})" for number, nozzle in tools.items())


def _purpose(name: str) -> str:
    return "the board is turned over and held" if name.startswith("flip") else "its work is done"


def _describe(wait: Wait) -> str:
    least = "" if wait.sensor is None else f" at least {short(wait.least, 6)}{_unit_of(wait.quantity)}"
    return f"{wait.words}{least} ({short(wait.timeout_s, 1)} s)"


def _unit_of(quantity: str) -> str:
    """Give the unit that the key of a quantity ends in, or the key where that is none."""
    unit = next((unit for end, unit in _UNITS.items() if quantity.endswith(f"_{end}")), quantity)
    return f" {unit}" if unit else ""
