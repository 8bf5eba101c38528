"""How every command ends when something stops its job: one line on stderr, and an exit code."""

import errno
import os
import sys
import traceback
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path

import typer

from specs import ending
from specs.errors import JobError, printable, shorten_line

UsageError: type[Exception] = typer.BadParameter.__bases__[0]
"""What typer raises for arguments that it cannot place; it exports no name for it."""
_REFUSED = 2
_INTERRUPTED = 130  # what a shell expects after Ctrl-C: 128 + SIGINT
_UNWRITTEN = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO}
_INTERNAL = 70  # EX_SOFTWARE of sysexits.h
DEBUG_VARIABLE = "WASHBOARD_DEBUG"
"""Set to 1 in the environment, it makes an internal error print its traceback."""


@contextmanager
def job_errors() -> Generator[None, None, None]:
    """Turn what stops a job into one line on stderr and an exit code.

    Raises:
        typer.Exit: 2 after a ``JobError`` or a file that cannot be read or written, 130 after Ctrl-C, 1 when the
            reader of the output has stopped reading, 70 after an internal error.
    """
    try:
        yield
    except typer.Exit:
        raise
    except JobError as error:
        _print_error(f"error: {error}")
        raise typer.Exit(_REFUSED) from None
    except BrokenPipeError:
        _discard_unwritten()
        raise typer.Exit(1) from None
    except OSError as error:
        _discard_unwritten()
        place = _place_of(error)
        _print_error(f"error: {place}{': ' if place else ''}{error.strerror or error}")
        raise typer.Exit(_REFUSED) from None
    except MemoryError:
        _print_error("error: not enough memory for this job; close other programs or use a smaller board")
        raise typer.Exit(_REFUSED) from None
    except KeyboardInterrupt:
        _print_error(f"error: interrupted; {ending.describe_written()}")
        raise typer.Exit(_INTERRUPTED) from None
    except Exception as error:
        _print_internal(error)
        raise typer.Exit(_INTERNAL) from None


def report_usage(error: Exception) -> int:
    """Print what is wrong with the arguments and where they are explained; return the exit code.

    Args:
        error: A ``UsageError``. Nothing is printed where there were no arguments at all: help has been printed then.
    """
    message = str(getattr(error, "format_message", error.__str__)())
    command = getattr(getattr(error, "ctx", None), "command_path", "washboard")
    if message:
        end = "" if message.endswith((".", "?")) else "."
        _print_error(f"error: {message}{end} `{command} --help` shows how it is used.")
    return _REFUSED


def _print_error(message: str) -> None:
    """Print lines on stderr; of a very long one, which quotes its input, the middle is left out."""
    with ending.lock, suppress(OSError):  # stderr takes no more: the exit code is left
        typer.echo("\n".join(map(shorten_line, message.splitlines())), err=True)
        ending.note_reported(message)


def _print_internal(error: Exception) -> None:
    """Request a report of an internal error; its traceback is printed if so set in the environment."""
    if os.environ.get(DEBUG_VARIABLE, "") not in ("", "0"):
        _print_error("".join(traceback.format_exception(error)).rstrip())
    text = " ".join(str(error).split())[:300]
    command = " ".join(["washboard", *sys.argv[1:]])
    _print_error(
        f"internal error: {type(error).__name__}: {text}. This is a defect of washboard: please report it with the "
        f"command `{command}` and its input; {DEBUG_VARIABLE}=1 in the environment shows more."
    )


def _place_of(error: OSError) -> str:
    """Name what an error of the system is about; empty where that is not known."""
    if error.filename and str(error.filename) != ".":
        return printable(str(error.filename))
    try:
        Path.cwd()
    except OSError:
        return "the current folder"
    if error.filename:
        return "the current folder"
    return "stdout" if error.errno in _UNWRITTEN else ""  # every file is written by its name


def _discard_unwritten() -> None:
    """Send what stdout refuses nowhere; otherwise Python would complain once more when it flushes at exit."""
    try:
        sys.stdout.flush()
    except OSError:
        with suppress(OSError, ValueError):  # a test's stdout has no file behind it
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)
