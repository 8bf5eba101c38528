"""Reads the RAPID that ``abb_paint`` writes: the brushes become outputs, the rest is read as RAPID."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from programs.errors import ProgramError
from programs.posts.abb import read as abb_reader
from programs.posts.reading.rebuilt import Rebuilt

_BRUSH = re.compile(r"SetBrush (\d+);")
_NAME = re.compile(r'CONST string sBrush(\d+):="(\w+)";')


def read(files: Mapping[str, str]) -> Rebuilt:
    """Rebuild what the modules do.

    Raises:
        ProgramError: a module is missing, or something is written that ``abb_paint`` does not write.
    """
    guns = {number: name for text in files.values() for number, name in _NAME.findall(text)}
    cabinet = _Cabinet(guns)
    return abb_reader.read({file: cabinet.translate(text) for file, text in files.items()})


@dataclass(slots=True)
class _Cabinet:
    """The process controller: which gun is open. Routines stand in the order in which they run."""

    guns: dict[str, str]
    """Output by the number of its brush."""
    opened: str = ""

    def translate(self, text: str) -> str:
        """Say a module without brushes."""
        lines: list[str] = []
        for line in text.splitlines():
            statement = line.strip()
            if match := _BRUSH.fullmatch(statement):
                lines += self.brush(match[1])
            elif statement.startswith("TriggL ") or any(f"SetDO {gun}," in statement for gun in self.guns.values()):
                raise ProgramError(f"{statement!r} would switch a gun past its brush.")
            elif not _NAME.fullmatch(statement):
                lines.append(statement.replace("PaintL ", "MoveL ", 1) if statement.startswith("PaintL ") else line)
        return "\n".join(lines)

    def brush(self, number: str) -> list[str]:
        """Change guns as a brush does: 0 shuts the one that is open, or all if none is known to be."""
        if number == "0":
            shut = [self.opened] if self.opened else list(self.guns.values())
            self.opened = ""
            return [f"SetDO {gun},0;" for gun in shut]
        if self.opened or number not in self.guns:
            raise ProgramError(f"brush {number} is not in the table, or {self.opened} is open.")
        self.opened = self.guns[number]
        return [f"SetDO {self.opened},1;"]
