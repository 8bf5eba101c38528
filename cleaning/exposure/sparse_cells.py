"""What reaches cells that too few rays hit, from moments spread evenly over the time in which they may be sprayed.

At each moment the nozzle is looked at from another place of the cell. Moments are a systematic sample of that time, and
places follow a Kronecker sequence over the cell's facets, so that the error falls faster than with the square root of
their number, and any number of samples of the nozzle's way or of facets costs the same.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from cleaning.exposure.exact import (
    CellPlaces,
    SightLines,
    fraction,
    lay_sight_line,
    place_of,
    places_of,
    room_for,
    samples_in_sight,
    shown_share,
)
from cleaning.exposure.exposure import Exposure, Poses, poses_of
from cleaning.jet.compiled_jet import KNIFE, JetForm
from cleaning.jet.jet import Jet
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from geometry.arrays import Indices, Points, Scalars
from geometry.compiled import inner, quick
from geometry.rays import RayScene, are_blocked

_FEW = 12
"""Exposed cells of a component that are so few that rays leave more than a tenth of doubt."""
_ENOUGH = 30
"""Rays that mean something for a component."""
MOMENTS = 1024
"""At which each cell of a small component is looked at."""
_LONE_MOMENTS = 256
"""Likewise for a cell without a hit on a component that has many others."""
_TOGETHER = 400
"""Cells whose lines of sight are traced at once."""
_VALUES = 6
_PLACE_STEPS, _WAY_STEPS = 6, 7
_GOLDEN = 0.6180339887498949
_OF_CHOICE = 0.25
"""Variance of a cone time for each time that the cone comes or goes between two moments, in squares of the time that a
moment stands for: 1/12 where all places see it come at once, 1/2 where they see it as if at random."""
_OF_STEP = 1.0 / 12.0
"""Likewise between two samples of the nozzle's way, which may be anywhere in between."""


def refine_sparse_cells(
    exposure: Exposure, stage: Stage, jet: Jet, facets: Facets, scene: RayScene, cells: Indices
) -> Exposure:
    """Put estimates by ``MOMENTS`` in the place of those that rest on nothing, or on too little.

    That is in cells that no ray hit, and in all cells of components that have no more than 12 or were hit by fewer than
    30 rays.

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
    seldom[1:] |= np.bincount(component, facets.cell_exposed[cells])[1:] <= _FEW
    poor = cells[facets.cell_exposed[cells] & ((exposure.hits[cells] == 0) | seldom[component])]
    if not len(poor):
        return exposure
    sparse = seldom[facets.cell_component[poor] + 1]
    found = np.empty((len(poor), _WAY_STEPS + 1))
    for some, moments in ((sparse, MOMENTS), (~sparse, _LONE_MOMENTS)):
        found[some] = look_at(stage, jet, facets, scene, poor[some], moments)
    changes: dict[str, Scalars] = {}
    for column, name in enumerate(("cone_s", "front_s", "volume_mm", "impulse_n_pa_s", "impulse_t_pa_s", "peak_pa")):
        changes[name] = getattr(exposure, name).copy()
        changes[name][poor] = found[:, column]
    errors = {"cone_error_s": (_OF_CHOICE, _PLACE_STEPS), "cone_shared_error_s": (_OF_STEP, _WAY_STEPS)}
    for name, (share, column) in errors.items():
        changes[name] = getattr(exposure, name).copy()
        changes[name][poor] = np.sqrt(share * found[:, column])
    return replace(exposure, **changes)


def look_at(
    stage: Stage, jet: Jet, facets: Facets, scene: RayScene, cells: Indices, moments: int = MOMENTS
) -> NDArray[np.float64]:
    """Estimate what reaches (k,) exposed cells.

    Returns:
        (k, 8): seconds in cone and front, mm, Pa s, Pa s, the highest stress in Pa; and the squares of what a moment
        stands for and of what a sample of the way lasts, added up over all times that the cone comes or goes, s².
    """
    if not len(cells):
        return np.empty((0, _WAY_STEPS + 1))
    places = places_of(facets, cells)
    poses, in_sight = poses_of(stage.samples), samples_in_sight(stage, jet, facets.cell_centres[cells], places.reach_mm)
    found = np.zeros((len(cells), _WAY_STEPS + 1))
    sights = room_for(min(_TOGETHER, len(cells)) * moments)
    most = int(np.diff(in_sight.start).max())
    lasting, jets = np.empty(len(cells)), np.ascontiguousarray(poses.axes[:, :, 2])
    for first in range(0, len(cells), _TOGETHER):
        last = min(first + _TOGETHER, len(cells))
        near = [in_sight.near(*place) for place in facets.cell_centres[cells[first:last], :2].tolist()]
        begins = np.cumsum([0, *map(len, near)])
        lines = lay_moments(
            jet.form,
            poses,
            (places, scene.origin, (first, last, moments)),
            (np.concatenate(near), begins),
            (jets, np.empty(most, dtype=np.int32), np.empty(3)),
            (sights, lasting),
        )
        blocked = are_blocked(scene, sights.origins[:lines], sights.directions[:lines], sights.lengths[:lines])
        add_moments(sights, blocked, (poses.seconds, lasting), found)
    share = shown_share(facets, cells)
    found[:, : _VALUES - 1] *= share[:, None]
    found[:, _VALUES:] *= share[:, None] ** 2
    found[:, 2] *= 0.0 if jet.gas else 1.0
    return found


@quick
def _candidates(
    steepest: float,
    poses: tuple[Points, Points, Scalars],
    near: NDArray[np.int32],
    cell: tuple[Points, Points, float],
    found: NDArray[np.int32],
) -> tuple[int, float]:
    """Find which samples may spray any place of a cell, by a cheap bound.

    Args:
        steepest: Tangent of the greatest angle between the jet and its rays; infinite for knives.
        poses: (n, 3) orifices, (n, 3) jets and (n,) seconds of the samples.
        near: Samples that may be close enough.
        cell: (3,) centre, (3,) normal, or zero where there are several, and how far the cell reaches from its centre.
        found: What is filled with samples.

    Returns:
        How many there are, and how long they last together.
    """
    tcp, jets, seconds = poses
    centre, normal, reach = cell
    x, y, z, facing = centre[0], centre[1], centre[2], not math.isinf(steepest)
    count, total = 0, 0.0
    for at in range(len(near)):
        i = near[at]
        dx, dy, dz = x - tcp[i, 0], y - tcp[i, 1], z - tcp[i, 2]
        if facing and dx * normal[0] + dy * normal[1] + dz * normal[2] > reach:
            continue
        along = jets[i, 0] * dx + jets[i, 1] * dy + jets[i, 2] * dz
        far = steepest * (along + reach) + reach
        if along + reach <= 0.0 or dx * dx + dy * dy + dz * dz - along * along > far * far:
            continue
        found[count] = i
        count += 1
        total += float(seconds[i])
    return count, total


@quick
def lay_moments(
    jet: JetForm,
    poses: Poses,
    target: tuple[CellPlaces, NDArray[np.float64], tuple[int, int, int]],
    near: tuple[NDArray[np.int32], Indices],
    room: tuple[Points, NDArray[np.int32], Scalars],
    out: tuple[SightLines, Scalars],
) -> int:
    """Lay lines of sight from the nozzle to places of cells at moments of the time in which it may spray them.

    Args:
        jet: Whose shape.
        poses: The samples.
        target: Places of all cells; (3,) origin from which the lines are counted; first and last + 1 of the cells whose
            lines are laid, and how many moments each has.
        near: Samples that may spray them, of one cell after the other, and where each cell's begin.
        room: (n, 3) jets of the samples, and room for as many samples as any cell has and for a place.
        out: What is filled: the lines, whose ``moments`` count on from cell to cell, and (k,) the time that a moment of
            each cell stands for, s.

    Returns:
        How many lines there are.
    """
    places, origin, (first, last, moments) = target
    samples, begins = near
    jets, candidates, place = room
    sights, lasting = out
    way, steepest = (poses.tcp, jets, poses.seconds), math.inf if jet.kind == KNIFE else math.sqrt(jet.steepest)
    row = 0
    for k in range(first, last):
        some = samples[begins[k - first] : begins[k - first + 1]]
        cell = (places.centre[k], places.normal[k], places.reach_mm[k])
        count, total = _candidates(steepest, way, some, cell, candidates)
        lasting[k] = total / moments
        offset = fraction(places.number[k] * _GOLDEN)
        at, passed = -1, 0.0
        for moment in range(moments if count > 0 else 0):
            while at < count - 1 and passed <= (moment + offset) * lasting[k]:
                at += 1
                passed += poses.seconds[candidates[at]]
            facet = place_of(places, k, moment + 1 + offset, place)
            sight = (place, places.normals[facet], origin)
            if lay_sight_line(jet, poses, candidates[at], lasting[k], sight, (sights, row)):
                sights.moments[row], sights.owners[row] = (k - first) * moments + moment, k
                row += 1
    return row


@quick
def add_moments(
    sights: SightLines, blocked: NDArray[np.bool_], seconds: tuple[Scalars, Scalars], found: NDArray[np.float64]
) -> None:
    """Add up what is not blocked.

    Args:
        sights: As ``lay_moments`` laid them.
        blocked: (n,) whether something stands in each of the first of them.
        seconds: That each sample of the way lasts, and that a moment of each cell stands for.
        found: (k, 8) what is added to, as ``look_at`` returns it.
    """
    owners, moments, values = sights.owners, sights.moments, sights.values
    last, counted = -1, -1
    for row in range(len(blocked)):
        if blocked[row]:
            continue
        cell = owners[row]
        for column in range(_VALUES - 1):
            found[cell, column] += values[row, column]
        found[cell, _VALUES - 1] = max(found[cell, _VALUES - 1], values[row, _VALUES - 1])
        if values[row, 0] <= 0.0:
            continue
        # Moments count on from cell to cell: the cone neither went nor came where they follow each other in one cell.
        if last < 0 or moments[row] != moments[last] + 1 or owners[last] != cell:
            counted = _add_steps(found, seconds, sights, (last, counted))
            counted = _add_steps(found, seconds, sights, (row, counted))
        last = row
    _add_steps(found, seconds, sights, (last, counted))


@inner
def _add_steps(
    found: NDArray[np.float64], seconds: tuple[Scalars, Scalars], sights: SightLines, which: tuple[int, int]
) -> int:
    """Add the squares of one coming or going; of a sample of the way once, however many moments fall on it."""
    row, counted = which
    if row < 0:
        return counted
    own, lasting = seconds
    cell, sample = sights.owners[row], sights.samples[row]
    found[cell, _PLACE_STEPS] += lasting[cell] * lasting[cell]
    if counted < 0 or sights.samples[counted] != sample or sights.owners[counted] != cell:
        found[cell, _WAY_STEPS] += own[sample] * own[sample]
    return row
