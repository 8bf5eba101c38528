"""Moves over a side of a board with the jet off: up, over, down; around the edge when the board is turned over."""

from dataclasses import dataclass, replace
from typing import assert_never

import numpy as np

from boards.board import Board, Side
from geometry.arrays import Directions, Points
from programs.plan import PlanItem, Transfer
from recipes.recipe import Limits
from rulesengine.strokes.laid import LaidStroke, Pose, Reached
from rulesengine.strokes.safe_height import Floors
from rulesengine.strokes.stroke import Retract, Stroke, reference_axes, reference_azimuth
from specs.finding import Finding
from specs.finding_rules import LEAD_IN_BLOCKED
from specs.source import Source

_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class BoardWays:
    """Ways over one side of a board. Side frame, mm, as of a ``Stroke``: heights count from the bare surface."""

    board: Board
    limits: Limits
    side: Side
    floors: Floors

    @property
    def parked(self) -> Pose:
        """Above the middle of the board, or at the recipe's place, pointing down, above everything."""
        centre = self.board.outline.centroid
        place = np.array([centre.x, centre.y]) if self.limits.park_mm is None else np.array(self.limits.park_mm)
        height = max(self.limits.park_height_mm, self.floors.highest)
        down = np.array([0.0, 0.0, -1.0])
        reference = reference_axes(down[None], reference_azimuth(self.board, self.limits)[None])[0]
        return Pose(np.append(place, height), down, reference)

    def place(self, tcp: Points, approach: Directions, reference: Directions) -> tuple[Points, Directions, Directions]:
        """Side frame to board frame: the bottom side's heights count downwards."""
        up = np.array([1.0, 1.0, 1.0 if self.side == "top" else -1.0])
        place = tcp * up
        place[:, 2] += self.board.surface_z_mm(self.side)
        return place, approach * up, reference * up

    def park(self, pose: Pose, speed_mm_s: float, made_by: Source) -> tuple[list[PlanItem], Pose]:
        """Go to the parked pose."""
        parked = self.parked
        return self._go(pose, parked, "everything", speed_mm_s, made_by), parked

    def reach(self, pose: Pose, stroke: LaidStroke, speed_mm_s: float) -> Reached:
        """Go to the beginning of a stroke, or to where its run-up begins so that the jet opens at speed."""
        made_by = replace(stroke.made_by, motion="transfer")
        begin = stroke.pose(0)
        heading = stroke.tcp[1] - stroke.tcp[0] if len(stroke.tcp) > 1 else np.zeros(3)
        length = float(np.linalg.norm(heading))
        if stroke.lead_in_mm == 0 or length < _SAME or pose.same_as(begin):
            return Reached(self._go(pose, begin, stroke.retract, speed_mm_s, made_by), stroke)
        back = replace(begin, tcp=begin.tcp - heading / length * stroke.lead_in_mm)
        if self.floors.over(np.array([back.tcp[:2], begin.tcp[:2]])) > min(back.tcp[2], begin.tcp[2]):
            message = f"No room for a run-up of {stroke.lead_in_mm:g} mm: a body stands there. The jet opens from rest."
            x, y, z = begin.tcp
            blocked = Finding(LEAD_IN_BLOCKED, message, stroke.made_by, (x, y, z))
            return Reached(self._go(pose, begin, stroke.retract, speed_mm_s, made_by), stroke, (blocked,))
        run_up = self.transfer([back, begin], float(stroke.speeds_mm_s[0]), made_by)
        return Reached([*self._go(pose, back, stroke.retract, speed_mm_s, made_by), run_up], stroke)

    def turn_over(self, before: "BoardWays", pose: Pose, speed_mm_s: float, made_by: Source) -> Transfer:
        """From a pose above the other side to the parked pose of this one, around the edge."""
        start = before.transfer([pose], speed_mm_s, made_by)
        return around_edge(
            self.board, self.limits, start, self.transfer([self.parked], speed_mm_s, made_by), speed_mm_s, made_by
        )

    def transfer(self, poses: list[Pose], speed_mm_s: float, made_by: Source) -> Transfer:
        """A move through poses, in the board frame."""
        rows = [np.array([getattr(pose, name) for pose in poses]) for name in ("tcp", "approach", "reference")]
        return Transfer(*self.place(*rows), speed_mm_s, made_by)

    def _go(self, start: Pose, end: Pose, retract: Retract, speed_mm_s: float, made_by: Source) -> list[PlanItem]:
        poses = free_way(start, end, self.floors, retract)
        return [self.transfer(poses, speed_mm_s, made_by)] if poses else []


def free_way(start: Pose, end: Pose, floors: Floors, retract: Retract) -> list[Pose]:
    """Poses of a move that keeps clear: straight if it may, else up, across and down; none if it is there already."""
    if start.same_as(end):
        return []
    match retract:
        case "corridor":
            level = floors.over(np.array([start.tcp[:2], end.tcp[:2]]))
        case "everything":
            level = floors.highest
        case _:
            assert_never(retract)
    if np.allclose(start.tcp[:2], end.tcp[:2], rtol=0, atol=_SAME):
        level = 0.0
    poses = [start]
    if level > min(start.tcp[2], end.tcp[2]) + _SAME:
        level = max(level + floors.corner_mm, start.tcp[2], end.tcp[2])
        poses += [
            replace(each, tcp=np.append(each.tcp[:2], level)) for each in (start, end) if level > each.tcp[2] + _SAME
        ]
    return [*poses, end]


def lay(stroke: Stroke, retract: Retract) -> LaidStroke:
    """Give an open stroke its speeds and references; side frame."""
    return LaidStroke(
        tcp=stroke.tcp,
        approach=stroke.approach,
        reference=reference_axes(stroke.approach, stroke.azimuth),
        speeds_mm_s=np.full(len(stroke.tcp) - 1, stroke.speed_mm_s),
        delays=stroke.delays,
        made_by=stroke.made_by,
        pauses=stroke.pauses,
        lead_in_mm=stroke.lead_in_mm,
        retract=retract,
    )


def around_edge(
    board: Board, limits: Limits, start: Transfer, end: Transfer, speed_mm_s: float, made_by: Source
) -> Transfer:
    """Transfer from above one side to above the other past the edge, as turning the board over looks from the board.

    It runs from the end of ``start`` to the beginning of ``end`` and clears all bodies, overhanging ones too.
    """
    along = reference_azimuth(board, limits)
    out = np.array([-along[1], along[0]])
    corners = np.concatenate([body.patches.reshape(-1, 3)[:, :2] for body in board.bodies])
    reach = (
        float((corners @ out).max())
        + limits.clearance_mm
        + limits.blend_mm
        + float(np.ptp([start.tcp[-1, 2], end.tcp[0, 2]])) / 4
    )
    first, last = start.tcp[-1], end.tcp[0]

    def beside(place: Points, height: float) -> Points:
        return np.append(place[:2] + out * (reach - float(place[:2] @ out)), height)

    middle = beside((first + last) / 2, float((first[2] + last[2]) / 2))
    inward = np.append(-out, 0.0)
    flat = np.append(along, 0.0)
    return Transfer(
        tcp=np.array([first, beside(first, first[2]), middle, beside(last, last[2]), last]),
        approach=np.array([start.approach[-1], start.approach[-1], inward, end.approach[0], end.approach[0]]),
        reference=np.tile(flat, (5, 1)),
        speed_mm_s=speed_mm_s,
        made_by=made_by,
    )
