"""Reads a FANUC CNC's programs back, as it would execute them."""

import re

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.fanuc_cnc.write import MAIN, OUTPUT_MACRO, SHUT, SYSTEMS, FanucCnc
from programs.posts.reading.blocks import AXES, MCodeReader, words_of
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import N, statements_of

_BRACKETED = r"(-?\d+(?:\.\d+)?|\[-\d+(?:\.\d+)?\])"
_READING = rf"\[{_BRACKETED}\*#(\d+)\]\+{_BRACKETED}"
_FAILS = (r"IF\[#3001LT(\d+)\]GOTO(\d+)", r"#3000=\d+\(.*\)", r"N(\d+)")
_LOOP = rf"IF\[(?:#(\d+)LT(\d+)|\[#(\d+)LT(\d+)\]AND\[\[{_READING}\]LT{_BRACKETED}\])\]GOTO(\d+)"


class FanucCncReader(MCodeReader):
    """Programs by O-numbers."""

    m_base = FanucCnc.m_base
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

    def grammar(self) -> dict[str, Action]:
        """List the blocks."""
        return {
            rf"((?:M\d+ )*)(G6[14] )?G1({AXES}) F{N}": self.feed_block,
            rf"G0({AXES})": self.rapid,
            rf"G53 G0({AXES})": self.go_home,
            r"M([2-3]\d\d)": lambda match: self.switch_by(match[1]),
            rf"G65 P{OUTPUT_MACRO} A(\d+) V{N}": self.set_value,
            rf"G4 X{N}": self.pause,
            r"T(\d+) M6": self.change_tool,
            r"G5[4-9]": self.use_system,
            rf"G10 L2 P(\d)({AXES})": self.set_offset,
            r"G43\.4 H(\d+)": self.take_points,
            r"G49": self.take_axes,
            r"G5\.1 Q([01])": self.look_ahead,
            rf"M98 P{SHUT}": self.shut("main"),
            r"M98 (?:P(\d+)|<(\w+)>)": self.call_program,
            r"IF\[#100GT(\d+)\]GOTO(\d+)": lambda match: self.run_part(
                match[1], rf"M98 P({MAIN + int(match[1])})", f"N{match[2]}"
            ),
            r"IF\[#100NE(\d+)\]GOTO(\d+)": lambda match: self.enter(match[1], f"N{match[2]}"),
            r"#3004=2": self.guard,
            r"#3001=0": self.wait,
            r"#(\d+)=0": self.set_counter,
            r"N(5\d\d)": self.begin_loop,
            _LOOP: lambda match: self.end_labelled(match, match[9]),
            r"#100=1|G21 G90 G17 G40 G49 G80 G94|N9\d+": skip,
        }

    def feed_block(self, match: re.Match[str]) -> None:
        """Switch outputs, and go straight to a tool point."""
        codes, path, words, feed = match.groups()
        self.stops = path == "G61 " if path else self.stops
        self.feed_with(codes, words, feed)

    def set_offset(self, match: re.Match[str]) -> None:
        """Set the zero of a coordinate system."""
        self.offsets[SYSTEMS[int(match[1]) - 1]] = words_of(match[2])

    def take_points(self, match: re.Match[str]) -> None:
        """Take tool points with the length of the tool that is in the spindle.

        Raises:
            ProgramError: another tool is.
        """
        if match[1] != self.mounted or not self.contour_control:
            raise ProgramError("tool points need the length of the tool in the spindle, and G5.1 Q1 before.")
        super().take_points(match)

    def change_tool(self, match: re.Match[str]) -> None:
        """Change the tool."""
        super().change_tool(match)
        self.mounted = match[1]

    def look_ahead(self, match: re.Match[str]) -> None:
        """Begin or end the control of contours."""
        self.contour_control = match[1] == "1"

    def call_program(self, match: re.Match[str]) -> None:
        """Call a program of the integrator's.

        Raises:
            ProgramError: it is one of the program's own, which only its part calls.
        """
        if match[1]:
            raise ProgramError(f"O{match[1]} is called outside its part.")
        self.call(re.compile(r"(.*)").fullmatch(match[2]) or match)

    def wait(self, match: re.Match[str]) -> None:
        """Wait for an input, and raise an alarm where that takes too long.

        Raises:
            ProgramError: it goes on elsewhere than after the alarm.
        """
        first = rf"IF\[(?:#(\d+)EQ([01])|{_READING}GE{_BRACKETED})\]GOTO(\d+)"
        begin, test, again, _, end = self.pass_on(r"N(\d+)", first, *_FAILS)
        if begin[1] != again[2] or test[7] != end[1]:
            raise ProgramError("the wait goes on elsewhere than after it.")
        if test[1]:
            self.wait_for(str(int(test[1]) - 1000), test[2] == "1", float(again[1]) / 1000.0)
        else:
            condition = [each.strip("[]") for each in (test[3], test[5], test[6])]
            self.wait_least(str(int(test[4]) - 600), condition, float(again[1]) / 1000.0)

    def begin_loop(self, match: re.Match[str]) -> None:
        """Begin a loop.

        Raises:
            ProgramError: nothing goes back to it.
        """
        end = next((found for found in self.ahead(_LOOP) if found[9] == match[1]), None)
        if end is None:
            raise ProgramError(f"nothing goes back to {match[0]}.")
        counter = end[1] or end[3]
        (raised,) = self.pass_on(rf"#({counter})=#{counter}\+1")
        condition: list[str] = []
        if end[5]:
            condition = [end[5].strip("[]"), str(int(end[6]) - 600), end[7].strip("[]"), end[8].strip("[]")]
        self.repeat(end[2] or end[4], condition, counter)
        self.labels.append(match[1])
        self.raise_counter(raised)
