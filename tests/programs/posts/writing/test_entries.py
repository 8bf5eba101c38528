from installations import small_cell
from robot_steps import line, pose, program

from programs.motion.steps import EndRepeat, Note, Reach, Repeat
from programs.posts.writing.chapters import Chapter, divide
from programs.posts.writing.entries import find_entries
from specs.source import NO_SOURCE


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
        moves = [step for step in entry if hasattr(step, "target")]
        assert moves[-1].target == pose(60)
