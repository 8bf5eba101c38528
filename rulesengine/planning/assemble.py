"""Ordered strokes to plan items: passes, dwells, transfers and commands, one after the other."""

from dataclasses import dataclass, field

from programs.plan import Jet, PlanItem
from rulesengine.strokes.laid import Ordered, Pose, Ways, stroke_items
from specs.finding import Finding
from specs.source import Source


@dataclass(slots=True)
class Assembly:
    """A plan in the making, with the pose of the nozzle, so that every item starts where the last one ended."""

    pose: Pose
    """In the frame of the ways that it is on."""
    ways: Ways | None = None
    """Of the strokes done last."""
    items: list[PlanItem] = field(default_factory=list[PlanItem])
    findings: list[Finding] = field(default_factory=list[Finding])
    settled: bool = True
    """Whether all orders so far are those that the full effort finds."""

    def extend(self, after: "Assembly") -> None:
        """Add what was assembled from this pose on."""
        self.items += after.items
        self.findings += after.findings
        self.settled = self.settled and after.settled
        self.pose, self.ways = after.pose, after.ways

    def park(self, speed_mm_s: float, made_by: Source) -> None:
        """Take the nozzle to its parked pose, jet off."""
        if self.ways is not None:
            items, self.pose = self.ways.park(self.pose, speed_mm_s, made_by)
            self.items += items

    def spray(self, ordered: Ordered, jet: Jet, transfer_speed_mm_s: float) -> None:
        """Do strokes one after the other."""
        self.ways = ordered.ways
        self.findings += ordered.findings
        self.settled = self.settled and ordered.settled
        for stroke in ordered.strokes:
            reached = ordered.ways.reach(self.pose, stroke, transfer_speed_mm_s)
            self.items += [*reached.items, *stroke_items(ordered.ways, reached.stroke, jet)]
            self.findings += reached.findings
            self.pose = reached.stroke.pose(-1)
