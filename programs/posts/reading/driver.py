"""The skeleton of every reader: a controller that executes a program's statements by a table of their patterns."""

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from typing import Any, ClassVar, Generic, Self, TypeAlias, TypeVar

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.pose import Pose, Quaternion, distance
from programs.posts.dialect import ProgramFiles
from programs.posts.rebuilt import (
    Axes,
    Due,
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadFrame,
    ReadHome,
    ReadLine,
    ReadPart,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadSignal,
    ReadStep,
    ReadSwitch,
    ReadTool,
    ReadWait,
    Rebuilt,
    TextPlace,
)

NUMBER = r"-?\d+(?:\.\d+)?"
N = rf"({NUMBER})"
"""A number that is kept."""
U = r"(\d+(?:\.\d+)?)"
"""A number that is kept and has no sign: times, speeds."""
_SAME_PLACE_MM = 5e-4
"""Places nearer than this are written with the same three decimals."""

_UNREADABLE = (ValueError, LookupError, ArithmeticError)
"""What numbers and names that no program has make of a statement that is executed."""

_MOST_DEGREES = 360.0
_UNIT = 3e-7
"""How far the length of a quaternion with seven decimals may be off."""

_Key = TypeVar("_Key")
_Value = TypeVar("_Value")
Action: TypeAlias = Callable[[re.Match[str]], None]
"""What a statement does, by its match."""


class Statement(str):
    """A statement without its comment and the blanks around it, and where it stands."""

    __slots__ = ("place",)

    def __new__(cls, text: str, place: TextPlace | None = None) -> Self:
        """Make a statement; text that the reader puts together stands nowhere."""
        made = super().__new__(cls, text)
        made.place = place
        return made

    place: TextPlace | None

    def become(self, text: str) -> "Statement":
        """Give other text at the same place."""
        return Statement(text, self.place)


def statements_of(file: str, text: str, comment: str = "") -> Iterator[Statement]:
    """Give the lines of a file without the blanks around them; empty ones too.

    Args:
        file: Its name.
        text: All of it.
        comment: What begins a comment, to the end of the line; nothing if comments stay.
    """
    for number, line in enumerate(text.splitlines(), start=1):
        kept = line.partition(comment)[0] if comment else line
        yield Statement(kept.strip(), TextPlace(file, number))


class EnteredError(Exception):
    """The program has come to the part that it starts at."""


def refusal(line: str, why: str) -> ProgramError:
    """Make the error of a line that cannot be read: the line, why, and where it stands."""
    return located(f"{line!r} {why}.", line)


def located(message: str, line: str) -> ProgramError:
    """Make an error at the place of a line, where that is known."""
    place = line.place if isinstance(line, Statement) else None
    return ProgramError(message, file=place and place.file, line=place and place.line)


class Declared(Generic[_Key, _Value]):
    """What a program declares of one kind: each once, and all of it used."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.values: dict[_Key, _Value] = {}
        self.used: set[_Key] = set()

    def add(self, key: _Key, value: _Value, line: str = "") -> None:
        """Declare a value.

        Raises:
            ProgramError: it is declared already.
        """
        if key in self.values:
            raise located(f"{self.what} {_words(key)} is declared twice.", line)
        self.values[key] = value

    def use(self, key: _Key) -> _Value:
        """Give a value that is used.

        Raises:
            ProgramError: it is not declared.
        """
        self.used.add(key)
        return look_up(self.values, key, f"{self.what} {_words(key)}")

    def check(self) -> None:
        """Make sure that all of it was used.

        Raises:
            ProgramError: something was not.
        """
        if unused := next((key for key in self.values if key not in self.used), None):
            raise ProgramError(f"{self.what} {_words(unused)} is declared and never used.")


def _words(key: object) -> str:
    return " ".join(map(str, key)) if isinstance(key, tuple) else str(key)  # type: ignore[reportUnknownArgumentType,reportUnknownVariableType]


class Reader(ABC):
    """A controller while it executes one program; a language is a subclass with a grammar."""

    shut_name: str = "shut_valves"
    """The fault routine; it is called before the first motion too."""
    reads_sensors: ClassVar[bool] = True
    """Whether the language can wait for a quantity."""
    writes_lines: ClassVar[bool] = True
    """Whether a line of the plan is one motion, and not several of the axes."""
    goes_home: ClassVar[bool] = True
    """Whether the language can go to joint values, as those of home."""
    home_in_tool_points: ClassVar[bool] = True
    """Whether home is a tool point too, where the cell's controller takes those."""
    handlers: ClassVar[AbstractSet[str]] = frozenset()
    """What has to call the fault routine, by the names that ``shut`` is given; none in languages without a frame."""

    def __init__(self) -> None:
        self.start = 1
        """The part to start at."""
        self.homes: list[ReadHome] = []
        """Motions to joint values; those from which a pose is reached are taken out again."""
        self.rise_mm: float | None = None
        """Height to which the orifice is raised before anything else moves."""
        self.parts: list[ReadPart] = []
        self.waits: list[ReadWait] = []
        self.watched: list[tuple[str, bool]] = []
        self.shut_by: set[str] = set()
        self.guards_override: bool | None = False
        self._entry_end: tuple[str, int] | None = None
        self.routines: dict[str, Sequence[str]] = {}
        """Statements by the routine's name."""
        self.steps: list[ReadStep] = []
        self.places: list[TextPlace | None] = []
        """Statement of each step."""
        self.routine, self.at = "", 0
        """The routine that runs, and its statement."""
        self.pose: Pose | None = None
        self.tool: ReadTool | None = None
        self.board: ReadBoard | None = None
        self.counted: tuple[float, ...] = ()
        """Joint values that it came to, as the controller counts them, degrees or mm: the next motion ends there.

        Empty where the last motion was no such one."""
        self.speed_share: float | None = None
        """Of joint motions, where their speed is modal or that of the last one to joint values."""
        self.lasts_s: float | None = None
        """Time that the last motion to joint values states."""
        self.terms = ReadLine(Axes(()), None, None)
        """Zone, turn rate and acceleration that are in force, or that the line to come states."""
        self.counters: dict[str, int] = {}
        """How often a loop's counter was raised, since it was set to 0."""
        self.loops: list[str] = []
        """Counters of the loops that run; empty for one that counts by itself."""
        self.declared: list[Declared[Any, Any]] = []
        self._used: tuple[ReadTool | None, ReadBoard | None] = (None, None)
        self._running: set[str] = set()
        self.called: set[str] = set()
        """Routines that were executed, or that are called in another way."""
        self._patterns: list[tuple[re.Pattern[str], Action]] = []

    @classmethod
    def rebuild(cls, files: ProgramFiles) -> Rebuilt:
        """Execute a program's files, each loop once.

        Raises:
            ProgramError: a file is missing, or a statement is not as the writer writes it.
        """
        reader, main = cls._loaded(files)
        reader.run(main)
        steps, places, frame = tuple(reader.steps), tuple(reader.places), None
        if reader.handlers:
            parts = tuple(replace(part, entry=reader.enter_at(files, part.number)) for part in reader.parts)
            shut = reader.read_shut()
            frame = ReadFrame(
                tuple(reader.waits), tuple(reader.watched), parts, shut, reader.guards_override, cls.reads_sensors
            )
        reader.finish()
        return Rebuilt(
            steps,
            places=places,
            frame=frame,
            dues=cls.due if cls.writes_lines else None,
            rise_mm=reader.rise_mm,
            homes=tuple(reader.homes) if cls.goes_home else None,
            home_in_tool_points=cls.home_in_tool_points,
        )

    @classmethod
    def _loaded(cls, files: ProgramFiles) -> tuple[Self, str]:
        """Give a controller that has loaded the files, and its main routine."""
        reader = cls()
        try:
            main = reader.load(files)
            reader._patterns = [(re.compile(pattern), action) for pattern, action in reader.grammar().items()]
        except _UNREADABLE as error:
            raise ProgramError(f"a declaration cannot be read ({error}).", file=next(iter(files), None)) from None
        return reader, main

    def enter_at(self, files: ProgramFiles, part: int) -> tuple[ReadStep, ...]:
        """Execute a program that starts at a part, as far as that part's own steps; what it uses counts as used."""
        if part == 1:
            return ()
        reader, main = self._loaded(files)
        reader.start = part
        try:
            reader.run(main)
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

    # What a language states

    @abstractmethod
    def load(self, files: ProgramFiles) -> str:
        """Sort the files into routines and data, and give the name of the routine to start with."""

    @abstractmethod
    def grammar(self) -> Mapping[str, Action]:
        """Give the action of each statement by its pattern; the first that matches the whole statement counts."""

    @classmethod
    @abstractmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give what the text of a line has to state; another line may come right after it."""

    def declares(self, what: str) -> "Declared[Any, Any]":
        """Give an empty list of what a program declares of one kind; it is checked at the end."""
        self.declared.append(Declared(what))
        return self.declared[-1]

    def finish(self) -> None:
        """Make sure at the end that nothing is left over.

        Raises:
            ProgramError: a routine was never called, a loop has no end, or a declaration was not used.
        """
        if left := next((name for name in self.routines if name not in self.called), None):
            raise ProgramError(f"routine {left} is never called.")
        if self.loops:
            raise ProgramError("a loop has no end.")
        for each in self.declared:
            each.check()

    # Execution

    def run(self, name: str) -> None:
        """Execute a routine.

        Raises:
            ProgramError: there is none of that name, it calls itself, or one of its statements is unknown.
        """
        if name not in self.routines:
            raise ProgramError(f"there is no routine {name or 'to start with'}.")
        if name in self._running:
            raise ProgramError(f"routine {name} calls itself.")
        caller = self.routine, self.at
        self.routine, self.at = name, 0
        self._running.add(name)
        self.called.add(name)
        while self.at < len(self.routines[name]):
            if (self.routine, self.at) == self._entry_end:
                raise EnteredError
            self.do_statement(self.routines[name][self.at])
            self.at += 1
        self._running.remove(name)
        self.routine, self.at = caller

    def do_statement(self, statement: str) -> None:
        """Execute one statement, and keep where it stands for the steps that it makes.

        Raises:
            ProgramError: it is unknown, or not possible there; the message names file and line.
        """
        try:
            self.execute(statement)
        except ProgramError as refused:
            if refused.file is not None:
                raise
            raise located(str(refused), statement) from None
        except _UNREADABLE as error:
            raise refusal(statement, f"cannot be read ({error})") from None
        place = statement.place if isinstance(statement, Statement) else None
        self.places += [place] * (len(self.steps) - len(self.places))

    def execute(self, statement: str) -> None:
        """Execute one statement."""
        for pattern, action in self._patterns:
            if match := pattern.fullmatch(statement):
                action(match)
                return
        raise ProgramError(f"unknown statement {statement!r}.")

    def ahead(self, pattern: str) -> Iterator[re.Match[str]]:
        """Give the statements of the routine from the one that runs on that match a pattern."""
        matches = re.compile(pattern).fullmatch
        return (found for statement in self.routines[self.routine][self.at :] if (found := matches(statement)))

    def find_end(self, pattern: str, label: str, group: int = 1) -> re.Match[str]:
        """Find the statement ahead that ends a loop: it has the loop's label in a group.

        Raises:
            ProgramError: there is none.
        """
        end = next((found for found in self.ahead(pattern) if found[group] == label), None)
        if end is None:
            raise ProgramError(f"the loop {label} has no end.")
        return end

    def sort(self, lines: Iterable[str], begin: str, end: str) -> Iterator[str]:
        """Keep what stands in routines, and give what stands outside; empty lines count for nothing.

        Args:
            lines: Of a file, comments left out.
            begin: Pattern of a routine's first line; its first group is the name.
            end: Pattern of its last line.
        """
        inside: list[str] | None = None
        line = ""
        for line in lines:
            if match := re.fullmatch(begin, line):
                if inside is not None or match[1] in self.routines:
                    raise refusal(line, "begins within another, or twice")
                inside = []
                self.routines[match[1]] = inside
            elif re.fullmatch(end, line):
                if inside is None:
                    raise refusal(line, "ends nothing")
                inside = None
            elif line and inside is not None:
                inside.append(line)
            elif line:
                yield line
        if inside is not None:
            raise refusal(line, "is the last line, and a routine has no end")

    # The production frame

    def shut(self, by: str) -> Action:
        """Give the action of a statement that calls the fault routine, by what has it called."""

        def note(match: re.Match[str]) -> None:
            self.shut_by.add(by)

        return note

    def guard(self, match: re.Match[str]) -> None:
        """Refuse to start where the speed override is not 100 %."""
        self.guards_override = True

    def pass_to(self, pattern: str) -> int:
        """Give the number of the next statement of the routine that matches a pattern.

        Raises:
            ProgramError: there is none.
        """
        matches = re.compile(pattern).fullmatch
        statements = self.routines[self.routine]
        found = next((at for at in range(self.at + 1, len(statements)) if matches(statements[at])), None)
        if found is None:
            raise ProgramError(f"nothing ends {statements[self.at]!r}.")
        return found

    def expect(self, routine: str, *patterns: str) -> None:
        """Make sure that a routine which is not run has the statements that it has to have.

        Raises:
            ProgramError: it has others.
        """
        statements = self.routines.get(routine, [])
        self.called.add(routine)
        if len(statements) != len(patterns) or not all(map(re.fullmatch, patterns, statements)):
            raise ProgramError(f"{routine} is not as it is written.")

    def pass_on(self, *patterns: str) -> list[re.Match[str]]:
        """Give the statements after this one, which are executed with it, by their patterns.

        Raises:
            ProgramError: they are others.
        """
        found: list[re.Match[str]] = []
        for pattern in patterns:
            self.at += 1
            statements = self.routines[self.routine]
            statement = statements[self.at] if self.at < len(statements) else ""
            match = re.fullmatch(pattern, statement)
            if match is None:
                raise refusal(statement, "is not what belongs to the statement before it")
            found.append(match)
        return found

    def rise(self, *patterns: str, unit_mm: float = 1.0) -> None:
        """Read how the orifice is raised before anything else moves; each pattern has one group, the height.

        Raises:
            ProgramError: the statements are others, or differ in their height.
        """
        heights = {found[1] for found in self.pass_on(*patterns)}
        if len(heights) != 1:
            raise ProgramError("the orifice is compared with one height and raised to another.")
        self.raise_to(unit_mm * float(heights.pop()))

    def raise_to(self, height_mm: float) -> None:
        """Raise the orifice to a height before anything else moves.

        Raises:
            ProgramError: something moved before.
        """
        if self.steps or self.homes or self.rise_mm is not None:
            raise ProgramError("the orifice is raised after other motions.")
        self.rise_mm = height_mm

    def begin_part(self, number: str, end: str = "") -> bool:
        """Begin a part of main; whether it is done. Where it is not, go on after the statement that ends it.

        Args:
            number: Of the part.
            end: Pattern of that statement; nothing where the part is one statement.
        """
        self.parts.append(ReadPart(int(number), len(self.steps)))
        if self.start <= int(number):
            return True
        if end:
            self.at = self.pass_to(end)
        return False

    def enter(self, number: str, end: str) -> None:
        """Begin what a part does first if the program starts there; pass over it otherwise."""
        at = self.pass_to(end)
        if self.start == int(number):
            self.start, self._entry_end = 1, (self.routine, at)
        else:
            self.at = at

    def run_part(self, number: str, call: str, end: str) -> None:
        """Do a part of main whose call and end are the next statements, unless the start is at a later one."""
        done = self.begin_part(number)
        called, *_ = self.pass_on(call, end)
        if done:
            self.run(called[1])

    def wait_for(self, channel: str, state: bool, timeout_s: float) -> None:
        """Wait for a contact."""
        self.waits.append(ReadWait(channel, state, timeout_s))

    def wait_least(self, channel: str, condition: Sequence[str], timeout_s: float) -> None:
        """Wait for a quantity: scale, offset, least value."""
        scale, offset, least = map(float, condition)
        self.waits.append(ReadWait(channel, None, timeout_s, (scale, offset, least)))

    # Statements that many languages have

    def refuse(self, match: re.Match[str]) -> None:
        """Refuse a statement."""
        raise ProgramError(f"unknown statement {match[0]!r}.")

    def call(self, match: re.Match[str]) -> None:
        """Call a routine by its name: one of the program's, or one of the integrator's."""
        if match[1] in self.routines:
            self.run(match[1])
        else:
            self.steps.append(ReadCall(match[1]))

    def pause(self, match: re.Match[str]) -> None:
        """Hold the pose for so many seconds."""
        self.steps.append(ReadPause(float(match[1])))

    def hold(self, seconds: float, longest_s: float) -> None:
        """Hold the pose; what follows a wait of the longest time there is belongs to it."""
        last = self.steps[-1] if self.steps else None
        waits = last.duration_s / longest_s if isinstance(last, ReadPause) else 0.0
        if isinstance(last, ReadPause) and waits > 0.5 and abs(waits - round(waits)) < 1e-9:
            self.steps[-1] = ReadPause(last.duration_s + seconds)
        else:
            self.steps.append(ReadPause(seconds))

    def switch(self, channel: str, value: float) -> None:
        """Set an output."""
        self.steps.append(ReadSwitch(channel, value))

    def use_tool(self, label: str, T_flange_tcp: Pose | None) -> None:  # noqa: N803
        """Use another tool from now on; its pose is not known where it is in the controller's table."""
        self.tool = ReadTool(label, T_flange_tcp)

    def use_board(self, T_base_board: Pose | None) -> None:  # noqa: N803
        """Use another frame from now on."""
        self.board = ReadBoard(T_base_board)

    def move_joints(self, match: re.Match[str]) -> None:
        """Come to joint values: a list with commas in the first group, percents of the speed in the last of more."""
        if match.re.groups > 1:
            self.set_share(match[match.re.groups])
        self.come_to(float(word) for word in match[1].split(","))

    def set_share(self, percent: str) -> None:
        """Set the speed of joint motions.

        Raises:
            ProgramError: it is none.
        """
        self.speed_share = 0.01 * float(percent)
        if not 0.0 < self.speed_share <= 1.0:
            raise ProgramError(f"{percent} percent is no speed of a joint motion.")

    def move_to(self, place: Pose | tuple[float, ...]) -> None:
        """Come to a pose, or to joint values, by a joint motion."""
        if isinstance(place, Pose):
            self.reach(place)
        else:
            self.come_to(place)

    def come_to(self, counted: Iterable[float]) -> None:
        """Come to joint values, as the controller counts them."""
        self.counted = self.come_home(counted)

    def come_home(self, counted: Iterable[float]) -> tuple[float, ...]:
        """Come to joint values from which no pose is reached, and give them."""
        joints = tuple(counted)
        self.homes.append(ReadHome(len(self.steps), joints, self.speed_share))
        return joints

    def set_counter(self, match: re.Match[str]) -> None:
        """Set a loop's counter, the first group, to 0."""
        self.counters[match[1]] = 0

    def raise_counter(self, match: re.Match[str]) -> None:
        """Raise the counter, the first group, of the innermost loop.

        Raises:
            ProgramError: it is that of another one.
        """
        if not self.loops or self.loops[-1] != match[1]:
            raise ProgramError(f"{match[0]!r} does not count the innermost loop.")
        self.counters[match[1]] += 1

    def repeat(self, count: str, condition: Sequence[str | None] = (), counter: str = "") -> None:
        """Begin a loop.

        Args:
            count: How often at most.
            condition: Scale, input, offset and least value of the quantity; nothing where the loop only counts.
            counter: Its name; empty where the loop counts by itself.

        Raises:
            ProgramError: the counter was not set to 0.
        """
        if counter and self.counters.get(counter) != 0:
            raise ProgramError(f"the counter {counter} is not 0 where its loop begins.")
        self.loops.append(counter)
        words = [word for word in condition if word is not None]
        if not words:
            self.steps.append(ReadRepeat(int(count), None))
            return
        scale, channel, offset, least = words
        self.steps.append(ReadRepeat(int(count), float(least), (float(scale), float(offset)), channel))

    def end_repeat(self, match: re.Match[str]) -> None:
        """End the innermost loop.

        Raises:
            ProgramError: there is none, or it was not counted once.
        """
        counter = self.loops.pop() if self.loops else None
        if counter is None or (counter and self.counters.pop(counter) != 1):
            raise ProgramError(f"{match[0]!r} ends no loop, or one that is not counted once.")
        self.steps.append(ReadEndRepeat())

    # Motion

    def reach(self, pose: Pose, counted: tuple[float, ...] = ()) -> None:
        """Come to a pose by a joint motion: to joint values, or to the pose itself where there are none."""
        if counted:
            self.homes.pop()
        self._use_frames()
        self.steps.append(ReadReach(pose, counted, self.speed_share, self.lasts_s))
        self.pose, self.counted, self.lasts_s = pose, (), None

    def line(self, pose: Pose, stops: bool, speed_mm_s: float, signals: tuple[ReadSignal, ...] = ()) -> None:
        """Go straight to a pose, under ``terms``; after joint values it is there already."""
        if self.counted or self.pose is None:
            self.reach(pose, self.counted)
            return
        self._use_frames()
        zone = 0.0 if stops else self.terms.zone
        self.steps.append(
            replace(self.terms, target=pose, stops=stops, speed_mm_s=speed_mm_s, signals=signals, zone=zone)
        )
        self.pose = pose

    def state(self, **terms: float | None) -> None:
        """Put terms of lines in force: ``zone``, ``turn_deg_s``, ``duration_s``, and accelerations."""
        self.terms = replace(self.terms, **terms)  # pyright: ignore[reportArgumentType]

    def length_to(self, pose: Pose) -> float:
        """Millimetres to a pose; 0 where the tool only turns, and where the robot's own pose is not known."""
        length_mm = distance(self.pose, pose) if self.pose is not None else 0.0
        return length_mm if length_mm > _SAME_PLACE_MM else 0.0

    def _use_frames(self) -> None:
        if self.tool is None or self.board is None:
            raise ProgramError("the program moves before it selects a tool and a frame.")
        if (self.tool, self.board) != self._used:
            self.steps += [self.tool, self.board]
            self._used = (self.tool, self.board)


def skip(match: re.Match[str]) -> None:
    """Pass over a statement that has no effect on motion and outputs."""


def look_up(table: Mapping[_Key, _Value], key: _Key, what: str) -> _Value:
    """Give what a program has declared.

    Raises:
        ProgramError: it has not.
    """
    if key not in table:
        raise ProgramError(f"{what} is not declared.")
    return table[key]


def checked(quaternion: Quaternion) -> Quaternion:
    """Give a quaternion that is of unit length to its digits, as controllers demand it.

    Raises:
        ProgramError: it is not.
    """
    if abs(math.hypot(*quaternion) - 1.0) > _UNIT:
        raise ProgramError(f"the quaternion {quaternion} is not of unit length.")
    return quaternion


def read_pose(numbers: Iterable[str], orientation: Callable[[float, float, float], Quaternion]) -> Pose:
    """Read a pose: x, y, z in mm, then the angles of a maker."""
    x, y, z, a, b, c = map(float, numbers)
    if max(map(abs, (a, b, c))) > _MOST_DEGREES:
        raise ProgramError("an angle of a pose is more than a turn.")
    return Pose((x, y, z), orientation(a, b, c))
