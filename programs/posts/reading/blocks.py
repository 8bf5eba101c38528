"""Reads blocks that name axes, under a controller that takes tool points while its program has that switched on."""

import re
from collections.abc import Iterator, Mapping
from typing import ClassVar

from programs.errors import ProgramError
from programs.motion.steps import Line
from programs.posts.reading.driver import Reader
from programs.posts.reading.execution import skip
from programs.posts.reading.forms import Block, Values
from programs.posts.reading.statements import NUMBER, look_up
from programs.posts.rebuilt import Axes, Due, ReadBoard, ReadLine, ReadReach, ReadTool
from programs.posts.writing.blocks import BLEND_MM, VALUE_NUMBERS, AxisSyntax, MCodeSyntax, ToolPointSyntax

_AXIS = rf"[XYZABCUVW](?:=|\+)?{NUMBER}"
AXES = rf"(?: {_AXIS})+"
WORD = re.compile(rf"([XYZABCUVW])(?:=|\+)?({NUMBER})")


class AxisReader(Reader):
    """Coordinate systems, and the modes of the machine."""

    syntax: ClassVar[type[AxisSyntax]]  # pyright: ignore[reportIncompatibleVariableOverride]
    writes_lines = watches_inputs = False
    handlers = frozenset({"main"})

    def __init__(self) -> None:
        super().__init__()
        self.offsets: dict[str, dict[str, float]] = {}
        self.system = ""
        self.axes: dict[str, float] = {}
        """In machine coordinates, in the order in which they are first written."""
        self.stops = False
        self.raised: dict[str, float] = {}
        """Axis that was raised before the first motion home, and to where."""

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        return {**super().fields(), "axes": rf"{_AXIS}(?: {_AXIS})*", "output": r"\d+", "value": r"\+?" + NUMBER}

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        syntax = self.syntax
        yield [syntax.home_form], self.go_home
        yield [syntax.rapid_form], self.rapid
        yield [syntax.change_form], self.change_tool
        yield syntax.modes, skip
        if syntax.zero_form:
            yield [syntax.zero_form], self.set_zero
        yield from super().blocks()

    @classmethod
    def due(cls, line: Line, after: Line | None) -> Due:
        """Give nothing: blocks are compared with the line that they are parts of."""
        return Due()

    def move(self, words: str) -> Axes:
        """Give the axes after a block.

        Raises:
            ProgramError: no coordinate system is in use.
        """
        if self.system not in self.offsets:
            raise ProgramError("the program moves before it names a coordinate system.")
        for letter, value in WORD.findall(words):
            self.axes[letter] = float(value) + self.offsets[self.system].get(letter, 0.0)
        return Axes(tuple(self.axes.values()))

    def use_system(self, match: re.Match[str]) -> None:
        """Use another coordinate system from now on."""
        look_up(self.offsets, match[0], match[0])
        self.system = match[0]
        self.steps.append(ReadBoard(None))

    def set_zero(self, values: Values) -> None:
        """Set the zero of a coordinate system."""
        self.offsets[self.syntax.systems[int(values["number"]) - 1]] = words_of(values["axes"])

    def go_home(self, values: Values) -> None:
        """Go home in machine coordinates: Z alone before the first time, then all axes.

        Raises:
            ProgramError: Z is raised to another height than that of home.
        """
        words = words_of(values["axes"])
        if len(words) == 1:
            self.raised = words
        elif words.items() >= self.raised.items():
            self.come_home(words.values())
        else:
            raise ProgramError(
                f"{self.routines[self.routine][self.at]!r} is not as high as the axis was raised before."
            )

    def rapid(self, values: Values) -> None:
        """Come to axes at rapid speed."""
        self.steps.append(ReadReach(self.move(values["axes"])))

    def change_tool(self, values: Values) -> None:
        """Change the tool, not before the valves are shut.

        Raises:
            ProgramError: nothing was done yet.
        """
        if not self.steps:
            raise ProgramError("the tool is changed before anything else.")
        self.steps.append(ReadTool(values["tool"], None))


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

    def feed(self, words: str, feed: str) -> None:
        """Go straight to a tool point."""
        self.check_points()
        target, zone = self.move(words), 0.0 if self.stops else BLEND_MM
        per_s = float(feed) / 60.0
        if any(letter in words for letter in "XYZ"):
            self.steps.append(ReadLine(target, self.stops, per_s, zone=zone))
        else:
            self.steps.append(ReadLine(target, self.stops, 0.0, zone=zone, turn_deg_s=per_s))

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

    def switch_by(self, code: str) -> None:
        """Switch a digital output by the number of its M code."""
        number, value = divmod(int(code) - self.syntax.m_base, 2)
        self.switch(f"digital {number}", float(value))

    def feed_with(self, codes: str, words: str, feed: str) -> None:
        """Switch outputs by the M codes of a block, and go straight to its tool point."""
        for code in re.findall(r"M(\d+)", codes):
            self.switch_by(code)
        self.feed(words, feed)

    def set_value(self, values: Values) -> None:
        """Set an analog output or a group: the number that its value is sent with, and the value."""
        number = int(values["output"])
        kind = "group" if number >= VALUE_NUMBERS["group"] else "analog"
        self.switch(f"{kind} {number - VALUE_NUMBERS[kind]}", float(values["value"]))


def words_of(words: str) -> dict[str, float]:
    """Give the axes of a block by their letters."""
    return {letter: float(value) for letter, value in WORD.findall(words)}
