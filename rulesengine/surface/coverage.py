"""What a plan over a part keeps in the cone, for how long; what no free pose sees, and why."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.rays import cast
from geometry.solids.cone_view import Stretch, are_seen, cells_in_view, cut_cells, turns_between
from rulesengine.surface.negotiate import TILT_STEP_DEG, leaning
from rulesengine.surface.site import FINE_MM, PartSite, Piece, turned
from specs.progress import Progress, no_progress

_COARSE = 2
_ASIDE = 0.85
"""Of the half angle, by which the axis is turned away from a cell that the axis itself cannot be aimed at."""
_SIDES = 8
_WIDE_DEG = 10.0
_BESIDE = (0.0, 0.45, 0.85)
_MOST_POSES = 6000
_REFINED_MM = 2.8
_MOST_REFINED = 40_000


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """A plan as moments of spraying."""

    tcp: Points
    """(m, 3)"""
    approach: Directions
    """(m, 3)"""
    stretch: Stretch
    """How they move while each lasts."""
    seconds: Scalars
    """(m,) that each stands for."""
    part: Indices
    """(m,) which of the times of all pieces it is a share of: those of the segments, then those of the pauses."""
    share: Scalars
    """(m,) of that time."""


def moments_of(pieces: Sequence[Piece]) -> Moments:
    """Cut the ways of pieces into short stretches, each with its middle, and their pauses where they are."""
    rows: list[tuple[Points, Directions, Points, Directions, Scalars, Indices, Scalars]] = []
    segments, poses = 0, sum(len(piece.seconds) for piece in pieces)
    for piece in pieces:
        lengths = np.linalg.norm(np.diff(piece.targets, axis=0), axis=1)
        counts = np.maximum(np.ceil(np.maximum(lengths, piece.ways_mm) / FINE_MM), 1).astype(np.int64)
        segment = np.repeat(np.arange(len(counts)), counts)
        along = (np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts) + 0.5) / counts[segment]
        onward = np.minimum(segment + 1, len(piece.tcp) - 1)
        held = np.flatnonzero(piece.pauses_s > 0)
        between = piece.tcp[segment] * (1 - along)[:, None] + piece.tcp[onward] * along[:, None]
        share = 1.0 / counts[segment] if len(segment) else np.empty(0)
        way, turn = np.diff(piece.tcp, axis=0), turns_between(piece.approach)
        rest = np.zeros((len(held), 3))
        rows.append((
            np.vstack([between, piece.tcp[held]]),
            np.vstack([turned(piece.approach[segment], piece.approach[onward], along), piece.approach[held]]),
            np.vstack([way[segment] * share[:, None], rest]),
            np.vstack([turn[segment] * share[:, None], rest]),
            np.concatenate([piece.seconds[segment] * share, piece.pauses_s[held]]),
            np.concatenate([segments + segment, poses + held]),
            np.concatenate([share, np.ones(len(held))]),
        ))  # fmt: skip
        segments, poses = segments + len(piece.seconds), poses + len(piece.tcp)
    if not rows:
        none = np.empty(0)
        nowhere = np.empty((0, 3))
        return Moments(nowhere, nowhere, Stretch(nowhere, nowhere), none, none.astype(np.int64), none)
    tcp, approach, ways, turns, seconds, part, share = (np.concatenate(each) for each in zip(*rows, strict=True))
    return Moments(tcp, approach, Stretch(ways, turns), seconds, part.astype(np.int64), share)


def held_at(tcp: Points, approach: Directions) -> Moments:
    """Moments at poses (n, 3), each a time of its own."""
    count = len(tcp)
    rest = Stretch(np.zeros((count, 3)), np.zeros((count, 3)))
    return Moments(tcp, approach, rest, np.zeros(count), np.arange(count), np.ones(count))


def view_of(site: PartSite, moments: Moments) -> csr_array:
    """(moments, cells) which cells are in the cone and seen at which moment."""
    return cells_in_view(site.cells, site.scene, site.cone, moments.tcp, moments.approach, moments.stretch)


@dataclass(frozen=True, slots=True, eq=False)
class Covered:
    """Pieces, and how long they keep each cell in the cone."""

    pieces: tuple[Piece, ...]
    moments: Moments
    view: csr_array
    """(moments, cells)"""
    seconds: Scalars
    """(c,)"""

    @property
    def spray_s(self) -> float:
        """Time with the jet on."""
        return sum(piece.spray_s for piece in self.pieces)


def cover(site: PartSite, pieces: Sequence[Piece]) -> Covered:
    """Find how long pieces keep each cell in the cone."""
    moments = moments_of(pieces)
    view = view_of(site, moments)
    return Covered(tuple(pieces), moments, view, np.asarray(view.T @ moments.seconds, dtype=np.float64))


@dataclass(frozen=True, slots=True, eq=False)
class Sight:
    """What can be seen of the cells at all, by poses whose lance is free."""

    visible: NDArray[np.bool_]
    """(c,)"""
    tcp: Points
    """(c, 3) orifice of one pose that sees each cell; not a number where the plan sees it, or nothing does."""
    approach: Directions
    """(c, 3)"""
    hider: Indices
    """(c,) index into the part's bodies of what hides a cell most; -1 where it is visible."""


def strongest_of(rates: csr_array) -> Scalars:
    """(m,) largest entry of each row."""
    return np.asarray(rates.max(axis=1).todense(), dtype=np.float64).ravel()


def share_held(site: PartSite, covered: Covered, sight: Sight) -> float:
    """Share of the visible area that is in the cone for the required time."""
    areas = site.cells.areas_mm2 * sight.visible
    held = covered.seconds >= site.spec.required_s * (1 - 1e-9)
    return float((areas * held).sum() / max(areas.sum(), 1e-12))


def refine(site: PartSite, sight: Sight) -> tuple[PartSite, Sight]:
    """Give a part with smaller cells, and what is seen of them; large parts as they are.

    What lies between the middles of cells is held only as far as the program knows of it.
    """
    if len(site.cells.points) > _MOST_REFINED:
        return site, sight
    cells = cut_cells(site.cells.triangles, _REFINED_MM)
    of = cells.patch
    fine = replace(site, cells=replace(cells, patch=site.cells.patch[of]), cell_face=site.cell_face[of])
    return fine, Sight(sight.visible[of], sight.tcp[of], sight.approach[of], sight.hider[of])


def find_visible(site: PartSite, seen: NDArray[np.bool_], progress: Progress = no_progress) -> Sight:
    """Find which cells any free pose sees: the axis on the cell first, then beside it with the cell inside the cone.

    Args:
        site: The part with its nozzle.
        seen: (c,) cells that a plan sees: they are not looked at again.
        progress: Receives the stage and the share done.
    """
    count = len(seen)
    sight = Sight(seen.copy(), np.full((count, 3), np.nan), np.full((count, 3), np.nan), np.full(count, -1))
    blame = np.zeros((count, len(site.part.bodies)), dtype=np.int64)
    travel = site.across(site.cells.normals)
    tilts = np.arange(0.0, site.most_tilt_deg + 1e-9, TILT_STEP_DEG)
    steepest = 90.0 - site.spec.incidence_min_deg
    for level, tilt in enumerate(tilts.tolist()):
        _look(site, sight, blame, leaning_at(site, sight, travel, tilt))
        progress("looking for what can be seen", 0.4 * (level + 1) / len(tilts))
    wide = np.arange(0.0, steepest + 1e-9, _COARSE * TILT_STEP_DEG)
    for level, tilt in enumerate(wide.tolist()):
        # Cells that lie near the rim of the cone, whose axis is turned to eight sides of them.
        cell, outward = leaning_at(site, sight, travel, tilt)
        tcp = site.cells.points[cell] + outward * site.spec.standoff_mm
        rows = np.flatnonzero(are_seen(site.scene, tcp, site.cells.points[cell]))
        for side in range(_SIDES):
            axes, free = _turned_aside(site, tcp[rows], outward[rows], _ASIDE, side)
            _keep(sight, cell[rows[free]], tcp[rows[free]], axes[free])
            rows = rows[~sight.visible[cell[rows]]]
        progress("looking for what can be seen", 0.4 + 0.6 * (level + 1) / len(wide))
    hidden = ~sight.visible
    sight.hider[hidden] = np.argmax(blame[hidden], axis=1)
    return sight


def leaning_at(site: PartSite, sight: Sight, travel: Directions, tilt: float) -> tuple[Indices, Directions]:
    """Directions at a tilt over the cells that are not seen yet: (k,) cell and (k, 3) direction."""
    left = np.flatnonzero(~sight.visible)
    outward = leaning(site.cells.normals[left], travel[left], tilt)
    return np.repeat(left, outward.shape[1]), outward.reshape(-1, 3)


def _look(site: PartSite, sight: Sight, blame: NDArray[np.int64], at: tuple[Indices, Directions]) -> None:
    """Look at cells along the cone's axis; count which bodies are in the way."""
    cell, outward = at
    targets = site.cells.points[cell]
    tcp = targets + outward * site.spec.standoff_mm
    owner = site.part.owner_of_patches()
    hits = site.blockers(tcp, -outward)
    np.add.at(blame, (cell[hits >= 0], owner[hits[hits >= 0]]), 1)
    rows = np.flatnonzero(hits < 0)
    seen = are_seen(site.scene, tcp[rows], targets[rows])
    if not seen.all():
        lost = rows[~seen]
        faces, _ = cast(site.scene, tcp[lost], -outward[lost])
        found = faces >= 0
        np.add.at(blame, (cell[lost][found], site.scene.body[faces[found]]), 1)
    _keep(sight, cell[rows[seen]], tcp[rows[seen]], -outward[rows[seen]])


def _turned_aside(
    site: PartSite, tcp: Points, outward: Directions, share: float, side: int
) -> tuple[Directions, NDArray[np.bool_]]:
    """Turn the axis away from places by a share of the half angle, to one of eight sides; and where that is free.

    It meets the part no flatter than it may; beside the part it may go anywhere.
    """
    across = site.across(outward)
    angle, turn = share * site.cone.half_angle_rad, 2 * np.pi * side / _SIDES
    away = across * np.cos(turn) + np.cross(outward, across) * np.sin(turn)
    axes = -outward * np.cos(angle) + away * np.sin(angle)
    free = site.blockers(tcp, axes) < 0
    faces, _ = cast(site.scene, tcp[free], axes[free])
    own = np.array([body.role == "part" for body in site.part.bodies])[site.scene.body[faces]] & (faces >= 0)
    steepness = -np.einsum("ij,ij->i", axes[free], site.scene.normals[faces])
    free[free] = ~own | (steepness >= np.cos(np.radians(site.most_tilt_deg)) - 1e-6)
    return axes, free


def poses_around(site: PartSite, cells: Indices) -> tuple[Points, Directions]:
    """Free poses that see some cells, on and beside the axis: (k, 3) orifices and directions."""
    travel = site.across(site.cells.normals[cells])
    steepest = 90.0 - site.spec.incidence_min_deg
    found: list[tuple[Points, Directions]] = []
    for tilt in np.arange(0.0, steepest + 1e-9, _WIDE_DEG).tolist():
        outward = leaning(site.cells.normals[cells], travel, tilt)
        row = np.repeat(cells, outward.shape[1])
        outward = outward.reshape(-1, 3)
        targets = site.cells.points[row]
        tcp = targets + outward * site.spec.standoff_mm
        seen = are_seen(site.scene, tcp, targets)
        tcp, outward = tcp[seen], outward[seen]
        for share in _BESIDE:
            for side in range(_SIDES if share else 1):
                axes, free = _turned_aside(site, tcp, outward, share, side)
                found.append((tcp[free], axes[free]))
    tcp, axes = (np.concatenate(each) for each in zip(*found, strict=True))
    some = np.unique(np.linspace(0, len(tcp) - 1, min(len(tcp), _MOST_POSES)).round().astype(np.int64))
    return tcp[some], axes[some]


def _keep(sight: Sight, cell: Indices, tcp: Points, axes: Directions) -> None:
    """Keep the first pose of each cell that is seen now."""
    cells, first = np.unique(cell, return_index=True)
    fresh = ~sight.visible[cells]
    cells, first = cells[fresh], first[fresh]
    sight.visible[cells] = True
    sight.tcp[cells] = tcp[first]
    sight.approach[cells] = axes[first]
