"""Reads a program from its file."""

from pathlib import Path

from programs import native
from programs.errors import ProgramError
from programs.program import TimedProgram
from programs.soundness import LARGEST_BYTES
from specs.read_file import read_file


def load_program(path: Path) -> TimedProgram:
    """Read a ``.wash`` file.

    Raises:
        ProgramError: it cannot be read or is not a program; the message names the file and the line.
    """
    data = read_file(path, ProgramError, "program (.wash)", LARGEST_BYTES)
    try:
        text = data.decode("utf-8-sig")  # some editors on Windows put a byte order mark in front
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ProgramError("this is not UTF-8 text; give a .wash file.", file=path, line=line) from None
    return native.parse(text, file=path)
