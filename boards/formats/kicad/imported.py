"""Boards of other systems that KiCad imports: converted by its command line, where that is installed."""

import re
import shutil
import subprocess
from pathlib import Path

from boards.errors import BoardError
from specs.errors import printable

_SUFFIXES = (".pcbdoc", ".cpa", ".epro")
"""Of Altium, CADSTAR and EasyEDA Pro."""
_MARK = re.compile(rb'\A\s*[!*]PADS-|\A\s*\(CADSTARPCB|\A\s*\{[^{]*\{[^{}]*"docType"\s*:\s*"?3', re.IGNORECASE)
"""Beginnings of PADS ASCII, a CADSTAR archive and a board of EasyEDA."""
_COMMAND = "kicad-cli"
_LONGEST_S = 300.0
_LONGEST = 200
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
    command = [program, "pcb", "import", "--output", str(made), str(path.absolute())]
    try:
        done = subprocess.run(
            command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_LONGEST_S, check=False, cwd=folder
        )
    except subprocess.TimeoutExpired:
        raise BoardError(f"{_COMMAND} took more than {_LONGEST_S:g} s to import it; {_INSTEAD}", file=path) from None
    except OSError as reason:
        raise BoardError(f"{_COMMAND} cannot be started: {reason.strerror}.", file=path) from None
    if done.returncode or not made.is_file():
        output = (done.stderr or done.stdout).decode(errors="replace").strip().splitlines()[-1:] or ["no reason given"]
        reason = printable(output[0].strip()[:_LONGEST])
        raise BoardError(f"{_COMMAND} does not import it ({reason}): use KiCad 10 or newer, {_INSTEAD}", file=path)
    return made
