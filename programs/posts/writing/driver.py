"""The skeleton of every writer: walks the routines and steps of a lowered program, and has a syntax write each."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import ClassVar

from programs.motion.handshake import after_motion, after_waits, before_waits
from programs.motion.installation import Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, Pause, Reach, Repeat, UseBoard, UseTool
from programs.posts.dialect import PAGE_ENDING, Dialect, Handover, ProgramFiles
from programs.posts.writing.chapters import Chapter, Placed, nest, place_events
from programs.posts.writing.entries import safe_height
from programs.posts.writing.forms import fill, fixed, short
from programs.posts.writing.frame import PART_LABEL, heading, sheet, short_heading
from programs.posts.writing.joint_moves import CAUTIOUS
from programs.posts.writing.steps import StepSyntax
from programs.posts.writing.wording import cut, indent, make_name
from specs.source import NO_SOURCE


@dataclass(frozen=True, slots=True)
class Routine:
    """A routine as text, the main one too."""

    name: str
    number: int
    """Of its chapter; 0 for main."""
    body: list[str]
    data: list[str]
    """Declarations that belong to it, such as its points."""


class Syntax(StepSyntax, ABC):
    """How one program is written in one language; a language is a subclass, with its words, limits and forms."""

    longest_heading: ClassVar[int] = 196
    """Characters of a comment in the header."""
    home_comment: ClassVar[str] = ""
    rise_forms: ClassVar[tuple[str, ...]] = ()
    """Lines that raise the orifice of a ``tool`` to a ``height`` before anything else; empty where an axis does."""
    counter: ClassVar[str] = "nLoop{number}"
    first_counter: ClassVar[int] = 1
    """Of the loops, by their ``number``, and the number of the first."""
    loop_text: ClassVar[str] = "until {key} >= {least}, {count} times at most"
    """Of the comment before a loop."""
    loop_begin: ClassVar[tuple[str, ...]] = ()
    loop_end: ClassVar[tuple[str, ...]] = ()
    """Lines around a loop, of its ``number``, ``counter``, ``count`` and ``condition``; empty ones are left out.

    Of its ``label`` too, and of the one ``after`` it."""
    sensed_begin: ClassVar[tuple[str, ...]] = ()
    sensed_end: ClassVar[tuple[str, ...]] = ()
    """The same of a loop that reads an input, where they are others: of its ``input``, ``scale`` and ``offset`` too."""
    loop_label: ClassVar[int] = 500
    """Labels of loops begin after it."""
    comments_counting: ClassVar[bool] = True
    """Whether a loop that only counts has a comment."""
    counted: ClassVar[str] = ""
    sensed: ClassVar[str] = ""
    """Condition of a loop that counts, and of one that reads an input too: of ``reading`` and ``least`` as well."""
    last: ClassVar[tuple[str, ...]] = ()
    """End of main."""
    declare_counter: ClassVar[str] = ""
    """Of the ``counter`` of a loop; empty where main does not declare it."""
    begin: ClassVar[tuple[str, ...]] = ()
    """Statements before all others."""
    page: ClassVar[str] = ""
    """Suffix of the text beside programs whose headers are short; empty where they have the whole header."""
    routine_form: ClassVar[tuple[str, str]]
    """First and last line of a ``routine``."""
    longest_title: ClassVar[int] = 20
    """Characters of a routine's name before its number."""
    names_parts_by_program: ClassVar[bool] = False
    """Whether routines are known outside the program, so that they have its name."""
    numbers_points_by_routine: ClassVar[bool] = False
    """Whether the points of each routine are numbered from the first again."""
    indents_loops: ClassVar[bool] = True
    """Whether what is in a loop of main is indented."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.rises = False
        """Whether main raises the orifice first."""

    @classmethod
    def write(cls, dialect: Dialect, lowered: Lowered, installation: Installation) -> tuple[ProgramFiles, Handover]:
        """Write a program: its routines in their order, then main, then the files that hold them; and its facts."""
        syntax = cls(dialect, lowered, installation)
        routines = [
            syntax.routine(syntax.routine_name(part), part.number, syntax.chapter(part))
            for part in syntax.parts
            if isinstance(part, Chapter)
        ]
        files = syntax.files(syntax.routine(syntax.name, 0, syntax.main()), routines)
        return files, syntax.handover()

    # Routines

    def routine(self, name: str, number: int, lines: Iterable[str]) -> Routine:
        """Write a routine from its lines; it begins without declarations and modal words."""
        self.data, self.settings = [], {}
        self.points = 0 if self.numbers_points_by_routine else self.points
        return Routine(name, number, list(lines), self.data)

    def whole(self, name: str, body: Iterable[str], **words: object) -> list[str]:
        """Write a routine with its first and last line, and an empty one after it."""
        begin, end = (fill(form, routine=name, **words) for form in self.routine_form)
        return [begin, *indent(body), end, ""]

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a chapter: the frames it begins with, its steps, and a comment wherever the recipe path changes."""
        for frame in self.initial_frames(chapter):
            if frame is not None:
                yield from self.use(frame)
        yield from self.enter(chapter)
        maker = NO_SOURCE
        for placed in place_events(chapter.steps):
            step = placed.step
            if step.made_by != maker and isinstance(step, Line | Reach | Pause):
                maker = step.made_by
                yield self.comment(str(maker))
            yield from self.statements(step, placed)

    def enter(self, chapter: Chapter) -> Iterator[str]:
        """Write what a part does first if the program starts there; modal words are then as before it."""
        if not self.enter_begin or chapter.number not in self.part_entries:
            return
        words = {"start": self.start, "number": str(chapter.number)}
        yield from (form.format(**words) for form in self.enter_begin)
        indent = "  " if self.indents_loops else ""
        for step in (*self.entry_frames(chapter), *self.part_entries[chapter.number].steps):
            yield from (f"{indent}{line}" for line in self.statements(step, Placed(step)))
        yield from (form.format(**words) for form in self.enter_end)
        self.settings.clear()
        self.forget()

    def entry_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard]:
        """Give what is selected at the start only, as the parts before it have done so otherwise."""
        return ()

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Give what a routine selects first."""
        return (chapter.board, chapter.tool)

    def main(self) -> Iterator[str]:
        """Write main: preparation, guard and waits, home, the routines with their loops, home, end."""
        yield from self.prepare()
        yield from self.begin_production()
        yield from self.rise()
        home = list(self.home())
        yield from home
        for margin, part in nest(self.parts):
            if isinstance(part, Chapter):
                words = {"start": self.start, "number": str(part.number), "label": str(PART_LABEL + part.number)}
                words["call"] = self.call(self.routine_name(part))
                lines = [form.format(**words) for form in self.part_form]
            else:
                write = self.begin_loop if part.begins else self.end_loop
                lines = write(part.number, part.loop)
            yield from (f"{margin if self.indents_loops else ''}{line}" for line in lines)
        yield from home
        yield from self.end_watches()
        yield from self.acts(after_motion(self.installation.handshake))
        yield from self.last

    def begin_production(self) -> Iterator[str]:
        """Write the guard, shut all valves, and wait for what the cell maps; nothing in languages without the forms."""
        guard = [] if self.motion.first_run else self.with_fault(self.guard)
        shut = [self.call(self.shut_name)] if self.enter_begin else []
        line = self.installation.handshake
        yield from (*guard, *shut) if line is None else (*shut, *self.acts(before_waits(line)), *guard)
        yield from self.waits()
        yield from self.acts(after_waits(line))

    def shut(self) -> list[str]:
        """Write the body of the routine that shuts the valves."""
        return [self.output(channel, 0.0) for channel in self.valves]

    def prepare(self) -> Iterable[str]:
        """Write what comes before the first motion: the short header, counters, settings, frames."""
        if self.page:
            yield from map(self.comment, short_heading(self.lowered, self.installation, f"{self.name}{self.page}"))
        for number in self.loops if self.declare_counter else ():
            yield self.declare_counter.format(counter=self.counter.format(number=number))
        yield from self.begin
        if self.set_tool:
            yield from self.slot_lines()

    def sheet(self, main: str, tables: Iterable[str] = ()) -> ProgramFiles:
        """Write the text beside the program, whose main file has a name; and tables that are in no other file."""
        page = f"{main}{PAGE_ENDING}"
        lines = [
            *self.frame_lines(),
            "",
            f"What to load, enter, wire and check, with tools, frames and signals: {page}",
        ]
        return {f"{self.name}{self.page}": sheet(self.dialect, self.lowered, self.installation, (*lines, *tables))}

    def rise(self) -> list[str]:
        """Raise the orifice of the first tool straight up if it is lower than the program ever has it in its lines."""
        height, tool = safe_height(self.motion, self.installation), self.first_tool()
        if not self.rise_forms or height is None or not tool:
            return []
        self.rises = True
        return [form.format(tool=tool, height=self.height(height)) for form in self.rise_forms]

    def first_tool(self) -> str:
        """Give the name, or the number, of the tool that the program uses first; empty if it uses none."""
        return next(iter(self.tools or map(str, self.slots.tools.values())), "")

    def height(self, millimetres: float) -> str:
        """Write a height above the base's origin."""
        return fixed(millimetres, 1)

    def home(self) -> Iterable[str]:
        """Write the motion to the cell's home; nothing where it has none."""
        home = self.installation.home
        return [*self.slow_down(CAUTIOUS), f"{self.joint_move(home)}{self.home_comment}"] if home else []

    def heading(self, *more: str) -> list[str]:
        """Write the header as comments; its last lines are the language's own."""
        general = heading(self.dialect, self.lowered, self.installation)
        lines = (*general, *self.frame_lines(), *self.signal_lines(), *more)
        return [self.comment(line, self.longest_heading) for line in lines]

    @abstractmethod
    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Put the routines into files, the one to start with first."""

    def routine_name(self, chapter: Chapter) -> str:
        """Name the routine of a chapter."""
        title = self.name if self.names_parts_by_program else make_name(chapter.title, self.longest_title)
        proposed = f"{title}{self.name_link}{chapter.number:0{self.digits}d}"
        return self.names.give("routine", chapter.number, proposed)

    @property
    def fits_one_file(self) -> bool:
        """Whether all routines together are no longer than one may be."""
        steps = sum(len(part.steps) for part in self.parts if isinstance(part, Chapter))
        return steps <= self.dialect.most_steps

    # Loops

    def begin_loop(self, number: int, loop: Repeat) -> list[str]:
        """Begin a loop of main; loops are numbered from 1."""
        comment = [self.loop_comment(loop)] if loop.sensor is not None or self.comments_counting else []
        forms = (loop.sensor and self.sensed_begin) or self.loop_begin
        return [*comment, *self.loop_lines(forms, number, loop)]

    def end_loop(self, number: int, loop: Repeat) -> list[str]:
        """End a loop of main."""
        return self.loop_lines((loop.sensor and self.sensed_end) or self.loop_end, number, loop)

    def loop_lines(self, forms: Sequence[str], number: int, loop: Repeat) -> list[str]:
        """Fill in the lines of a loop."""
        label = self.loop_label + number
        counter = self.counter.format(number=self.first_counter - 1 + number)
        words = {"number": str(number), "counter": counter, "count": str(loop.count)}
        words |= {"label": str(label), "after": str(label + 100)}
        condition = self.counted
        if (sensor := loop.sensor) is not None:
            condition = self.sensed
            scale, offset = (self.operand(each, 9) for each in self.dialect.capability.analog.reading(sensor))
            words |= {"reading": self.quantity(sensor), "least": self.operand(loop.least)}
            words |= {"scale": scale, "offset": offset, "input": str(sensor.number + self.sensor_base)}
        words["condition"] = condition.format(**words)
        return [line for form in forms if (line := form.format(**words))]

    def loop_comment(self, loop: Repeat) -> str:
        """Write under which condition a loop ends."""
        least = short(loop.least, 6)
        return self.comment(self.loop_text.format(key=cut(loop.key, 40), least=least, count=loop.count))

    @property
    def loops(self) -> range:
        """Numbers of the loops."""
        return range(1, 1 + sum(isinstance(part, Repeat) for part in self.parts))
