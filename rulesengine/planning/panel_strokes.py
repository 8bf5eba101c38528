"""Strokes on a panel: those of the single board, brought to each of its instances."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from boards.board import Instance
from geometry.arrays import Scalars
from rulesengine.modifiers.raise_over import raise_over
from rulesengine.strokes.safe_height import Floors
from rulesengine.strokes.stroke import Stroke, StrokeSet
from specs.finding import Finding

_SAME_MM = 1e-6


def place_on_panel(instances: Sequence[Instance], sets: Sequence[StrokeSet], floors: Floors) -> StrokeSet:
    """Bring the strokes of one template to every instance of a panel, as one set whose order is found together.

    Each stroke is that of the single board, turned and moved. Only one that would come too near a body of a neighbour
    is raised over it.

    Args:
        instances: Of the panel.
        sets: Strokes of the board of each instance.
        floors: Of the panel, on the side that is sprayed.
    """
    strokes: list[Stroke] = []
    findings: dict[Finding, None] = {}
    for instance, planned in zip(instances, sets, strict=True):
        findings |= dict.fromkeys(planned.findings)
        for stroke in planned.strokes:
            placed = move_stroke(stroke, instance)
            raised = raise_over(StrokeSet((placed,), planned.freedom), floors)
            # What its own board made it rise over is in the way on the panel as well, and is cleared already.
            if raised.strokes[0] is placed or _lift_mm(placed, raised.strokes[0]) < _SAME_MM:
                strokes.append(placed)
            else:
                strokes += raised.strokes
                findings |= dict.fromkeys(raised.findings)
    planned = next((each for each in sets if each.strokes), sets[0])
    return StrokeSet(tuple(strokes), planned.freedom, planned.retract, tuple(findings))


def _lift_mm(stroke: Stroke, raised: Stroke) -> float:
    """Greatest height of a raised stroke over what it was."""
    before, after = (_heights(each) for each in (stroke, raised))
    return float((after[1] - np.interp(after[0], *before)).max())


def _heights(stroke: Stroke) -> tuple[Scalars, Scalars]:
    """Plan length from the beginning to each point, the first one again at the end of a ring, and the heights."""
    tcp = np.vstack([stroke.tcp, stroke.tcp[:1]]) if stroke.closed else stroke.tcp
    steps = np.linalg.norm(np.diff(tcp[:, :2], axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)]), tcp[:, 2]


def move_stroke(stroke: Stroke, instance: Instance) -> Stroke:
    """Bring a stroke of an instance's board onto the panel; its components get the name of the instance."""
    tcp, approach = stroke.tcp.copy(), stroke.approach.copy()
    tcp[:, :2], approach[:, :2] = instance.points(tcp[:, :2]), instance.directions(approach[:, :2])
    return replace(
        stroke,
        tcp=tcp,
        approach=approach,
        azimuth=instance.directions(stroke.azimuth),
        made_by=replace(stroke.made_by, components=tuple(map(instance.rename, stroke.made_by.components))),
        pauses=tuple(instance.rename(name) if name else "" for name in stroke.pauses),
    )
