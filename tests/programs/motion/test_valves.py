import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from installations import AIR, RING, WASH, small_cell
from robot_programs import PROGRAMS
from robot_steps import lasting, line, pose, ramp, signals

from programs.motion.make_motion import make_motion
from programs.motion.steps import EndRepeat, Line, Note, Pause, Reach, Repeat, Step, Switch
from programs.motion.valves import SwitchRequest, open_valves
from specs.source import NO_SOURCE

START = Reach(pose(0), (), "s")
THERE = line(pose(0), pose(100), 100.0, blend_mm=0.3)
ON, OFF = True, False


def request(step: int, seconds: float, spraying: bool, nozzle: str = "ring60") -> SwitchRequest:
    return SwitchRequest(step, seconds, spraying, nozzle, "s/pass")


def opened(steps: list[Step], *requests: SwitchRequest) -> tuple[list[Step], list[str]]:
    made, findings = open_valves(steps, requests, small_cell())
    return made, [finding.rule.id for finding in findings]


def test_the_signal_leaves_earlier_by_the_lag_and_names_the_place_of_the_jet() -> None:
    """The valve needs 40 ms to open and 20 ms to shut: 4 mm and 2 mm at 100 mm/s."""
    steps, findings = opened([START, THERE], request(1, 0.3, ON), request(1, 0.8, OFF))
    assert signals(steps, WASH)[1:] == [(pytest.approx(0.26), 1.0), (pytest.approx(0.78), 0.0)]
    assert not findings
    begin, end = next(step for step in steps if isinstance(step, Line)).events
    assert (begin.reference, begin.offset_mm, begin.offset_s) == ("start", pytest.approx(30), pytest.approx(-0.04))
    assert (end.reference, end.offset_mm, end.offset_s) == ("end", pytest.approx(-20), pytest.approx(-0.02))
    assert begin.speed_mm_s == pytest.approx(100.0)


def test_a_valve_is_shut_before_anything_else() -> None:
    steps, _ = opened([START, THERE], request(1, 0.3, ON), request(1, 0.8, OFF))
    assert steps[0] == Switch(WASH, 0.0, NO_SOURCE)


def test_near_the_beginning_of_a_line_the_signal_leaves_on_the_line_before() -> None:
    after = line(pose(100), pose(200), 100.0)
    steps, _ = opened([START, THERE, after], request(2, 0.01, ON), request(2, 0.9, OFF))
    first, second = (step for step in steps if isinstance(step, Line))
    (event,) = first.events
    assert (event.reference, event.offset_mm) == ("end", 0.0)
    assert event.offset_s == pytest.approx(-0.03)
    assert len(second.events) == 1


def test_at_rest_a_jet_that_begins_or_ends_at_a_stop_has_its_signal_there() -> None:
    motion = make_motion(PROGRAMS["loop"](), small_cell(), switches_at_rest=True)
    assert not any(each.events for each in motion.lines)
    steps = motion.steps
    switched = [at for at, step in enumerate(steps) if isinstance(step, Switch) and step.channel == WASH]
    for at, opens in zip(switched[1:], (True, False, True, False), strict=True):
        assert steps[at] == Switch(WASH, float(opens), steps[at].made_by)
        wait = steps[at + 1]
        before = next(each for each in steps[at::-1] if isinstance(each, Line))
        assert before.blend_mm == 0.0
        assert isinstance(wait, Pause)
        assert wait.duration_s == pytest.approx(RING.open_lag_s if opens else RING.close_lag_s)


def test_a_pause_is_divided_where_the_signal_leaves() -> None:
    steps, _ = opened(
        [START, THERE, Pause(0.2, "s"), line(pose(100), pose(0), 50.0)], request(3, 0.0, ON), request(3, 1, OFF)
    )
    at = next(index for index, step in enumerate(steps) if isinstance(step, Switch) and step.value == 1.0)
    before, after = steps[at - 1], steps[at + 1]
    assert isinstance(before, Pause)
    assert isinstance(after, Pause)
    assert (before.duration_s, after.duration_s) == (pytest.approx(0.16), pytest.approx(0.04))


def test_a_short_pause_is_looked_through() -> None:
    steps, _ = opened(
        [START, THERE, Pause(0.01, "s"), line(pose(100), pose(0), 50.0)], request(3, 0.0, ON), request(3, 1, OFF)
    )
    assert signals(steps, WASH)[1] == (pytest.approx(1.0 - 0.03), 1.0)


def test_a_loop_waits_for_the_jet_in_every_turn_of_it() -> None:
    loop = Repeat(3, "clean", 1.0, None, "s")
    steps, findings = opened([START, loop, THERE, EndRepeat("s")], request(2, 0.0, ON), request(2, 1.0, OFF))
    at = steps.index(loop)
    assert steps[at + 1] == Switch(WASH, 1.0, "s/pass")
    assert steps[at + 2] == Pause(pytest.approx(0.04), "s/pass")
    assert findings == ["waits-for-valve"]
    assert signals(steps, WASH)[-1] == (pytest.approx(1.04 - 0.02), 0.0)


def test_a_pulse_too_short_for_the_valve_is_lengthened_and_said() -> None:
    """5 ms of jet ask for a signal of 5 + 40 - 20 = 25 ms; the valve follows 30 ms."""
    steps, findings = opened([START, THERE], request(1, 0.5, ON), request(1, 0.505, OFF))
    (_, (on_s, _), (off_s, _)) = signals(steps, WASH)
    assert off_s - on_s == pytest.approx(RING.min_pulse_s)
    assert findings == ["valve-pulse-lengthened"]


def test_a_gap_too_short_for_the_valve_is_sprayed_through_and_said() -> None:
    steps, findings = opened(
        [START, THERE], request(1, 0.2, ON), request(1, 0.4, OFF), request(1, 0.42, ON), request(1, 0.8, OFF)
    )
    assert [value for _, value in signals(steps, WASH)] == [0.0, 1.0, 0.0]
    assert findings == ["valve-stays-open"]


def test_a_lengthened_signal_may_end_on_the_next_line_or_before_a_barrier() -> None:
    after = line(pose(100), pose(200), 100.0)
    short = [request(1, 0.999, ON), request(1, 1.0, OFF)]
    steps, _ = opened([START, THERE, after], *short)
    assert signals(steps, WASH)[-1] == (pytest.approx(0.959 + 0.03), 0.0)
    never = Repeat(2, "x", 1.0, None, "s")
    slow = [request(1, 0.9999, ON, "knife"), request(1, 1.0, OFF, "knife")]
    steps, _ = opened([START, THERE, never, EndRepeat("s")], *slow)
    told = signals(steps, AIR)
    assert told[-1][0] - told[-2][0] == pytest.approx(0.0501)


def test_a_nozzle_without_a_valve_leaves_comments_and_one_error() -> None:
    steps, findings = opened([START, THERE], request(1, 0.3, ON, "lance"), request(1, 0.8, OFF, "lance"))
    assert [step.text for step in steps if isinstance(step, Note)] == ["spray on", "spray off"]
    assert findings == ["no-valve"]


def test_the_speed_at_the_jet_is_that_of_the_course() -> None:
    hill = ramp(pose(0), pose(100), 2.0)
    steps, _ = opened([START, hill], request(1, 0.5, ON), request(1, 1.5, OFF))
    driven = next(step for step in steps if isinstance(step, Line))
    assert [event.speed_mm_s for event in driven.events] == [pytest.approx(50.0, rel=0.06)] * 2


@st.composite
def journeys(draw: st.DrawFn) -> tuple[list[Step], list[tuple[float, bool]]]:
    """Lines and pauses one after the other, and moments for the jet, all further apart than the valve needs."""
    steps: list[Step] = [START]
    x = 0.0
    for _ in range(draw(st.integers(1, 6))):
        if draw(st.booleans()):
            steps.append(Pause(draw(st.floats(0.005, 0.4)), "s"))
        else:
            length = draw(st.floats(0.5, 80.0))
            steps.append(
                line(pose(x), pose(x + length), draw(st.floats(5, 150)), blend_mm=draw(st.sampled_from([0.0, 0.3])))
            )
            x += length
    total = sum(map(lasting, steps))
    count = draw(st.integers(0, 6))
    moments = sorted(draw(st.lists(st.floats(0.0, 1.0), min_size=count, max_size=count)))
    times = [0.05 + number * 0.1 + moment * total for number, moment in enumerate(moments)]
    return steps, [(time_s, number % 2 == 0) for number, time_s in enumerate(times) if time_s < total]


@settings(max_examples=80)
@given(journey=journeys())
def test_without_barriers_every_signal_leaves_exactly_a_lag_before_its_jet(
    journey: tuple[list[Step], list[tuple[float, bool]]],
) -> None:
    steps, moments = journey
    requests: list[SwitchRequest] = []
    for time_s, spraying in moments:
        now = 0.0
        for index, step in enumerate(steps):
            if lasting(step) and now <= time_s <= now + lasting(step):
                requests.append(request(index, time_s - now, spraying))
                break
            now += lasting(step)
    made, _ = opened(steps, *requests)
    expected = [time_s - (RING.open_lag_s if spraying else RING.close_lag_s) for time_s, spraying in moments]
    assert [time_s for time_s, _ in signals(made, WASH)[1:]] == pytest.approx(expected, abs=1e-6)
    assert sum(map(lasting, made)) == pytest.approx(sum(map(lasting, steps)))


@pytest.mark.slow
@pytest.mark.parametrize("made", list(PROGRAMS))
def test_programs_begin_and_end_with_shut_valves(made: str) -> None:
    motion = make_motion(PROGRAMS[made](), small_cell())
    for channel in (WASH, AIR):
        told = [value for _, value in signals(motion.steps, channel)]
        assert told == [float(number % 2) for number in range(len(told))]
        assert len(told) % 2 == 1 or not told
