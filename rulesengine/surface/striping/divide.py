"""The stripes of a part's faces."""

from collections.abc import Callable
from typing import assert_never

from boards.part.part import Face
from recipes.paths import Surface
from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.along import stripe_along
from rulesengine.surface.striping.contour import stripe_contour, stripe_curved
from rulesengine.surface.striping.fewest import stripe_fewest
from rulesengine.surface.striping.longest_edge import stripe_longest_edge
from rulesengine.surface.striping.stripe import Plane, Stripe, plane_of


def divide_face(site: PartSite, face: Face) -> list[Stripe]:
    """Divide a face into stripes no wider than the nozzle's; a curved one into contours whatever the striping."""
    if not face.flat:
        return stripe_curved(site, face)
    return _striping(site.spec)(site, plane_of(face, site.patches_of(face)))


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
