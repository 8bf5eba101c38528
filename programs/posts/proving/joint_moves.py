"""Compares joint motions with the plan: the ways home, and how fast each goes."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from programs.motion.installation import Installation
from programs.motion.steps import MotionProgram, Reach
from programs.posts.proving.production import same_joints
from programs.posts.proving.terms import Wrong
from programs.posts.rebuilt import ReadHome, ReadReach, Rebuilt
from programs.posts.writing.entries import safe_height
from programs.posts.writing.joint_moves import CAUTIOUS, Pace, pace_moves
from programs.posts.writing.tool_points import one_row, own_axes
from specs.source import NO_SOURCE

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
    yield from _compare_rise(rebuilt, motion, installation)
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


def _compare_rise(rebuilt: Rebuilt, motion: MotionProgram, installation: Installation) -> Iterator[Wrong]:
    """Compare the height to which the orifice is raised first; machines of axes raise one of them."""
    if rebuilt.dues is None:
        return
    due, found = safe_height(motion, installation), rebuilt.rise_mm
    if due != (None if found is None else round(found, 3)):
        yield f"the orifice is first raised to {found} mm above the base, planned {due}", NO_SOURCE, 0


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
        elif not _is_cautious(home, rebuilt):
            share = "no" if home.speed_share is None else f"{100.0 * home.speed_share:g} %"
            message = f"the motion home has {share} speed, planned {CAUTIOUS.percent} % of the joints'"
            yield message, NO_SOURCE, max(home.after - 1, 0)


def _is_cautious(home: ReadHome, rebuilt: Rebuilt) -> bool:
    """Whether a motion home has the cautious share of the joints' speeds, in languages that state shares."""
    if home.speed_share is not None:
        return abs(home.speed_share - 0.01 * CAUTIOUS.percent) <= _SHARE
    return all(step.speed_share is None for step in rebuilt.steps if isinstance(step, ReadReach))


def _is_home(home: ReadHome, rebuilt: Rebuilt, installation: Installation) -> bool:
    """Whether joint values are those of home when they are counted as the cell does."""
    if rebuilt.dues is not None:
        return same_joints(installation.home, home.joints, installation)
    machine = installation.tool_point  # axes are counted as the cell does
    planned = installation.home
    if machine is not None:
        planned = one_row(machine, planned) if rebuilt.home_in_tool_points else own_axes(machine, planned)
    return same_joints(planned, home.joints, replace(installation, convention=None))
