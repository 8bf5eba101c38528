"""Everything that a plan over a part's faces may use: part, nozzle, lance, free ways, and pieces of stripes."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from boards.board import Face, Part, scene_of
from boards.part.cells import served_cells
from cleaning.jet.drops import spray_cone, spray_range_mm
from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.mesh import areas_and_normals
from geometry.rays import RayScene, cast, split_patches
from geometry.solids.cone_view import Cells, Cone, are_seen
from geometry.solids.tree import Tree, build_tree, capsule_hits
from recipes.footprint import mean_angle
from recipes.nozzles import Nozzle
from recipes.paths import FacePath, Film, OverFaces, Slices
from recipes.recipe import Function, Limits, Recipe, film_in
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
_PIECE_MM, _OFF_MM = 10.0, 0.01
"""Size of the pieces of a face from which is looked along its normal, and how far in front of it."""
_MOST_STEP_MM = 2.0
_LEAST_S = 1e-4
_SHORT = 0.02
"""Of the standoff, before the targets of a film's passes at which sight ends."""


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
    limits: Limits
    function: Function
    """Of the step."""
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
    def max_speed_mm_s(self) -> float:
        """Of the step's function."""
        return self.function.max_speed_mm_s

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
        return spray_cone(self.nozzle, self.function, self.spec, _EDGE_MM)

    @property
    def range_mm(self) -> float:
        """From the orifice: farther the jet does not count."""
        return spray_range_mm(self.nozzle, self.function.pressure_bar, self.spec.standoff_mm)

    @property
    def film(self) -> Film | None:
        """What the passes are to lay."""
        return film_in(self.spec)

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
        """Speed over the surface at which the edge of a stripe of this width is in the cone for the required time.

        Of a film that of its passes.
        """
        if self.film is not None and self.film.speed_mm_s != "auto":
            return self.film.speed_mm_s
        chord = np.sqrt(max(self.diameter_mm**2 - width_mm**2, (0.2 * self.diameter_mm) ** 2))
        return float(min(chord / self.spec.required_s, self.max_speed_mm_s))

    def blockers(self, orifices: Points, axes: Directions, grown_mm: float = 0.0) -> Indices:
        """(n,) patch of all bodies that the lance of a pose comes too near to, or -1; (n, 3) axes along the jet.

        The lance may be made thicker.
        """
        lance = self.lance
        radius = lance.radius_mm - _TOUCH_MM + grown_mm
        return capsule_hits(self.tree, orifices, orifices - axes * lance.length_mm, radius)

    def are_free(self, orifices: Points, axes: Directions, targets: Points) -> NDArray[np.bool_]:
        """(n,) whether the lance keeps clear of all bodies and the orifice sees its target."""
        free = self.blockers(orifices, axes) < 0
        rows = np.flatnonzero(free)
        if self.film is not None:
            # Passes run over a smoothed surface, which may lie a little below the true one.
            targets = targets - _SHORT * self.spec.standoff_mm * axes
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


def build_site(part: Part, recipe: Recipe, made_by: Source) -> PartSite:
    """Make a part ready for planning with one template over faces in its step."""
    assert made_by.step is not None
    spec, step, found = recipe.templates[made_by.template], recipe.sequence[made_by.step], served_cells(part)
    assert isinstance(spec, OverFaces)
    function, nozzle = recipe.functions[step.function], recipe.nozzles[step.nozzle]
    tree = build_tree(np.concatenate([body.patches for body in part.bodies]))
    return PartSite(part, spec, nozzle, recipe.limits, function, made_by, tree, scene_of(part), found.cells, found.face)


def up_of(part: Part) -> Directions:
    """(3,) direction away from what the part stands on, taken from the part, so that it turns with it.

    The faces that are not sprayed are those it stands on. Of a part that is sprayed all around, those that look at a
    fixture, or at the part itself, are no more to be seen. Where what is left has no side the part stands on its
    broadest flat face, and what has none is begun along the normal of its largest face.
    """
    faces = part.served
    flat = [face for face in faces if face.flat]
    least_mm2 = _LEAST_MEAN * sum(face.area_mm2 for face in faces)
    served = np.concatenate([face.patches for face in faces])  # of a closed body, round sides too, they add up to none
    areas, normals = areas_and_normals(part.patches[served])
    up = _side_of(areas[:, None] * normals, least_mm2)
    if up is None and len(part.own_bodies) < len(part.bodies):
        up = _side_of(
            [area * np.array(face.normal) for face, area in zip(flat, _free_areas(part, flat), strict=True)], least_mm2
        )
    if up is not None:
        return up
    return np.array(_largest(faces).normal) if not flat else -np.array(_largest(flat).normal)


def _largest(faces: Sequence[Face]) -> Face:
    return max(faces, key=lambda face: round(face.area_mm2, 1))


def _side_of(areas: Sequence[Directions] | Directions, least_mm2: float) -> Directions | None:
    """(3,) direction in which (n, 3) areas along their normals, mm², look on the whole; ``None`` for hardly any."""
    mean = np.sum(areas, axis=0)
    length = float(np.linalg.norm(mean))
    return mean / length if length > least_mm2 else None


def _free_areas(part: Part, faces: Sequence[Face]) -> list[float]:
    """Areas of flat faces from which nothing is in the way along the normal, mm²."""
    scene, areas = scene_of(part), list[float]()
    for face in faces:
        pieces, _ = split_patches(part.patches[face.patches], _PIECE_MM)
        sizes, _ = areas_and_normals(pieces)
        normals = np.repeat(np.array([face.normal]), len(pieces), axis=0)
        met, _ = cast(scene, pieces.mean(axis=1) + _OFF_MM * normals, normals)
        areas.append(float(sizes[met < 0].sum()))
    return areas


def step_of(site: PartSite) -> float:
    """Largest way of any point of the lance between two samples, mm.

    No point of the lance is farther than half of it from where it was at a sample: what is free at the samples with the
    clearance, is free all the way with what is left of it.
    """
    return float(min(site.limits.clearance_mm, _MOST_STEP_MM))


def turned(first: Directions, second: Directions, share: Scalars) -> Directions:
    """Directions (n, 3) that an even turn passes at shares (n,) of it; between opposite ones about any axis."""
    cosines = np.clip(np.einsum("ij,ij->i", first, second), -1.0, 1.0)
    angles = np.arccos(cosines)
    across = second - first * cosines[:, None]
    lengths = np.linalg.norm(across, axis=1)
    lost = lengths < 1e-9
    if lost.any():
        helper = np.eye(3)[np.argmin(np.abs(first[lost]), axis=1)]
        across[lost] = np.cross(first[lost], helper)
        lengths[lost] = np.linalg.norm(across[lost], axis=1)
        angles[lost] = np.where(cosines[lost] > 0, 0.0, np.pi)
    across /= lengths[:, None]
    swept = angles * share
    return first * np.cos(swept)[:, None] + across * np.sin(swept)[:, None]


def way_samples(site: PartSite, tcp: Points, approach: Directions) -> tuple[Points, Directions, Indices]:
    """Poses along a way (n, 3) of straight lines and even turns, dense enough to prove it free.

    Returns:
        (m, 3) orifices, (m, 3) directions, and (m,) the segment that each is on; ends of segments are left out.
    """
    back = tcp - approach * site.lance.length_mm
    moves = np.maximum(*(np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (tcp, back)))
    angles = np.arccos(np.clip(np.einsum("ij,ij->i", approach[1:], approach[:-1]), -1.0, 1.0))
    # The far end of the lance moves along an arc: no longer than the orifice's way and the arc together.
    moves = np.maximum(moves, np.linalg.norm(np.diff(tcp, axis=0), axis=1) + angles * site.lance.length_mm)
    counts = np.maximum(np.ceil(moves / step_of(site)).astype(np.int64), 1) - 1
    segment = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts) + 1
    share = number / (counts[segment] + 1)
    places = tcp[segment] * (1 - share)[:, None] + tcp[segment + 1] * share[:, None]
    return places, turned(approach[segment], approach[segment + 1], share), segment


def blocked_segments(site: PartSite, tcp: Points, approach: Directions) -> NDArray[np.bool_]:
    """(n - 1,) whether the lance comes too near to a body between poses (n, 3) of a way; the poses are not checked."""
    places, directions, segment = way_samples(site, tcp, approach)
    hits = site.blockers(places, directions, grown_mm(site)) >= 0
    return np.bincount(segment[hits], minlength=len(tcp) - 1) > 0


def is_free(site: PartSite, tcp: Points, approach: Directions) -> bool:
    """Whether the lance keeps clear along a way (n, 3) without the poses at its two ends."""
    if len(tcp) > 2 and (site.blockers(tcp[1:-1], approach[1:-1], grown_mm(site)) >= 0).any():
        return False
    places, directions, _ = way_samples(site, tcp, approach)
    # Coarse first: most ways that are not free are found by a few samples.
    for some in (slice(None, None, 16), slice(None)):
        if (site.blockers(places[some], directions[some], grown_mm(site)) >= 0).any():
            return False
    return True


def grown_mm(site: PartSite) -> float:
    """By how much the lance is thickened where the clearance does not hold what corners are cut by, mm."""
    return max(0.0, site.limits.blend_mm + step_of(site) / 2 - site.limits.clearance_mm)


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A run of poses with the jet on. The part's frame, mm, s."""

    face: str
    targets: Points
    """(n, 3) where the cone's axis meets the surface; n is 1 where the nozzle only pauses."""
    tcp: Points
    """(n, 3) orifice."""
    approach: Directions
    """(n, 3) along the jet."""
    tilts_deg: Scalars
    """(n,) of the jet from the surface's normal."""
    seconds: Scalars
    """(n - 1,) time from each pose to the next: what a speed for each segment will be made of."""
    pauses_s: Scalars
    """(n,) held still at each pose, jet on."""

    @property
    def length_mm(self) -> float:
        """Way of the cone's centre over the surface."""
        return float(np.linalg.norm(np.diff(self.targets, axis=0), axis=1).sum())

    @property
    def ways_mm(self) -> Scalars:
        """(n - 1,) way of the orifice from each pose to the next."""
        return np.linalg.norm(np.diff(self.tcp, axis=0), axis=1)

    @property
    def spray_s(self) -> float:
        """Time with the jet on."""
        return float(self.seconds.sum() + self.pauses_s.sum())

    def reversed(self) -> "Piece":
        """The same from its end to its beginning."""
        return replace(
            self, targets=self.targets[::-1], tcp=self.tcp[::-1], approach=self.approach[::-1],
            tilts_deg=self.tilts_deg[::-1], seconds=self.seconds[::-1], pauses_s=self.pauses_s[::-1],
        )  # fmt: skip


def seconds_along(site: PartSite, targets: Points, tcp: Points, approach: Directions, speed_mm_s: float) -> Scalars:
    """Least seconds (n - 1,) between poses at a speed over the surface that keep the limits of speed and turning."""
    over, through = (np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (targets, tcp))
    turns = np.arccos(np.clip(np.einsum("ij,ij->i", approach[1:], approach[:-1]), -1.0, 1.0))
    least = np.maximum(through / site.max_speed_mm_s, turns / np.radians(site.limits.rotation_deg_s))
    return np.maximum(np.maximum(over / speed_mm_s, least), _LEAST_S)


def spot(site: PartSite, face: str, tcp: Points, approach: Directions, seconds: float) -> Piece:
    """Give a piece that only pauses at one pose, both (3,)."""
    target = tcp + approach * site.spec.standoff_mm
    return Piece(face, target[None], tcp[None], approach[None], np.zeros(1), np.empty(0), np.array([seconds]))
