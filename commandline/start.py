"""Entry point of the command: small, so that an interrupt finds its handling in place from the beginning."""

import os
import sys
from errno import EMFILE

_INTERRUPTED = 130
_REFUSED = 2


def main() -> None:
    """Run ``washboard`` and end the process: at any moment with an exit code, and after a signal with one line.

    The process ends without the interpreter's own shutdown, in which an interrupt prints a traceback: what that would
    do is done before, while signals are still heard.
    """
    try:
        code = _run()
        _finish(code)
    except KeyboardInterrupt:  # before the watch stands; after that there is no such exception
        os.write(2, b"error: interrupted; nothing was written\n")
        os._exit(_INTERRUPTED)


def _run() -> int:
    """Run the command; returns its exit code."""
    try:
        from commandline.process import find_foreign, find_shortage, return_memory, watch

        watch()
        refusal = find_shortage() or find_foreign()
        if refusal is not None:
            sys.stderr.write(f"error: {refusal}\n")
            return _REFUSED
        return_memory()
        from commandline.main import main as run

        run()
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except Exception as error:
        if os.environ.get("WASHBOARD_DEBUG", "") not in ("", "0"):
            raise
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        cure = (
            "raise the limit (`ulimit -n`)"
            if os.strerror(EMFILE) in reason
            else "its installation is damaged. Install it anew"
        )
        sys.stderr.write(f"error: washboard cannot start ({reason}): {cure}.\n")
        return _REFUSED
    return 0


def _finish(code: int) -> None:
    """End the process with a code: nothing that other threads do is left half done."""
    import atexit

    ending = sys.modules.get("specs.ending")  # not there if the packages are somebody else's
    atexit._run_exitfuncs()  # pyright: ignore[reportPrivateUsage]
    for stream in (sys.stdout, sys.stderr):
        try:
            if stream is not None:
                stream.flush()
        except (OSError, ValueError):
            code = code or 1
    if ending is not None:
        ending.abandon()
    os._exit(code)
