"""Strokes as they are laid into a plan: in their order and sense, with the free ways from one to the next."""

from dataclasses import dataclass, replace
from typing import Literal, Protocol, TypeAlias

import numpy as np

from geometry.arrays import Directions, Points, Scalars
from programs.plan import Dwell, Jet, PlanItem, SprayPass
from rulesengine.strokes.stroke import Retract
from specs.finding import Finding
from specs.source import Source

Notices: TypeAlias = Literal["all", "errors and warnings"]
"""Findings on a plan: all of them, or without those of severity info that take long to find."""

_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Aim:
    """An orifice (3,), mm, and the unit vector (3,) along its jet, in the frame of the ways that it is on."""

    tcp: Points
    approach: Directions


@dataclass(frozen=True, slots=True, eq=False)
class Pose(Aim):
    """An aim with the unit vector (3,) of the nozzle's reference, at right angles to the jet: tool +X."""

    reference: Directions

    def same_as(self, other: "Pose") -> bool:
        """Whether nothing has to move to get from one to the other."""
        mine, theirs = (np.concatenate([each.tcp, each.approach, each.reference]) for each in (self, other))
        return bool(np.abs(mine - theirs).max() <= _SAME)


@dataclass(frozen=True, slots=True, eq=False)
class LaidStroke:
    """A run of poses with the jet on, in the frame of its ways; mm, s."""

    tcp: Points
    """(n, 3) orifice."""
    approach: Directions
    """(n, 3) along the jet."""
    reference: Directions | None
    """(n, 3) tool +X; ``None`` where a round pattern leaves it to the way that leads here."""
    speeds_mm_s: Scalars
    """(n - 1,) of the orifice from each pose to the next."""
    delays: Scalars
    """(n,) seconds held still on arrival at each pose, jet on."""
    made_by: Source
    pauses: tuple[str, ...] = ()
    """(n,) component at whose edge each delay is, empty where it is the stroke's own; or none of them."""
    lead_in_mm: float = 0.0
    retract: Retract = "corridor"
    """What the way to it must clear."""

    def pose(self, index: int) -> Pose:
        """One of its poses, once its reference is known."""
        assert self.reference is not None
        return Pose(self.tcp[index], self.approach[index], self.reference[index])


@dataclass(frozen=True, slots=True, eq=False)
class Reached:
    """The way to a stroke."""

    items: list[PlanItem]
    stroke: LaidStroke
    """With its reference."""
    findings: tuple[Finding, ...] = ()


class Ways(Protocol):
    """Free ways with the jet off, on one side of a board or around a part."""

    def place(self, tcp: Points, approach: Directions, reference: Directions) -> tuple[Points, Directions, Directions]:
        """Bring (n, 3) poses into the workpiece's frame."""
        ...

    def reach(self, pose: Pose, stroke: LaidStroke, speed_mm_s: float) -> Reached:
        """Go to the beginning of a stroke, at a speed of transfers.

        Raises:
            RecipeError: no free way was found.
        """
        ...

    def park(self, pose: Pose, speed_mm_s: float, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """Go to the parked pose.

        Raises:
            RecipeError: no free way was found.
        """
        ...


@dataclass(frozen=True, slots=True, eq=False)
class Ordered:
    """The strokes of one template in a step, in the order in which they are done, and the ways between them."""

    strokes: tuple[LaidStroke, ...]
    ways: Ways
    findings: tuple[Finding, ...] = ()
    settled: bool = True
    """Whether the full effort would give the same."""


def stroke_items(ways: Ways, stroke: LaidStroke, jet: Jet) -> list[PlanItem]:
    """Cut a stroke at its pauses: passes and dwells in turn, in the workpiece's frame."""
    assert stroke.reference is not None
    tcp, approach, reference = ways.place(stroke.tcp, stroke.approach, stroke.reference)
    items: list[PlanItem] = []
    pose = np.hstack([tcp, approach, reference])
    begin = 0
    for index in sorted({*np.flatnonzero(stroke.delays > 0).tolist(), len(tcp) - 1}):
        cut = slice(begin, index + 1)
        if np.abs(pose[cut] - pose[begin]).max() > _SAME:
            speeds = stroke.speeds_mm_s[begin:index]
            items.append(SprayPass(tcp[cut], approach[cut], reference[cut], speeds, jet, stroke.made_by))
        if stroke.delays[index] > 0:
            at = stroke.pauses[index : index + 1]
            made_by = replace(stroke.made_by, components=at) if any(at) else stroke.made_by
            items.append(Dwell(float(stroke.delays[index]), jet, made_by))
        begin = index
    return items
