"""Passes of a film over a sheet: equally far apart over the surface, from before its rim to behind it."""

import numpy as np

from boards.board import Face
from geometry.rays import build_ray_scene
from geometry.solids.sections import SurfaceMesh, connected_pieces, surface_mesh
from geometry.solids.sheet_field import CurveNet, geodesic_net, is_sheet, plane_net, sheet_field
from recipes.errors import RecipeError
from recipes.paths import Film, Slices
from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.divide import Sliced, directions_over
from rulesengine.surface.striping.stripe import Stripe, curve_stripe

_SMOOTH = 0.2
"""Of the pattern's radius: shorter waves of the surface, facets and noise are none of the passes."""
_BEYOND = 0.75
"""Of the spacing, by which the outermost passes lie beyond the rim."""


def stripe_passes(site: PartSite, spec: Slices, film: Film, face: Face) -> Sliced:
    """Lay passes over each piece of a face, along a stated direction or its longest.

    Raises:
        RecipeError: a piece is no sheet, or its geodesics run together.
    """
    assert spec.spacing_mm != "auto"
    assert spec.overshoot_mm != "auto"
    patches = site.patches_of(face)
    stripes: list[Stripe] = []
    texts: list[str] = []
    for mesh in connected_pieces(surface_mesh(patches)):
        if not is_sheet(mesh):
            raise RecipeError(
                f"{face.name} bends out of sight of one side, and a film is laid over sheets. Split it at a smaller "
                "angle (faces: split_deg), or ignore it.",
                path=f"templates.{site.made_by.template}.film",
            )
        net = _net(site, spec, face, mesh)
        least, most = net.width
        spacing = spec.spacing_mm
        if spec.slices == "auto":
            count = int(np.ceil((most - least) / spacing + 2.0 * _BEYOND - 1e-3)) + 1
        else:
            count = spec.slices
        places = (least + most) / 2.0 + spacing * (np.arange(count) - (count - 1) / 2.0)
        reach = site.diameter_mm / 2.0
        sections = [
            section for place in places.tolist() for section in net.curve(place, spec.overshoot_mm, reach, site.step_mm)
        ]
        stripes += [curve_stripe(site, face, section, spacing) for section in sections]
        what = "parallel over the surface" if spec.start == "geodesic" else "in parallel planes"
        texts.append(f"{count} passes {what}, {spacing:.2f} mm apart")
    return Sliced(stripes, f"{face.name}: {'; '.join(texts)}.")


def _net(site: PartSite, spec: Slices, face: Face, mesh: SurfaceMesh) -> CurveNet:
    assert spec.spacing_mm != "auto"
    assert spec.overshoot_mm != "auto"
    patches = site.patches_of(face)
    along = None if spec.along == "auto" else np.array(spec.along) / np.linalg.norm(spec.along)
    directions = directions_over(site, mesh, patches[0, 1] - patches[0, 0], along)
    across = directions[int(np.argmin(np.round(np.ptp(mesh.points @ directions.T, axis=0), 1)))]
    triangles = mesh.points[mesh.corners]
    scene = build_ray_scene(triangles, mesh.facing, np.zeros(len(triangles), dtype=np.int64), np.inf)
    radius = site.diameter_mm / 2.0
    beyond = max(spec.overshoot_mm, 2.0 * spec.spacing_mm) + radius
    field = sheet_field(mesh, scene, across, beyond, _SMOOTH * radius)
    if spec.start == "plane":
        return plane_net(field, site.step_mm)
    net = geodesic_net(field, site.step_mm)
    if net.is_crowded:
        raise RecipeError(
            f"{face.name} is bent so much that passes parallel over it run together. Take planes (start: plane).",
            path=f"templates.{site.made_by.template}.start",
        )
    return net
