"""What stands between the nozzle and a place that it does not reach."""

from collections import Counter

import numpy as np

from cleaning.jet.jet import Jet
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.surface.ray_scene import Scene, cast
from geometry.arrays import Indices

_PLACES = 12
_MOMENTS = 24
_LIFT_MM = 1e-3
_WIDE = 2.0
"""Sigmas beyond the half angle that still count as within the cone."""


def occluder(cells: Indices, stage: Stage, jet: Jet, facets: Facets, scene: Scene) -> int:
    """Find the body that most often stands before cells that a stage misses.

    Rays go from the largest of the cells to the nozzle at moments, evenly chosen, in which it points at them.

    Args:
        cells: (k,) cells that are missed.
        stage: Has the nozzle's way.
        jet: Its jet.
        facets: The surface.
        scene: What may stand in the way.

    Returns:
        Index of the body; -1 where nothing stands in the way: the jet never points there, or only from behind.
    """
    largest = cells[np.argsort(-facets.cell_areas_mm2[cells], kind="stable")[:_PLACES]]
    least = np.cos(jet.half_angle + _WIDE * jet.sigma)
    seen: Counter[int] = Counter()
    for cell in largest.tolist():
        place, normal = facets.cell_centres[cell], facets.cell_normals[cell]
        away = stage.samples.tcp - place
        distance = np.linalg.norm(away, axis=1)
        along = -np.einsum("ij,ij->i", away, stage.samples.axes[:, :, 2]) / distance
        pointing = np.flatnonzero((along > least) & (away @ normal > 0))
        chosen = pointing[np.linspace(0, len(pointing) - 1, min(_MOMENTS, len(pointing))).astype(np.int64)]
        ways = away[chosen] / distance[chosen, None]
        faces, reach = cast(scene, place + _LIFT_MM * normal + np.zeros((len(chosen), 3)), ways)
        blocked = (faces >= 0) & (reach < distance[chosen])
        seen.update(scene.body[faces[blocked]].tolist())
    return min(seen, key=lambda body: (-seen[body], body), default=-1)
