"""Making sure of what rays did not find: a place is missed only if nothing reaches it, not if few rays came by."""

from dataclasses import replace

import numpy as np

from cleaning.exposure.exact import visible_flux
from cleaning.exposure.exposure import Exposure
from cleaning.jet.jet import Jet
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.surface.ray_scene import Scene
from geometry.arrays import Indices, Scalars

_ENOUGH = 30
"""Rays that say something about a component."""


def refine_sparse_cells(
    exposure: Exposure, stage: Stage, jet: Jet, facets: Facets, scene: Scene, cells: Indices
) -> Exposure:
    """Put exact values in the place of estimates that rest on nothing, or on too little.

    That is in cells that no ray hit, and in all cells of components that were hit by fewer than 30.

    Args:
        exposure: As the rays found it.
        stage: Its stage.
        jet: Its jet.
        facets: The surface.
        scene: What casts shadows.
        cells: Of the surfaces that are judged in this stage.
    """
    component = facets.cell_component[cells] + 1
    seldom = np.bincount(component, exposure.hits[cells]) < _ENOUGH
    poor = cells[facets.cell_exposed[cells] & ((exposure.hits[cells] == 0) | seldom[component])]
    if not len(poor):
        return exposure
    exact = visible_flux(stage, jet, facets, scene, poor)
    return replace(
        exposure,
        cone_s=_put(exposure.cone_s, poor, exact.cone_s),
        front_s=_put(exposure.front_s, poor, exact.front_s),
        volume_mm=_put(exposure.volume_mm, poor, exact.volume_mm),
        peak_pa=_put(exposure.peak_pa, poor, exact.peak_pa),
        impulse_n_pa_s=_put(exposure.impulse_n_pa_s, poor, exact.impulse_n_pa_s),
        impulse_t_pa_s=_put(exposure.impulse_t_pa_s, poor, exact.impulse_t_pa_s),
    )


def _put(values: Scalars, at: Indices, others: Scalars) -> Scalars:
    """Give a copy with other values at some places."""
    changed = values.copy()
    changed[at] = others
    return changed
