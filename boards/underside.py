"""What is beneath a component: the gap, and the joints that stand in it."""

from dataclasses import dataclass
from typing import TypeAlias


@dataclass(frozen=True, slots=True)
class Joint:
    """One solder joint in a gap, in the frame of the underside: x along its length, origin in its middle. mm."""

    x_mm: float
    y_mm: float
    length_mm: float
    """Along x before it is turned; the diameter if it is round."""
    width_mm: float
    round: bool = False
    turn_rad: float = 0.0


@dataclass(frozen=True, slots=True)
class GapCase:
    """One way in which the gap may look."""

    standoff_mm: float
    joints: tuple[Joint, ...]


@dataclass(frozen=True, slots=True)
class Underside:
    """The gap under one component. Board frame, mm; both sides as seen from the top."""

    component: str
    x_mm: float
    y_mm: float
    """Middle of the underside."""
    turn_rad: float
    """From the board's x to the direction of the length."""
    length_mm: float
    width_mm: float
    cases: tuple[GapCase, ...]
    """One if everything is known; else the two bounds, the harder to clean first."""
    standoff_source: str
    """``"stated"``, the family and its document, or how the bounds were assumed."""
    joints_source: str
    """``"board file"``, the family and its document, or ``"unknown: none and many"``."""


Undersides: TypeAlias = tuple[Underside, ...]
