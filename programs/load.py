"""Reads a program from its file."""

from pathlib import Path

from programs import native
from programs.errors import ProgramError
from programs.program import TimedProgram

LARGEST_BYTES = 200_000_000


def load_program(path: Path) -> TimedProgram:
    """Read a ``.wash`` file.

    Raises:
        ProgramError: it cannot be read or is not a program; the message names the file and the line.
    """
    try:
        if path.is_dir():
            raise ProgramError("this is a folder; give a .wash file.", file=path)
        size = path.stat().st_size
        if size > LARGEST_BYTES:
            raise ProgramError(f"the file has {size / 1e6:.0f} MB; programs above 200 MB are not read.", file=path)
        data = path.read_bytes()
    except FileNotFoundError:
        raise ProgramError("there is no such file; give the path of a .wash file.", file=path) from None
    except OSError as error:
        raise ProgramError(f"the file cannot be read: {error.strerror or error}.", file=path) from None
    try:
        text = data.decode("utf-8-sig")  # some editors on Windows put a byte order mark in front
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise ProgramError("this is not UTF-8 text; give a .wash file.", file=path, line=line) from None
    return native.parse(text, file=path)
