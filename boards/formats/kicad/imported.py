"""Boards of other systems that KiCad imports: converted by its command line, where that is installed."""

import json
import re
import shutil
from pathlib import Path

from boards.child import ChildError, Limits, in_child
from boards.errors import BoardError
from boards.formats.kicad.convert import convert
from specs.input_file import InputFile
from specs.temporary import write_temporary

_SUFFIXES = (".pcbdoc", ".cpa", ".epro")
"""Of Altium, CADSTAR and EasyEDA Pro."""
_MARK = re.compile(rb'\A\s*[!*]PADS-|\A\s*\(CADSTARPCB|\A\s*\{[^{]*\{[^{}]*"docType"\s*:\s*"?3', re.IGNORECASE)
"""Beginnings of PADS ASCII, a CADSTAR archive and a board of EasyEDA."""
_COMMAND = "kicad-cli"
_LIMITS = Limits(cpu_s=300, memory_bytes=16_000_000_000, wall_s=300.0, written_bytes=500_000_000)
"""KiCad reserves far more memory than it uses."""
_INSTEAD = "or export the board as ODB++, IPC-2581 or Gerber with a placement table."


def is_imported(name: str, head: bytes) -> bool:
    """Whether a file is a board that KiCad imports, by its name or its beginning."""
    return name.lower().endswith(_SUFFIXES) or _MARK.match(head) is not None


def import_board(path: Path, folder: Path) -> Path:
    """Convert a board into that of KiCad.

    Args:
        path: Of the board.
        folder: Takes the file of KiCad.

    Raises:
        BoardError: KiCad's command line is not there, or does not convert it.
    """
    program = shutil.which(_COMMAND)
    if program is None:
        message = f"is read through KiCad, whose {_COMMAND} is not installed: install KiCad 10 or newer, {_INSTEAD}"
        raise BoardError(message, file=path)
    made = folder / "board.kicad_pcb"
    source = write_temporary(folder / "given", path.name, InputFile(path, BoardError, "board file").read())
    command = [program, "pcb", "import", "--output", str(made), str(source)]
    reason = ""
    try:
        in_child(convert, json.dumps([command, str(folder)]).encode(), _LIMITS)
    except ChildError as error:
        reason = str(error)
    if reason or not made.is_file():
        reason = reason or "no board was made"
        raise BoardError(f"{_COMMAND} does not import it ({reason}): use KiCad 10 or newer, {_INSTEAD}", file=path)
    return made
