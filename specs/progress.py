"""How long work tells how far it is."""

from collections.abc import Callable
from typing import TypeAlias

Progress: TypeAlias = Callable[[str, float], None]
"""Takes what is being done and which part of the whole job is behind us (0 to 1)."""


def part_of(tell: Progress, begin: float, end: float) -> Progress:
    """Map the progress of a part onto its share of the whole."""

    def told(what: str, done: float) -> None:
        tell(what, begin + (end - begin) * done)

    return told


def tell_nobody(_what: str, _done: float) -> None:
    """Be the progress of work that nobody waits for."""
