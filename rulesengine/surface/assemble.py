"""Ordered pieces to plan items: passes, pauses, and free transfers between them."""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from geometry.arrays import Directions, Points, Scalars
from programs.plan import Command, Dwell, PlanItem, SprayPass, Transfer
from recipes.nozzles import AirKnife, FlatFan
from rulesengine.surface.piece import Piece
from rulesengine.surface.site import PartSite
from rulesengine.surface.transfers import Airways, Pose
from specs.source import Source

_SAME = 1e-6
_RAMP_ROUNDS = 20


@dataclass(slots=True, eq=False)
class PartAssembly:
    """A plan in the making, with the pose of the nozzle, so that every item starts where the last one ended."""

    park: Pose
    pose: Pose
    reference: Directions
    """(3,) tool +X at the pose."""
    items: list[PlanItem] = field(default_factory=list[PlanItem])

    def add(self, command: Command) -> None:
        """Add an instruction to the cell."""
        self.items.append(command)

    def go_home(self, airways: Airways, speed_mm_s: float, made_by: Source) -> None:
        """Transfer to the parked pose."""
        self._go(airways, self.park, speed_mm_s, made_by)

    def spray(self, site: PartSite, airways: Airways, piece: Piece, transfer_mm_s: float) -> None:
        """Go to the beginning of a piece and spray along it."""
        made_by = replace(site.made_by, components=(piece.face,))
        self._go(airways, Pose(piece.tcp[0], piece.approach[0]), transfer_mm_s, replace(made_by, motion="transfer"))
        reference = self._references(site, piece.tcp, piece.approach)
        if not np.allclose(reference[0], self.reference, rtol=0, atol=_SAME):
            turn = np.stack([self.reference, reference[0]])
            both = np.tile(piece.tcp[0], (2, 1)), np.tile(piece.approach[0], (2, 1))
            self.items.append(Transfer(*both, turn, transfer_mm_s, replace(made_by, motion="transfer")))
        speeds = _speeds(site, piece)
        for begin, end in _passes(piece):
            if piece.pauses_s[begin] > 0:
                self.items.append(Dwell(float(piece.pauses_s[begin]), site.jet, made_by))
            if end > begin:
                cut = slice(begin, end + 1)
                poses = piece.tcp[cut], piece.approach[cut], reference[cut]
                self.items.append(SprayPass(*poses, speeds[begin:end], site.jet, made_by))
        if len(piece.tcp) > 1 and piece.pauses_s[-1] > 0:
            self.items.append(Dwell(float(piece.pauses_s[-1]), site.jet, made_by))
        self.pose, self.reference = Pose(piece.tcp[-1], piece.approach[-1]), reference[-1]

    def _go(self, airways: Airways, end: Pose, speed_mm_s: float, made_by: Source) -> None:
        way = airways.connect(self.pose, end)
        if len(way) > 1:
            tcp, approach = np.array([each.tcp for each in way]), np.array([each.approach for each in way])
            reference = carried(self.reference, approach)
            self.items.append(Transfer(tcp, approach, reference, speed_mm_s, made_by))
            self.reference = reference[-1]
        self.pose = end

    def _references(self, site: PartSite, tcp: Points, approach: Directions) -> Directions:
        """Tool +X along a piece: of a flat pattern across the travel, of a round one turned as little as possible."""
        if not isinstance(site.nozzle, FlatFan | AirKnife) or len(tcp) < 2:
            return carried(self.reference, approach)
        across = np.cross(approach, np.gradient(tcp, axis=0))
        lengths = np.linalg.norm(across, axis=1, keepdims=True)
        if (lengths < 1e-9).any():
            return carried(self.reference, approach)
        across /= lengths
        return across if across[0] @ self.reference >= 0 else -across


def carried(reference: Directions, approach: Directions) -> Directions:
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


def _passes(piece: Piece) -> list[tuple[int, int]]:
    """Cut a piece at its pauses: first and last pose of each pass."""
    last = len(piece.tcp) - 1
    cuts = [0, *(int(at) for at in np.flatnonzero(piece.pauses_s[1:last] > 0) + 1), last]
    return list(pairwise(cuts)) if last else [(0, 0)]
