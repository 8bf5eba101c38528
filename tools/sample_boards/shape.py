"""A sample part before it is placed."""

from dataclasses import dataclass
from typing import TypeAlias

from boards.board import Pad
from geometry.arrays import Triangles

Solids: TypeAlias = tuple[tuple[str, tuple[Triangles, ...]], ...]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A part around its own origin, mm; z = 0 is the surface of the board."""

    package: str
    pins: int
    gap_height_mm: float
    """Gap between z = 0 and the underside of the body, as modelled."""
    solids: Solids
    """Named surfaces, each of one or more closed solids."""
    drills: tuple[tuple[float, float, float], ...] = ()
    """Holes that the board needs: x, y and diameter."""
    lands: tuple[Pad, ...] = ()
    """Pads of the board where they are larger than what touches them."""
    overhang_mm: float = 0.0
    """How far the part may reach over the board's edge."""
