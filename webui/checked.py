"""What came of trying a program in a robot cell, as one frozen value."""

from dataclasses import dataclass

import numpy as np

from geometry.arrays import Scalars
from geometry.finding import Finding
from geometry.progress import Progress, part_of
from programs.program import TimedProgram
from robotcell.load import LoadedCell
from robotcell.robot import Robot
from rulesengine.pipeline import Run
from rulesengine.summary import clock
from webui.layers.joint_plots import Quantity, joint_curves, use_of
from webui.layers.robot import JointMotion, joint_motion
from webui.nearness import Near, find_nearest

_TRACKING = 0.9
"""Share of the work that finding the joint motion is."""
_LOOKED_AT = 400
"""Postures whose distance to other bodies is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A run in a cell."""

    run: Run
    cell: LoadedCell
    program: TimedProgram
    """As the robot does it; as planned where it cannot."""
    motion: JointMotion | None
    """``None`` where the robot cannot do it."""
    findings: tuple[Finding, ...]
    """Worst first."""
    nearest: Near | None
    """Where robot or tool come nearest to something; ``None`` where nothing is near."""
    facts: tuple[tuple[str, str], ...]
    """What to know of it at one glance: a name and a text each."""


def check_program(run: Run, cell: LoadedCell, tell: Progress) -> Checked:
    """Try a program in a cell.

    Args:
        run: Its program, and the board for collisions.
        cell: The cell.
        tell: Is told how far it is.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from robotcell.track import terms_of, track

    report = track(run.program, cell.cell, run.board, terms=terms_of(cell), progress=part_of(tell, 0.0, _TRACKING))
    if not report.possible:
        return Checked(run, cell, report.program, None, report.findings, None, ())
    motion = joint_motion(report.program, report.joints)
    tell("measuring distances", _TRACKING)
    rows = np.unique(np.linspace(0, len(motion.times) - 1, _LOOKED_AT).astype(np.intp))
    nearest = find_nearest(cell.cell, run.board, motion, rows)
    facts = {
        "Time": _time(run.program.totals.duration_s, report.program.totals.duration_s),
        "Speed": _hardest(cell.cell.robot, motion, "speed"),
        "Acceleration": _hardest(cell.cell.robot, motion, "acceleration"),
        "Nearest": _nearest(nearest),
        "Manipulability": _least(report.singularity, "at the least"),
        "Condition": _least(report.condition, "inverse, at the least"),
    }
    return Checked(run, cell, report.program, motion, report.findings, nearest, tuple(facts.items()))


def _time(asked_s: float, taken_s: float) -> str:
    if abs(taken_s - asked_s) < 0.05:
        return f"{clock(taken_s)}, as planned"
    return f"{clock(taken_s)}, planned {clock(asked_s)}"


def _hardest(robot: Robot, motion: JointMotion, quantity: Quantity) -> str:
    """Say which joint uses most of what it may."""
    curves = joint_curves(robot, motion, quantity)
    hardest = max(curves, key=use_of)
    return f"{hardest.name} at {use_of(hardest):.0%} of its limit"


def _nearest(near: Near | None) -> str:
    from robotcell.clearance import FARTHEST

    if near is None:
        return f"nothing within {1000 * FARTHEST:g} mm"
    return f"{near.body} to {near.other}, {near.distance_mm:.1f} mm"


def _least(values: Scalars, words: str) -> str:
    return f"{float(values.min()):.3g} {words}"
