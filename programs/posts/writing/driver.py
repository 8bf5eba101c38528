"""The skeleton of every writer: walks the routines and steps of a lowered program, and has a syntax write each."""

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from typing import ClassVar

from programs.motion.installation import Channel, Installation, Sensor, Tool
from programs.motion.lower import Lowered
from programs.motion.steps import (
    Call,
    EndRepeat,
    Line,
    Note,
    Pause,
    Reach,
    Repeat,
    Step,
    Switch,
    UseBoard,
    UseTool,
)
from programs.pose import Pose
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.writing.axes import as_controller_counts
from programs.posts.writing.chapters import Chapter, Part, divide, nest
from programs.posts.writing.entries import find_entries, safe_height
from programs.posts.writing.frame import PART_LABEL, ProductionFrame
from programs.posts.writing.heading import heading
from programs.posts.writing.joint_moves import CAUTIOUS, Pace, pace_moves
from programs.posts.writing.lines import Placed, follow, place_events
from programs.posts.writing.naming import Names, number_slots
from programs.posts.writing.wording import cut, fixed, make_name, short
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


class Syntax(ProductionFrame, ABC):
    """How one program is written in one language; a language is a subclass.

    The class attributes hold what is a word or a limit. The methods write one kind of step each; those without a body
    here differ too much between languages to have a common form.
    """

    mark: ClassVar[str]
    """Before a comment, with its space."""
    longest_comment: ClassVar[int] = 100
    """Characters of a comment in a routine."""
    longest_heading: ClassVar[int] = 196
    """Characters of a comment in the header."""
    call_form: ClassVar[str]
    """Of a routine, by its name: ours or the integrator's."""
    pause_form: ClassVar[str] = ""
    """Of a pause in seconds with three decimals."""
    digital: ClassVar[str] = ""
    group: ClassVar[str] = ""
    analog: ClassVar[str] = ""
    """Forms that set an output of each kind, of its ``name``, ``number`` and ``value``."""
    off_on: ClassVar[tuple[str, str]] = ("0", "1")
    """Values of a digital output."""
    to_joints: ClassVar[str] = ""
    """Of a motion to joint values: those, with commas between them, and ``percent`` of the joints' speeds."""
    by_joints: ClassVar[str] = ""
    """Of a motion by joints to a point, likewise."""
    straight: ClassVar[str] = ""
    """Of the line to a point that is left after its joint values."""
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
    """Lines around a loop, of its ``number``, ``counter``, ``count`` and ``condition``; empty ones are left out."""
    counted: ClassVar[str] = ""
    sensed: ClassVar[str] = ""
    """Condition of a loop that counts, and of one that reads an input too: of ``reading`` and ``least`` as well."""
    reading: ClassVar[str] = ""
    """Of the quantity that an input shows: ``scale``, ``name`` or ``number`` of the input, ``offset``."""
    reading_digits: ClassVar[int] = 9
    select_tool: ClassVar[str] = ""
    select_board: ClassVar[str] = ""
    """Of another tool or frame from now on, by its number; empty where numbers stand with the points."""
    most_frames: ClassVar[int | None] = None
    """Numbers of tools, and of frames, from 1; ``None`` where tools have any number."""
    last: ClassVar[tuple[str, ...]] = ()
    """End of main."""
    rounds_groups: ClassVar[bool] = False
    """Whether a group takes whole numbers only."""
    reserved: ClassVar[AbstractSet[str]] = frozenset()
    """Words of the language that are no names; lower case."""
    longest_name: ClassVar[int]
    """Characters of a name."""
    longest_program_name: ClassVar[int] = 0
    """Characters of the program's name where that has to be shorter."""
    longest_title: ClassVar[int] = 20
    """Characters of a routine's name before its number."""
    setting_form: ClassVar[str] = "{} {}"
    """Of a modal word and its value."""
    numbers_points_by_routine: ClassVar[bool] = False
    """Whether the points of each routine are numbered from the first again."""
    indents_loops: ClassVar[bool] = True
    """Whether what is in a loop of main is indented."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        self.dialect, self.lowered, self.installation = dialect, lowered, installation
        self.motion = lowered.motion
        self.parts = self.divide()
        self.part_entries = find_entries(self.parts, installation, self.motion.is_clear)
        """What a part other than the first does if the program starts there."""
        self.name = make_name(self.motion.origin.board, self.longest_program_name or self.longest_name, self.reserved)
        self.names = self.make_names()
        for step in self.motion.steps:  # only the integrator's routines have names that are known outside the program
            if isinstance(step, Call):
                self.call_name(step.name)
        self.following = follow(self.motion.steps)
        """The line right after each line that is passed, by its identity."""
        self.slots = number_slots(self.motion, self.most_frames)
        """Tools and places of the board by numbers, for languages that number them."""
        self.tools: dict[str, Tool] = {}
        self.boards: dict[str, Pose] = {}
        self.poses: dict[str, Pose] = {}
        """Of tools and places of the board by their names, in the order of use."""
        self.paces: dict[int, Pace] = {}
        """Of the joint motions that take their planned times, by their identity."""
        if dialect.controller is not None:
            self.paces = pace_moves(self.motion.steps, installation, dialect.controller)
        self.points = 0
        """How many points have been numbered."""
        self.rises = False
        """Whether main raises the orifice first."""
        self.data: list[str] = []
        """Declarations of the routine that is being written."""
        self.settings: dict[str, str] = {}
        """Modal words in force in that routine."""

    @classmethod
    def write(cls, dialect: Dialect, lowered: Lowered, installation: Installation) -> ProgramFiles:
        """Write a program: its routines in their order, then main, then the files that hold them."""
        syntax = cls(dialect, lowered, installation)
        routines = [
            syntax.routine(syntax.routine_name(part), part.number, syntax.chapter(part))
            for part in syntax.parts
            if isinstance(part, Chapter)
        ]
        return syntax.files(syntax.routine(syntax.name, 0, syntax.main()), routines)

    # Routines

    def divide(self) -> tuple[Part, ...]:
        """Divide the program into what main calls and repeats."""
        return divide(self.motion, self.dialect.most_steps)

    def routine(self, name: str, number: int, lines: Iterable[str]) -> Routine:
        """Write a routine from its lines; it begins without declarations and modal words."""
        self.data, self.settings = [], {}
        self.points = 0 if self.numbers_points_by_routine else self.points
        return Routine(name, number, list(lines), self.data)

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
        for indent, part in nest(self.parts):
            if isinstance(part, Chapter):
                words = {"start": self.start, "number": str(part.number), "label": str(PART_LABEL + part.number)}
                words["call"] = self.call(self.routine_name(part))
                lines = [form.format(**words) for form in self.part_form]
            else:
                write = self.begin_loop if part.begins else self.end_loop
                lines = write(part.number, part.loop)
            yield from (f"{indent if self.indents_loops else ''}{line}" for line in lines)
        yield from home
        yield from self.last

    def begin_production(self) -> Iterator[str]:
        """Write the guard, shut all valves, and wait for what the cell maps; nothing in languages without the forms."""
        yield from self.guard
        if self.enter_begin:
            yield self.call(self.shut_name)
        yield from self.waits()

    def shut(self) -> list[str]:
        """Write the body of the routine that shuts the valves."""
        return [self.output(channel, 0.0) for channel in self.valves]

    def prepare(self) -> Iterable[str]:
        """Write what comes before the first motion."""
        return ()

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

    def begin_loop(self, number: int, loop: Repeat) -> list[str]:
        """Begin a loop of main; loops are numbered from 1."""
        return [self.loop_comment(loop), *self.loop_lines(self.loop_begin, number, loop)]

    def end_loop(self, number: int, loop: Repeat) -> list[str]:
        """End a loop of main."""
        return self.loop_lines(self.loop_end, number, loop)

    def loop_lines(self, forms: Sequence[str], number: int, loop: Repeat) -> list[str]:
        """Fill in the lines of a loop."""
        counter = self.counter.format(number=self.first_counter - 1 + number)
        words = {"number": str(number), "counter": counter, "count": str(loop.count)}
        condition = self.counted
        if (sensor := loop.sensor) is not None:
            condition = self.sensed
            words |= {"reading": self.quantity(sensor), "least": self.operand(loop.least)}
        words["condition"] = condition.format(**words)
        return [line for form in forms if (line := form.format(**words))]

    def quantity(self, sensor: Sensor) -> str:
        """Write the quantity that an input shows."""
        scale, offset = (
            self.operand(value, self.reading_digits) for value in self.dialect.capability.analog.reading(sensor)
        )
        return self.reading.format(scale=scale, name=sensor.name, number=sensor.number, offset=offset)

    @abstractmethod
    def files(self, main: Routine, routines: Sequence[Routine]) -> ProgramFiles:
        """Put the routines into files, the one to start with first."""

    # Steps

    def statements(self, step: Step, placed: Placed) -> Iterable[str]:
        """Write one step."""
        match step:
            case Line():
                yield from self.line(step, placed)
            case Reach():
                yield from self.reach(step)
            case Pause():
                yield from self.pause(step.duration_s)
            case Switch():
                yield self.output(step.channel, step.value)
            case UseTool() | UseBoard():
                yield from self.use(step)
            case Call():
                yield self.call(self.call_name(step.name))
                self.forget()
            case Note():
                yield self.comment(step.text)
            case Repeat() | EndRepeat():
                raise AssertionError("loops stand between routines")

    @abstractmethod
    def line(self, line: Line, placed: Placed) -> Iterable[str]:
        """Write a line, and the outputs that change on it."""

    def reach(self, reach: Reach) -> Iterable[str]:
        """Write a joint motion to a pose: to joint values and along the line that is left, or to the pose alone."""
        pace = self.pace(reach)
        yield from self.slow_down(pace)
        if reach.joints:
            yield self.joint_move(reach.joints, pace)
        form = self.straight if reach.joints else self.by_joints
        yield form.format(self.point(reach.target), percent=pace.percent)

    def pace(self, reach: Reach) -> Pace:
        """Give the speed of a joint motion: a cautious one where it is not planned where it begins."""
        return self.paces.get(id(reach), CAUTIOUS)

    def slow_down(self, pace: Pace) -> Iterable[str]:
        """Write the speed of the joint motions that follow, in languages in which it is modal."""
        return ()

    def joint_move(self, joints: tuple[float, ...], pace: Pace = CAUTIOUS) -> str:
        """Write a motion to joint values."""
        return self.to_joints.format(", ".join(self.joints(joints)), percent=pace.percent)

    def point(self, pose: Pose) -> str:
        """Write or declare a point on the board."""
        raise NotImplementedError

    def use(self, step: UseTool | UseBoard) -> Iterable[str]:
        """Use another tool or place of the board from now on."""
        self.slots.use(step)
        tool = isinstance(step, UseTool)
        form = self.select_tool if tool else self.select_board
        return [form.format(self.slots.tool if tool else self.slots.board)] if form else []

    def pause(self, seconds: float) -> Iterable[str]:
        """Hold the pose."""
        return (self.pause_form.format(fixed(seconds, 3)),)

    def output(self, channel: Channel, value: float) -> str:
        """Set an output."""
        match channel.kind:
            case "digital":
                form, word = self.digital, self.off_on[value > 0.5]
            case "group":
                form, word = self.group, self.number(round(value) if self.rounds_groups else value)
            case "analog":
                count = self.dialect.capability.analog.count(channel, value)
                form, word = self.analog, self.number(count)
        return form.format(name=channel.name, number=channel.number, value=word)

    def number(self, value: float) -> str:
        """Write the value of an output that is not digital."""
        return short(value, 6)

    def call(self, name: str) -> str:
        """Call a routine."""
        return self.call_form.format(name)

    def forget(self) -> None:
        """Write modal words again: an integrator's routine may have changed what they set."""
        self.settings.clear()

    def comment(self, text: str, longest: int = 0) -> str:
        """Write a comment."""
        return f"{self.mark}{cut(text, longest or self.longest_comment)}"

    # Words and names

    def heading(self, *more: str) -> list[str]:
        """Write the header as comments; its last lines are the language's own."""
        general = heading(self.dialect, self.lowered, self.installation)
        lines = (*general, *self.frame_lines(), *self.signal_lines(), *more)
        return [self.comment(line, self.longest_heading) for line in lines]

    def loop_comment(self, loop: Repeat) -> str:
        """Write under which condition a loop ends."""
        least = short(loop.least, 6)
        return self.comment(self.loop_text.format(key=cut(loop.key, 40), least=least, count=loop.count))

    def joints(self, joints: tuple[float, ...], digits: int = 4) -> list[str]:
        """Write joint values as the controller counts them: degrees and mm."""
        return [fixed(value, digits) for value in as_controller_counts(joints, self.installation)]

    def set(self, word: str, value: str) -> list[str]:
        """Write a modal word if its value is another."""
        if self.settings.get(word) == value:
            return []
        self.settings[word] = value
        return [self.setting_form.format(word, value)]

    def make_names(self) -> Names:
        """Begin the list of names: the program's, and the words of the language."""
        return Names(self.longest_name, {self.name.lower(), *self.reserved})

    def call_name(self, name: str) -> str:
        """Name a routine of the integrator's."""
        return self.names.give("call", name, name)

    def routine_name(self, chapter: Chapter) -> str:
        """Name the routine of a chapter."""
        title = make_name(chapter.title, self.longest_title)
        return self.names.give("routine", chapter.number, f"{title}_{chapter.number:02d}")

    def frame_name(self, step: UseTool | UseBoard, tool: str, board: str, mounted: str = "board") -> str:
        """Name a tool or a place of the board: a prefix, and its name in the cell; ``mounted`` where it lies first."""
        if isinstance(step, UseTool):
            nozzle = self.installation.tool(step.number)
            name = self.names.give("tool", step.number, f"{tool}{nozzle.name}")
            self.tools[name] = nozzle
            self.poses[name] = nozzle.T_flange_tcp
        else:
            name = self.names.give("board", step.placement, f"{board}{step.placement or mounted}")
            self.boards[name] = step.T_base_board
            self.poses[name] = step.T_base_board
        return name

    @property
    def loops(self) -> range:
        """Numbers of the loops."""
        return range(1, 1 + sum(isinstance(part, Repeat) for part in self.parts))

    @property
    def fits_one_file(self) -> bool:
        """Whether all routines together are no longer than one may be."""
        steps = sum(len(part.steps) for part in self.parts if isinstance(part, Chapter))
        return steps <= self.dialect.most_steps
