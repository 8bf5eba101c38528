"""Parts: workpieces of any shape, and the faces that a planner covers with stripes."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Board, Body, Workpiece
from geometry.arrays import Directions, Indices, Triangles


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """One face of a part: a plane region, or a curved one without sharp edges. The part's frame, mm."""

    name: str
    """Unique in the part, such as ``"face-3"``, or as the ``.tri`` file calls its surface."""
    patches: Indices
    """(k,) its patches, numbered over the part's own bodies in their order (``Part.patches``)."""
    normal: tuple[float, float, float]
    """Unit vector: the mean over the area, outwards. Of a face that goes all the way around, any one of its normals."""
    area_mm2: float
    flat: bool
    """Whether it lies in one plane."""
    serve: bool
    """Whether it is to be sprayed."""


@dataclass(frozen=True, slots=True, eq=False)
class Part(Workpiece):
    """A part that has been read and understood, with its fixtures; the origin of its file is kept."""

    faces: tuple[Face, ...]
    """In the order of their first patches."""

    @property
    def own_bodies(self) -> tuple[Body, ...]:
        """The bodies that are cleaned, without the fixtures."""
        return tuple(body for body in self.bodies if body.role == "part")

    @property
    def patches(self) -> Triangles:
        """(n, 3, 3) patches of the part itself, body after body, wound so that their normals point outwards."""
        return np.concatenate([body.patches for body in self.own_bodies])

    @property
    def normals(self) -> Directions:
        """(n, 3) outward unit normals of them."""
        return np.concatenate([body.normals for body in self.own_bodies])

    @property
    def served(self) -> tuple[Face, ...]:
        """The faces that are to be sprayed."""
        return tuple(face for face in self.faces if face.serve)

    def owner_of_patches(self) -> NDArray[np.int64]:
        """(all,) index into ``bodies`` of every patch, body after body, fixtures included."""
        return np.repeat(np.arange(len(self.bodies)), [len(body.patches) for body in self.bodies])


BoardOrPart: TypeAlias = Board | Part
"""Every kind of workpiece that is planned."""
