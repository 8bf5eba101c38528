from installations import WASH
from robot_steps import line, pose

from programs.motion.steps import Event, Pause
from programs.posts.writing.lines import place_events


def event(share: float, value: float = 1.0) -> Event:
    return Event(WASH, value, "start", 0.0, 0.0, share, share, 60.0, "s")


def test_an_output_at_the_end_of_a_passed_line_belongs_to_the_next() -> None:
    passed = line(pose(0), pose(10), 60.0, blend_mm=1.0, events=(event(0.0), event(0.5, 0.0), event(1.0)))
    after = line(pose(10), pose(20), 60.0, events=(event(0.0, 0.0), event(1.0)))
    first, second = place_events((passed, after))
    assert [len(first.begins), len(first.inside), len(first.ends)] == [1, 1, 0]
    assert [each.value for each in second.begins] == [1.0, 0.0]
    assert second.ends == (event(1.0),)


def test_where_the_robot_stops_an_output_stays_at_the_end() -> None:
    stopped = line(pose(0), pose(10), 60.0, events=(event(1.0),))
    first, second, _ = place_events((stopped, Pause(0.1, "s"), line(pose(10), pose(20), 60.0)))
    assert first.ends == (event(1.0),)
    assert not second.begins
