"""The one way in which a command ends when something stops its job."""

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager, suppress

import typer

from geometry.errors import JobError

_INTERRUPTED = 130  # what a shell expects after Ctrl-C: 128 + SIGINT


@contextmanager
def job_errors() -> Generator[None, None, None]:
    """Turn what stops a job into one line on stderr and an exit code.

    Raises:
        typer.Exit: 2 after a ``JobError`` or a file that cannot be read or written, 130 after Ctrl-C, 1 when whoever
            read our output has stopped reading.
    """
    try:
        yield
    except JobError as error:
        _say(str(error))
        raise typer.Exit(2) from None
    except BrokenPipeError:
        # Nothing more can be said on stdout; without this Python would complain once more when it flushes at exit.
        with suppress(OSError, ValueError):  # a test's stdout has no file behind it
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise typer.Exit(1) from None
    except OSError as error:
        place = f"{error.filename}: " if error.filename else ""
        _say(f"{place}{error.strerror or error}")
        raise typer.Exit(2) from None
    except MemoryError:
        _say("not enough memory for this job; close other programs or use a smaller board")
        raise typer.Exit(2) from None
    except KeyboardInterrupt:
        _say("interrupted; nothing was left half written")
        raise typer.Exit(_INTERRUPTED) from None


def _say(message: str) -> None:
    typer.echo(f"error: {message}", err=True)
