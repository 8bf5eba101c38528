"""Reads SINUMERIK programs back, as the controller would execute them."""

import re
from collections.abc import Mapping

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.reading.blocks import AXES, ToolPointReader
from programs.posts.reading.execution import Action
from programs.posts.reading.forms import Values
from programs.posts.reading.statements import N, statements_of
from programs.posts.sinumerik.write import SYSTEMS, WORDS, Sinumerik

_SET = rf"(\$A_(?:OUT|OUTA|DBB))\[(\d+)\]={N}"
_KINDS = {word: kind for kind, word in WORDS.items()}


class SinumerikReader(ToolPointReader):
    """A main program and its subprograms."""

    syntax = Sinumerik
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

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        return {**super().fields(), "routine": r"[A-Za-z]{2}\w*"}

    def grammar(self) -> dict[str, Action]:
        """List the other blocks."""
        return {
            rf"(G60 |G642 )?G1({AXES}) F{N}": self.feed_block,
            r"FGROUP\(([XYZBC,]+)\)": self.set_group,
            rf"(?:WHEN TRUE DO )?{_SET}": lambda match: self.switch(*_output(*match.groups())),
            r"G5(?:[4-7]|0[5-9])": self.use_system,
            rf"\$P_UIFR\[(\d+)\]=CTRANS\(X,{N},Y,{N},Z,{N}\)": self.set_offset,
            r"IDS=1 EVERY \$AC_STAT<>2 DO (.*)": self.shut_at_fault,
            r"CANCEL\(1\)": self.shut("IDS"),
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
        self.offsets[SYSTEMS[int(match[1]) - 1]] = dict(zip("XYZ", map(float, match.groups()[1:]), strict=True))

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

    def read_part(self, values: Values) -> None:
        """Do a part of main.

        Raises:
            ProgramError: it calls another one.
        """
        if not re.fullmatch(rf"\w+_0*{values['number']}(?:_\d+)?", values["routine"]):
            raise ProgramError(f"part {values['number']} calls {values['routine']}.")
        super().read_part(values)

    def call(self, name: str) -> None:
        """Call a program of the integrator's.

        Raises:
            ProgramError: it is one of the program's own, which only its part calls.
        """
        if name in self.routines:
            raise ProgramError(f"{name} is called outside its part.")
        super().call(name)


def _output(word: str, number: str, value: str) -> tuple[str, float]:
    kind = _KINDS[word]
    return f"{kind} {int(number) - (kind != 'group')}", float(value)
