from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from installations import small_cell
from robot_steps import line, pose, program

from programs.motion.steps import EndRepeat, Line, Note, Reach, Repeat, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.writing.chapters import Chapter, Part, divide
from programs.posts.writing.entries import find_entries
from specs.source import NO_SOURCE

HIGH, LOW, BACK = (0.1,) * 6, (0.2,) * 6, (0.3,) * 6


def at_height(x: float, z: float) -> Pose:
    return replace(pose(x), position=(x, 0.0, z))


def two_parts() -> tuple[Part, ...]:
    """Down from 110 mm, along, and up to 90 mm; the second part begins down there."""
    places = [at_height(0, 110), at_height(0, 50), at_height(60, 50), at_height(60, 90), at_height(60, 50)]
    joints = [HIGH, LOW, LOW, BACK, LOW]
    lines = [
        replace(line(a, b, 60.0), samples=replace(line(a, b, 60.0).samples, joints=np.array([q, q])))
        for a, b, q in zip(places, places[1:], joints[1:], strict=False)
    ]
    motion = program(
        UseBoard("", small_cell().T_base_board, NO_SOURCE),
        UseTool(2, "knife", NO_SOURCE),
        Note("function clean", NO_SOURCE),
        Reach(places[0], HIGH, NO_SOURCE),
        *lines,
        Note("function rinse", NO_SOURCE),
        line(places[-1], at_height(0, 50), 60.0),
    )
    return divide(motion, 100)


CASES = [((), HIGH, True), ((HIGH,), BACK, True), ((HIGH, BACK), LOW, True), ((HIGH, BACK, LOW), HIGH, False)]


@pytest.mark.parametrize(("blocked", "joints", "clear"), CASES)
def test_a_part_is_entered_at_the_highest_place_to_which_the_way_from_home_is_clear(
    blocked: tuple[tuple[float, ...], ...], joints: tuple[float, ...], clear: bool
) -> None:
    seen: list[tuple[int, str]] = []

    def is_clear(rows: tuple[tuple[float, ...], ...], tool: int, placement: str) -> bool:
        seen.append((tool, placement))
        return rows[0] == small_cell().home and rows[-1] not in blocked

    (entry,) = find_entries(two_parts(), small_cell(), is_clear).values()
    first = next(step for step in entry.steps if isinstance(step, Reach))
    assert (first.joints, entry.is_clear) == (joints, clear)
    assert set(seen) == {(2, "")}
    last = [step for step in entry.steps if hasattr(step, "target")][-1]
    assert last.target == at_height(60, 50)


def test_without_a_check_the_highest_place_is_taken() -> None:
    (entry,) = find_entries(two_parts(), small_cell()).values()
    first = next(step for step in entry.steps if isinstance(step, Reach))
    assert (first.joints, entry.is_clear) == (HIGH, None)


def test_a_part_that_only_switches_before_a_loop_is_entered_where_the_loop_begins() -> None:
    """Nothing moves in the second part, and the loop after it begins with a line."""
    motion = program(
        Note("function clean", NO_SOURCE),
        Reach(pose(0), (), NO_SOURCE),
        line(pose(0), pose(60), 60.0),
        Note("function rinse", NO_SOURCE),
        Repeat(2, "resistivity", 1.0, None, NO_SOURCE),
        line(pose(60), pose(0), 60.0),
        EndRepeat(NO_SOURCE),
    )
    parts = divide(motion, 100)
    assert [part.number for part in parts if isinstance(part, Chapter)] == [1, 2, 3]
    for entry in find_entries(parts, small_cell()).values():
        moves = [step for step in entry.steps if hasattr(step, "target")]
        assert moves[-1].target == pose(60)


@pytest.mark.parametrize("count", [198, 199, 200, 201, 450])
def test_an_entry_drives_from_the_last_highest_of_the_last_places(count: int) -> None:
    heights = np.random.default_rng(count).uniform(50.0, 60.0, count + 1).tolist()
    heights[0] = 90.0  # where the joint motion ends
    places = [at_height(float(at), z) for at, z in enumerate(heights)]
    parts = divide(
        program(
            UseBoard("", small_cell().T_base_board, NO_SOURCE),
            UseTool(2, "knife", NO_SOURCE),
            Note("function clean", NO_SOURCE),
            Reach(places[0], HIGH, NO_SOURCE),
            *(line(a, b, 60.0) for a, b in pairwise(places)),
            Note("function rinse", NO_SOURCE),
            line(places[-1], at_height(0, 50), 60.0),
        ),
        1000,
    )
    (entry,) = find_entries(parts, small_cell()).values()
    nearest = max(count - 200, 0)
    begin = max(at for at in range(nearest, count + 1) if heights[at] >= max(heights[nearest:]) - 0.5)
    driven = [step.target for step in entry.steps if isinstance(step, Reach | Line)]
    assert driven == places[begin:]
