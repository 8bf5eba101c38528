"""Ordered strokes to plan items: passes, dwells, transfers and commands, one after the other."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

import numpy as np

from boards.board import Board, Side
from programs.plan import Command, Dwell, Jet, PlanItem, SprayPass
from recipes.recipe import Limits
from rulesengine.planning.transfers import Pose, around_edge, board_frame, parked, to_board, transfer
from rulesengine.strokes.safe_height import Floors
from rulesengine.strokes.stroke import Retract, Stroke
from specs.finding import Finding
from specs.finding_rules import LEAD_IN_BLOCKED
from specs.source import Source

_SAME_MM = 1e-6


@dataclass(slots=True)
class Assembly:
    """A plan in the making, with the pose of the nozzle, so that every item starts where the last one ended."""

    board: Board
    limits: Limits
    side: Side
    floors: Floors
    pose: Pose
    items: list[PlanItem] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    settled: bool = True
    """Whether all orders so far are those that the full effort finds."""

    def command(self, keyword: str, *arguments: str, made_by: Source) -> None:
        """Add an instruction to the cell."""
        self.items.append(Command(keyword, arguments, made_by))

    def extend(self, after: "Assembly") -> None:
        """Add what was assembled from this pose on."""
        self.items += after.items
        self.findings += after.findings
        self.settled = self.settled and after.settled
        self.pose = after.pose

    def park(self, speed_mm_s: float, made_by: Source) -> None:
        """Take the nozzle to its parked pose, jet off."""
        self.go_to(parked(self.board, self.limits, self.floors), "everything", speed_mm_s, made_by)

    def go_to(self, pose: Pose, retract: Retract, speed_mm_s: float, made_by: Source) -> None:
        """Transfer to a pose, if the nozzle is not there already."""
        poses = transfer(self.pose, pose, self.floors, retract)
        if poses:
            self.items.append(to_board(self.board, self.side, poses, speed_mm_s, made_by))
        self.pose = pose

    def turn_over(self, side: Side, floors: Floors, speed_mm_s: float, made_by: Source) -> None:
        """Turn the board over; the nozzle is parked before and after."""
        self.park(speed_mm_s, made_by)
        before = to_board(self.board, self.side, [self.pose], speed_mm_s, made_by)
        self.command("CALL", f"flip_to_{side}", made_by=made_by)
        self.side, self.floors = side, floors
        self.pose = parked(self.board, self.limits, floors)
        after = to_board(self.board, side, [self.pose], speed_mm_s, made_by)
        self.items.append(around_edge(self.board, self.limits, before, after, speed_mm_s, made_by))

    def spray(self, strokes: Iterable[Stroke], jet: Jet, retract: Retract, transfer_speed_mm_s: float) -> None:
        """Do open strokes one after the other."""
        for stroke in strokes:
            self._run_up(stroke, retract, transfer_speed_mm_s)
            self.items += stroke_items(self.board, self.side, stroke, jet)
            self.pose = _pose(stroke, -1)

    def _run_up(self, stroke: Stroke, retract: Retract, transfer_speed_mm_s: float) -> None:
        """Go to the beginning of a stroke, or to where the run-up begins so that the jet opens at speed."""
        made_by = replace(stroke.made_by, motion="transfer")
        begin = _pose(stroke, 0)
        heading = stroke.tcp[1] - stroke.tcp[0] if len(stroke.tcp) > 1 else np.zeros(3)
        length = float(np.linalg.norm(heading))
        if stroke.lead_in_mm == 0 or length < _SAME_MM or self.pose.same_as(begin):
            self.go_to(begin, retract, transfer_speed_mm_s, made_by)
            return
        back = Pose(begin.tcp - heading / length * stroke.lead_in_mm, begin.approach, begin.azimuth)
        if self.floors.over(np.array([back.tcp[:2], begin.tcp[:2]])) > min(back.tcp[2], begin.tcp[2]):
            message = f"No room for a run-up of {stroke.lead_in_mm:g} mm: a body stands there. The jet opens from rest."
            x, y, z = begin.tcp
            self.findings.append(Finding(LEAD_IN_BLOCKED, message, stroke.made_by, (x, y, z)))
            self.go_to(begin, retract, transfer_speed_mm_s, made_by)
            return
        self.go_to(back, retract, transfer_speed_mm_s, made_by)
        run_up = to_board(self.board, self.side, [back, begin], stroke.speed_mm_s, made_by)
        self.items.append(run_up)
        self.pose = begin


def _pose(stroke: Stroke, index: int) -> Pose:
    return Pose(stroke.tcp[index], stroke.approach[index], stroke.azimuth[index])


def stroke_items(board: Board, side: Side, stroke: Stroke, jet: Jet) -> list[PlanItem]:
    """Cut an open stroke at its pauses: passes and dwells in turn, board frame."""
    tcp, approach, reference = board_frame(board, side, stroke.tcp, stroke.approach, stroke.azimuth)
    items: list[PlanItem] = []
    pose = np.hstack([tcp, approach, reference])
    begin = 0
    for index in sorted({*np.flatnonzero(stroke.delays > 0).tolist(), len(tcp) - 1}):
        cut = slice(begin, index + 1)
        if np.abs(pose[cut] - pose[begin]).max() > _SAME_MM:
            speeds = np.full(index - begin, stroke.speed_mm_s)
            items.append(SprayPass(tcp[cut], approach[cut], reference[cut], speeds, jet, stroke.made_by))
        if stroke.delays[index] > 0:
            at = stroke.pauses[index : index + 1]
            made_by = replace(stroke.made_by, components=at) if any(at) else stroke.made_by
            items.append(Dwell(float(stroke.delays[index]), jet, made_by))
        begin = index
    return items
