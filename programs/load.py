"""Reads a program from its file."""

from pathlib import Path

from programs import native
from programs.errors import ProgramError
from programs.program import TimedProgram
from programs.soundness import LARGEST_BYTES
from specs.input_file import InputFile


def load_program(path: Path) -> TimedProgram:
    """Read a ``.wash`` file.

    Raises:
        ProgramError: it cannot be read or is not a program; the message names the file and the line.
    """
    file = InputFile(path, ProgramError, "program (.wash)", LARGEST_BYTES)
    return native.parse(file.text("this is not UTF-8 text; give a .wash file."), file=path)
