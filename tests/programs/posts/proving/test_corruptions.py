"""Random corruptions of written texts: those that change motion or events are found.

A corruption changes something if the text is no longer read, or if it executes otherwise than the original text: other
steps, or numbers that differ by more than the tolerances to which a text is compared with its plan. What stands in
comments and headers changes nothing, nor does an output that is set to what it is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import cache
from itertools import zip_longest
from math import degrees
from random import Random

import pytest
from corruptions import corrupt
from installations import ARM_LANGUAGES, for_language, small_cell
from joint_journey import journey
from robot_programs import PROGRAMS, joints_of

from programs.errors import ProgramError
from programs.motion.installation import Installation
from programs.motion.lower import lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import MotionProgram
from programs.pose import Pose, angle, distance
from programs.posts.dialects import DIALECTS
from programs.posts.proving.compare import compare
from programs.posts.rebuilt import ReadBoard, ReadStep, ReadSwitch, ReadTool, Rebuilt

MADE = ("loop", "two_tools", "in_flight", "bottom", "three_speeds")
NOT_COMPARED = {"label"}
TOLERANCES = {
    "speed_mm_s": 1.3,
    "duration_s": 0.012,
    "offset_s": 0.012,
    "share": 0.011,
    "zone": 0.012,
    "turn_deg_s": 0.102,
    "joints": 0.002,
    "axes": 0.008,
    "values": 0.008,
}
"""Twice what a text may be off from its plan: the original may be off by as much on the other side."""


@cache
def written(dialect: str, made: str) -> tuple[Mapping[str, str], Rebuilt, MotionProgram, Installation]:
    language = DIALECTS[dialect]
    if made == "journey":
        motion, cell = journey(dialect)
    else:
        cell, program = for_language(small_cell(), dialect), PROGRAMS[made]()
        motion = make_motion(program, cell, joints_of(program))
    files = language.render(lower(motion, language.capability), cell)
    return files, language.read(files), motion, cell


def is_same(before: object, after: object, tolerance: float = 1e-9) -> bool:
    """Whether two things that were read are the same within the tolerances."""
    if isinstance(before, Pose) and isinstance(after, Pose):
        return distance(before, after) <= 0.02 and degrees(angle(before, after)) <= 0.02
    if isinstance(before, float) and isinstance(after, float):
        return abs(before - after) <= tolerance
    if isinstance(before, tuple) and isinstance(after, tuple):
        return len(before) == len(after) and all(is_same(*pair, tolerance) for pair in zip(before, after, strict=True))
    if is_dataclass(before) and type(before) is type(after):
        return all(
            is_same(getattr(before, each.name), getattr(after, each.name), TOLERANCES.get(each.name, tolerance))
            for each in fields(before)
            if each.name not in NOT_COMPARED
        )
    return before == after


def plain(steps: Sequence[ReadStep]) -> tuple[ReadStep, ...]:
    """Steps without the selection of a tool or a frame that is in use already, each right before it is needed.

    Outputs that change before, where the robot stands, change as well after it.
    """
    kept: list[ReadStep] = []
    in_use: dict[type, ReadStep] = {}
    switches_last = sorted(range(len(steps)), key=_stretches(steps).__getitem__)
    for step in (steps[at] for at in switches_last):
        if isinstance(step, ReadTool | ReadBoard):
            if in_use.get(type(step)) == step:
                continue
            in_use[type(step)] = step
        kept.append(step)
    return tuple(kept)


def _stretches(steps: Sequence[ReadStep]) -> list[tuple[int, bool]]:
    """For each step how many motions and the like are before it, and whether it is an output's."""
    before, found = 0, list[tuple[int, bool]]()
    for step in steps:
        before += not isinstance(step, ReadSwitch | ReadBoard)
        found.append((before, isinstance(step, ReadSwitch)))
        before += not isinstance(step, ReadSwitch | ReadBoard)
    return found


def frame_of(rebuilt: Rebuilt) -> object:
    """The production frame; an output that is set twice to the same, or in another order at rest, does the same."""
    if (frame := rebuilt.frame) is None:
        return None
    parts: list[object] = []
    for part in frame.parts:
        outputs = {step.channel: step.value for step in part.entry if isinstance(step, ReadSwitch)}
        rest = plain([step for step in part.entry if not isinstance(step, ReadSwitch)])
        parts.append((part.number, tuple(sorted(outputs.items())), rest))
    return frame.waits, frame.watched, tuple(sorted(set(frame.shut))), frame.guards_override, tuple(parts)


def homes_of(rebuilt: Rebuilt) -> tuple[object, ...]:
    """The ways home; what changes nothing before them does not count."""
    return tuple(replace(each, after=len(plain(rebuilt.steps[: each.after]))) for each in rebuilt.homes or ())


def tally(dialect: str, count: int) -> tuple[int, list[str]]:
    """How many of so many corruptions change something, and those of them that are not found."""
    changed, missed = 0, list[str]()
    made_by_joints = ("journey",) if DIALECTS[dialect].maker is not None else ()
    for made in (*MADE, *made_by_joints):
        files, original, motion, cell = written(dialect, made)
        assert compare(original, motion, cell) == ()
        random = Random(f"{dialect} {made}")
        for _ in range(count):
            corrupted = corrupt(files, random)
            try:
                read = DIALECTS[dialect].read(corrupted.files)
            except ProgramError:
                changed += 1
                continue
            pairs = zip_longest(plain(original.steps), plain(read.steps))
            others = ((frame_of(original), frame_of(read)), (homes_of(original), homes_of(read)))
            if all(is_same(*pair) for pair in (*pairs, *others)):
                continue
            changed += 1
            if compare(read, motion, cell) == ():
                missed.append(f"{made} {corrupted.kind}: {corrupted.before!r} -> {corrupted.after!r}")
    return changed, missed


@pytest.mark.slow
@pytest.mark.parametrize("dialect", ARM_LANGUAGES)
def test_corruptions_that_change_something_are_found(dialect: str) -> None:
    changed, missed = tally(dialect, 12)
    assert changed >= 12
    assert len(missed) <= 1, missed


@pytest.mark.slow
@pytest.mark.parametrize("dialect", ARM_LANGUAGES)
def test_of_many_corruptions_that_change_something_all_but_a_hundredth_are_found(dialect: str) -> None:
    changed, missed = tally(dialect, 50)
    assert len(missed) <= 0.01 * changed, missed
