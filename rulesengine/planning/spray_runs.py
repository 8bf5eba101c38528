"""Sprayed runs of a plan: passes of one stroke that follow each other."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Points
from programs.plan import Dwell, Plan, SprayPass
from specs.source import Source


@dataclass(frozen=True, slots=True, eq=False)
class Sprayed:
    """Passes of one stroke that follow each other with nothing but pauses between them."""

    passes: tuple[SprayPass, ...]
    """At least one."""
    pauses: tuple[Dwell, ...]

    @property
    def made_by(self) -> Source:
        """Recipe path of the stroke, such as ``"sequence[0]/around/U12"``."""
        return self.passes[0].made_by

    @property
    def place(self) -> Source:
        """Recipe path of the template in its step, such as ``"sequence[0]/around"``."""
        return self.made_by.place

    @property
    def points(self) -> Points:
        """(n, 3) orifice, n >= 2. Board frame, mm."""
        return np.concatenate([self.passes[0].tcp, *(each.tcp[1:] for each in self.passes[1:])])

    @property
    def way_mm(self) -> float:
        """All of the way, lap after lap."""
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())


def sprayed_in(plan: Plan) -> list[Sprayed]:
    """Sprayed runs of a plan, in order."""
    found: list[Sprayed] = []
    passes: list[SprayPass] = []
    pauses: list[Dwell] = []
    for item in plan.items:
        if isinstance(item, Dwell) and passes:
            pauses.append(item)
            continue
        if passes and not (isinstance(item, SprayPass) and item.made_by == passes[0].made_by):
            found.append(Sprayed(tuple(passes), tuple(pauses)))
            passes, pauses = [], []
        if isinstance(item, SprayPass):
            passes.append(item)
    return [*found, Sprayed(tuple(passes), tuple(pauses))] if passes else found
