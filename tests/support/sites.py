"""Sites and specs for tests of the path planners."""

from recipes.nozzles import HollowCone
from recipes.recipe import Limits
from rulesengine.strokes.stroke import Site
from specs.source import Source

CONE = HollowCone(half_angle_deg=30, flow_lpm=2)


PATH = Source(0, "path")


def site_on(board, nozzle=CONE, limits=None, side="top", served=None, made_by=PATH):
    """A site that serves every component of the side and puts all of them into the class ``any``."""
    names = frozenset(c.name for c in board.components if c.side == side) if served is None else frozenset(served)
    classes = {component.name: "any" for component in board.components}
    return Site(board, side, nozzle, limits or Limits(), classes, names, made_by)
