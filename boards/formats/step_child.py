"""The process in which OpenCASCADE triangulates a STEP file, from stdin to stdout: bounded, and ended with its parent.

It is started by its path and imports nothing of the house, so that it is there in a tenth of a second.
"""

import ctypes
import os
import resource
import signal
import sys

TOL_LINEAR_MM = 0.02
"""Sag of a chord; the angle bounds the number of chords of small arcs."""

TOL_ANGULAR_RAD = 0.8
_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_MOST_LOG_BYTES = 20_000_000


def end_with_parent(parent: int) -> None:
    """Have the system kill this process when its parent ends, however that ends."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it ended before that
        os._exit(1)


def bound_resources(cpu_s: int, memory_bytes: int) -> None:
    """Bound processor time (SIGXCPU ends the process), memory, and what the library may log."""
    resource.setrlimit(resource.RLIMIT_CPU, (cpu_s, cpu_s + 1))
    resource.setrlimit(resource.RLIMIT_AS, (memory_bytes, memory_bytes))
    resource.setrlimit(resource.RLIMIT_FSIZE, (_MOST_LOG_BYTES, _MOST_LOG_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def convert(data: bytes) -> bytes:
    """Triangulate the bytes of a STEP file; empty where it holds nothing that can be."""
    import cascadio

    return cascadio.load(data, tol_linear=TOL_LINEAR_MM, tol_angular=TOL_ANGULAR_RAD, use_parallel=False)


def main() -> None:
    """Convert stdin, with parent, processor time and memory as arguments."""
    parent, cpu_s, memory_bytes = map(int, sys.argv[1:])
    end_with_parent(parent)
    bound_resources(cpu_s, memory_bytes)
    sys.modules["trimesh"] = None  # pyright: ignore[reportArgumentType]  # 0.6 s for an extension that is not used
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)  # OpenCASCADE writes to stdout as it likes: into the log with it
        out.write(convert(sys.stdin.buffer.read()))


if __name__ == "__main__":
    main()
