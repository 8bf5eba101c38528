"""The production frame around a program: guard, waits and faults before the first motion, and where it may start."""

from collections.abc import Iterable, Iterator, Sequence
from typing import ClassVar

from programs.motion.analog import analog_channels
from programs.motion.installation import Channel, Installation, Sensor, Wait
from programs.motion.lower import Lowered
from programs.motion.steps import Await, Line, Reach, Step, Switch
from programs.posts.dialect import Dialect
from programs.posts.writing.chapters import Placed
from programs.posts.writing.forms import short
from programs.posts.writing.handover import HandedOver
from programs.posts.writing.wording import cut, join_lines, plain

FIRST_RUN_ADVICE = (
    "in manual mode, then in automatic with a hand on the stop; the override may be below 100 %",
    "then load the program exported without --first-run, which has another name",
)
_MOST_FINDINGS = 12
_AWAIT = 91
"""Index among the waits of those of the handshake."""
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
    if motion.first_run:
        notes += [f"FIRST RUN: {words}" for words in (*motion.first_run.split("; "), *FIRST_RUN_ADVICE)]
    elif dialect.maker is not None and any(step.way for step in motion.steps if isinstance(step, Reach)):
        notes.append("Joint motions take their planned times: first run at reduced speed, in manual mode, valves dry")
    if (forecast := lowered.forecast) is not None:
        event = f"{forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms at predicted speeds"
        notes.append(f"Predicted time {forecast.describe()}")
        notes.append(f"Worst event error {event}{f' ({forecast.event_by})' if forecast.event_by else ''}")
    lines = (
        f"{dialect.title}, written by Washboard",
        f"{installation.workpiece.capitalize():6s} {origin.board}  sha256 {origin.board_sha256}",
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
        *(["FIRST RUN, valves stay shut"] if lowered.motion.first_run else []),
        f"Washboard: {installation.workpiece} {origin.board}",
        f"recipe {origin.recipe}",
        f"cell {installation.cell}",
        *predicted,
        f"Event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms",
        f"Frames: see {page}",
    )


def sheet(dialect: Dialect, lowered: Lowered, installation: Installation, more: Iterable[str]) -> str:
    """Write the text beside programs whose comments are short: the header of every other program.

    Args:
        dialect: The language.
        lowered: The program.
        installation: The cell.
        more: What follows there.
    """
    return join_lines(cut(line, _WIDTH) for line in (*heading(dialect, lowered, installation), "", *more))


PART_LABEL, WAIT_LABEL, READY_LABEL, INTERRUPT, ERROR, MOUNT_ERROR = 200, 300, 400, 21, 9100, 9200
"""Labels of parts, of waits and of what follows them, interrupts and errors, of waits and tools, begin after these."""


def under_each(forms: Sequence[str], *conditions: str) -> Iterator[tuple[str, ...]]:
    """Give forms for each ``condition`` in them, as for that of a contact and of a quantity."""
    return (tuple(form.replace("{condition}", condition) for form in forms) for condition in conditions)


class ProductionFrame(HandedOver):
    """Forms of the frame in one language, and what is filled into them; ``Syntax`` is made of it.

    Forms are lines of text; empty ones are left out. A language without a form does not have what it is for, and its
    ``setup`` states what the integrator has to provide in its place.
    """

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
    states: ClassVar[tuple[str, str]] = ("0", "1")
    wait_contact: ClassVar[tuple[str, ...]] = ()
    """Wait with a time-out for a contact, of ``input``, ``name``, ``state`` and ``other`` state; ``wait_sensor`` for a
    quantity, of ``reading`` and ``least``. Of ``index`` from 1, a ``label``, ``seconds``, ``tenths``, ``ms`` and
    ``message`` too."""
    watch: ClassVar[tuple[str, ...]] = ()
    """Begins to watch a contact while the program runs, with the words of its wait."""
    end_watch: ClassVar[tuple[str, ...]] = ()
    """Ends that at the end of main, and while a person may open the cell."""
    await_contact: ClassVar[tuple[str, ...]] = ()
    """Waits without a time-out for a watched contact, with the words of its wait."""
    await_forms: ClassVar[tuple[str, ...]] = ()
    """The same of a contact that is not watched, in languages that do not have ``await_contact``."""
    fault_form: ClassVar[str] = ""
    """Sets the output of a number or name, ``fault``; empty where it is as digital outputs are."""
    longest_message: ClassVar[int] = 60

    def operand(self, value: float, digits: int = 6) -> str:
        """Write a number in an expression; a negative one stands in brackets where the language requires it."""
        text = short(value, digits)
        return f"{self.brackets[0]}{text}{self.brackets[1]}" if self.brackets and text.startswith("-") else text

    def quantity(self, sensor: Sensor) -> str:
        """Write the quantity that an input shows."""
        raise NotImplementedError

    def output(self, channel: Channel, value: float) -> str:
        """Set an output."""
        raise NotImplementedError

    def statements(self, step: Step, placed: Placed) -> Iterable[str]:
        """Write one step."""
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
        return [line for form in self.with_fault(forms) if (line := form.format(**words))]

    def with_fault(self, forms: Sequence[str]) -> list[str]:
        """Have forms set the output of a fault before the program stops itself; they do not where there is none."""
        line = self.installation.handshake
        if line is None or line.fault is None:
            return [form for form in forms if "{fault}" not in form]
        return [form.replace("{fault}", self.output(line.fault, 1.0)) for form in forms]

    def acts(self, steps: Iterable[Step]) -> Iterator[str]:
        """Write the steps of the handshake."""
        for step in steps:
            if isinstance(step, Switch):
                yield from self.statements(step, Placed(step))
            elif isinstance(step, Await):
                wait = Wait("", step.contact, step.state, None, 0.0, 0.0)
                yield from self.wait_lines(self.await_forms or self.await_contact, _AWAIT + step.state, wait)

    def message(self, text: str) -> str:
        """Give a message that stands in a string of any language."""
        return cut("".join(letter if letter not in "\"'();:,{}[]!\\" else " " for letter in text), self.longest_message)

    def waits(self) -> Iterator[str]:
        """Write the waits, then begin to watch."""
        for index, wait in enumerate(self.installation.waits, start=1):
            yield from self.wait_lines(self.wait_contact if wait.contact else self.wait_sensor, index, wait)
        yield from self.of_watched(self.watch)

    def of_watched(self, forms: Sequence[str]) -> Iterator[str]:
        """Fill in the forms of each wait that is watched."""
        for index, wait in enumerate(self.installation.waits, start=1):
            if wait.watched:
                yield from self.wait_lines(forms, index, wait)

    def begin_watches(self) -> Iterable[str]:
        """Begin to watch again."""
        return self.of_watched(self.watch)

    def end_watches(self) -> Iterable[str]:
        """Watch no longer."""
        return self.of_watched(self.end_watch)

    def attended(self, lines: Iterable[str]) -> Iterator[str]:
        """Watch nothing while a person may be in the cell; then wait for what is watched, and watch again."""
        ends = [*self.end_watches()]
        yield from (*ends, *lines)
        if ends:
            yield from (*self.of_watched(self.await_contact), *self.begin_watches())

    def state_words(self, state: bool) -> str:
        """Write the state of a contact as the language does."""
        return self.states[state]
