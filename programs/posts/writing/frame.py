"""The production frame around a program: guard, waits and faults before the first motion, and where it may start."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import ClassVar

from programs.motion.analog import analog_channels
from programs.motion.installation import USUAL_WAITS, Channel, Installation, Sensor, Wait
from programs.motion.lower import Lowered
from programs.motion.steps import Call, Line, MotionProgram, Reach, Repeat, Switch, UseTool
from programs.posts.dialect import Dialect
from programs.posts.writing.chapters import Chapter, Part
from programs.posts.writing.entries import Entry
from programs.posts.writing.forms import short
from programs.posts.writing.wording import cut, join_lines, plain

_MOST_FINDINGS = 12
_WIDTH = 110


def heading(dialect: Dialect, lowered: Lowered, installation: Installation) -> tuple[str, ...]:
    """Give the lines of a program's header without comment marks: printable ASCII, of any length.

    It has no date and no path, so that the same program gives the same bytes.
    """
    motion, error, capability = lowered.motion, lowered.error, dialect.capability
    origin = motion.origin
    found = [f"{finding.severity}: {finding.message}" for finding in motion.findings if finding.severity != "info"]
    notes: list[str] = []
    lines_at = [at for at, step in enumerate(motion.steps) if isinstance(step, Line)]
    out, back = (
        sum(step.duration_s for step in part if isinstance(step, Reach))
        for part in (motion.steps[: min(lines_at, default=0)], motion.steps[max(lines_at, default=0) :])
    )
    if out or back:
        notes.append(f"In it {out:.1f} s from home and {back:.1f} s back, at half of the joints' speeds")
    if dialect.maker is not None and any(step.way for step in motion.steps if isinstance(step, Reach)):
        notes.append("Joint motions take their planned times: first run at reduced speed, in manual mode, valves dry")
    if (forecast := lowered.forecast) is not None:
        event = f"{forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms at predicted speeds"
        notes.append(f"Predicted time {forecast.describe()}")
        notes.append(f"Worst event error {event}{f' ({forecast.event_by})' if forecast.event_by else ''}")
    lines = (
        f"{dialect.title}, written by Washboard",
        f"Board  {origin.board}  sha256 {origin.board_sha256}",
        f"Recipe {origin.recipe}  sha256 {origin.recipe_sha256}",
        f"Cell   {installation.cell}  robot {installation.robot}",
        *([f"Held   {installation.held}"] if installation.held else []),
        f"Planned time {motion.duration_s:.1f} s, each loop once",
        *notes,
        f"Worst event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms at planned speeds"
        + (f" ({error.made_by})" if error.made_by else ""),
        f"Controller class {capability.controller_class}; cycle {1e3 * capability.cycle_s:g} ms is in the error",
        *(f"Analog {capability.analog.describe(channel)}" for channel in analog_channels(motion.steps)),
        *found[:_MOST_FINDINGS],
        *([f"and {len(found) - _MOST_FINDINGS} findings more"] if len(found) > _MOST_FINDINGS else []),
    )
    return tuple(plain(line) for line in lines)


def short_heading(lowered: Lowered, installation: Installation, page: str) -> tuple[str, ...]:
    """Give the lines of a header for comments of some 30 characters, the rest being on a page."""
    origin, error, forecast = lowered.motion.origin, lowered.error, lowered.forecast
    predicted = () if forecast is None else (f"Time {forecast.predicted_s:.1f} s, {forecast.ratio:.2f} x plan",)
    return (
        f"Washboard: board {origin.board}",
        f"recipe {origin.recipe}",
        f"cell {installation.cell}",
        *predicted,
        f"Event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms",
        f"Frames: see {page}",
    )


def sheet(dialect: Dialect, lowered: Lowered, installation: Installation, notes: Iterable[str]) -> str:
    """Write the page: the header of every program, the language's own notes, the outputs and inputs in use.

    Args:
        dialect: The language.
        lowered: The program.
        installation: The cell.
        notes: Tables, units and registers of the language.
    """
    outputs = (f"{channel.kind} output {channel.number}  {channel.name}" for channel in _channels(lowered.motion))
    inputs: dict[str, None] = {}
    for step in lowered.motion.steps:
        if isinstance(step, Repeat) and (sensor := step.sensor) is not None:
            reading = f"{step.key} = {short(sensor.scale, 6)} * reading + {short(sensor.offset, 6)}"
            inputs[f"analog input {sensor.number}  {sensor.name}: {reading}"] = None
    lines = [*heading(dialect, lowered, installation), "", *notes, "", *outputs, *inputs]
    return join_lines(cut(line, _WIDTH) for line in lines)


def channels_of(motion: MotionProgram) -> list[Channel]:
    """Give the outputs that a program sets, by kind and number."""
    return sorted(_channels(motion), key=lambda channel: (channel.kind, channel.number))


def _channels(motion: MotionProgram) -> dict[Channel, None]:
    """Outputs in the order in which they first change."""
    used: dict[Channel, None] = {}
    for step in motion.steps:
        if isinstance(step, Switch):
            used[step.channel] = None
        elif isinstance(step, Line):
            used |= {event.channel: None for event in step.events}
    return used


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
        yield from (
            f"You provide {self.call_name(name)}: it returns when "
            + ("the board is turned over and held" if name.startswith("flip") else "its work is done")
            for name in names
        )
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


def _describe(wait: Wait) -> str:
    least = ""
    if wait.sensor is not None:
        unit = next((unit for end, unit in _UNITS.items() if wait.quantity.endswith(f"_{end}")), wait.quantity)
        least = f" at least {short(wait.least, 6)}{f' {unit}' if unit else ''}"
    return f"{wait.words}{least} ({short(wait.timeout_s, 1)} s)"
