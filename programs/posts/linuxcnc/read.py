"""Reads G-code back, as LinuxCNC's interpreter would execute it."""

import re
from itertools import pairwise

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.linuxcnc.write import GROUP_BASE, SYSTEMS
from programs.posts.reading.blocks import AxisReader, words_of
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import NUMBER, N, statements_of
from programs.posts.rebuilt import ReadLine, ReadReach
from programs.posts.writing.blocks import BLEND_MM

_AXES = rf"(?: [XYZABCUVW]{NUMBER})+"
_WHILE = rf"(o\d+) while \[\[#<loop\d+> LT (\d+)\] AND \[\[{N} \* #5399 \+ {N}\] LT {N}\]\]"
_MAIN = "(main)"
_LEAST = rf"if \[\[{N} \* #5399 \+ {N}\] LT {N}\]"


class GCodeReader(AxisReader):
    """Subroutines, coordinate systems, and the modes of the machine."""

    def __init__(self) -> None:
        super().__init__()
        self.tolerance_mm = 0.0
        self.inverse = False

    def load(self, files: ProgramFiles) -> str:
        """Keep the subroutines; what else the first file holds is the program."""
        for file in files:
            blocks = (
                line
                for line in statements_of(file, files[file])
                if line.startswith("(ABORT,") or not (line.startswith("(") and line.endswith(")"))
            )
            outside = list(self.sort(blocks, r"o<(\w+)> sub", r"o<\w+> endsub"))
            if _MAIN not in self.routines:
                self.routines[_MAIN] = outside
            elif outside != ["M2"]:
                raise ProgramError("a subroutine's file holds more than the subroutine.")
        return _MAIN

    def grammar(self) -> dict[str, Action]:
        """List the blocks."""
        return {
            rf"((?:G61\.1 |G64 P({BLEND_MM:g}) Q0 )?)(G9[34] )?G1({_AXES}) F{N}": self.feed,
            rf"G0({_AXES})": lambda match: self.steps.append(ReadReach(self.move(match[1]))),
            rf"G53 G0({_AXES})": self.go_home,
            r"M6([2-5]) P(\d+)": lambda match: self.switch(f"digital {match[2]}", float(match[1] in "24")),
            rf"M6[78] E(\d+) Q{N}": self.set_analog,
            rf"G4 P{N}": self.pause,
            r"(T\d+) M6": lambda match: self.mount(match[1]),
            r"G5\d(?:\.\d)?": self.use_system,
            rf"G10 L2 P(\d)({_AXES}) R0": self.set_offset,
            rf"o<{self.shut_name}> call": self.shut("main"),
            r"o<(\w+)> call": self.call,
            r"(o\d+) if \[#<_start> LE (\d+)\]": lambda match: self.do_part(match[1], match[2]),
            r"(o\d+) if \[#<_start> EQ (\d+)\]": lambda match: self.do_entry(match[1], match[2]),
            r"M49": self.guard,
            r"M66 P(\d+) (L[34]) Q(\d+(?:\.\d)?)": self.wait_contact,
            r"#<waited> = 0": self.wait_sensor,
            r"(o\d+) repeat \[(\d+)\]": self.begin_counted,
            r"(o\d+) do": self.begin_loop,
            rf"o\d+ endrepeat|{_WHILE}": lambda match: self.end_labelled(match, match[0]),
            r"o\d+ endif": self.end_if,
            r"G21 G90 G17 G40 G49 G80|M2|M66 E\d+ L0|#<loop\d+> = .*|#<_start> = 1": skip,
        }

    def do_part(self, word: str, number: str) -> None:
        """Begin a part of main."""
        if self.begin_part(number, f"{word} endif"):
            self.labels.append(f"{word} endif")

    def do_entry(self, word: str, number: str) -> None:
        """Begin what a part does first."""
        starts = self.start == int(number)
        self.enter(number, f"{word} endif")
        if starts:
            self.labels.append(f"{word} endif")

    def end_if(self, match: re.Match[str]) -> None:
        """End what is done if the program starts at a part.

        Raises:
            ProgramError: it is not the innermost.
        """
        if not self.labels or self.labels.pop() != match[0]:
            raise ProgramError(f"{match[0]} ends another condition than the innermost.")

    def wait_contact(self, match: re.Match[str]) -> None:
        """Wait for a digital input, and abort where that takes too long."""
        self.pass_on(r"o(\d+) if \[#5399 LT 0\]", r"\(ABORT,.*\)", r"o\d+ endif")
        self.wait_for(match[1], match[2] == "L3", float(match[3]))

    def wait_sensor(self, match: re.Match[str]) -> None:
        """Wait for a quantity, and abort where that takes too long."""
        again = r"o\d+ while \[\[#<waited> LT (\d+)\] AND " + _LEAST.removeprefix("if ") + r"\]"
        begin = (r"o\d+ do", r"G4 P0\.1", r"#<waited> = \[#<waited> \+ 1\]", r"M66 E(\d+) L0")
        found = self.pass_on(*begin, again, rf"o\d+ {_LEAST}", r"\(ABORT,.*\)", r"o\d+ endif")
        tenths, *condition = found[4].groups()
        if list(found[5].groups()) != condition:
            raise ProgramError("what is waited for is not what is looked at then.")
        self.wait_least(found[3][1], condition, float(tenths) / 10.0)

    def feed(self, match: re.Match[str]) -> None:
        """Move in a straight line of the axes."""
        path, tolerance_mm, feed_mode, words, feed = match.groups()
        self.stops = path.startswith("G61.1") if path else self.stops
        self.tolerance_mm = float(tolerance_mm) if tolerance_mm else self.tolerance_mm
        self.inverse = feed_mode == "G93 " if feed_mode else self.inverse
        target, zone = self.move(words), 0.0 if self.stops else self.tolerance_mm
        if self.inverse:
            line = ReadLine(target, self.stops, None, duration_s=60.0 / float(feed), zone=zone)
        elif any(letter in words for letter in "XYZ"):
            line = ReadLine(target, self.stops, float(feed) / 60.0, zone=zone)
        else:
            line = ReadLine(target, self.stops, 0.0, zone=zone, turn_deg_s=float(feed) / 60.0)
        self.steps.append(line)

    def set_analog(self, match: re.Match[str]) -> None:
        """Set an analog output, or a group."""
        number = int(match[1])
        channel = f"group {number - GROUP_BASE}" if number >= GROUP_BASE else f"analog {number}"
        self.switch(channel, float(match[2]))

    def set_offset(self, match: re.Match[str]) -> None:
        """Set the zero of a coordinate system."""
        self.offsets[SYSTEMS[int(match[1]) - 1]] = words_of(match[2])

    def begin_counted(self, match: re.Match[str]) -> None:
        """Begin a loop that only counts."""
        self.labels.append(f"{match[1]} endrepeat")
        self.repeat(match[2])

    def begin_loop(self, match: re.Match[str]) -> None:
        """Begin a loop that reads an input where it ends."""
        end = self.find_end(_WHILE, match[1])
        self.labels.append(end[0])
        looks = list(self.ahead(rf"M66 E(\d+) L0|{re.escape(end[0])}"))
        channel = next((before[1] for before, each in pairwise(looks) if each[0] == end[0]), None)
        if channel is None:
            raise ProgramError("the loop does not read its input where it ends.")
        scale, offset, least = end.groups()[2:]
        self.repeat(end[2], (scale, channel, offset, least))
