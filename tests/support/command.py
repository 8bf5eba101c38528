"""The command line in this process, as a shell would call it."""

import io
import os
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

from commandline.main import main


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a command ended and what it printed."""

    code: int
    out: str
    err: str


def washboard(*words: str | Path, columns: int | None = None) -> Outcome:
    """Run ``washboard WORDS`` with both streams piped, or as wide as a terminal of so many columns."""
    streams = [io.TextIOWrapper(io.BytesIO(), encoding="utf-8", newline="") for _ in range(2)]
    kept = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "FORCE_COLOR")}
    wide = {} if columns is None else {"COLUMNS": str(columns)}
    code = 0
    with (
        redirect_stdout(streams[0]),
        redirect_stderr(streams[1]),
        patch.object(sys, "argv", ["washboard", *map(str, words)]),
        patch.dict(os.environ, kept | wide, clear=True),
    ):
        try:
            main()
        except SystemExit as end:
            code = int(end.code or 0)
    for stream in streams:
        stream.flush()
    return Outcome(code, *(stream.buffer.getvalue().decode() for stream in streams))


def contents(folder: Path) -> dict[str, bytes]:
    """All files in a folder and below, hidden ones too: name to content."""
    return {str(file.relative_to(folder)): file.read_bytes() for file in folder.rglob("*") if file.is_file()}
