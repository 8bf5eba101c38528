import numpy as np
import pytest
from small_plans import pause, plan_of, spray, transfer
from tiny_session import tiny_session

from programs.plan import Command, Dwell
from specs.source import Source
from webui.layers.paths.nozzle import find_markers, marker_sizes, markers_glb

EDGE = Source(0, "edge")


def lap():
    return [
        spray([[0, 0, 40], [20, 0, 40]], made_by=EDGE),
        pause(0.5, EDGE),
        spray([[20, 0, 40], [0, 0, 40]], made_by=EDGE),
    ]


def test_a_stroke_is_switched_on_where_it_begins_and_off_where_it_ends():
    plan = plan_of(transfer([[0, 0, 99], [0, 0, 40]]), *lap(), transfer([[0, 0, 40], [0, 0, 99]]))
    found = [(marker.kind, marker.place_mm) for marker in find_markers(plan)]
    assert found == [("jet on", (0, 0, 40)), ("pause", (20, 0, 40)), ("jet off", (0, 0, 40))]


def test_pauses_in_one_place_add_up():
    (pauses,) = [marker for marker in find_markers(plan_of(*lap(), *lap())) if marker.kind == "pause"]
    assert pauses.seconds == pytest.approx(1.0)


def test_a_command_stands_where_the_nozzle_is_and_one_before_the_first_move_nowhere():
    begin, later = Command("FUNCTION", ("clean",), Source(0)), Command("CALL", ("flip",), Source(1))
    plan = plan_of(begin, transfer([[1, 2, 99], [3, 4, 99]]), later)
    assert [(marker.kind, marker.place_mm) for marker in find_markers(plan)] == [("command", (3, 4, 99))]


def test_all_pauses_of_a_plan_are_there():
    plan = tiny_session().run.plan
    pauses = sum(item.duration_s for item in plan.items if isinstance(item, Dwell))
    assert sum(marker.seconds for marker in find_markers(plan)) == pytest.approx(pauses)
    assert {"jet on", "jet off"} <= {marker.kind for marker in find_markers(plan)}


def test_longer_pauses_are_larger_up_to_a_limit():
    sizes = marker_sizes(np.array([0.0, 0.2, 1.0, 4.0, 400.0]), 1.0)
    assert np.all(np.diff(sizes[:4]) > 0)
    assert sizes[4] == sizes[3]


def test_no_markers_draw_nothing():
    assert markers_glb([], 1.0) == b""
    assert markers_glb(find_markers(plan_of(*lap())), 1.0)[:4] == b"glTF"
