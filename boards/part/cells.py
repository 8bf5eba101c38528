"""The sprayed faces of a part cut into cells: planning and analysis look at the same ones."""

from dataclasses import dataclass, replace

import numpy as np

from boards.board import Part
from geometry.arrays import Directions, Indices, Points, Scalars
from geometry.solids.cone_view import Cells, cut_cells
from geometry.solids.sections import surface_mesh

_CELL_MM = 4.0
_MOST_CELLS = 60_000
_COARSER = 1.4
_EDGE = 1.5
"""Longest edge of a cell, in pitches: its area is about that of a square of the pitch then."""
_OFF_MIDDLE = np.array([0.55, 0.3, 0.15])
"""Weights of a patch's corners: a place off its middle, so that places of one cutting are none of a finer one's."""


@dataclass(frozen=True, slots=True, eq=False)
class FaceCells:
    """Cells of the served faces."""

    cells: Cells
    """``patch`` counts the part's own patches."""
    face: Indices
    """(c,) index into ``part.faces``."""


def served_cells(part: Part) -> FaceCells:
    """Cut the served faces of a part into cells of about 4 mm, coarser ones where that would be too many."""
    face_of = np.full(len(part.patches), -1, dtype=np.int64)
    for number, face in enumerate(part.faces):
        if face.serve:
            face_of[face.patches] = number
    served = np.flatnonzero(face_of >= 0)
    area = float(sum(face.area_mm2 for face in part.served))
    longest = max(_CELL_MM, float(np.sqrt(4.0 * area / _MOST_CELLS)))
    cells = cut_cells(part.patches[served], longest)
    while len(cells.points) > _MOST_CELLS and len(cells.points) > 2 * len(served):  # long patches give many
        longest *= _COARSER
        cells = cut_cells(part.patches[served], longest)
    cells = replace(cells, patch=served[cells.patch])
    return FaceCells(cells, face_of[cells.patch])


@dataclass(frozen=True, slots=True, eq=False)
class FilmCells:
    """n places of the served faces, with the normals of a smooth surface through their corners. The part's frame."""

    points: Points
    """(n, 3) mm."""
    normals: Directions
    """(n, 3) outward."""
    areas_mm2: Scalars
    """(n,) that each stands for."""
    face: Indices
    """(n,) index into ``part.faces``."""


def film_cells(part: Part, pitch_mm: float, *, at_corners: bool = False) -> FilmCells:
    """Cut the served faces into patches about a pitch wide, and give a place on each; or their corners, rims too.

    Args:
        part: The part.
        pitch_mm: Coarser where there would be too many.
        at_corners: Corners of the patches, in place of places off their middles.
    """
    area = float(sum(face.area_mm2 for face in part.served))
    pitch = max(pitch_mm, float(np.sqrt(area / _MOST_CELLS)))
    found: list[tuple[Points, Directions, Scalars, Indices]] = []
    for number, face in enumerate(part.faces):
        if not face.serve:
            continue
        mesh = surface_mesh(part.patches[face.patches], _EDGE * pitch)
        if at_corners:
            points, normals = mesh.points, mesh.normals
            shares = np.repeat(mesh.areas_mm2 / 3.0, 3)
            around = np.asarray(np.bincount(mesh.corners.ravel(), shares, len(points)), dtype=np.float64)
        else:
            points = np.einsum("c,nci->ni", _OFF_MIDDLE, mesh.points[mesh.corners])
            normals = np.einsum("c,nci->ni", _OFF_MIDDLE, mesh.normals[mesh.corners])
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
            around = mesh.areas_mm2
        # Halved patches may be many more than were required: some of them, evenly spread.
        most = min(len(points), int(np.ceil(face.area_mm2 / pitch**2)))
        some = np.unique(np.linspace(0, len(points) - 1, most).round().astype(np.int64))
        scale = float(face.area_mm2 / around[some].sum())
        found.append((points[some], normals[some], around[some] * scale, np.full(len(some), number)))
    return FilmCells(*(np.concatenate(each) for each in zip(*found, strict=True)))
