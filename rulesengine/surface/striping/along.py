"""Stripes along a direction of the part's frame, such as the one in which a robot moves best."""

import numpy as np

from recipes.paths import Surface
from rulesengine.surface.site import PartSite
from rulesengine.surface.striping.longest_edge import stripe_longest_edge
from rulesengine.surface.striping.stripe import Plane, Stripe, stripes_along

_UPRIGHT = 0.05
"""Sine of the angle to the normal below which a direction has no projection on a face."""


def stripe_along(site: PartSite, plane: Plane) -> list[Stripe]:
    """Stripes along the projection of ``along`` on a plane face; along its longest edge where it has none."""
    spec = site.spec
    assert isinstance(spec, Surface)
    direction = np.array(spec.along) / max(float(np.linalg.norm(spec.along)), 1e-12)
    flat = plane.axes[:2] @ direction
    length = float(np.linalg.norm(flat))
    return stripe_longest_edge(site, plane) if length < _UPRIGHT else stripes_along(site, plane.turned(flat / length))
