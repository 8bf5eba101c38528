"""The untimed plan: where the nozzle goes and in what order, before anyone has decided when."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from geometry.arrays import Directions, Points, Scalars
from specs.finding import Finding
from specs.source import Source


@dataclass(frozen=True, slots=True)
class Jet:
    """What leaves the nozzle while it is open."""

    function: str
    nozzle: str
    solution: str
    flow_lpm: float
    """At the function's pressure: Q_ref sqrt(P / P_ref)."""
    liquid: bool
    """False for air: it is not counted in litres."""


@dataclass(frozen=True, slots=True, eq=False)
class SprayPass:
    """Where the open nozzle goes without stopping. Board frame, millimetres.

    It starts and ends at rest. Corners inside it may be blended by the timing within the limits' tolerance.
    Two passes that follow each other with nothing but dwells between them keep the jet on.
    """

    tcp: Points
    """(n, 3) nozzle orifice in travel order, n >= 2. Equal neighbours with different directions turn on the spot."""
    approach: Directions
    """(n, 3) unit vectors from the orifice to the surface: tool +Z."""
    reference: Directions
    """(n, 3) unit vectors of the nozzle's reference azimuth, at right angles to ``approach``: tool +X."""
    speeds_mm_s: Scalars
    """(n - 1,) programmed speed of the orifice from each point to the next; never above the function's maximum."""
    jet: Jet
    made_by: Source
    """Recipe path it comes from, e.g. ``"sequence[0]/around/U12"``."""


@dataclass(frozen=True, slots=True)
class Dwell:
    """The open nozzle held still where the pass before it ended."""

    duration_s: float
    jet: Jet
    made_by: Source


@dataclass(frozen=True, slots=True, eq=False)
class Transfer:
    """A move with the jet off, clear of every body. Board frame, millimetres; starts and ends at rest."""

    tcp: Points
    approach: Directions
    reference: Directions
    speed_mm_s: float
    made_by: Source


@dataclass(frozen=True, slots=True)
class Command:
    """An instruction to the cell between moves: FUNCTION, NOZZLE, SOLUTION, SET, CALL, REPEAT, ENDREPEAT."""

    keyword: str
    arguments: tuple[str, ...]
    made_by: Source


PlanItem: TypeAlias = SprayPass | Dwell | Transfer | Command


@dataclass(frozen=True, slots=True)
class Origin:
    """Which board and recipe something was made from."""

    board: str
    board_sha256: str
    recipe: str
    recipe_sha256: str
    cell: str = ""
    """Name of the cell whose robot's limits the times keep to; empty where they are those of the recipe alone."""
    cell_sha256: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Passes, dwells, transfers and commands in order. The first item that moves starts at its own first point.

    Every moving item starts where the one before it ended, in position and in orientation.
    """

    origin: Origin
    items: tuple[PlanItem, ...]
    findings: tuple[Finding, ...]

    def moving(self) -> Iterator[SprayPass | Transfer]:
        """Give the items that move the nozzle, in order."""
        return (item for item in self.items if isinstance(item, SprayPass | Transfer))
