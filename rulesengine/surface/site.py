"""Everything that a plan over a part's faces may use: part, nozzle, lance, what hides and what is in the way."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from boards.board import Face, Part, scene_of
from boards.part.cells import served_cells
from geometry.arrays import Directions, Indices, Points, Triangles
from geometry.rays import RayScene
from geometry.solids.cone_view import Cells, Cone, are_seen
from geometry.solids.tree import Tree, build_tree, capsule_hits
from programs.plan import Jet
from recipes.footprint import mean_angle
from recipes.nozzles import Nozzle
from recipes.paths import FacePath, Slices
from recipes.recipe import Limits
from rulesengine.timing.time_plan import ACCELERATION_SHARE
from specs.source import Source

_TOUCH_MM = 1e-3
"""Less than this between lance and body is no matter: coordinates of parts are rounded to a tenth of it."""
FINE_MM = 2.5
"""Longest stretch of a way over the surface of which a cell is seen, or not, as from its middle."""
_EDGE_MM = 0.5
"""Width at the standoff over which a cell passes from inside to outside of a cone at rest."""
_WIDEST = 0.78
_LEAST_MEAN = 0.01


@dataclass(frozen=True, slots=True)
class Lance:
    """The nozzle's body: a capsule from the orifice backwards, grown by the clearance. Millimetres."""

    radius_mm: float
    length_mm: float


@dataclass(frozen=True, slots=True, eq=False)
class PartSite:
    """A part with one nozzle in one step. The part's frame, mm."""

    part: Part
    spec: FacePath
    nozzle: Nozzle
    jet: Jet
    limits: Limits
    max_speed_mm_s: float
    """Of the step's function."""
    made_by: Source
    tree: Tree
    """Of all bodies."""
    scene: RayScene
    """Of all bodies."""
    cells: Cells
    """Of the served faces; ``patch`` counts the part's own patches."""
    cell_face: Indices
    """(c,) index into ``part.faces``."""

    @property
    def lance(self) -> Lance:
        """The lance with the clearance around it; without a body of the nozzle, its orifice alone."""
        body = self.nozzle.body
        if body is None:
            return Lance(self.limits.clearance_mm, 0.0)
        return Lance(body.radius_mm + self.limits.clearance_mm, body.length_mm)

    @property
    def cone(self) -> Cone:
        """What counts as sprayed."""
        edge = _EDGE_MM / self.spec.standoff_mm
        return Cone(mean_angle(self.nozzle) + edge / 2, float(np.radians(self.spec.incidence_min_deg)), edge)

    @property
    def diameter_mm(self) -> float:
        """Diameter of the cone at the standoff, on a surface at right angles to it."""
        return 2.0 * self.spec.standoff_mm * float(np.tan(mean_angle(self.nozzle)))

    @property
    def width_mm(self) -> float:
        """Largest width of a stripe: at D / sqrt 2 the time in the cone over the whole stripe costs least liquid.

        Where speeds are chosen for each segment, wider and fewer stripes take less time.
        """
        widest = _WIDEST if self.spec.repair else np.sqrt(0.5)
        stated = self.spec.spacing_mm if isinstance(self.spec, Slices) else self.spec.width_mm
        return float(widest * self.diameter_mm) if stated == "auto" else stated

    @property
    def most_tilt_deg(self) -> float:
        """Largest tilt that keeps the jet's angle of incidence too."""
        return min(self.spec.tilt_max_deg, 90.0 - self.spec.incidence_min_deg)

    @property
    def acceleration_mm_s2(self) -> float:
        """Of the orifice, as the timed program plans with it."""
        return ACCELERATION_SHARE * self.limits.acceleration_mm_s2

    @property
    def step_mm(self) -> float:
        """Distance of the poses along a stripe."""
        return float(np.clip(self.diameter_mm / 7.0, 1.0, 5.0))

    def speed_mm_s(self, width_mm: float) -> float:
        """Speed over the surface at which the edge of a stripe of this width is in the cone for the required time."""
        chord = np.sqrt(max(self.diameter_mm**2 - width_mm**2, (0.2 * self.diameter_mm) ** 2))
        return float(min(chord / self.spec.required_s, self.max_speed_mm_s))

    def blockers(self, orifices: Points, axes: Directions) -> Indices:
        """(n,) patch of all bodies that the lance of a pose comes too near to, or -1; (n, 3) axes along the jet."""
        lance = self.lance
        return capsule_hits(self.tree, orifices, orifices - axes * lance.length_mm, lance.radius_mm - _TOUCH_MM)

    def blockers_within(self, orifices: Points, axes: Directions, grown_mm: float) -> Indices:
        """As ``blockers``, with a lance that is thicker by this."""
        lance = self.lance
        radius = lance.radius_mm - _TOUCH_MM + grown_mm
        return capsule_hits(self.tree, orifices, orifices - axes * lance.length_mm, radius)

    def are_free(self, orifices: Points, axes: Directions, targets: Points) -> NDArray[np.bool_]:
        """(n,) whether the lance keeps clear of all bodies and the orifice sees its target."""
        free = self.blockers(orifices, axes) < 0
        rows = np.flatnonzero(free)
        free[rows] = are_seen(self.scene, orifices[rows], targets[rows])
        return free

    def across(self, directions: Directions) -> Directions:
        """(n, 3) unit vectors at right angles to (n, 3) directions, by axes that turn with the part."""
        patch, normal = self.part.patches[0], self.part.normals[0]
        along = (patch[1] - patch[0]) / np.linalg.norm(patch[1] - patch[0])
        axes = np.stack([along, np.cross(normal, along), normal])
        nearest = np.argmin(np.round(np.abs(directions @ axes.T), 3), axis=1)
        across = np.cross(directions, axes[nearest])
        return across / np.linalg.norm(across, axis=1, keepdims=True)

    def patches_of(self, face: Face) -> Triangles:
        """(k, 3, 3) patches of a face."""
        return self.part.patches[face.patches]


def build_site(
    part: Part, spec: FacePath, nozzle: Nozzle, jet: Jet, limits: Limits, step: tuple[float, Source]
) -> PartSite:
    """Make a part ready for planning with one template.

    Args:
        part: What is sprayed.
        spec: The template.
        nozzle: The step's.
        jet: What leaves it.
        limits: The recipe's.
        step: Largest speed of the step's function, and the recipe path of the template in its step.
    """
    patches = np.concatenate([body.patches for body in part.bodies])
    found = served_cells(part)
    speed, made_by = step
    return PartSite(
        part, spec, nozzle, jet, limits, speed, made_by, build_tree(patches), scene_of(part),
        found.cells, found.face,
    )  # fmt: skip


def up_of(part: Part) -> Directions:
    """(3,) direction away from what the part stands on, taken from the part, so that it turns with it.

    The faces that are not sprayed are those it stands on; where they have no side, the normal of the largest face.
    """
    faces = part.served
    mean = sum((np.array(face.normal) * face.area_mm2 for face in faces if face.flat), np.zeros(3))
    length, area = float(np.linalg.norm(mean)), sum(face.area_mm2 for face in faces)
    if length > _LEAST_MEAN * area:
        return mean / length
    largest = max(faces, key=lambda face: round(face.area_mm2, 1))
    return np.array(largest.normal)
