"""Reads Klartext back, as a TNC would execute it."""

import re
from dataclasses import replace

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.heidenhain.write import STAND, TOLERANCE, Heidenhain
from programs.posts.reading.blocks import AXES, MCodeReader, words_of
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.statements import N, statements_of
from programs.posts.rebuilt import ReadBoard, ReadLine

_MAIN = "(main)"
_S = r"\+?(-?\d+(?:\.\d+)?)"
_READING = rf"Q61 = {_S} \* Q61 \+ {_S}"
_AGAIN = r"FN 12: IF \+(Q\d+) LT \+(\d+) GOTO LBL (\d+)"
_EQUAL, _MORE = (rf"FN {word} {_S} GOTO LBL (\d+)" for word in (r"9: IF \+Q61 EQU", r"11: IF \+Q61 GT"))
_INPUT = r"FN 18: SYSREAD Q61 = ID2000 NR(20|70) IDX(\d+)"


class HeidenhainReader(MCodeReader):
    """Labels, Q parameters, modes of the machine."""

    m_base = Heidenhain.m_base

    def __init__(self) -> None:
        super().__init__()
        self.guards_override = None
        self.system = "datum"
        self.offsets = {self.system: {}}

    def load(self, files: ProgramFiles) -> str:
        """Sort the labels; what comes before them is the program.

        Raises:
            ProgramError: blocks are not numbered one by one, or the program does not begin and end as it has to.
        """
        ((file, text),) = files.items()
        blocks: list[str] = []
        for number, line in enumerate(statements_of(file, text)):
            found, _, block = line.partition(" ")
            if found != str(number):
                raise ProgramError(f"block {found} is not number {number}.", file=file, line=number + 1)
            kept = block.partition(";")[0].strip()
            if kept:
                blocks.append(line.become(kept))
        name = file.removesuffix(".h")
        if len(blocks) < 2 or blocks.pop(0) != f"BEGIN PGM {name} MM" or blocks.pop() != f"END PGM {name} MM":
            raise ProgramError("the program does not begin and end with its name.", file=file)
        self.routines[_MAIN] = list(self.sort(blocks, r'LBL "(\w+)"', r"LBL 0"))
        if not self.routines[_MAIN] or self.routines[_MAIN][-1] != "M30":
            raise ProgramError("the program does not end with M30.", file=file)
        return _MAIN

    def grammar(self) -> dict[str, Action]:
        """List the blocks."""
        return {
            rf"L({AXES}) F{N}((?: M\d+)*)": lambda match: self.feed_with(match[3], match[1], match[2]),
            rf"L({AXES}) R0 FMAX": self.rapid,
            rf"L({AXES}) R0 FMAX M91": self.go_home,
            re.escape(STAND): self.stand,
            r"M(4\d\d|5\d\d)": lambda match: self.switch_by(match[1]),
            rf"FN 19: PLC=\+(\d+)/{_S}": self.set_value,
            r"CYCL DEF 9\.0 DWELL TIME": lambda match: self.pause(self.pass_on(rf"CYCL DEF 9\.1 DWELL {N}")[0]),
            r"TOOL CALL (\d+) Z": self.change_tool,
            r"CYCL DEF 7\.0 DATUM SHIFT": self.shift,
            r"FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS": self.take_points,
            r"FUNCTION RESET TCPM": self.take_axes,
            rf'CALL LBL "{self.shut_name}"': self.shut("main"),
            r"CALL PGM (\w+)": self.call,
            r"FN 11: IF \+Q50 GT \+(\d+) GOTO LBL (\d+)": lambda match: self.run_part(
                match[1], r'CALL LBL "(\w+)"', f"LBL {match[2]}"
            ),
            r"FN 10: IF \+Q50 NE \+(\d+) GOTO LBL (\d+)": lambda match: self.enter(match[1], f"LBL {match[2]}"),
            r"Q60 = \+0": self.wait,
            r"(Q\d+) = \+0": self.set_counter,
            r"LBL (5\d\d)": self.begin_loop,
            _INPUT: self.read_again,
            _AGAIN: self.end_loop,
            re.escape(TOLERANCE[0]): self.set_tolerance,
            r"Q50 = \+1|LBL 9\d+|M30": skip,
        }

    def set_tolerance(self, match: re.Match[str]) -> None:
        """Let corners be passed."""
        self.pass_on(*map(re.escape, TOLERANCE[1:]))

    def stand(self, match: re.Match[str]) -> None:
        """Stand at the end of the block before."""
        if self.steps and isinstance(last := self.steps[-1], ReadLine):
            self.steps[-1] = replace(last, stops=True, zone=0.0)

    def shift(self, match: re.Match[str]) -> None:
        """Shift the datum."""
        shifts = self.pass_on(*(rf"CYCL DEF 7\.{n} ({letter}{_S})" for n, letter in enumerate("XYZ", start=1)))
        self.offsets[self.system] = words_of(" ".join(found[1] for found in shifts))
        self.steps.append(ReadBoard(None))

    def wait(self, match: re.Match[str]) -> None:
        """Wait for an input, and raise an error where that takes too long.

        Raises:
            ProgramError: it goes on elsewhere than after the error.
        """
        dwell = (r"LBL (\d+)", r"CYCL DEF 9\.0 DWELL TIME", r"CYCL DEF 9\.1 DWELL 0\.1", r"Q60 = Q60 \+ 1")
        begin, *_, read = self.pass_on(*dwell, _INPUT)
        fails = (_AGAIN.replace(r"(Q\d+)", "(Q60)"), r"FN 14: ERROR=\d+", r"LBL (\d+)")
        if read[1] == "20":
            test, again, _, end = self.pass_on(_EQUAL, *fails)
            jumps = {test[2]}
            self.wait_for(read[2], float(test[1]) == 1.0, float(again[2]) / 10.0)
        else:
            quantity, equal, more, again, _, end = self.pass_on(_READING, _EQUAL, _MORE, *fails)
            jumps = {equal[2], more[2]} | ({"other"} if equal[1] != more[1] else set[str]())
            self.wait_least(read[2], [quantity[1], quantity[2], more[1]], float(again[2]) / 10.0)
        if jumps != {end[1]} or begin[1] != again[3]:
            raise ProgramError("the wait goes on elsewhere than after it.")

    def begin_loop(self, match: re.Match[str]) -> None:
        """Begin a loop.

        Raises:
            ProgramError: nothing goes back to it, or what it reads leads elsewhere.
        """
        label = match[1]
        (raised,) = self.pass_on(r"(Q\d+) = \1 \+ 1")
        statements = self.routines[self.routine]
        back = (at for at in range(self.at, len(statements)) if re.fullmatch(_AGAIN, statements[at]))
        at = next((at for at in back if statements[at].endswith(f"GOTO LBL {label}")), None)
        end = re.fullmatch(_AGAIN, statements[at]) if at is not None else None
        if at is None or end is None or end[1] != raised[1]:
            raise ProgramError(f"nothing goes back to {match[0]}.")
        condition: list[str] = []
        if re.fullmatch(_MORE, statements[at - 1]):
            forms = (_INPUT, _READING, _EQUAL, _MORE, r"LBL (\d+)")
            lines = [*statements[at - 4 : at], *statements[at + 1 : at + 2]]
            read, quantity, equal, more, after = (re.fullmatch(f, s) for f, s in zip(forms, lines, strict=True))
            if not (read and quantity and equal and more and after) or read[1] != "70":
                raise ProgramError("the loop does not read its input where it ends.")
            if equal.groups() != more.groups() or more[2] != after[1]:
                raise ProgramError("the loop goes on elsewhere than after it.")
            condition = [quantity[1], read[2], quantity[2], more[1]]
        self.repeat(end[2], condition, raised[1])
        self.labels.append(label)
        self.raise_counter(raised)

    def read_again(self, match: re.Match[str]) -> None:
        """Read the input of a loop, and go on to its end."""
        self.pass_on(_READING, _EQUAL, _MORE)

    def end_loop(self, match: re.Match[str]) -> None:
        """End the loop that was begun last, and pass the label after it."""
        self.end_labelled(match, match[3])
        after = self.routines[self.routine][self.at + 1 : self.at + 2]
        if after and re.fullmatch(r"LBL 6\d\d", after[0]):
            self.at += 1
