"""Ways around a part with the jet off, and the pieces of its stripes as strokes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Directions, Points, Scalars
from programs.plan import PlanItem, Transfer
from recipes.nozzles import AirKnife, FlatFan
from rulesengine.strokes.laid import Aim, LaidStroke, Pose, Reached
from rulesengine.surface.airways import Airways
from rulesengine.surface.piece import Piece
from rulesengine.surface.site import PartSite
from specs.source import Source

_SAME = 1e-6
_RAMP_ROUNDS = 20


@dataclass(frozen=True, slots=True, eq=False)
class PartWays:
    """Free ways around a part. The part's frame, mm."""

    parked: Pose
    airways: Airways

    def place(self, tcp: Points, approach: Directions, reference: Directions) -> tuple[Points, Directions, Directions]:
        """Poses are in the part's frame already."""
        return tcp, approach, reference

    def park(self, pose: Pose, speed_mm_s: float, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """Go to the parked pose, turned about the jet as little as possible on the way."""
        items = list(self._go(pose, self.parked, speed_mm_s, made_by))
        reference = items[-1].reference[-1] if items else pose.reference
        return [*items], Pose(self.parked.tcp, self.parked.approach, reference)

    def reach(self, pose: Pose, stroke: LaidStroke, speed_mm_s: float) -> Reached:
        """Go to the beginning of a stroke, and turn about the jet there if its pattern lies across the travel."""
        made_by = replace(stroke.made_by, motion="transfer")
        items = list(self._go(pose, Aim(stroke.tcp[0], stroke.approach[0]), speed_mm_s, made_by))
        carried = items[-1].reference[-1] if items else pose.reference
        if stroke.reference is None:
            return Reached([*items], replace(stroke, reference=carry(carried, stroke.approach)))
        # A flat pattern is the same turned by half a turn.
        reference = stroke.reference if stroke.reference[0] @ carried >= 0 else -stroke.reference
        if not np.allclose(reference[0], carried, rtol=0, atol=_SAME):
            tcp, approach = (np.tile(each[0], (2, 1)) for each in (stroke.tcp, stroke.approach))
            items.append(Transfer(tcp, approach, np.stack([carried, reference[0]]), speed_mm_s, made_by))
        return Reached([*items], replace(stroke, reference=reference))

    def _go(self, pose: Pose, end: Aim, speed_mm_s: float, made_by: Source) -> Iterator[Transfer]:
        way = self.airways.connect(pose, end)
        if len(way) > 1:
            tcp, approach = np.array([each.tcp for each in way]), np.array([each.approach for each in way])
            yield Transfer(tcp, approach, carry(pose.reference, approach), speed_mm_s, made_by)


def lay(site: PartSite, piece: Piece) -> LaidStroke:
    """Give a piece its speeds; a flat pattern lies across its travel, a round one is turned as little as possible."""
    return LaidStroke(
        tcp=piece.tcp,
        approach=piece.approach,
        reference=_across(site, piece),
        speeds_mm_s=_speeds(site, piece),
        delays=piece.pauses_s,
        made_by=replace(site.made_by, components=(piece.face,)),
    )


def _across(site: PartSite, piece: Piece) -> Directions | None:
    """(n, 3) directions across the travel of a flat pattern; ``None`` of a round one, or where it has no travel."""
    if not isinstance(site.nozzle, FlatFan | AirKnife) or len(piece.tcp) < 2:
        return None
    across = np.cross(piece.approach, np.gradient(piece.tcp, axis=0))
    lengths = np.linalg.norm(across, axis=1, keepdims=True)
    return None if (lengths < 1e-9).any() else across / lengths


def carry(reference: Directions, approach: Directions) -> Directions:
    """Tool +X (n, 3) along (n, 3) directions of the jet, each turned from the last about the axis that both share.

    Args:
        reference: (3,) at right angles to the first direction.
        approach: (n, 3) unit vectors; neighbours are not opposite.
    """
    rows = [reference]
    for before, after in pairwise(approach):
        axis, cosine = np.cross(before, after), float(before @ after)
        last = rows[-1]
        # Rodrigues, for the smallest rotation that takes the one direction to the other.
        turned = last * cosine + np.cross(axis, last) + axis * float(axis @ last) / max(1.0 + cosine, 1e-9)
        turned -= after * float(after @ turned)
        rows.append(turned / np.linalg.norm(turned))
    return np.array(rows)


def _speeds(site: PartSite, piece: Piece) -> Scalars:
    """(n - 1,) speeds of the orifice that give each segment its time; where it only turns, the largest.

    A segment is entered and left no faster than its neighbours are gone through. While the orifice speeds up from u to
    v, it falls (v - u)² / (2 a) behind, which the speed makes up for.
    """
    ways, fastest = piece.ways_mm, site.max_speed_mm_s
    if not len(ways):
        return ways
    moving = ways > _SAME
    speeds = np.where(moving, ways / piece.seconds, fastest)
    acceleration = site.acceleration_mm_s2
    if site.spec.repair:
        for _ in range(_RAMP_ROUNDS):
            beside = np.concatenate([[0.0], speeds, [0.0]])
            before, after = beside[:-2], beside[2:]
            lost = (np.maximum(speeds - before, 0.0) ** 2 + np.maximum(speeds - after, 0.0) ** 2) / (2.0 * acceleration)
            reached = np.sqrt(acceleration * ways + (before**2 + after**2) / 2.0)
            speeds = np.where(moving, np.minimum(np.minimum((ways + lost) / piece.seconds, reached), fastest), fastest)
    return np.clip(speeds, 0.01, fastest)
