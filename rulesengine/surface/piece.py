"""Pieces of stripes that are sprayed in one go: poses, seconds between them, pauses."""

from dataclasses import dataclass, replace

import numpy as np

from geometry.arrays import Directions, Points, Scalars
from rulesengine.surface.site import PartSite

_LEAST_S = 1e-4


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
