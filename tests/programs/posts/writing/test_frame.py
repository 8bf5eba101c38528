from installations import WASH
from robot_steps import line, pose, program

from programs.motion.steps import Event, Switch
from programs.posts.writing.handover import channels_of


def test_the_outputs_of_a_program_are_listed_once() -> None:
    event = Event(WASH, 1.0, "start", 0.0, 0.0, 0.5, 0.5, 60.0, "s")
    steps = (Switch(WASH, 0.0, "s"), line(pose(0), pose(10), 60.0, events=(event,)))
    assert channels_of(program(*steps)) == [WASH]
