"""Reads SINUMERIK programs back, as the controller would execute them."""

import re

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.blocks import AXES, ToolPointReader
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import N, statements_of
from programs.posts.sinumerik.write import SYSTEMS, WORDS, Sinumerik, frame_number

_B = r"(-?\d+(?:\.\d+)?|\(-\d+(?:\.\d+)?\))"
_READING = rf"{_B}\*\$A_INA\[(\d+)\]\+{_B}"
_UNTIL = rf"UNTIL (?:(R\d+)>=(\d+)|\((R\d+)>=(\d+)\) OR \({_READING}>={_B}\))"
_SET = rf"(\$A_(?:OUT|OUTA|DBB))\[(\d+)\]={N}"
_KINDS = {word: kind for kind, word in WORDS.items()}
_FRAMES = {frame_number(system): system for system in SYSTEMS}


class SinumerikReader(ToolPointReader):
    """A main program and its subprograms."""

    handlers = frozenset({"main", "IDS"})
    watches_inputs = True

    def __init__(self) -> None:
        super().__init__()
        self.at_fault: list[str] = []
        """Outputs that a static action shuts."""
        self.group = ""
        """Axes for which F counts."""

    def load(self, files: ProgramFiles) -> str:
        """Sort the programs by their files.

        Raises:
            ProgramError: one does not end.
        """
        main = ""
        for file in files:
            name, _, suffix = file.rpartition(".")
            lines = [line for line in statements_of(file, files[file], ";") if line]
            last = "M30" if suffix == "mpf" else "M17"
            if not lines or lines.pop() != last:
                raise ProgramError(f"the program does not end with {last}.", file=file)
            self.routines[name] = lines
            main = name if suffix == "mpf" else main
        return main

    def grammar(self) -> dict[str, Action]:
        """List the blocks."""
        return {
            rf"(G60 |G642 )?G1({AXES}) F{N}": self.feed_block,
            rf"G0 SUPA D0({AXES})": self.go_home,
            rf"G0({AXES})": self.rapid,
            r"FGROUP\(([XYZBC,]+)\)": self.set_group,
            rf"(?:WHEN TRUE DO )?{_SET}": lambda match: self.switch(*_output(*match.groups())),
            rf"G4 F{N}": self.pause,
            r"T(\d+) M6": self.change_tool,
            r"G5(?:[4-7]|0[5-9])": self.use_system,
            rf"\$P_UIFR\[(\d+)\]=CTRANS\(X,{N},Y,{N},Z,{N}\)": self.set_offset,
            r"D1": self.begin_points,
            r"TRAFOOF": self.take_axes,
            r"IDS=1 EVERY \$AC_STAT<>2 DO (.*)": self.shut_at_fault,
            r"CANCEL\(1\)": self.shut("IDS"),
            r"IDS=(\d+) EVERY \$A_IN\[(\d+)\]==([01]) DO SETAL\(650(\d+)\)": self.watch,
            rf"{self.shut_name}": self.shut("main"),
            r"IF R100<=(\d+)": lambda match: self.run_part_named(match[1]),
            r"IF R100==(\d+)": lambda match: self.enter(match[1], "ENDIF"),
            r"STOPRE": self.stop_reading_ahead,
            r"\$AC_TIMER\[1\]=0": self.wait,
            r"(R11\d|R1[2-9]\d|R[2-9]\d\d)=0": self.set_counter,
            r"REPEAT": self.begin_loop,
            _UNTIL: self.end_repeat,
            r"R100=1|G17 G40 G90 G94 G710|ENDIF": skip,
            r"([A-Za-z]{2}\w*)": self.call_program,
        }

    def feed_block(self, match: re.Match[str]) -> None:
        """Go straight to a tool point.

        Raises:
            ProgramError: F counts for other axes than those that move.
        """
        path, words, feed = match.groups()
        self.stops = path == "G60 " if path else self.stops
        if self.group != ("X,Y,Z" if set(words) & set("XYZ") else "B,C"):
            raise ProgramError(f"F counts for {self.group or 'no axes'}, and others move.")
        self.feed(words, feed)

    def set_group(self, match: re.Match[str]) -> None:
        """Let F count for some axes."""
        self.group = match[1]

    def set_offset(self, match: re.Match[str]) -> None:
        """Set the zero of a coordinate system."""
        self.offsets[_FRAMES[int(match[1])]] = dict(zip("XYZ", map(float, match.groups()[1:]), strict=True))

    def begin_points(self, match: re.Match[str]) -> None:
        """Take tool points, by the blocks that belong to that."""
        self.pass_on(*map(re.escape, Sinumerik.points_on[1:]))
        self.take_points(match)

    def shut_at_fault(self, match: re.Match[str]) -> None:
        """Shut outputs while no program runs."""
        for action in match[1].split(" "):
            found = re.fullmatch(_SET, action)
            if found is None or float(found[3]):
                raise ProgramError(f"{action} shuts no valve.")
            self.at_fault.append(_output(*found.groups())[0])
        self.shut("IDS")(match)

    def read_shut(self) -> tuple[str, ...]:
        """Give the outputs that the fault routine shuts.

        Raises:
            ProgramError: the static action shuts others.
        """
        shut = super().read_shut()
        if list(shut) != self.at_fault:
            raise ProgramError(f"IDS=1 shuts {self.at_fault}, and {self.shut_name} {list(shut)}.")
        return shut

    def watch(self, match: re.Match[str]) -> None:
        """Begin to watch an input.

        Raises:
            ProgramError: its alarm has another number.
        """
        if match[1] != match[4]:
            raise ProgramError("the alarm is not that of its action.")
        self.watched.append((str(int(match[2]) - 1), match[3] == "0"))

    def run_part_named(self, number: str) -> None:
        """Do a part of main."""
        self.run_part(number, rf"(\w+_0*{number}(?:_\d+)?)", "ENDIF")

    def call_program(self, match: re.Match[str]) -> None:
        """Call a program of the integrator's.

        Raises:
            ProgramError: it is one of the program's own, which only its part calls.
        """
        if match[1] in self.routines:
            raise ProgramError(f"{match[1]} is called outside its part.")
        self.call(match)

    def stop_reading_ahead(self, match: re.Match[str]) -> None:
        """Wait for the motion; at the start the override is looked at then."""
        if self.routines[self.routine][self.at + 1].startswith("IF $AC_TOTAL_OVR"):
            self.pass_on(*map(re.escape, (each.strip() for each in Sinumerik.guard[1:])))
            self.guard(match)

    def wait(self, match: re.Match[str]) -> None:
        """Wait for an input, and raise an alarm where that takes too long."""
        first = rf"IF (?:\$A_IN\[(\d+)\]==([01])|{_READING}>={_B}) GOTOF READY_(\d+)"
        again = r"IF \$AC_TIMER\[1\]<(\d+(?:\.\d)?) GOTOB WAIT_(\d+)"
        alarm = r'SETAL\(65\d+,".*"\)'
        begin, _, test, late, _, _, end = self.pass_on(
            r"WAIT_(\d+):", "STOPRE", first, again, alarm, "M30", r"READY_(\d+):"
        )
        if len({begin[1], test[7], late[2], end[1]}) > 1:
            raise ProgramError("the wait goes on elsewhere than after it.")
        if test[1]:
            self.wait_for(str(int(test[1]) - 1), test[2] == "1", float(late[1]))
        else:
            condition = [each.strip("()") for each in (test[3], test[5], test[6])]
            self.wait_least(str(int(test[4]) - 1), condition, float(late[1]))

    def begin_loop(self, match: re.Match[str]) -> None:
        """Begin a loop, which counts first.

        Raises:
            ProgramError: it has no end.
        """
        (raised,) = self.pass_on(r"(R\d+)=\1\+1")
        end = next((found for found in self.ahead(_UNTIL) if raised[1] in (found[1], found[3])), None)
        if end is None:
            raise ProgramError("the loop has no end.")
        condition: list[str] = []
        if end[5]:
            condition = [end[5].strip("()"), str(int(end[6]) - 1), end[7].strip("()"), end[8].strip("()")]
        self.repeat(end[2] or end[4], condition, raised[1])
        self.raise_counter(raised)


def _output(word: str, number: str, value: str) -> tuple[str, float]:
    kind = _KINDS[word]
    return f"{kind} {int(number) - (kind != 'group')}", float(value)
