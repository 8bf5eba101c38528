import math
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from installations import WASH, small_cell
from robot_programs import PROGRAMS
from robot_steps import line, pose, program, ramp, signals, turn

from programs.motion.installation import Sensor
from programs.motion.lower import Capability, EventTiming, Lowered, lower
from programs.motion.make_motion import make_motion
from programs.motion.steps import EndRepeat, Event, Line, MotionProgram, Pause, Reach, Repeat, Step, Switch
from programs.motion.valves import SwitchRequest, open_valves
from programs.pose import angle, between, distance

CLASSES: dict[EventTiming, Capability] = {
    "distance and time": Capability(1, "distance and time", 0.002),
    "distance": Capability(1, "distance", 0.002, ("end",)),
    "time": Capability(1, "time", 0.004, ("end",), step_s=0.01),
    "percent": Capability(2, "percent", 0.002, most_events=16),
    "boundary": Capability(3, "boundary", 0.001),
    "stop": Capability(5, "stop", 0.002),
}
PATH_TIMED = [name for name in CLASSES if name != "stop"]
START = Reach(pose(0), (), "s")


def sprayed(*steps: Step, jets: tuple[tuple[int, float], ...]) -> MotionProgram:
    """Steps with a jet that changes at each (step, seconds); on first."""
    requests = [
        SwitchRequest(step, seconds, number % 2 == 0, "ring60", "s/pass") for number, (step, seconds) in enumerate(jets)
    ]
    made, _ = open_valves((START, *steps), requests, small_cell())
    return program(*made)


def flown(jets: int) -> MotionProgram:
    return sprayed(ramp(pose(0), pose(300), 6.0), jets=tuple((1, 0.5 + 0.4 * number) for number in range(jets)))


def events_of(lowered: Lowered) -> list[tuple[Line, Event]]:
    return [(line, event) for line in lowered.motion.lines for event in line.events]


@pytest.mark.parametrize("timing", PATH_TIMED)
@pytest.mark.parametrize("made", ["in_flight", "short_strokes", "three_speeds"])
def test_lowering_keeps_the_path_the_time_and_every_signal(timing: EventTiming, made: str) -> None:
    motion = make_motion(PROGRAMS[made](), small_cell())
    lowered = lower(motion, CLASSES[timing]).motion
    assert sum(each.length_mm for each in lowered.lines) == pytest.approx(sum(each.length_mm for each in motion.lines))
    assert sum(each.duration_s for each in lowered.lines) == pytest.approx(
        sum(each.duration_s for each in motion.lines)
    )
    before, after = signals(motion.steps, WASH), signals(lowered.steps, WASH)
    assert [value for _, value in after] == [value for _, value in before]
    slack_s = 11.1e-3 if timing == "percent" else 5.1e-3  # half of the shortest part of a line
    assert [time_s for time_s, _ in after] == pytest.approx([time_s for time_s, _ in before], abs=slack_s)


@pytest.mark.parametrize("timing", PATH_TIMED)
def test_only_what_the_language_has_is_used(timing: EventTiming) -> None:
    capability = CLASSES[timing]
    for each, event in events_of(lower(flown(8), capability)):
        assert event.reference in (*capability.references, "start") if timing == "percent" else capability.references
        match timing:
            case "distance":
                assert event.offset_s == 0.0
                assert -each.length_mm - 1e-6 <= event.offset_mm <= 0.0
            case "time":
                assert event.offset_mm == 0.0
                assert event.offset_s <= 0.0
                assert event.offset_s / 0.01 == pytest.approx(round(event.offset_s / 0.01))
            case "percent":
                assert event.share * 100 == pytest.approx(round(event.share * 100))
                assert event.offset_s == 0.0
            case "boundary":
                assert event.share in (0.0, 1.0)
                assert event.offset_mm == event.offset_s == 0.0
            case _:
                assert 0.0 <= event.share <= 1.0


def test_a_boundary_is_a_collinear_point_where_the_signal_leaves() -> None:
    motion = sprayed(line(pose(0), pose(100), 50.0), jets=((1, 0.5), (1, 1.5)))
    lowered = lower(motion, CLASSES["boundary"]).motion
    assert [each.target.position[0] for each in lowered.lines] == pytest.approx([25 - 2, 75 - 1, 100])
    assert [len(each.events) for each in lowered.lines] == [0, 1, 1]
    assert [each.blend_mm > 0 for each in lowered.lines] == [True, True, False]


def test_time_alone_divides_the_line_where_the_jet_is_wanted() -> None:
    motion = sprayed(line(pose(0), pose(100), 50.0), jets=((1, 0.5), (1, 1.5)))
    lowered = lower(motion, CLASSES["time"]).motion
    assert [each.target.position[0] for each in lowered.lines] == pytest.approx([25, 75, 100])
    assert [event.offset_s for _, event in events_of(lower(motion, CLASSES["time"]))] == pytest.approx([-0.04, -0.02])


def test_percents_that_are_too_coarse_are_replaced_by_a_division() -> None:
    """One percent of a metre is 10 mm: half of that is not within half a millimetre of the jet."""
    long = sprayed(line(pose(0), pose(1000), 100.0), jets=((1, 2.0374), (1, 5.0)))
    assert len(lower(long, CLASSES["percent"]).motion.lines) == 3
    short = sprayed(line(pose(0), pose(50), 100.0), jets=((1, 0.2), (1, 0.4)))
    lowered = lower(short, CLASSES["percent"])
    assert [round(100 * event.share) for _, event in events_of(lowered)] == [32, 76]


def test_a_percent_before_a_stop_is_no_jet_that_begins_after_it() -> None:
    """At the end of 94 mm the last percent lasts 60 ms: a signal 40 ms before the end is not to be in the next line."""
    motion = sprayed(ramp(pose(0), pose(94), 0.96), ramp(pose(94), pose(170), 1.4), jets=((2, 0.0), (2, 1.0)))
    lowered = lower(motion, CLASSES["percent"]).motion
    (before, opens), (after, _) = (signals(each.steps, WASH)[1] for each in (motion, lowered))
    assert after == pytest.approx(before, abs=1e-3)
    assert opens == 1.0


def test_a_stop_is_made_for_each_signal_and_said() -> None:
    lowered = lower(flown(4), CLASSES["stop"]).motion
    driven = [step for step in lowered.steps if isinstance(step, Line | Switch)]
    assert not any(each.events for each in lowered.lines)
    for before, step in pairwise(driven[1:]):
        if isinstance(step, Switch) and isinstance(before, Line):
            assert before.blend_mm == 0.0
    assert [finding.rule.id for finding in lowered.findings] == ["stops-for-output"]
    assert "4 times" in lowered.findings[0].message


@pytest.mark.parametrize("most", [1, 2, 8])
def test_no_line_has_more_events_than_the_language_allows(most: int) -> None:
    lowered = lower(flown(11), Capability(1, "distance and time", 0.002, most_events=most))
    assert max(len(each.events) for each in lowered.motion.lines) <= most
    before, after = signals(flown(11).steps, WASH), signals(lowered.motion.steps, WASH)
    assert after == [(pytest.approx(time_s, abs=1e-3), value) for time_s, value in before]
    assert lowered.error.time_s < 0.004


def test_a_lead_that_is_too_long_becomes_a_place() -> None:
    motion = sprayed(line(pose(0), pose(100), 50.0), jets=((1, 0.5), (1, 1.5)))
    short = Capability(1, "distance and time", 0.002, longest_lead_s=0.03)
    begin, end = (event for _, event in events_of(lower(motion, short)))
    assert (begin.offset_mm, begin.offset_s) == (pytest.approx(23.0), 0.0)
    assert (end.offset_mm, end.offset_s) == (pytest.approx(-25.0), pytest.approx(-0.02))


@pytest.mark.parametrize("timing", PATH_TIMED)
def test_a_signal_during_a_turn_on_the_spot_is_not_lost(timing: EventTiming) -> None:
    motion = sprayed(turn(pose(0), 1.5, 2.0), line(pose(0), pose(50), 50.0), jets=((1, 0.7), (2, 0.5)))
    lowered = lower(motion, CLASSES[timing]).motion
    told = signals(lowered.steps, WASH)
    assert told[1] == (pytest.approx(0.66, abs=0.011), 1.0)
    assert angle(lowered.lines[0].start, motion.lines[0].target) == pytest.approx(1.5)


def test_the_error_counts_the_cycle_and_the_rounding_at_the_speed_of_the_jet() -> None:
    motion = sprayed(line(pose(0), pose(100), 100.0), jets=((1, 0.3), (1, 0.7)))
    exact = lower(motion, Capability(1, "distance and time", 0.002)).error
    assert exact.distance_mm == pytest.approx(0.2)
    assert exact.time_s == pytest.approx(0.002)
    assert str(exact.made_by) == "s/pass"
    coarse = lower(motion, Capability(1, "distance and time", 0.002, step_s=0.03)).error
    assert coarse.time_s == pytest.approx(0.012)
    assert coarse.distance_mm == pytest.approx(1.2)
    assert lower(program(START, line(pose(0), pose(100), 100.0)), CLASSES["distance"]).error.time_s == 0.0


@settings(max_examples=60)
@given(speed=st.floats(0.1, 400), step=st.sampled_from([0.001, 0.1, 1.0]))
def test_speeds_are_steps_and_hardly_above_what_was_planned(speed: float, step: float) -> None:
    motion = program(START, line(pose(0), pose(100), speed))
    (lowered,) = lower(motion, Capability(1, "distance", 0.002, step_mm_s=step)).motion.lines
    assert lowered.speed_mm_s / step == pytest.approx(round(lowered.speed_mm_s / step))
    assert 0 < lowered.speed_mm_s <= max(speed + 0.5 * step + 1e-6, step)
    assert lowered.speed_mm_s >= speed - step or speed < step


@pytest.mark.parametrize(("length_mm", "speed"), [(0.2981, 14.0), (0.31, 15.0), (0.25, 14.0)])
def test_a_speed_is_not_rounded_up_where_the_move_would_take_less_than_20_ms(length_mm: float, speed: float) -> None:
    motion = program(START, line(pose(0), pose(length_mm), 14.83))
    (lowered,) = lower(motion, Capability(1, "distance", 0.002, step_mm_s=1.0, least_part_s=0.0)).motion.lines
    assert lowered.speed_mm_s == speed


def test_a_language_without_inputs_counts_and_says_so() -> None:
    loop = Repeat(4, "resistivity", 1.0, Sensor("ai", 1), "s")
    motion = program(START, loop, line(pose(0), pose(10), 10.0), EndRepeat("s"))
    lowered = lower(motion, Capability(3, "boundary", 0.001, reads_sensors=False)).motion
    assert lowered.steps[1] == Repeat(4, "resistivity", 1.0, None, "s")
    assert [finding.rule.id for finding in lowered.findings] == ["no-sensor"]
    assert lower(motion, CLASSES["boundary"]).motion.steps[1] == loop


def test_what_stands_between_lines_is_left_alone() -> None:
    motion = program(START, Pause(0.2, "s"), Switch(WASH, 1.0, "s"))
    assert lower(motion, CLASSES["percent"]).motion.steps == motion.steps


@settings(max_examples=60)
@given(moments=st.lists(st.floats(0.06, 5.9), min_size=1, max_size=6, unique=True), timing=st.sampled_from(PATH_TIMED))
def test_any_moments_keep_their_order_and_their_places(moments: list[float], timing: EventTiming) -> None:
    spread = [
        0.06 + 0.95 * moment * number / len(moments) + 0.05 * number for number, moment in enumerate(sorted(moments))
    ]
    motion = sprayed(ramp(pose(0), pose(300), 8.0), jets=tuple((1, moment) for moment in sorted(spread)))
    lowered = lower(motion, CLASSES[timing])
    assert [value for _, value in signals(lowered.motion.steps, WASH)] == [
        value for _, value in signals(motion.steps, WASH)
    ]
    worst = lowered.error.time_s - CLASSES[timing].cycle_s
    assert worst <= 0.0051 or lowered.error.distance_mm <= 0.6
    ends = [motion.lines[0].start, *(each.target for each in lowered.motion.lines)]
    total = distance(ends[0], ends[-1])
    for each in ends:
        share = distance(ends[0], each) / total
        assert math.isclose(distance(each, between(ends[0], ends[-1], share)), 0.0, abs_tol=1e-6)


def test_no_short_part_is_left_where_a_signal_leaves_shortly_before_the_robot_stands() -> None:
    """The jet is shut 8 ms or 16 ms before the end of a motion that slows down: at the end, or 22 ms before it."""
    for before_s, leaves_s in ((0.008, 0.0), (0.016, 0.022), (0.1, 0.1)):
        motion = sprayed(ramp(pose(0), pose(60), 2.0), jets=((0, 0.0), (1, 2.0 - before_s + 0.02)))
        lines = lower(motion, CLASSES["boundary"]).motion.lines
        assert lines[-1].duration_s >= 0.0219
        (event,) = (event for line in lines for event in line.events if event.value == 0.0)
        ends_s = lines[-1].duration_s if event.reference == "start" else 0.0
        assert ends_s == pytest.approx(leaves_s, abs=1e-6)
        assert lines[-1].length_mm / lines[-1].speed_mm_s >= 0.0205


def test_a_signal_in_full_flight_leaves_where_it_has_to() -> None:
    fast = line(pose(0), pose(300), 300.0, blend_mm=1.0)
    motion = sprayed(fast, line(pose(300), pose(400), 300.0), jets=((0, 0.0), (1, 0.985 + 0.02)))
    *_, last, _ = lower(motion, CLASSES["boundary"]).motion.lines
    assert last.duration_s == pytest.approx(0.015, abs=1e-6)
