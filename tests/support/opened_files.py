"""The files that this process opens, in all threads: an audit hook, which no reader can go around."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_seen: list[str] = []
_active: list[bool] = []


def _hook(event, arguments):
    if _active and event == "open" and isinstance(arguments[0], str | bytes):
        _seen.append(os.path.realpath(os.fsdecode(arguments[0])))


@contextmanager
def opened_below(*folders: Path) -> Iterator[list[str]]:
    """Collect the real paths of the files in some folders that are opened meanwhile; filled at the end."""
    if not hasattr(_hook, "added"):
        sys.addaudithook(_hook)  # it cannot be removed
        _hook.added = True
    _seen.clear()
    _active.append(True)
    found: list[str] = []
    try:
        yield found
    finally:
        _active.clear()
        found += [path for path in _seen if any(path.startswith(f"{folder.resolve()}{os.sep}") for folder in folders)]
