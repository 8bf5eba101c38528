"""Machines whose controller takes tool points while its program has that switched on, and the axes otherwise."""

from collections.abc import Iterator, Mapping
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, Reach, Step, UseBoard, UseTool
from programs.posts.dialect import Dialect
from programs.posts.gcode.axes import DIGITS, SPOT_LINE, AxisReader, AxisSyntax
from programs.posts.reading.execution import Block, Values
from programs.posts.writing.axes import own_axes
from programs.posts.writing.chapters import Chapter, Placed
from programs.posts.writing.forms import fill, fixed, short

VALUE_NUMBERS = {"analog": 100, "group": 200}
"""Added to the number of an output where its value is sent, in languages that switch outputs by M codes."""
_MOST_OUTPUT = 99
"""Of the outputs of each kind there: those numbers, and the M codes, begin a hundred outputs apart."""


class ToolPointSyntax(AxisSyntax):
    """A language that switches tool points on before its lines, and off for home and the change of tools."""

    points_on: ClassVar[tuple[str, ...]]
    points_off: ClassVar[tuple[str, ...]]
    """Blocks of that, of the number of the ``tool``."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.tool = 0

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a subroutine; it switches tool points on before its first motion."""
        self.tool = chapter.tool.number if chapter.tool is not None else 0
        yield from super().chapter(chapter)

    def statements(self, step: Step, placed: Placed) -> Iterator[str]:
        """Write one step, a motion under tool points."""
        if isinstance(step, Line | Reach) and self.set("points", str(self.tool)):
            yield from (form.format(tool=self.tool) for form in self.points_on)
        yield from super().statements(step, placed)

    def use(self, step: UseTool | UseBoard) -> Iterator[str]:
        """Change the tool, or select the coordinate system of a placement."""
        self.written = ()
        if isinstance(step, UseTool):
            self.tool = step.number
            self.settings.pop("points", None)
            yield from self.points_off
            yield from self.attended([self.change_form.format(tool=step.number)])
            return
        system, self.offset = self.offsets[step.placement]
        yield from self.select(system)

    def select(self, system: str) -> Iterator[str]:
        """Select a coordinate system."""
        yield system

    def rise(self) -> list[str]:
        """Raise Z to that of home before any other axis moves, where no line is higher."""
        height = self.rising_z()
        if height is None:
            return []
        return [*self.points_off, self.home_form.format(axes=self.word("Z", fixed(height, DIGITS)))]

    def home(self) -> Iterator[str]:
        """Go home by the machine's own axes."""
        if self.installation.home and self.machine is not None:
            self.offset, self.written = (), ()
            yield from self.points_off
            yield self.home_form.format(axes=self.axes(own_axes(self.machine, self.installation.home)))

    def legend(self) -> Iterator[str]:
        """Describe the words of a block, and what the machine's configuration has to be."""
        yield from self.axis_lines()
        if self.machine is not None:
            pivot = short(self.machine.pivot_mm, 4)
            yield f"Tool points: {pivot} mm from the axis of B to the orifice, with every tool"
        yield "Machine zero: X Y Z of the cell's joints where B is 0; the tool's length is beyond it"
        yield "F: mm/min of the orifice, deg/min where only B and C turn. B and C count on beyond a turn: no roll-over"
        yield from self.sign_lines()
        yield SPOT_LINE


class MCodeSyntax(ToolPointSyntax):
    """A language in which M codes switch digital outputs, in the block with which they change; others get values."""

    m_base: ClassVar[int]
    """M codes of digital output n: this plus 2 n shuts it, one more opens it."""
    fault_form = "M{fault}"
    value_form: ClassVar[str]
    """Sends the ``value`` of an analog ``output`` or a group."""
    code_form: ClassVar[str] = "M{code:0}"
    m_words: ClassVar[str] = "M codes"
    """What the language calls them."""
    value_words: ClassVar[str]
    """What an analog output or a group is in the controller, of the number that its value is sent with."""

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.codes: list[str] = []
        """M codes for the block to come."""

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write the blocks of a line; an output that changes in passing is in the block that begins there."""
        yield from (each for each in super().line(line, placed) if each)

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block with the M codes that wait for it, and the modes that change."""
        codes, self.codes = self.codes, []
        written = " ".join(codes)
        path, feed = self.path(stops), self.tool_point_feed(line)
        yield fill(self.feed_form, codes=written, has_codes=codes, path=path, axes=words, feed=feed)

    def output(self, channel: Channel, value: float, when: str = "immediate") -> str:
        """Set an output: nothing where it is left to the block to come.

        Raises:
            ProgramError: its number has no M code, or it is not digital and changes while the machine moves.
        """
        described, digital = f"{channel.name} is {channel.kind} output {channel.number}", channel.kind == "digital"
        if when != "immediate" and not digital:
            why = f"while the machine moves only {self.m_words} switch, which are digital outputs"
            raise ProgramError(f"{described}; {why}.")
        if not 0 <= channel.number <= _MOST_OUTPUT:
            what = f"{self.m_words if digital else 'numbers'} are assigned to outputs 0 to {_MOST_OUTPUT}"
            raise ProgramError(f"{described}; {what}. Give it another number in the cell.")
        if not digital:
            output = VALUE_NUMBERS[channel.kind] + channel.number
            return self.value_form.format(output=output, value=self.number(value))
        code = fill(self.code_form, code=self.m_base + 2 * channel.number + (value > 0.5))
        if when == "immediate":
            return code
        self.codes.append(code)
        return ""

    def address(self, channel: Channel) -> str:
        """Give the M codes of an output, or the number that its value is sent with."""
        if channel.kind == "digital":
            code = self.m_base + 2 * channel.number
            return f"M{code + 1} on, M{code} off"
        return self.value_words.format(VALUE_NUMBERS[channel.kind] + channel.number)


class ToolPointReader(AxisReader):
    """A controller that takes tool points while its program has that switched on, and the axes themselves otherwise."""

    syntax: ClassVar[type[ToolPointSyntax]]  # pyright: ignore[reportIncompatibleVariableOverride]
    home_in_tool_points = False

    def __init__(self) -> None:
        super().__init__()
        self.takes_points = False
        """Whether tool points are taken."""

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        yield self.syntax.points_on, self.take_points
        yield self.syntax.points_off, self.take_axes
        yield from super().blocks()

    def take_points(self, values: Values) -> None:
        """Take tool points from now on."""
        self.takes_points = True

    def take_axes(self, values: Values) -> None:
        """Take the machine's own axes from now on."""
        self.takes_points = False

    def change_tool(self, values: Values) -> None:
        """Change the tool, where no tool points are taken.

        Raises:
            ProgramError: they are.
        """
        if self.takes_points:
            raise ProgramError("the tool is changed while tool points are taken.")
        super().change_tool(values)

    def rapid(self, values: Values) -> None:
        """Come to a tool point at rapid speed."""
        self.check_points()
        super().rapid(values)

    def feed(self, values: Values) -> None:
        """Go straight to a tool point."""
        self.check_points()
        super().feed(values)

    def check_points(self) -> None:
        """Make sure that tool points are taken.

        Raises:
            ProgramError: they are not.
        """
        if not self.takes_points:
            raise ProgramError("the machine moves to a tool point, and takes none.")

    def go_home(self, values: Values) -> None:
        """Go home by the axes themselves.

        Raises:
            ProgramError: tool points are taken.
        """
        if self.takes_points:
            raise ProgramError("the axes go home while tool points are taken.")
        super().go_home(values)


class MCodeReader(ToolPointReader):
    """A controller whose M codes switch digital outputs; a program sends the values of others by numbers."""

    syntax: ClassVar[type[MCodeSyntax]]  # pyright: ignore[reportIncompatibleVariableOverride]

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        yield from super().blocks()
        yield [self.syntax.value_form], self.set_value
        yield [self.syntax.code_form], self.switch_by

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        return {**super().fields(), "codes": r"M\d+(?: M\d+)*", "output": r"\d+"}

    def fault_label(self, word: str) -> str:
        """Give the output of an M code that opens."""
        return f"digital {(int(word) - self.syntax.m_base) // 2}"

    def switch_by(self, values: Values) -> None:
        """Switch a digital output by the number of its M code."""
        number, value = divmod(int(values["code"]) - self.syntax.m_base, 2)
        self.switch(f"digital {number}", float(value))

    def feed(self, values: Values) -> None:
        """Switch outputs by the M codes of a block, and go straight to its tool point."""
        for code in values.get("codes", "").split():
            self.switch_by({"code": code[1:]})
        super().feed(values)

    def set_value(self, values: Values) -> None:
        """Set an analog output or a group: the number that its value is sent with, and the value."""
        number = int(values["output"])
        kind = "group" if number >= VALUE_NUMBERS["group"] else "analog"
        self.switch(f"{kind} {number - VALUE_NUMBERS[kind]}", float(values["value"]))
