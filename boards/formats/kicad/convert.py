"""KiCad's command line, run in the bounded process of a foreign reader; it imports nothing that takes time."""

import ctypes
import json
import os
import signal
import subprocess
import sys

_PR_SET_PDEATHSIG = 1  # linux/prctl.h
_MOST_BYTES = 20_000


def convert(request: bytes) -> bytes:
    """Run a command, which ends with this process; a request has its words and its folder, as JSON.

    Raises:
        SystemExit: it fails; with the last line that it wrote.
    """
    command, folder = json.loads(request)

    def end_with_parent() -> None:
        if sys.platform == "linux":
            ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)

    with os.fdopen(os.memfd_create("log"), "w+b") as log:
        done = subprocess.run(
            command,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
            check=False,
            cwd=folder,
            preexec_fn=end_with_parent,
        )
        if done.returncode:
            log.seek(-min(log.seek(0, os.SEEK_END), _MOST_BYTES), os.SEEK_END)
            lines = log.read().decode(errors="replace").strip().splitlines()
            sys.exit(lines[-1] if lines else "no reason given")
    return b""
