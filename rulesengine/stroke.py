"""What the path planners make and the modifiers change, before it becomes a plan."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from boards.board import Board, Side
from geometry.arrays import Directions, Points, Scalars
from programs.plan import Jet
from recipes.nozzles import Nozzle
from recipes.recipe import Limits

Sense: TypeAlias = Literal["fixed", "either"]


@dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A run of nozzle points that is sprayed in one piece; where a ring starts and which way it goes may be open.

    Side frame: x and y as in the board frame, as seen from the top; z is the height above the bare surface of the
    side that is sprayed, for both sides; so the jet always has a negative z. Millimetres.
    """

    tcp: Points
    """(n, 3) nozzle orifice. A closed stroke does not repeat its first point. Equal neighbours turn on the spot."""
    approach: Directions
    """(n, 3) unit vectors from the orifice to the surface."""
    delays: Scalars
    """(n,) seconds to hold still at each point with the jet on; 0 goes through."""
    speed_mm_s: float
    made_by: str
    closed: bool = False
    repeats: int = 1
    """How often it is done: a closed one goes around, an open one goes back and forth."""
    sense: Sense = "either"
    """Whether the order of strokes may turn it around."""
    entries: tuple[int, ...] = (0,)
    """Points at which a closed stroke may begin, in order of preference; an open one begins at either end."""
    lead_in_mm: float = 0.0
    overshoot_mm: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """Strokes of one template and how free their order is."""

    strokes: tuple[Stroke, ...]
    free: bool
    """True lets the order of strokes save air travel; False keeps it (rinse water must run one way)."""


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """Everything a path planner may look at: the board, the nozzle, and who is asking."""

    board: Board
    side: Side
    nozzle: Nozzle
    limits: Limits
    jet: Jet
    classes: dict[str, str]
    """Component name to class name."""
    served: frozenset[str]
    """Components of this side that get passes of their own: neither avoided nor ignored."""
    made_by: str
    """Recipe path of the template in its step, such as ``"sequence[0]/around"``."""
