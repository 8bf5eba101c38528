"""Stripes in the direction in which a face needs the fewest."""

import numpy as np

from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.stripe import Plane, Stripe, edge_directions, stripes_along

_TRIED = 12
"""Directions that are tried besides those of the face's edges, 15 degrees apart."""


def stripe_fewest(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along an edge or one of twelve directions: the fewest, of as many the shortest together."""
    longest = edge_directions(plane)
    x, y = longest[0][0]
    angles = np.arange(_TRIED) * np.pi / _TRIED
    turned = [np.array([x * np.cos(a) - y * np.sin(a), x * np.sin(a) + y * np.cos(a)]) for a in angles]
    tried = [stripes_along(site, plane.turned(each)) for each in (*(way for way, _ in longest[:_TRIED]), *turned)]
    return min(tried, key=lambda stripes: (len(stripes), round(sum(_length(each) for each in stripes), 1)))


def _length(stripe: Stripe) -> float:
    return float(np.linalg.norm(np.diff(stripe.targets, axis=0), axis=1).sum())
