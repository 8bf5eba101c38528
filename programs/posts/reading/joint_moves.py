"""Compares joint motions with the plan: the ways home, and how fast each goes."""

from collections.abc import Iterator, Mapping

from programs.motion.installation import Installation
from programs.motion.steps import MotionProgram, Reach
from programs.posts.reading.terms import Wrong
from programs.posts.rebuilt import ReadHome, ReadReach, Rebuilt
from programs.posts.writing.axes import from_controller_counts, in_degrees_and_mm
from programs.posts.writing.joint_moves import CAUTIOUS, Pace, pace_moves
from programs.posts.writing.tool_points import one_row
from specs.source import NO_SOURCE

_JOINT = 0.001
"""mm and degrees, of a joint."""
_TIME_S, _SHARE = 6e-4, 1e-6


def compare_joint_moves(
    rebuilt: Rebuilt, reaches: Mapping[int, Reach], motion: MotionProgram, installation: Installation
) -> Iterator[Wrong]:
    """List joint motions that differ from the plan in their speed, and motions home that are missing or end elsewhere.

    Args:
        rebuilt: What the reader found.
        reaches: The planned joint motion of each step that is one.
        motion: What ``make_motion`` gave.
        installation: The cell; its home counts.
    """
    yield from _compare_homes(rebuilt, installation)
    if rebuilt.controller is None:
        return
    paces = pace_moves(motion.steps, installation, rebuilt.controller)
    read = {at: step for at in reaches if isinstance(step := rebuilt.steps[at], ReadReach)}
    states_paces = any(step.duration_s is not None or step.speed_share is not None for step in read.values())
    for at, step in read.items() if states_paces else ():
        due = paces.get(id(reaches[at]), CAUTIOUS)
        if not _has_pace(step, due):
            stated = f"{100.0 * step.speed_share:g} %" if step.duration_s is None and step.speed_share else "no speed"
            stated = f"{step.duration_s:g} s" if step.duration_s is not None else stated
            planned = f"{due.percent} %" if due.seconds is None else f"{due.percent} %, {due.seconds:g} s"
            yield f"the joint motion states {stated}, planned {planned}", reaches[at].made_by, at


def _has_pace(step: ReadReach, due: Pace) -> bool:
    """Whether a joint motion states the time or the speed that it is due, or none where it is the cautious one."""
    if step.duration_s is not None:
        return due.seconds is not None and abs(step.duration_s - due.seconds) <= _TIME_S
    if step.speed_share is not None:
        return abs(step.speed_share - 0.01 * due.percent) <= _SHARE
    return due.seconds is None


def _compare_homes(rebuilt: Rebuilt, installation: Installation) -> Iterator[Wrong]:
    """Compare the motions home: one before anything else, one after everything."""
    if rebuilt.homes is None:
        return
    due = [0, len(rebuilt.steps)] if installation.home else []
    found = [home.after for home in rebuilt.homes]
    if found != due:
        message = f"the program goes home {len(found)} times, planned {len(due)}, first and last"
        yield message, NO_SOURCE, min(found[0] if found else 0, max(len(rebuilt.steps) - 1, 0))
        return
    for home in rebuilt.homes:
        if not _is_home(home, rebuilt, installation):
            yield f"the joints go to {home.joints} for home", NO_SOURCE, max(home.after - 1, 0)
        elif home.speed_share is not None and abs(home.speed_share - 0.01 * CAUTIOUS.percent) > _SHARE:
            message = f"the motion home has {100.0 * home.speed_share:g} % of the joints' speeds"
            yield f"{message}, planned {CAUTIOUS.percent} %", NO_SOURCE, max(home.after - 1, 0)


def _is_home(home: ReadHome, rebuilt: Rebuilt, installation: Installation) -> bool:
    """Whether joint values are those of home when they are counted as the cell does."""
    machine, dof = installation.tool_point, len(installation.home)
    if len(home.joints) < dof or any(home.joints[dof:]):  # RAPID has six at least
        return False
    read, planned = home.joints[:dof], installation.home
    if rebuilt.dues is not None:
        read = from_controller_counts(read, installation)
    elif machine is not None:
        planned = one_row(machine, planned)
    pairs = zip(read, in_degrees_and_mm(planned, installation), strict=True)
    return all(abs(one - other) <= _JOINT for one, other in pairs)
