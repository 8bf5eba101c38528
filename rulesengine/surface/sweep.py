"""Whether the lance keeps clear of everything on the way from one pose to the next, proved by samples of the way."""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Scalars
from rulesengine.surface.site import PartSite

_MOST_STEP_MM = 2.0


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
    hits = site.blockers_within(places, directions, grown_mm(site)) >= 0
    return np.bincount(segment[hits], minlength=len(tcp) - 1) > 0


def is_free(site: PartSite, tcp: Points, approach: Directions) -> bool:
    """Whether the lance keeps clear along a way (n, 3) without the poses at its two ends."""
    if len(tcp) > 2 and (site.blockers_within(tcp[1:-1], approach[1:-1], grown_mm(site)) >= 0).any():
        return False
    places, directions, _ = way_samples(site, tcp, approach)
    # Coarse first: most ways that are not free are found by a few samples.
    for some in (slice(None, None, 16), slice(None)):
        if (site.blockers_within(places[some], directions[some], grown_mm(site)) >= 0).any():
            return False
    return True


def grown_mm(site: PartSite) -> float:
    """By how much the lance is thickened where the clearance does not hold what corners are cut by, mm."""
    return max(0.0, site.limits.blend_mm + step_of(site) / 2 - site.limits.clearance_mm)
