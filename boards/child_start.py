"""The process in which a foreign library reads a file, from stdin to stdout: bounded, and ended with its parent.

It imports nothing that takes time.
"""

import ctypes
import os
import resource
import signal
import sys
from importlib import import_module

_PR_SET_PDEATHSIG = 1  # linux/prctl.h


def end_with_parent(parent: int) -> None:
    """Have the system kill this process when its parent ends, however that ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before that
        os._exit(1)


def bound_resources(cpu_s: int, memory_bytes: int, written_bytes: int) -> None:
    """Bound processor time (SIGXCPU ends the process), memory, and what is written and logged; no more than before."""
    for kind, soft, hard in (
        (resource.RLIMIT_CPU, cpu_s, cpu_s + 1),
        (resource.RLIMIT_AS, memory_bytes, memory_bytes),
        (resource.RLIMIT_FSIZE, written_bytes, written_bytes),
        (resource.RLIMIT_CORE, 0, 0),
    ):
        _, most = resource.getrlimit(kind)
        resource.setrlimit(kind, (soft, hard) if most == resource.RLIM_INFINITY else (min(soft, most), min(hard, most)))


def main() -> None:
    """Read stdin, with parent, processor time, memory, bytes of a file and ``MODULE:FUNCTION`` as arguments.

    Raises:
        SystemExit: the reason for the end, on stderr.
    """
    parent, *bounds = map(int, sys.argv[1:5])
    end_with_parent(parent)
    bound_resources(*bounds)
    module, function = sys.argv[5].split(":")
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)  # what the library writes to stdout goes into the log
        try:
            out.write(getattr(import_module(module), function)(sys.stdin.buffer.read()))
        except MemoryError:
            sys.exit("its reader needed too much memory")
