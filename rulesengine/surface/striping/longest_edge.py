"""Stripes along the longest edge of a face: this tends to need the fewest (Sandia 1993, section 2.1)."""

from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.stripe import Plane, Stripe, edge_directions, stripes_along


def stripe_longest_edge(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along the longest edge of a plane face."""
    return stripes_along(site, plane.turned(edge_directions(plane)[0][0]))
