"""Reads G-code back, as LinuxCNC's interpreter would execute it."""

import re

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.linuxcnc.write import GROUP_BASE, GCode
from programs.posts.reading.blocks import AXES, AxisReader
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import N, statements_of
from programs.posts.rebuilt import ReadLine, ReadPart
from programs.posts.writing.blocks import BLEND_MM

_MAIN = "(main)"


class GCodeReader(AxisReader):
    """Subroutines, coordinate systems, and the modes of the machine."""

    syntax = GCode

    def __init__(self) -> None:
        super().__init__()
        self.tolerance_mm = 0.0
        self.inverse = False
        self.conditions: list[str] = []
        """Ends of the parts that run and have other statements than their calls."""

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
        """List the other blocks."""
        return {
            rf"((?:G61\.1 |G64 P({BLEND_MM:g}) Q0 )?)(G9[34] )?G1({AXES}) F{N}": self.feed,
            r"M6([2-5]) P(\d+)": lambda match: self.switch(f"digital {match[2]}", float(match[1] in "24")),
            rf"M6[78] E(\d+) Q{N}": self.set_analog,
            r"G5\d(?:\.\d)?": self.use_system,
            r"(o\d+) if \[#<_start> LE (\d+)\]": self.begin_part,
            r"o\d+ endif": self.end_part,
            r"M2": skip,
        }

    def begin_part(self, match: re.Match[str]) -> None:
        """Begin a part that has other statements than its call, unless the start is at a later one."""
        self.parts.append(ReadPart(int(match[2]), len(self.steps)))
        if self.start <= int(match[2]):
            self.conditions.append(f"{match[1]} endif")
        else:
            self.at = self.pass_to(f"{match[1]} endif")

    def end_part(self, match: re.Match[str]) -> None:
        """End such a part.

        Raises:
            ProgramError: it is not the innermost.
        """
        if not self.conditions or self.conditions.pop() != match[0]:
            raise ProgramError(f"{match[0]} ends another condition than the innermost.")

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
