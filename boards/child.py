"""Foreign readers in a process of their own: bounded in time and memory, and ended with their parent."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from specs.errors import printable

_START = "import sys; sys.path += sys.argv[6:]; from boards.child_start import main; main()"
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_LONGEST = 200


class ChildError(Exception):
    """A reader did not come to its end: the message is why, as a clause."""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the reading of a file may use."""

    cpu_s: int
    memory_bytes: int
    wall_s: float
    """In all: a reader may also wait for what never comes."""
    written_bytes: int = 20_000_000
    """Of each file, as of its log."""


def in_child(
    reader: Callable[[bytes], bytes], data: bytes, limits: Limits, tick: Callable[[float], object] = float
) -> tuple[bytes, str]:
    """Call a function of a foreign library in a child process; returns what it gives, and its log.

    A library may write to the terminal as it likes, hold the interpreter, never end, fill the memory, and crash on a
    damaged file; a process keeps all that away from the caller.

    Args:
        reader: A function of a module that imports quickly, as the child imports it anew. What it exits with
            (``SystemExit``) is the reason of its failure.
        data: Content of the file.
        limits: What the child may use.
        tick: Is called ten times a second with the seconds it has taken.

    Raises:
        ChildError: it was beyond its limits, crashed or failed, or there can be no child.
    """
    try:
        code, output, log = run_child(reader, data, limits, tick)
    except subprocess.TimeoutExpired:
        raise ChildError(f"its reader took more than {limits.wall_s:g} s") from None
    except OSError as error:
        raise ChildError(f"no process for its reader: {error.strerror}") from None
    if code == -signal.SIGXCPU:
        raise ChildError(f"its reader took more than {limits.cpu_s} s of processor time")
    if code != 0:
        last = log.strip().splitlines()[-1:] if code > 0 else []
        raise ChildError(
            printable(last[0].strip()[:_LONGEST]) if last else "its reader crashed or needed too much memory"
        )
    return output, log


def run_child(
    reader: Callable[[bytes], bytes], data: bytes, limits: Limits, tick: Callable[[float], object]
) -> tuple[int, bytes, str]:
    """Run a child process to its end; returns its exit code, what it gives, and its log.

    Raises:
        subprocess.TimeoutExpired: it has not ended in time, and is ended.
        OSError: there can be none.
    """
    # Neither the user's site nor the variables of Python: an interpreter that is there in a fiftieth of a second.
    command = [sys.executable, "-ISB" if sys.dont_write_bytecode else "-IS", "-c", _START, str(os.getpid())]
    command += [
        str(limits.cpu_s),
        str(limits.memory_bytes),
        str(limits.written_bytes),
        f"{reader.__module__}:{reader.__name__}",
    ]
    command += [str(Path(__file__).parents[1]), *map(os.path.abspath, filter(None, sys.path))]
    started = time.monotonic()
    # Files in memory, which nothing can leave behind; a pipe to stdin would have to be fed meanwhile.
    with os.fdopen(os.memfd_create("source"), "w+b") as source, os.fdopen(os.memfd_create("log"), "w+b") as sink:
        source.write(data)
        source.seek(0)
        folder = Path(__file__).parent  # holds nothing that a file could name
        with subprocess.Popen(command, stdin=source, stdout=subprocess.PIPE, stderr=sink, cwd=folder) as process:
            try:
                while (elapsed := time.monotonic() - started) < limits.wall_s:
                    tick(elapsed)
                    with suppress(subprocess.TimeoutExpired):
                        output, _ = process.communicate(timeout=0.1)
                        break
                else:
                    raise subprocess.TimeoutExpired(command, limits.wall_s)
            finally:
                process.kill()
        sink.seek(0)
        return process.returncode, output, _COLOUR.sub("", sink.read().decode(errors="replace"))
