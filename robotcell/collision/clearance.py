"""How near robot and tool come to board and fixtures, for reports and pictures. Metres, radians."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Scalars
from robotcell.collision.body_pairs import Scene, gaps, near_items
from robotcell.collision.collision import Collider, in_chunks, scene_of
from robotcell.collision.contacts import Probe, Touch, probe_of, touch_of
from robotcell.robot.robot import Joints

FARTHEST = 0.02
"""m: what is farther away is of no interest. The work grows steeply with it: the more of a board is within reach."""
_EXACT = 5e-5
"""m: how exact a distance is."""
_WIDER = 1.5


@dataclass(frozen=True, slots=True, eq=False)
class Clearance:
    """The nearest that robot or tool is to board or fixture, row by row. Not of bodies of the robot to one another."""

    distances: Scalars
    """(n,) m, exact to 0.05 mm; 0 where bodies overlap, ``farthest`` where nothing is nearer than that."""
    touches: tuple[Touch | None, ...]
    """(n,) which bodies, and their nearest points; None where nothing is nearer than ``farthest``."""


def clearance(collider: Collider, q: Joints, tool: int, farthest: float = FARTHEST) -> Clearance:
    """Measure the clearance at (n, dof) rows of joints, as far as it is smaller than ``farthest``.

    A fixture that the base stands on is left out for the first link, as everywhere.

    Raises:
        CellError: The cell has no such tool.
    """
    scene = scene_of(collider, tool)
    touches: list[Touch | None] = []
    for _, places in in_chunks(scene, q):
        items = near_items(scene, places, np.where(scene.outside, farthest, -np.inf))
        least, probe = gaps(scene, places, items), probe_of(scene, places)
        order = np.lexsort((items.pairs, least, items.rows))
        ends = np.searchsorted(items.rows[order], np.arange(len(places.turns) + 1))
        for row in range(len(places.turns)):
            mine = order[ends[row] : ends[row + 1]]
            touches.append(_nearest(scene, probe, row, items.pairs[mine].tolist(), (least[mine].tolist(), farthest)))
    distances = np.array([farthest if touch is None else touch.distance for touch in touches])
    return Clearance(distances, tuple(touches))


def _nearest(scene: Scene, probe: Probe, row: int, pairs: list[int], bounds: tuple[list[float], float]) -> Touch | None:
    """Narrow the margin until nothing is within it: what was met last is the nearest, within ``_EXACT``.

    A pair is first met by widening from what its boxes allow: a margin far beyond the distance makes coal try most
    triangles of a board.
    """
    nearest, (least, farthest) = None, bounds
    for pair, bound in zip(pairs, least, strict=True):
        margin = min(max(_WIDER * bound, _EXACT), farthest)
        while margin >= 0.0 and bound <= farthest:
            contact = probe(row, pair, margin)
            if contact is not None:
                nearest = touch_of(scene, pair, contact)
                margin = farthest = nearest.distance - _EXACT
            elif margin < farthest:
                margin = min(_WIDER * margin, farthest)
            else:
                break
    return nearest
