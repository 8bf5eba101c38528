"""Reads Klartext back, as a TNC would execute it."""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

from programs.errors import ProgramError
from programs.posts.dialect import ProgramFiles
from programs.posts.heidenhain.write import STAND, Heidenhain
from programs.posts.reading.blocks import AXES, MCodeReader, words_of
from programs.posts.reading.execution import Action, skip
from programs.posts.reading.forms import Block
from programs.posts.reading.statements import NUMBER, N, statements_of
from programs.posts.rebuilt import ReadBoard, ReadLine

_MAIN = "(main)"


class HeidenhainReader(MCodeReader):
    """Labels, Q parameters, modes of the machine."""

    syntax = Heidenhain

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

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms."""
        return {**super().fields(), **dict.fromkeys(("scale", "offset", "least"), rf"\+?{NUMBER}")}

    def blocks(self) -> Iterator[Block]:
        """List the blocks of forms."""
        yield from super().blocks()
        yield Heidenhain.pause_forms, self.pause

    def grammar(self) -> dict[str, Action]:
        """List the other blocks."""
        return {
            rf"L({AXES}) F{N}((?: M\d+)*)": lambda match: self.feed_with(match[3], match[1], match[2]),
            re.escape(STAND): self.stand,
            r"M(4\d\d|5\d\d)": lambda match: self.switch_by(match[1]),
            r"CYCL DEF 7\.0 DATUM SHIFT": self.shift,
            r"M30": skip,
        }

    def stand(self, match: re.Match[str]) -> None:
        """Stand at the end of the block before."""
        if self.steps and isinstance(last := self.steps[-1], ReadLine):
            self.steps[-1] = replace(last, stops=True, zone=0.0)

    def shift(self, match: re.Match[str]) -> None:
        """Shift the datum."""
        shifts = self.pass_on(*(rf"CYCL DEF 7\.{n} ({letter}\+?{NUMBER})" for n, letter in enumerate("XYZ", start=1)))
        self.offsets[self.system] = words_of(" ".join(found[1] for found in shifts))
        self.steps.append(ReadBoard(None))
