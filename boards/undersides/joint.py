"""One solder joint beneath a component."""

from dataclasses import dataclass


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
