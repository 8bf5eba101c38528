"""Reads the G-code that ``linuxcnc`` writes, as the interpreter would execute it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from programs.errors import ProgramError
from programs.posts.linuxcnc.axes import SYSTEMS
from programs.posts.linuxcnc.write import GROUP_BASE
from programs.posts.reading.rebuilt import (
    Axes,
    ReadBoard,
    ReadCall,
    ReadEndRepeat,
    ReadLine,
    ReadPause,
    ReadReach,
    ReadRepeat,
    ReadStep,
    ReadSwitch,
    ReadTool,
    Rebuilt,
)
from programs.posts.reading.scanner import read_repeat

_NUMBER = r"-?\d+(?:\.\d+)?"
_AXES = rf"(?: [XYZABCUVW]{_NUMBER})+"
_MOTION = re.compile(rf"((?:G61\.1 |G64 P{_NUMBER} Q0 )?)(G9[34] )?G1({_AXES}) F({_NUMBER})")
_RAPID = re.compile(rf"G0({_AXES})")
_HOME = re.compile(rf"G53 G0{_AXES}")
_OFFSET = re.compile(rf"G10 L2 P(\d)({_AXES}) R0")
_DIGITAL = re.compile(r"M6([2-5]) P(\d+)")
_ANALOG = re.compile(rf"M6[78] E(\d+) Q({_NUMBER})")
_DWELL = re.compile(rf"G4 P({_NUMBER})")
_TOOL = re.compile(r"(T\d+) M6")
_CALL = re.compile(r"o<(\w+)> call")
_COUNTED = re.compile(r"(o\d+) repeat \[(\d+)\]")
_LOOP = re.compile(r"(o\d+) do")
_WHILE = re.compile(
    rf"(o\d+) while \[\[#<loop\d+> LT (\d+)\] AND \[\[({_NUMBER}) \* #5399 \+ ({_NUMBER})\] LT ({_NUMBER})\]\]"
)
_IGNORED = re.compile(r"|G21 G90 G17 G40 G49 G80|M2|M66 E\d+ L0|#<loop\d+> = .*")
_WORD = re.compile(rf"([XYZABCUVW])({_NUMBER})")


@dataclass(slots=True)
class _Interpreter:
    """Subroutines by name, and the state of the machine."""

    routines: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    steps: list[ReadStep] = field(default_factory=list[ReadStep])
    offsets: dict[str, dict[str, float]] = field(default_factory=dict[str, dict[str, float]])
    system: str = ""
    axes: dict[str, float] = field(default_factory=dict[str, float])
    """In machine coordinates, in the order in which they are first written."""
    stops: bool = False
    inverse: bool = False
    loops: list[str] = field(default_factory=list[str])

    def run(self, lines: list[str]) -> None:
        """Execute blocks; a loop's body once."""
        for block in lines:
            self.execute(block, lines)

    def execute(self, block: str, lines: list[str]) -> None:
        """Execute one block."""
        if match := _MOTION.fullmatch(block):
            self.feed(match)
        elif match := _RAPID.fullmatch(block):
            self.steps.append(ReadReach(self.move(match[1])))
        elif match := _DIGITAL.fullmatch(block):
            self.steps.append(ReadSwitch(f"digital {match[2]}", float(match[1] in "24")))
        elif match := _ANALOG.fullmatch(block):
            number = int(match[1])
            channel = f"group {number - GROUP_BASE}" if number >= GROUP_BASE else f"analog {number}"
            self.steps.append(ReadSwitch(channel, float(match[2])))
        elif match := _DWELL.fullmatch(block):
            self.steps.append(ReadPause(float(match[1])))
        elif match := _TOOL.fullmatch(block):
            self.steps.append(ReadTool(match[1], None))
        elif block in self.offsets:
            self.system = block
            self.steps.append(ReadBoard(None))
        elif match := _OFFSET.fullmatch(block):
            words = {letter: float(value) for letter, value in _WORD.findall(match[2])}
            self.offsets[SYSTEMS[int(match[1]) - 1]] = words
        else:
            self.control(block, lines)

    def control(self, block: str, lines: list[str]) -> None:
        """Execute what directs the run."""
        if match := _CALL.fullmatch(block):
            if match[1] in self.routines:
                self.run(self.routines[match[1]])
            else:
                self.steps.append(ReadCall(match[1]))
        elif match := _COUNTED.fullmatch(block):
            self.loops.append(f"{match[1]} endrepeat")
            self.steps.append(ReadRepeat(int(match[2]), None))
        elif match := _LOOP.fullmatch(block):
            end = next((found for line in lines if (found := _WHILE.fullmatch(line)) and found[1] == match[1]), None)
            if end is None:
                raise ProgramError(f"{block} has no end.")
            self.loops.append(end[0])
            self.steps.append(read_repeat(end[2], end.groups()[2:]))
        elif self.loops and block == self.loops[-1]:
            self.loops.pop()
            self.steps.append(ReadEndRepeat())
        elif not _IGNORED.fullmatch(block) and not _HOME.fullmatch(block):
            raise ProgramError(f"unknown block {block!r}.")

    def feed(self, match: re.Match[str]) -> None:
        """Move in a straight line of the axes."""
        path, feed_mode, words, feed = match.groups()
        self.stops = path.startswith("G61.1") if path else self.stops
        self.inverse = feed_mode == "G93 " if feed_mode else self.inverse
        target = self.move(words)
        if self.inverse:
            self.steps.append(ReadLine(target, self.stops, None, duration_s=60.0 / float(feed)))
        else:
            self.steps.append(ReadLine(target, self.stops, float(feed) / 60.0))

    def move(self, words: str) -> Axes:
        """Give the axes after a block."""
        if self.system not in self.offsets:
            raise ProgramError("the program moves before it names a coordinate system.")
        for letter, value in _WORD.findall(words):
            self.axes[letter] = float(value) + self.offsets[self.system].get(letter, 0.0)
        return Axes(tuple(self.axes.values()))


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the program does.

    Raises:
        ProgramError: something is written that ``linuxcnc`` does not write.
    """
    interpreter = _Interpreter()
    texts = list(files.values())
    main = [line for text in texts[:1] for line in _load(interpreter, text)]
    for text in texts[1:]:
        if any(line not in ("", "M2") for line in _load(interpreter, text)):
            raise ProgramError("a subroutine's file holds more than the subroutine.")
    interpreter.run(main)
    return Rebuilt(tuple(interpreter.steps))


def _load(interpreter: _Interpreter, text: str) -> list[str]:
    """Keep the subroutines of a file and give its other lines, comments left out."""
    outside: list[str] = []
    name = ""
    for line in text.splitlines():
        block = line.strip()
        if block.startswith("(") and block.endswith(")"):
            continue
        if match := re.fullmatch(r"o<(\w+)> (sub|endsub)", block):
            name = match[1] if match[2] == "sub" else ""
            interpreter.routines.setdefault(match[1], [])
        else:
            (interpreter.routines[name] if name else outside).append(block)
    return outside
