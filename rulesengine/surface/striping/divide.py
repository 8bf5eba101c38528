"""The stripes of a part's faces, and slices of free-form ones.

Slices are curves over the face, parallel to a geodesic that halves it or in parallel planes, the fewest.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import assert_never

import numpy as np

from boards.board import Face
from geometry.arrays import Directions, Points, Scalars
from geometry.solids.geodesics import Geodesics
from geometry.solids.sections import (
    Section,
    SurfaceMesh,
    connected_pieces,
    cut_section,
    least_bent_axis,
    length_of,
    section_lengths,
    surface_mesh,
)
from recipes.paths import Slices, Surface
from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.stripe import (
    SHORT,
    Plane,
    Stripe,
    curve_stripe,
    edge_directions,
    plane_of,
    run_on,
    stripe_along,
    stripe_contour,
    stripe_curved,
    stripe_fewest,
    stripe_longest_edge,
    stripes_along,
    surface_levels,
)

_TRIED = 12
"""Directions in the middle plane of a sheet, 15 degrees apart; around the axis of a closed face two times six."""
_SHEET = 0.3
"""Length of the mean normal from which on a face is a sheet, seen from one side on the whole."""
_SLANT_DEG = 50.0
_STANDING = 0.25
"""Sine of the angle to the mean normal of a sheet below which a direction is none to travel in."""
_FINE = 0.2
"""Of the footprint's diameter: longer edges are halved before geodesics run over them."""
_MOST_PATCHES = 40_000
_OFF = 0.02
"""Of the area: a geodesic with more than this beside a half on one side is no start."""


@dataclass(frozen=True, slots=True, eq=False)
class Sliced:
    """A face in slices."""

    stripes: list[Stripe]
    text: str
    """Which direction was taken, and how many curves the others have: a sentence."""


@dataclass(frozen=True, slots=True, eq=False)
class _Family:
    """Curves of one direction: where a field over the surface has one of some values."""

    values: Scalars
    """(v,) at the corners."""
    levels: list[tuple[float, float]]
    """Values, and the width of the stripe at each."""
    start: tuple[Section, ...] = ()
    """Curves that are known already: the geodesics on which the field is 0."""
    start_mm: float = 0.0
    """Width of their stripes; 0 where an even number of curves has none there."""
    share: float = 0.5
    """Of the area on the positive side of the start."""


def stripe_slices(site: PartSite, spec: Slices, face: Face) -> Sliced:
    """Slice a face in the direction in which there are the fewest curves, of as many the shortest together.

    A recipe may state the direction of travel, and the number of curves on each piece of the face. Curves parallel to a
    geodesic are equally far apart over the surface, at most ``spacing_mm``; those in planes are so in the mean. Pieces
    shorter than a tenth of the footprint's diameter are left to their neighbours.
    """
    patches = site.patches_of(face)
    longest = max(_FINE * site.diameter_mm, float(np.sqrt(4.0 * face.area_mm2 / _MOST_PATCHES)))
    stripes: list[Stripe] = []
    texts: list[str] = []
    along = None if spec.along == "auto" else np.array(spec.along) / np.linalg.norm(spec.along)
    for mesh in connected_pieces(surface_mesh(patches, longest)):
        directions = directions_over(site, mesh, patches[0, 1] - patches[0, 0], along)
        families = list(_families(site, spec, mesh, directions))
        lengths = [_lengths(site, mesh, family) for family in families]
        # Lengths are compared in mm, so that rounding does not decide.
        best = min(range(len(families)), key=lambda each: (len(lengths[each]), round(sum(lengths[each]))))
        stripes += [
            run_on(each, 0.0 if spec.overshoot_mm == "auto" else spec.overshoot_mm, site.step_mm)
            for each in _stripes(site, mesh, families[best], face)
        ]
        stated = "along" if len(directions) < _TRIED else "as the face stands up along"
        stated = "" if along is None else f"{stated} the stated direction"
        texts.append(_text(families[best], [len(each) for each in lengths], len(directions), stated))
    return Sliced(stripes, f"{face.name}: {'; '.join(texts)}.")


def _families(site: PartSite, spec: Slices, mesh: SurfaceMesh, directions: Directions) -> Iterator[_Family]:
    """Curves of each direction; planes where no geodesic halves the surface."""
    count = None if spec.slices == "auto" else spec.slices
    match spec.start:
        case "geodesic":
            geodesics, found = Geodesics(mesh), False
            for direction in directions:
                halving = geodesics.halve(direction)
                if halving is not None and abs(halving.share - 0.5) <= _OFF:
                    found = True
                    levels, width = _parallels(halving.distances, site.width_mm, count)
                    yield _Family(halving.distances, levels, halving.lines, width, halving.share)
            if found:
                return
        case "plane":
            pass
        case _:
            assert_never(spec.start)
    for direction in directions:
        heights = mesh.points @ direction
        slopes = mesh.facing @ direction
        levels, width = surface_levels(heights[mesh.corners], slopes, mesh.areas_mm2, site.width_mm, count)
        yield _Family(heights, [(float(level), width) for level in levels])


def directions_over(site: PartSite, mesh: SurfaceMesh, first: Points, along: Points | None = None) -> Directions:
    """(12 or 13, 3) directions across which a surface is cut, in a frame that turns with it.

    Of a sheet twelve at right angles to its mean normal; of a closed surface its axis, six across it and six slanted.
    Where curves are to run along a unit vector (3,), the one of a sheet across it, or the six of a closed surface; on a
    sheet on which it stands up as if none were stated.
    """
    mean = (mesh.facing * mesh.areas_mm2[:, None]).sum(axis=0) / mesh.areas_mm2.sum()
    length = float(np.linalg.norm(mean))
    sheet = length > _SHEET
    if sheet:
        axis = mean / length
    elif along is not None:
        axis = along
    else:
        axis = least_bent_axis(mesh.facing, mesh.areas_mm2, first)
    x = site.across(axis[None])[0]
    y = np.cross(axis, x)
    if sheet and along is not None:
        across = np.cross(axis, along)
        if np.linalg.norm(across) > _STANDING:
            return across[None] / np.linalg.norm(across)
    angles = np.arange(_TRIED) * np.pi / _TRIED
    around = np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y
    if sheet:
        return around
    if along is not None:
        return around[::2]
    slant = np.radians(_SLANT_DEG)
    turns = np.cos(2 * angles[::2])[:, None] * x + np.sin(2 * angles[::2])[:, None] * y
    return np.vstack([axis, around[::2], axis * np.cos(slant) + turns * np.sin(slant)])


def _parallels(distances: Scalars, spacing_mm: float, count: int | None) -> tuple[list[tuple[float, float]], float]:
    """Distances of the curves on both sides of a start curve, with their widths, and the width at the start.

    An even number of curves begins half a width to both sides of the start; its width there is 0.
    """
    is_even = count is not None and count % 2 == 0
    levels: list[tuple[float, float]] = []
    widths: list[float] = []
    for sign in (-1.0, 1.0):
        reach = max(0.0, float((sign * distances).max()))
        first = 0.5 if is_even else 1.0
        beside = max(0, int(np.ceil(reach / spacing_mm - 0.5 - 1e-3))) if count is None else count // 2
        width = reach / (beside + first - 0.5)
        levels += [(sign * (number + first) * width, width) for number in range(beside)]
        widths.append(width)
    return sorted(levels), 0.0 if is_even else float(np.mean(widths))


def _lengths(site: PartSite, mesh: SurfaceMesh, family: _Family) -> list[float]:
    """Lengths of the curves that are long enough for a stripe, mm."""
    found = [length_of(each) for each in family.start if family.start_mm]
    for level, _ in family.levels:
        found += section_lengths(mesh, family.values, level).tolist()
    return [each for each in found if each > SHORT * site.diameter_mm]


def _stripes(site: PartSite, mesh: SurfaceMesh, family: _Family, face: Face) -> list[Stripe]:
    curves = [(section, family.start_mm) for section in family.start if family.start_mm]
    for level, width in family.levels:
        curves += [(section, width) for section in cut_section(mesh, family.values, level)]
    shortest = SHORT * site.diameter_mm
    return [curve_stripe(site, face, section, width) for section, width in curves if length_of(section) > shortest]


def _text(family: _Family, counts: list[int], tried: int, stated: str) -> str:
    least, most = min(counts), max(counts)
    curves = f"{least} curve{'s' * (least != 1)}"
    what, halving = "in parallel planes", ""
    if family.start:
        length = sum(length_of(each) for each in family.start)
        what = f"parallel to a geodesic of {length:.0f} mm with {family.share:.1%} of the area on one side"
        halving = f"; such a geodesic exists in {len(counts)}" if len(counts) < tried else ""
    if tried == 1:
        return f"{curves} {what}, {stated}"
    chosen = f"the fewest of {tried} directions tried ({least} to {most}{halving})"
    return f"{curves} {what}, {stated and f'{stated}, '}{chosen}"


def divide_face(site: PartSite, face: Face) -> list[Stripe] | Sliced:
    """Divide a face into stripes no wider than the nozzle's, or into slices.

    A curved face is divided into contours whatever the striping.
    """
    match site.spec:
        case Slices() as spec:
            return stripe_slices(site, spec, face)
        case Surface() as spec if face.flat:
            return _striping(spec)(site, plane_of(face, site.patches_of(face)))
        case Surface():
            return stripe_curved(site, face)
        case _:
            assert_never(site.spec)


def candidate_stripes(site: PartSite, face: Face) -> list[Stripe]:
    """Stripes of a face that others are chosen of: those of its division, and along its second longest edge too.

    Only ``longest_edge`` leaves the direction to the planner.
    """
    divided = divide_face(site, face)
    stripes = divided.stripes if isinstance(divided, Sliced) else divided
    if face.flat and isinstance(site.spec, Surface) and site.spec.striping == "longest_edge":
        plane = plane_of(face, site.patches_of(face))
        stripes = [
            *stripes,
            *(each for way, _ in edge_directions(plane)[1:2] for each in stripes_along(site, plane.turned(way))),
        ]
    return stripes


def _striping(spec: Surface) -> Callable[[PartSite, Plane], list[Stripe]]:
    match spec.striping:
        case "longest_edge":
            return stripe_longest_edge
        case "fewest":
            return stripe_fewest
        case "along":
            return stripe_along
        case "contour":
            return stripe_contour
        case _:
            assert_never(spec.striping)
