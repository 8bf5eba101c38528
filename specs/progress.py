"""Callbacks by which long work reports its progress."""

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, float], None]
"""Receives the present stage and the share of the whole that is done, 0 to 1."""


def subprogress(progress: Progress, begin: float, end: float) -> Progress:
    """Map the progress of a subtask, 0 to 1, onto its share of the whole."""
    return lambda what, done: progress(what, begin + (end - begin) * done)


def no_progress(_what: str, _done: float) -> None:
    """Ignore the progress: the default of functions that take a callback."""
