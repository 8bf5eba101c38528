"""Compares how lines are passed, and how fast the tool turns, with what is due in the language."""

from collections.abc import Iterator, Sequence
from itertools import zip_longest
from typing import TypeAlias

from programs.motion.installation import Installation
from programs.motion.steps import Line, MotionProgram
from programs.posts.proving.agreement import Match
from programs.posts.rebuilt import ReadLine, ReadReach, Rebuilt
from programs.posts.writing.chapters import follow
from specs.source import Source

_DIGIT = {"zone": 6e-3, "turn_deg_s": 0.051, "duration_s": 6e-4}
"""A little more than half of the last digit: zones have two decimals at least, rates one, times three."""
_WORDS = {
    "zone": "the line is passed at {} (zone, or share of the speed), planned {}",
    "turn_deg_s": "the tool turns at {} deg/s, planned {}",
    "duration_s": "the turn takes {} s, planned {}",
}


Wrong: TypeAlias = tuple[str, Source, int]
"""What differs, what requested it, and the step that was read."""


def compare_arms(rebuilt: Rebuilt, matches: Sequence[Match], installation: Installation) -> Iterator[Wrong]:
    """List the positions that state another arm than the planned joints there have."""
    if rebuilt.arm_due is None:
        return
    for match in matches:
        found, planned = rebuilt.steps[match.step], match.planned
        joints = planned.joints
        if isinstance(planned, Line) and match.end < 1.0:
            joints = planned.samples.joints_at(match.end)
        due = rebuilt.arm_due(joints, installation)
        if isinstance(found, ReadLine | ReadReach) and due is not None and found.arm != due:
            yield f"the arm is stated as {found.arm or 'nothing'}, planned {due}", planned.made_by, match.step


def compare_terms(rebuilt: Rebuilt, lowered: MotionProgram) -> Iterator[Wrong]:
    """List the lines whose zone, rate of turn or time of a turn differs by more than a digit from what is due.

    Args:
        rebuilt: What the reader found, the steps of the plan in their order.
        lowered: The motion in the controller's terms.
    """
    if rebuilt.dues is None:
        return
    following = follow(lowered.steps)
    read = [at for at, step in enumerate(rebuilt.steps) if isinstance(step, ReadLine)]
    for at, line in zip_longest(read, lowered.lines):
        if at is None or line is None:
            return  # a line too many or too few is a difference of its own
        found = rebuilt.steps[at]
        assert isinstance(found, ReadLine)
        due = rebuilt.dues(line, following.get(id(line)))
        for word, digit in _DIGIT.items():
            if word == "zone" and line.blend_mm == 0.0:
                continue
            stated, planned = getattr(found, word), getattr(due, word)
            if (stated is None) != (planned is None) or (planned is not None and abs(stated - planned) > digit):
                values = ("none" if value is None else f"{value:g}" for value in (stated, planned))
                yield _WORDS[word].format(*values), line.made_by, at
