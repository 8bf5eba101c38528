"""Reads a FANUC CNC's programs back, as it would execute them."""

import re
from collections.abc import Iterator

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.fanuc_cnc.write import MAIN, SHUT, FanucCnc
from programs.posts.reading.blocks import AXES, MCodeReader
from programs.posts.reading.execution import Action
from programs.posts.reading.forms import Block, Values
from programs.posts.reading.statements import N, statements_of


class FanucCncReader(MCodeReader):
    """Programs by O-numbers."""

    syntax = FanucCnc
    shut_name = str(SHUT)

    def __init__(self) -> None:
        super().__init__()
        self.mounted = ""
        """Number of the tool in the spindle."""
        self.contour_control = False

    def load(self, files: ProgramFiles) -> str:
        """Sort the programs.

        Raises:
            ProgramError: the file has no program, or one does not end.
        """
        ((file, text),) = files.items()
        programs: dict[str, list[str]] = {}
        current: list[str] = []
        for line in statements_of(file, text):
            if match := re.fullmatch(r"O(\d+)(?:\(.*\))?", line):
                if match[1] in programs:
                    raise ProgramError(f"O{match[1]} is there twice.")
                current = programs[match[1]] = []
            elif line != "%" and not re.fullmatch(r"\(.*\)|", line):
                current.append(line)
        for name, lines in programs.items():
            last = "M30" if name == str(MAIN) else "M99"
            if not lines or lines.pop() != last:
                raise ProgramError(f"O{name} does not end with {last}.")
        self.routines |= programs
        return str(MAIN)

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms; those of the control of contours stand by themselves."""
        contour, points = FanucCnc.points_on
        yield [contour], lambda values: self.control(True)
        yield [points], self.take_points
        yield [FanucCnc.points_off[0]], self.take_axes
        yield [FanucCnc.points_off[1]], lambda values: self.control(False)
        yield from (each for each in super().blocks() if each[0] not in (FanucCnc.points_on, FanucCnc.points_off))

    def grammar(self) -> dict[str, Action]:
        """List the other blocks."""
        return {
            rf"((?:M\d+ )*)(G6[14] )?G1({AXES}) F{N}": self.feed_block,
            r"M([2-3]\d\d)": lambda match: self.switch_by(match[1]),
            r"G5[4-9]": self.use_system,
        }

    def feed_block(self, match: re.Match[str]) -> None:
        """Switch outputs, and go straight to a tool point."""
        codes, path, words, feed = match.groups()
        self.stops = path == "G61 " if path else self.stops
        self.feed_with(codes, words, feed)

    def take_points(self, values: Values) -> None:
        """Take tool points with the length of the tool that is in the spindle.

        Raises:
            ProgramError: another tool is.
        """
        if values["tool"] != self.mounted or not self.contour_control:
            raise ProgramError("tool points need the length of the tool in the spindle, and G5.1 Q1 before.")
        super().take_points(values)

    def control(self, contours: bool) -> None:
        """Begin or end the control of contours."""
        self.contour_control = contours

    def change_tool(self, values: Values) -> None:
        """Change the tool."""
        super().change_tool(values)
        self.mounted = values["tool"]

    def read_part(self, values: Values) -> None:
        """Do a part of main.

        Raises:
            ProgramError: it calls another one.
        """
        if int(values["routine"]) != MAIN + int(values["number"]):
            raise ProgramError(f"part {values['number']} calls O{values['routine']}.")
        super().read_part(values)
