"""A part from two silhouettes at right angles, where no CAD is at hand (Cairo 2008).

The front view looks along +Y and shows X to its right, the side view looks along -X and shows Y to its right; Z is up
in both. Two views do not define a body: of all that have these silhouettes the largest is their hull. A stated
symmetry makes it one: a body of revolution about the upright axis, an extrusion along one of the views, or a body with
rectangular sections that is its own mirror image in both middle planes.
"""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias, cast

import manifold3d
import numpy as np
import shapely
from shapely import Polygon

from boards.board import Body, Part, Surface
from boards.errors import BoardError
from boards.part.silhouette import Silhouette
from boards.part.understand import FaceChoice, Facing, understand_part
from geometry.arrays import Triangles
from geometry.mesh import areas_and_normals
from geometry.polygons import project
from specs.finding import Finding
from specs.finding_rules import SCAN_HULL, SCAN_OUTLINE, SCAN_RECESS, SCAN_SHADOW, SCAN_SPECKS

Symmetry: TypeAlias = Literal["revolution", "extrusion", "mirror"]

ROUND_SHARE = np.pi / 4
"""Volume of a body with elliptical sections, as a share of the hull of its two silhouettes."""
_NEAR_PX = 1.5
"""Pixels by which an outline may miss a symmetry: one of its edge, half of one of where its middle is."""
_FACETS = 180
"""Around a body of revolution: they take away 0.02 % of its volume."""
_WITHIN_PX = 1.0
_ON_AXIS_PX = 0.1
_FOOT = (Facing((0.0, 0.0, -1.0), 10.0),)
"""What a part stands on when its silhouettes are taken."""
_FRONT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0]])
_SIDE = np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0]])
"""(3, 4) from a picture's right, up and depth to the part's frame."""


@dataclass(frozen=True, slots=True, eq=False)
class Scan:
    """A part out of two silhouettes. Its frame: the middle of both views at x = y = 0, its foot at z = 0; mm."""

    part: Part
    """What it stands on is not to be sprayed; its findings include those of the scan."""
    symmetry: Symmetry | None
    volume_mm3: float
    off_px: tuple[float, float]
    """Largest distance of its own silhouettes from those of the pictures, front and side, in pixels of each; corners
    that a picture rounds are not counted."""
    shadows: tuple[Polygon, Polygon]
    """Its own silhouettes, front and side, in the frames of the pictures."""


def scan_part(name: str, front: Silhouette, side: Silhouette, symmetry: Symmetry | None = None) -> Scan:
    """Make the part of two silhouettes.

    Args:
        name: What to call it.
        front: Seen along +Y.
        side: Seen along -X.
        symmetry: Stated, and held against both views; without it the body is the hull of both.

    Raises:
        BoardError: the views differ in height, or contradict the symmetry.
    """
    _check_heights(front, side)
    match symmetry:
        case "revolution":
            solid = _revolved(front, side)
        case "extrusion":
            _check_extrusion(front, side)
            solid = _hull(front, side)
        case "mirror":
            for each in (front, side):
                _check_mirror(each, "a mirror image of itself in its upright middle")
            solid = _hull(front, side)
        case None:
            solid = _hull(front, side)
    patches = _patches(solid)
    views = (patches[:, :, [0, 2, 1]], patches[:, :, [1, 2, 0]])  # along +Y and along -X
    front_shadow, side_shadow = (
        max(shapely.get_parts(project(each)).tolist(), key=lambda piece: float(piece.area)) for each in views
    )
    shadows = (front_shadow, side_shadow)
    off_front, off_side = (
        _off_mm(shadow, each) / each.mm_per_pixel for shadow, each in zip(shadows, (front, side), strict=True)
    )
    normals = areas_and_normals(patches.copy())[1]
    body = Body("part", "part", patches, normals, (Surface("surface-1", len(patches)),))
    findings = _findings(front, side, symmetry, (off_front, off_side))
    return Scan(
        part=understand_part([body], name, FaceChoice(ignore=_FOOT), findings),
        symmetry=symmetry,
        volume_mm3=volume_of(patches),
        off_px=(off_front, off_side),
        shadows=shadows,
    )


def volume_of(patches: Triangles) -> float:
    """Volume inside a closed mesh (n, 3, 3), mm3."""
    a, b, c = patches[:, 0], patches[:, 1], patches[:, 2]
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def _check_heights(front: Silhouette, side: Silhouette) -> None:
    (_, tall), (_, other) = front.size_mm, side.size_mm
    if abs(tall - other) > _NEAR_PX * max(front.mm_per_pixel, side.mm_per_pixel):
        raise BoardError(
            f"{front.name} is {tall:.2f} mm high and {side.name} {other:.2f} mm: both are to show the part upright. "
            "State the scale of each (--mm-per-pixel, --side-mm-per-pixel)."
        )


def _check_mirror(view: Silhouette, what: str) -> None:
    off = _apart_mm(shapely.transform(view.contour, lambda at: at * [-1.0, 1.0]), view.contour)
    if off > 2 * _NEAR_PX * view.mm_per_pixel:
        raise BoardError(
            f"{view.name} is not {what}: it differs by up to {off / view.mm_per_pixel:.1f} pixels, "
            f"{off:.2f} mm. Leave the symmetry out."
        )


def _check_extrusion(front: Silhouette, side: Silhouette) -> None:
    """One of the views is a rectangle: the body goes through it from edge to edge."""
    off = [_apart_mm(shapely.box(*each.contour.bounds), each.contour) / each.mm_per_pixel for each in (front, side)]
    if min(off) > _NEAR_PX:
        raise BoardError(
            f"neither view is a rectangle, as one of an extrusion is: {front.name} misses one by {off[0]:.1f} pixels, "
            f"{side.name} by {off[1]:.1f}. Leave the symmetry out, or turn the part."
        )


def _hull(front: Silhouette, side: Silhouette) -> manifold3d.Manifold:
    """What both views allow: the common part of two prisms without end."""
    far = 2.0 * max(*front.size_mm, *side.size_mm)
    return _prism(front.outline, _FRONT, far) ^ _prism(side.outline, _SIDE, far)


def _prism(outline: Polygon, turn: np.ndarray[Any, np.dtype[np.float64]], length: float) -> manifold3d.Manifold:
    section = manifold3d.CrossSection(_rings(outline), manifold3d.FillRule.EvenOdd)
    return section.extrude(length).translate((0.0, 0.0, -length / 2)).transform(turn)


def _revolved(front: Silhouette, side: Silhouette) -> manifold3d.Manifold:
    """The right half of the front view, turned about its middle."""
    for each in (front, side):
        _check_mirror(each, "a mirror image of itself in its axis, as a body of revolution is")
    off = _apart_mm(front.contour, side.contour)
    scale = max(front.mm_per_pixel, side.mm_per_pixel)
    if off > 2 * _NEAR_PX * scale:
        raise BoardError(
            f"{front.name} and {side.name} differ by up to {off:.2f} mm: a body of revolution about the upright axis "
            "looks the same from both. Leave the symmetry out."
        )
    half = shapely.intersection(front.outline, shapely.box(0.0, -1.0, 1e9, 1e9))
    beside = _ON_AXIS_PX * front.mm_per_pixel  # a tip beside the axis would be a ring of patches without an area
    half = shapely.transform(half, lambda at: np.where([True, False] & (at < beside), 0.0, at))
    rings = [ring for piece in shapely.get_parts(half) if isinstance(piece, Polygon) for ring in _rings(piece)]
    return manifold3d.CrossSection(rings, manifold3d.FillRule.EvenOdd).revolve(_FACETS)


def _rings(outline: Polygon) -> list[Any]:
    return [np.asarray(ring.coords, dtype=np.float64)[:-1] for ring in (outline.exterior, *outline.interiors)]


def _patches(solid: manifold3d.Manifold) -> Triangles:
    mesh = cast("Any", solid.to_mesh())
    corners = np.asarray(mesh.vert_properties, dtype=np.float64)[:, :3]
    patches = np.round(corners, 4)[np.asarray(mesh.tri_verts, dtype=np.int64)] + 0.0
    areas, _ = areas_and_normals(patches.copy())
    patches = patches[areas > 0.0]
    if not len(patches):
        raise BoardError("both views together leave no body; look at the pictures and their scale")
    return patches


def _apart_mm(one: Polygon, other: Polygon) -> float:
    """Largest distance between two outlines."""
    return float(shapely.hausdorff_distance(one.boundary, other.boundary, densify=0.25))


def _off_mm(shadow: Polygon, view: Silhouette) -> float:
    """Largest distance of what is seen from a shadow, and of the shadow from the outline: a picture rounds corners."""
    seen, own = (
        shapely.points(shapely.segmentize(each, view.mm_per_pixel).exterior.coords) for each in (view.contour, shadow)
    )
    return float(max(shapely.distance(seen, shadow.boundary).max(), shapely.distance(own, view.outline.boundary).max()))


def _findings(
    front: Silhouette, side: Silhouette, symmetry: Symmetry | None, off: tuple[float, float]
) -> list[Finding]:
    found: list[Finding] = []
    if symmetry is None:
        text = (
            "the body is the hull of both views, the largest that has these silhouettes; one with round sections would "
            f"have {ROUND_SHARE:.1%} of its volume, the hull is {1 / ROUND_SHARE:.3f} times that. State its symmetry "
            "if it has one."
        )
        found.append(Finding(SCAN_HULL, text))
    for view in (front, side):
        if not view.convex:
            text = f"{view.name} is not convex: what lies in a recess that no outline shows is filled. Check the part."
            found.append(Finding(SCAN_RECESS, text))
        if view.specks:
            text = f"{view.specks} small spots or holes of {view.name} were left out."
            found.append(Finding(SCAN_SPECKS, text))
    for view in (front, side):
        if view.shadow:
            text = (
                f"{view.name}: a grey between part and ground, {view.shadow:.0%} of the part's area, was left out as "
                f"a shadow, at a threshold of {view.threshold:g}. Look at it (--picture), or state --threshold."
            )
            found.append(Finding(SCAN_SHADOW, text))
    for view, pixels in zip((front, side), off, strict=True):
        if pixels > _WITHIN_PX:
            text = f"the part's own outline is up to {pixels:.1f} pixels off that of {view.name}: the views disagree."
            found.append(Finding(SCAN_OUTLINE, text))
    return found
