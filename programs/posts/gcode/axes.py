"""Blocks of a machine's axes: the walk over lines that every G-code has in common, written and read."""

import re
from abc import abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import degrees
from typing import ClassVar

import numpy as np

from geometry.arrays import Scalars
from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, MotionProgram, Reach, UseBoard, UseTool, limit_speed
from programs.pose import Position
from programs.posts.dialect import Dialect
from programs.posts.reading.driver import Reader
from programs.posts.reading.execution import Block, Values, look_up, skip
from programs.posts.rebuilt import Axes, Due, ReadBoard, ReadLine, ReadReach, ReadTool
from programs.posts.writing.axes import (
    COARSE_TURN_DEG,
    TURN_DEG,
    allowed_on,
    in_degrees_and_mm,
    needed_samples,
    units_of,
)
from programs.posts.writing.chapters import Chapter, Placed
from programs.posts.writing.driver import Syntax
from programs.posts.writing.forms import NUMBER, fill, fixed, short
from programs.timing.forecast import SHORT_S

BLEND_MM = 0.05
"""How far a corner that is passed may be cut; zones are planned for the same."""
DIGITS = 4
"""Decimals of an axis."""
_LETTERS = "XYZABCUVW"
_FINENESS = 0.7
"""Share of the allowed deviation that straight blocks may use; the rest is for rounding."""

SPOT_LINE = "On the spot, and with the jet off, B and C go evenly, as the check found clear"
"""How a block turns the tool on the spot."""


class AxisSyntax(Syntax):
    """A language whose blocks name axes: one block a line where the controller takes tool points."""

    systems: ClassVar[Sequence[str]]
    """Coordinate systems, for as many places of the board."""
    controller_name: ClassVar[str]
    change_form: ClassVar[str] = "T{tool} M6"
    """Of a ``tool`` into the spindle."""
    rapid_form: ClassVar[str] = "G0 {axes}"
    """Of a joint motion to ``axes``."""
    feed_form: ClassVar[str] = "{path}G1 {axes} F{feed}"
    """Of a straight motion at a ``feed``, with the modal words of its ``path``."""
    path_words: ClassVar[tuple[str, str]] = ("", "")
    """Modal words that have motions be passed, and stop; empty where they do neither."""
    system_form: ClassVar[str] = "{system}"
    """Of another coordinate system from now on; empty where it takes other statements."""
    home_form: ClassVar[str] = "G53 G0 {axes}"
    """Of ``axes`` in the machine's own coordinates."""
    modes: ClassVar[tuple[str, ...]]
    """Set before anything else."""
    zero_form: ClassVar[str]
    """Of the zero of the coordinate system of a ``number``, by its ``axes``."""
    no_joints: ClassVar[str] = "G-code is made of joint values; track the program in a cell first."

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        super().__init__(dialect, lowered, installation)
        self.letters = _name_axes(installation, self.controller_name)
        kinds = {letter: joint.kind for letter, joint in zip(self.letters, installation.joints, strict=True)}
        self.slides = all(kinds.get(letter) == "prismatic" for letter in "XYZ")
        """Whether X, Y and Z are straight axes: then F in mm/min is the speed of an orifice that does not turn."""
        self.machine = installation.tool_point
        base = self.machine.base if self.machine is not None else (0.0, 0.0, 0.0)
        self.offsets = self.zeros(base if self.slides else None)
        self.offset: tuple[float, ...] = ()
        self.written: tuple[str, ...] = ()
        """Axes as written last; empty where the next block has to write all."""

    def block(self, line: Line, words: str, share: float, *, stops: bool, turns: bool) -> Iterator[str]:
        """Write a block that does this share of a line, with the modes that change.

        Args:
            line: The line.
            words: The axes that change.
            share: Of the line.
            stops: Whether the machine stands at the block's end.
            turns: Whether other axes than X, Y and Z move.
        """
        yield fill(self.feed_form, path=self.path(stops), axes=words, feed=self.tool_point_feed(line))

    def path(self, stops: bool) -> str:
        """Write whether motions stop or are passed, if that changes."""
        return "".join(f"{word} " for word in self.set("path", self.path_words[stops]))

    @abstractmethod
    def output(self, channel: Channel, value: float, when: str = "immediate") -> str:
        """Set an output at once, or ``synchronised`` with the next motion."""

    def word(self, letter: str, value: str) -> str:
        """Write where an axis is."""
        return f"{letter}{value}"

    def initial_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard | None]:
        """Select the coordinate system; the tool is in the spindle."""
        return (chapter.board,)

    def entry_frames(self, chapter: Chapter) -> Sequence[UseTool | UseBoard]:
        """Change the tool: it is in the spindle otherwise."""
        return (chapter.tool,) if chapter.tool is not None else ()

    def chapter(self, chapter: Chapter) -> Iterator[str]:
        """Write a subroutine; its first blocks state all modes and axes, so that it runs alone."""
        self.offset = ()
        self.forget()
        yield from super().chapter(chapter)

    def forget(self) -> None:
        """Write modes and axes again."""
        super().forget()
        self.written = ()

    def line(self, line: Line, placed: Placed) -> Iterator[str]:
        """Write as many blocks as the axes need to follow a line, its outputs before the first or after the last."""
        for event in line.events:
            if event.share < 1.0:
                yield self.output(event.channel, event.value, "synchronised")
        yield from self.blocks(line)
        then = "immediate" if line.blend_mm == 0.0 else "synchronised"
        yield from (self.output(event.channel, event.value, then) for event in line.events if event.share == 1.0)

    def blocks(self, line: Line) -> Iterator[str]:
        """Write the motion of a line."""
        if not line.joints:
            raise ProgramError(self.no_joints)
        done, before = 0.0, 0
        units, spot = units_of(self.installation), self.machine is not None and line.turns_on_the_spot
        for sample in self.ends_of_blocks(line, units):
            share = float(line.samples.shares[sample])
            moved = self.moved(line, before, sample)
            if not moved and share < 1.0:
                continue  # the next block takes its time too: a block that goes nowhere would stop the others
            words = self.axes(tuple(line.samples.joints[sample].tolist()), rests=spot)
            stops, turns = share == 1.0 and line.blend_mm == 0.0, not moved <= set("XYZ")
            part = line
            if self.machine is not None and self.dialect.capability.least_part_s and not spot:
                lasts_s = float(line.samples.seconds[sample] - line.samples.seconds[before])
                part = limit_speed(line, share=share - done, lasts_s=lasts_s)
            yield from self.block(part, words, share - done, stops=stops, turns=turns)
            done, before = share, sample

    def ends_of_blocks(self, line: Line, units: Scalars) -> tuple[int, ...]:
        """Choose the samples at which the blocks of a line end; B and C may be off farther where one would be short."""
        fine = allowed_on(units, self.installation, TURN_DEG)
        ends = needed_samples(line.samples, units, _FINENESS, fine)
        if self.machine is None:
            return ends
        whole_s = line.length_mm / line.speed_mm_s if line.speed_mm_s > 0.0 else line.duration_s
        if whole_s * (1.0 if len(ends) == 1 else np.diff(line.samples.shares[[0, *ends]]).min()) >= SHORT_S:
            return ends
        return needed_samples(line.samples, units, _FINENESS, allowed_on(units, self.installation, COARSE_TURN_DEG))

    def moved(self, line: Line, begin: int, end: int) -> set[str]:
        """Give the letters of the axes that are not the same at two samples of a line."""
        key = ("moved", self.letters, begin, end)
        if (moved := line.samples.memo.get(key)) is None:
            rows = (
                in_degrees_and_mm(tuple(line.samples.joints[at].tolist()), self.installation) for at in (begin, end)
            )
            pairs = zip(self.letters, *rows, strict=True)
            moved = {letter for letter, a, b in pairs if fixed(a, DIGITS) != fixed(b, DIGITS)}
            line.samples.memo[key] = moved
        return moved

    def tool_point_feed(self, line: Line) -> str:
        """Give F of a block in tool points: mm/min of the orifice, degrees/min where that rests."""
        per_s = line.speed_mm_s if line.speed_mm_s > 0.0 else degrees(line.turn_rad_s)
        return short(60.0 * per_s, 1)

    def axes(self, joints: tuple[float, ...], *, rests: bool = False) -> str:
        """Write the axes that change, at least one; none of X, Y and Z where the tool point rests.

        Raises:
            ProgramError: the joints are not known.
        """
        if not joints or len(joints) != len(self.letters):
            raise ProgramError(self.no_joints)
        values = in_degrees_and_mm(joints, self.installation)
        offset = self.offset or tuple(0.0 for _ in values)
        words = tuple(
            self.word(letter, fixed(value - zero, DIGITS))
            for letter, value, zero in zip(self.letters, values, offset, strict=True)
        )
        before = self.written or tuple("" for _ in words)
        if rests and self.written:
            words = tuple(then if then[0] in "XYZ" else now for now, then in zip(words, before, strict=True))
        changed = [now for now, then in zip(words, before, strict=True) if now != then]
        self.written = words
        return " ".join(changed or words[:1])

    def reach(self, reach: Reach) -> Iterator[str]:
        """Write a rapid in all axes."""
        self.written = ()
        yield self.rapid_form.format(axes=self.axes(reach.joints))

    def prepare(self) -> Iterator[str]:
        """Set the part to start at, the modes, and the zero of each coordinate system."""
        yield self.comment(f"the part to start at; 1 is the whole program of {len(self.chapters)}")
        yield self.enter_begin[1].strip().format(start=self.start)
        yield from self.modes
        for number, (system, offset) in enumerate(self.offsets.values() if self.zero_form else (), start=1):
            yield self.comment(f"{system}: {self.zero_note()}")
            yield self.zero_form.format(number=number, zero=self.zero_words(offset))

    def zero_note(self) -> str:
        """Describe the zero of a coordinate system."""
        return f"origin of the {self.installation.workpiece}; leave this block out after touching off"

    def zero_words(self, offset: Sequence[float]) -> str:
        """Write the axes of a zero."""
        return " ".join(f"{letter}{short(value, 4)}" for letter, value in zip(self.letters, offset, strict=True))

    def zeros(self, base: Position | None) -> Mapping[str, tuple[str, tuple[float, ...]]]:
        """Give the coordinate system, and what it adds to each axis, by the placement of the board.

        Where X, Y and Z slide, assumed along the directions of the base frame, the board's origin is their zero;
        ``base`` is then where the base's origin is in their coordinates.

        Raises:
            ProgramError: there are fewer coordinate systems than places of the board.
        """
        places = {step.placement: step.T_base_board for step in self.motion.steps if isinstance(step, UseBoard)}
        if len(places) > len(self.systems):
            number = len(self.systems)
            raise ProgramError(
                f"{self.controller_name} has {number} coordinate systems; the board lies in {len(places)} places."
            )
        offsets: dict[str, tuple[str, tuple[float, ...]]] = {}
        for system, (placement, place) in zip(self.systems, places.items(), strict=False):
            shifted = [] if base is None else [a + b for a, b in zip(place.position, base, strict=True)]
            origin = dict(zip("XYZ", shifted, strict=False))
            offsets[placement] = (system, tuple(round(origin.get(letter, 0.0), DIGITS) for letter in self.letters))
        return offsets

    def rising_z(self) -> float | None:
        """Give the height of home, mm, to which Z goes alone first; ``None`` where a line is higher or z is not up."""
        home = self.installation.home
        if not (home and self.slides and self.installation.is_upright):
            return None
        z = self.letters.index("Z")
        return None if highest(self.motion, z) > home[z] else home[z]

    def axis_lines(self) -> Iterator[str]:
        """Describe the words of a block."""
        axes = ", ".join(
            f"{letter} = {joint.name} ({'deg' if joint.kind == 'revolute' else 'mm'})"
            for letter, joint in zip(self.letters, self.installation.joints, strict=True)
        )
        yield f"Axes: {axes}"

    def sign_lines(self) -> Iterator[str]:
        """Describe an axis that the controller counts in another way than the cell."""
        if (machine := self.machine) is None:
            return
        zeros, turning = (machine.swing_zero, machine.tilt_zero), (machine.swing, 7 - machine.swing)
        for at, sign, zero in zip(turning, machine.signs, zeros, strict=True):
            if sign < 0.0 or zero:
                plus = f", plus {short(degrees(zero), 4)} deg" if zero else ""
                counts = "against" if sign < 0.0 else "as"
                yield f"{self.letters[at]} counts {counts} the cell's joint{plus}; B tilts to +X at C0"


def highest(motion: MotionProgram, z: int) -> float:
    """Give the greatest value of an axis at the ends of lines; minus infinity where there are none."""
    return max((line.joints[z] for line in motion.lines if line.joints), default=float("-inf"))


def _name_axes(installation: Installation, controller: str) -> tuple[str, ...]:
    """Name the axes as the joints are named if those are axes, else X, Y, Z, A, B, C, U, V, W in their order."""
    names = [joint.name.upper() for joint in installation.joints]
    if len(names) > len(_LETTERS):
        raise ProgramError(
            f"{controller} has {len(_LETTERS)} axes; robot {installation.robot} has {len(names)} joints."
        )
    are_axes = len(set(names)) == len(names) and all(len(name) == 1 and name in _LETTERS for name in names)
    return tuple(names if are_axes else _LETTERS[: len(names)])


_AXIS = rf"[XYZABCUVW](?:=|\+)?{NUMBER}"
WORD = re.compile(rf"([XYZABCUVW])(?:=|\+|,)?({NUMBER})")


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
        axes, path = rf"{_AXIS}(?: {_AXIS})*", "|".join(f"{re.escape(word)} " for word in self.syntax.path_words)
        words = {
            "axes": axes,
            "zero": axes,
            "path": f"(?:{path})?",
            "feed": NUMBER,
            "tool": r"\d+",
            "system": "|".join(self.syntax.systems),
        }
        return {**super().fields(), **words, "value": r"\+?" + NUMBER}

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        syntax = self.syntax
        yield [syntax.feed_form], self.feed
        yield [syntax.home_form], self.go_home
        yield [syntax.rapid_form], self.rapid
        yield [syntax.change_form], self.change_tool
        yield syntax.modes, skip
        yield from (([form], self.set_zero) for form in [syntax.zero_form] if form)
        yield from (([form], self.use_system) for form in [syntax.system_form] if form)
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
        self.check_watched()
        if self.system not in self.offsets:
            raise ProgramError("the program moves before it names a coordinate system.")
        for letter, value in WORD.findall(words):
            self.axes[letter] = float(value) + self.offsets[self.system].get(letter, 0.0)
        return Axes(tuple(self.axes.values()))

    def use_system(self, values: Values) -> None:
        """Use another coordinate system from now on."""
        self.system = values["system"]
        look_up(self.offsets, self.system, self.system)
        self.steps.append(ReadBoard(None))

    def set_zero(self, values: Values) -> None:
        """Set the zero of a coordinate system."""
        self.offsets[self.syntax.systems[int(values["number"]) - 1]] = words_of(values["zero"])

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

    def feed(self, values: Values) -> None:
        """Go straight in the axes, or to a tool point."""
        if path := values.get("path", "").strip():
            self.stops = path == self.syntax.path_words[True]
        target, per_s = self.move(values["axes"]), float(values["feed"]) / 60.0
        line = ReadLine(target, self.stops, per_s, zone=0.0 if self.stops else BLEND_MM)
        if not set(values["axes"]) & set("XYZ"):
            line = replace(line, speed_mm_s=0.0, turn_deg_s=per_s)
        self.steps.append(line)

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


def words_of(words: str) -> dict[str, float]:
    """Give the axes of a block by their letters."""
    return {letter: float(value) for letter, value in WORD.findall(words)}
