"""The eight edge segments of every underside: where the spray presses liquid in or sucks it out."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Indices, Scalars

SEGMENTS = 8
"""Halves of the four edges of an underside, anticlockwise in its own frame (x along its length), beginning at the left
half of the front edge (-y): front left, front right, right front, right back, back right, back left, left back,
left front."""


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Edge segments of c components, each with eight. Board frame, mm."""

    component: Indices
    """(c,) index into the board's components."""
    middles: NDArray[np.float64]
    """(c, 8, 3) middle of each segment, at the board's surface."""
    outward: NDArray[np.float64]
    """(c, 8, 3) unit vectors in the plane of the board."""
    heights_mm: Scalars
    """(c,) of each component."""
    sheltered: NDArray[np.float64]
    """(c, 8) from each segment, along its outward normal at half height, to the next body; infinite if free."""


@dataclass(frozen=True, slots=True, eq=False)
class EdgePressure:
    """Pressure on the eight edge segments of one component while the jet is near, in one stage."""

    sample: Indices
    """(k,) ascending indices into the stage's samples: all that are near enough to matter."""
    pressure_pa: NDArray[np.float64]
    """(k, 8)"""
