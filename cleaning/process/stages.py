"""A program cut into the stages of its process, each sampled finely enough for the jet that it sprays."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from boards.board import Side
from cleaning.parameters.model import Liquid
from geometry.arrays import Indices, Points, Scalars
from recipes.nozzles import Nozzle
from recipes.recipe import Use
from specs.source import Source


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The open nozzle at n moments of a stage, in order of time, each standing for a share of the spraying.

    Board frame, mm, s.
    """

    times: Scalars
    """(n,) middle of each share, from the beginning of the program."""
    seconds: Scalars
    """(n,) spraying time that the sample stands for; their sum is the stage's spraying time."""
    tcp: Points
    """(n, 3) orifice."""
    axes: NDArray[np.float64]
    """(n, 3, 3) rotation of T_board_tool: columns are the nozzle's reference azimuth, its second axis, the jet."""
    made_by: Indices
    """(n,) index into ``makers``."""
    makers: tuple[Source, ...]

    @property
    def templates(self) -> NDArray[np.str_]:
        """(n,) The template of each: ``"around"`` of ``"sequence[0]/around/U1"``; empty where there is none."""
        return np.array([maker.template for maker in self.makers], dtype=np.str_)[self.made_by]


@dataclass(frozen=True, eq=False)
class Stage:
    """One step of the sequence as the program carries it out."""

    made_by: Source
    """Recipe path of the step, such as ``"sequence[0]"``."""
    function: str
    use: Use
    nozzle_name: str
    nozzle: Nozzle
    solution: str
    liquid: Liquid
    pressure_pa: float
    """At the nozzle, above ambient."""
    temperature_c: float
    begin_s: float
    end_s: float
    samples: Samples
    repeats: int = 1
    """How often a loop may do it, at most; its samples are those of once."""
    water_g_m3: float | None = None
    """What its rinse water carries, as salt, where a cascade of tanks is followed; else it follows from the liquid."""

    @cached_property
    def spray_s(self) -> float:
        """How long the jet is on."""
        return float(self.samples.seconds.sum())

    @cached_property
    def side(self) -> Side:
        """The side that it sprays: by where the jet points for most of the time."""
        return "bottom" if float(self.samples.seconds @ self.samples.axes[:, 2, 2]) > 0 else "top"
