"""The stripes of a part's faces."""

from collections.abc import Callable
from typing import assert_never

from boards.board import Face
from recipes.paths import Slices, Surface
from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.contour import stripe_contour, stripe_curved
from rulesengine.surface.striping.slices import Sliced, stripe_slices
from rulesengine.surface.striping.stripe import (
    Plane,
    Stripe,
    edge_directions,
    plane_of,
    stripe_along,
    stripe_fewest,
    stripe_longest_edge,
    stripes_along,
)


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
