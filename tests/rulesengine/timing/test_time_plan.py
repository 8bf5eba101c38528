from dataclasses import replace

import judge
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_plans import JET, LIMITS, leaning, moved, pause, plan_of, random_plan, spray, transfer

from programs import native
from programs.plan import Command as PlanCommand
from programs.plan import Plan, Transfer
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from recipes.recipe import Limits
from rulesengine.timing.time_plan import ACCELERATION_SHARE, TimedItems, sprayed_s, time_plan
from specs.finding import Finding

PLANNED = ACCELERATION_SHARE * LIMITS.acceleration_mm_s2

seeds = st.integers(0, 2**32 - 1)


def faults(program: TimedProgram, limits: Limits = LIMITS) -> list[str]:
    """What the independent reader finds wrong with the motion in the file; times are exact on its grid."""
    track = judge.read_track(native.render(program))
    return [
        *judge.times_running_back(track),
        *judge.wrong_totals(track),
        *judge.wrong_stated_speeds(track),
        *judge.too_sharp(track, limits.acceleration_mm_s2, time_rounding_s=0.0),
        *judge.turning_too_fast(track, limits.rotation_deg_s),
        *judge.turning_too_sharply(track, limits.rotation_acceleration_deg_s2),
    ]


def moves_of(program: TimedProgram) -> list[MoveTo]:
    return [item for item in program.instructions if isinstance(item, MoveTo)]


def columns(program: TimedProgram) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, positions and stated speeds of the moves."""
    moves = moves_of(program)
    return (
        np.array([move.time_s for move in moves]),
        np.array([move.position for move in moves]),
        np.array([move.speed_mm_s for move in moves]),
    )


def jet_on(program: TimedProgram) -> list[tuple[float, bool]]:
    return [(item.time_s, item.spraying) for item in program.instructions if isinstance(item, SetNozzle)]


def one_finding(program: TimedProgram) -> Finding:
    (finding,) = program.findings
    assert finding.rule.id == "speed-below-programmed"
    return finding


def test_a_pass_keeps_to_the_speed_of_each_of_its_segments() -> None:
    points = [(0, 0, 50), (60, 0, 50), (120, 0, 50), (180, 0, 50)]
    program = time_plan(plan_of(spray(points, speed=[40.0, 120.0, 60.0])), LIMITS)
    assert faults(program) == []
    _, places, speeds = columns(program)
    middles = 0.5 * (places[1:, 0] + places[:-1, 0])
    for low, high, speed in ((5, 58, 40), (75, 105, 120), (122, 175, 60)):
        held = speeds[1:][(middles > low) & (middles < high)]
        assert held.max() == pytest.approx(speed, rel=0.01)
        assert np.max(speeds[1:][middles < 58]) < 41
    one = time_plan(plan_of(spray(points, speed=[60.0, 60.0, 60.0])), LIMITS)
    assert native.render(one) == native.render(time_plan(plan_of(spray(points, speed=60.0)), LIMITS))


@pytest.mark.slow
@given(seed=seeds)
@settings(max_examples=15)
def test_an_independent_reader_finds_nothing_wrong_with_any_plan(seed: int) -> None:
    plan = random_plan(seed, 6)
    program = time_plan(plan, LIMITS)
    assert faults(program) == []
    asked: dict[str, float] = {}
    for item in plan.moving():
        fastest = item.speed_mm_s if isinstance(item, Transfer) else float(item.speeds_mm_s.max())
        asked[str(item.made_by)] = max(fastest, asked.get(str(item.made_by), 0.0))
    assert all(
        move.speed_mm_s <= asked[str(move.made_by)] * 1.001 for move in moves_of(program) if move.speed_mm_s > 0.0
    )
    turns = np.array([move.quaternion for move in moves_of(program)])
    np.testing.assert_allclose(np.linalg.norm(turns, axis=1), 1.0, atol=1e-6)
    assert np.all(np.einsum("ij,ij->i", turns[1:], turns[:-1]) >= 0.0)


@pytest.mark.slow
@given(
    acceleration=st.floats(50.0, 5000.0),
    speed=st.floats(2.0, 400.0),
    heading=st.floats(0.0, 6.3),
    way=st.floats(0.5, 90),
)
@settings(max_examples=30)
def test_no_segment_is_faster_than_asked_however_it_is_rounded(
    acceleration: float, speed: float, heading: float, way: float
) -> None:
    limits = Limits(acceleration_mm_s2=acceleration)
    angle = heading + np.linspace(0.0, 3.0, 31)
    ring = way / 3.0 * np.stack((np.cos(angle), np.sin(angle), 0.02 * angle), axis=1)
    program = time_plan(plan_of(spray(ring, speed)), limits)
    times, points, _ = columns(program)
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(times)
    assert speeds.max() <= speed * 1.0006
    assert faults(program, limits) == []


def test_small_changes_of_speed_are_kept_to_a_thousandth() -> None:
    """No tick is lost from sample to sample, though samples 8 ms apart are rounded to a micrometre."""
    steps = np.arange(401)
    speeds = 225.0 + 5.0 * np.sin(steps[:-1] / 30.0)
    points = np.column_stack((1.25 * steps, 0.0 * steps, 50.0 + 0.0 * steps))
    plan = plan_of(spray(points, speeds.tolist(), leaning((1e-3 * steps).tolist(), 0.3)))
    limits = Limits(acceleration_mm_s2=5000)
    program = time_plan(plan, limits)
    assert faults(program, limits) == []
    times, places, _ = columns(program)
    borders = np.arange(20.0, 481.0, 20.0)
    spent = np.diff(np.interp(borders, places[:, 0], times))
    programmed = np.diff(np.interp(borders, points[:, 0], np.concatenate(([0.0], np.cumsum(1.25 / speeds)))))
    np.testing.assert_allclose(spent / programmed, 1.0, atol=2e-3)
    assert spent.sum() / programmed.sum() == pytest.approx(1.0, abs=1e-3)


def test_a_straight_stretch_at_constant_speed_has_only_its_ends() -> None:
    program = time_plan(plan_of(spray([[0, 0, 50], [100, 0, 50]], 60.0)), LIMITS)
    times, points, speeds = columns(program)
    long = np.flatnonzero(np.diff(times) > 0.1)
    assert len(long) == 1
    ramp = 60.0**2 / (2 * PLANNED)
    np.testing.assert_allclose(points[long[0] : long[0] + 2, 0], [ramp, 100 - ramp], atol=6e-3)
    assert speeds[long[0] + 1] == pytest.approx(60.0, rel=1e-3)
    assert program.totals.duration_s == pytest.approx(100 / 60 + 60 / PLANNED, abs=2e-4)
    assert program.findings == ()


def test_between_samples_the_motion_is_as_good_as_straight() -> None:
    """Against the exact motion round a quarter of a circle: within 0.05 mm and 2 % of the asked speed."""
    angle = np.linspace(0.0, np.pi / 2, 10)
    ring = 30.0 * np.stack((np.cos(angle), np.sin(angle), 0.0 * angle), axis=1)
    program = time_plan(plan_of(spray(ring, 100.0)), LIMITS)
    times, points, _ = columns(program)
    fine = np.linspace(times[0], times[-1], 5001)
    radius = np.hypot(np.interp(fine, times, points[:, 0]), np.interp(fine, times, points[:, 1]))
    assert np.abs(radius - 30.0).max() < 0.05 + 30.0 * (1.0 - np.cos(angle[1] / 2))
    speeds = np.linalg.norm(np.diff(points, axis=0), axis=1) / np.diff(times)
    assert np.abs(np.diff(speeds)).max() <= 0.04 * 100.0 + 0.5


def test_the_jet_is_on_in_passes_and_pauses_and_off_in_between() -> None:
    program = time_plan(
        plan_of(
            PlanCommand("FUNCTION", ("clean",), "s"),
            transfer([[0, 0, 110], [0, 0, 50]]),
            spray([[0, 0, 50], [20, 0, 50]]),
            pause(0.25),
            spray([[20, 0, 50], [20, 20, 50]]),
            transfer([[20, 20, 50], [20, 20, 90]]),
            transfer([[20, 20, 90], [20, 30, 50]]),
            spray([[20, 30, 50], [0, 30, 50]]),
            PlanCommand("SET", ("pressure_bar", "2.5"), "s"),
            spray([[0, 30, 50], [0, 40, 50]]),
            PlanCommand("FUNCTION", ("rinse",), "s"),
            transfer([[0, 40, 50], [0, 40, 110]]),
        ),
        LIMITS,
    )
    track = judge.read_track(native.render(program))
    assert judge.spraying_in_transfers(track) == []
    switches = jet_on(program)
    assert [on for _, on in switches] == [True, False, True, False]
    (rinse,) = [item for item in program.instructions if isinstance(item, Command) and item.arguments == ("rinse",)]
    assert switches[-1][0] == rinse.time_s
    assert program.totals.spray_s == pytest.approx(switches[1][0] - switches[0][0] + switches[3][0] - switches[2][0])
    assert program.totals.liquid_l == (("clean", round(2.0 / 60.0 * program.totals.spray_s, 3)),)


def test_another_jet_means_off_and_on_and_gases_are_not_counted() -> None:
    air = replace(JET, function="dry", solution="hot-air", liquid=False)
    first, second = spray([[0, 0, 50], [20, 0, 50]]), spray([[20, 0, 50], [20, 20, 50]])
    program = time_plan(plan_of(first, replace(second, jet=air)), LIMITS)
    assert [on for _, on in jet_on(program)] == [True, False, True, False]
    assert [function for function, _ in program.totals.liquid_l] == ["clean"]


def test_a_lead_in_lets_the_jet_open_at_speed() -> None:
    program = time_plan(
        plan_of(transfer([[-10, 0, 50], [0, 0, 50]]), spray([[0, 0, 50], [40, 0, 50]], 60.0)),
        LIMITS,
    )
    times, points, speeds = columns(program)
    opened = jet_on(program)[0][0]
    at = int(np.flatnonzero(times == opened)[0])
    np.testing.assert_allclose(points[at], [0.0, 0.0, 50.0], atol=5e-3)
    assert speeds[at + 1] == pytest.approx(60.0, rel=5e-3)
    assert [str(move.made_by) for move in moves_of(program)[at : at + 2]] == ["s/transfer", "s/pass"]
    assert speeds[: at + 1].max() > 65.0
    assert faults(program) == []
    assert program.findings == ()


def test_a_pause_holds_exactly_as_long_as_it_says() -> None:
    program = time_plan(plan_of(spray([[0, 0, 50], [9, 0, 50]]), pause(1 / 3), spray([[9, 0, 50], [9, 9, 50]])), LIMITS)
    at = next(k for k, item in enumerate(program.instructions) if isinstance(item, Wait))
    before, wait, after = program.instructions[at - 1 : at + 2]
    assert isinstance(wait, Wait)
    assert isinstance(before, MoveTo)
    assert isinstance(after, MoveTo)
    assert wait.duration_s == 0.3334
    assert wait.time_s == before.time_s
    assert after.time_s == pytest.approx(wait.time_s + wait.duration_s, abs=1e-9)
    assert (after.position, after.speed_mm_s) == (before.position, 0.0)


def test_the_program_begins_with_the_start_pose_and_no_move_is_told_twice() -> None:
    program = time_plan(random_plan(3, 20), LIMITS)
    moves = moves_of(program)
    assert moves[0].time_s == 0.0
    assert moves[0].position == (50.0, 50.0, 50.0)
    told = [(move.time_s, move.position, move.quaternion) for move in moves]
    assert len(set(told)) == len(told)


def test_times_and_places_are_what_the_file_prints() -> None:
    for move in moves_of(time_plan(random_plan(4, 8), LIMITS)):
        assert move.time_s == float(f"{move.time_s:.4f}")
        assert all(value == float(f"{value:.3f}") for value in move.position)
        assert all(value == float(f"{value:.7f}") for value in move.quaternion)
        assert all(str(value) != "-0.0" for value in (*move.position, *move.quaternion))


@pytest.mark.slow
@given(seed=seeds, yaw=st.floats(-3.0, 3.0), x=st.floats(-300.0, 300.0), y=st.floats(-300.0, 300.0))
@settings(max_examples=10)
def test_a_moved_board_has_the_same_program_moved(seed: int, yaw: float, x: float, y: float) -> None:
    plan = random_plan(seed, 5)
    here, there = time_plan(plan, LIMITS), time_plan(moved(plan, yaw, (x, y, 5.0)), LIMITS)
    times, points, _ = columns(here)
    moved_times, moved_points, _ = columns(there)
    assert len(times) == len(moved_times)
    assert np.abs(times - moved_times).max() <= 3e-4
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])
    assert np.abs(points @ turn.T + [x, y, 5.0] - moved_points).max() <= 0.05
    assert [f.message for f in here.findings] == [f.message for f in there.findings]


def test_the_same_plan_gives_the_same_program() -> None:
    plan = random_plan(11, 10)
    assert native.render(time_plan(plan, LIMITS)) == native.render(time_plan(plan, LIMITS))


@pytest.mark.parametrize(
    ("plan", "cause", "severity"),
    [
        (plan_of(spray([[0, 0, 50], [40, 0, 50], [40, 40, 50]])), "corner", "info"),
        (plan_of(spray([[0, 0, 50], [4, 0, 50]])), "too short", "warning"),
        (plan_of(spray([[0, 0, 50], [40, 0, 50], [0, 0, 50]])), "stops inside", "info"),
        (plan_of(spray([[0, 0, 50], [20, 0, 50]], axes=leaning([0, 2.5], 1.0))), "has to turn", "warning"),
    ],
    ids=["corner", "short", "reversal", "rotation"],
)
def test_speed_below_the_asked_one_is_found_with_its_cause(plan: Plan, cause: str, severity: str) -> None:
    finding = one_finding(time_plan(plan, LIMITS))
    assert cause in finding.message
    assert finding.severity == severity
    assert str(finding.made_by) == "s/pass"


def test_the_finding_says_where_and_how_much() -> None:
    program = time_plan(plan_of(spray([[0, 0, 50], [50, 0, 50], [50, 50, 50]])), LIMITS)
    finding = one_finding(program)
    assert finding.where is not None
    assert np.hypot(finding.where[0] - 50.0, finding.where[1]) < 2.0
    slowest = np.sqrt(PLANNED * 0.5 / (1.0 / np.cos(np.pi / 4) - 1.0))
    assert f"at {slowest:.1f} instead of 60.0 mm/s" in finding.message


def test_a_pass_too_short_is_told_by_the_speed_it_gets_to() -> None:
    finding = one_finding(time_plan(plan_of(spray([[0, 0, 50], [4, 0, 50]])), LIMITS))
    assert f"at {np.sqrt(PLANNED * 4.0):.1f} instead of 60.0 mm/s" in finding.message
    assert finding.where == (2.0, 0.0, 50.0)


def test_one_finding_for_all_passes_of_one_maker() -> None:
    ell = [[0, 0, 50], [40, 0, 50], [40, 40, 50]]
    program = time_plan(plan_of(spray(ell), pause(0.1), spray(ell[::-1]), pause(0.1), spray(ell)), LIMITS)
    one_finding(program)


def test_ramps_at_the_ends_of_a_pass_are_no_finding() -> None:
    assert time_plan(plan_of(spray([[0, 0, 50], [7.8, 0, 50]])), LIMITS).findings == ()


def test_passes_without_length_double_points_and_turnings_back_are_fine() -> None:
    program = time_plan(
        plan_of(
            spray([[0, 0, 50], [0, 0, 50]]),
            spray([[0, 0, 50], [0, 0, 50], [9, 0, 50], [9, 0, 50], [0, 0, 50]], 1e-2),
            transfer([[0, 0, 50], [0, 0, 50]]),
            spray([[0, 0, 50], [2e-4, 0, 50], [5e-4, 3e-4, 50]], 250.0),
        ),
        LIMITS,
    )
    assert faults(program) == []
    assert program.totals.duration_s == pytest.approx(18.0 / 1e-2, rel=1e-3)
    assert [on for _, on in jet_on(program)] == [True, False]


def test_a_plan_that_does_not_move_has_no_moves_or_one() -> None:
    assert time_plan(plan_of(), LIMITS).instructions == ()
    still = time_plan(plan_of(spray([[1, 2, 50], [1, 2, 50]]), pause(0.5)), LIMITS)
    assert [type(item).__name__ for item in still.instructions] == ["MoveTo", "SetNozzle", "Wait", "SetNozzle"]
    assert (still.totals.duration_s, still.totals.spray_s, still.totals.travel_mm) == (0.5, 0.5, 0.0)


@pytest.mark.parametrize("again", [0, 1, 2, 5])
@pytest.mark.parametrize("points", [2, 9])
@pytest.mark.parametrize("turned", [0.0, 2.0 * np.pi])
@pytest.mark.parametrize("up", [1.0, -1.0])
def test_a_path_done_again_is_timed_once_and_gives_the_same_program(
    again: int, points: int, turned: float, up: float
) -> None:
    """Also from below, and where the nozzle turns all around, after which a quaternion has the other sign."""
    headings = np.linspace(0.0, turned, points if points > 2 else 2)
    approach, reference = (up * each for each in leaning(headings.tolist(), 0.3))
    line = np.column_stack((np.linspace(0.0, 40.0, points), np.zeros(points), np.full(points, 50.0 * up)))
    there, back = (spray(each, 60.0, (approach, reference)) for each in (line, line[::-1]))
    known: TimedItems = {}
    lap = (there, pause(0.1), back)
    time_plan(plan_of(*lap), LIMITS, known)
    plan = plan_of(*lap * (1 + again))
    program = time_plan(plan, LIMITS)
    assert native.render(time_plan(plan, LIMITS, known)) == native.render(program)
    assert len(known) == 2
    assert sprayed_s(plan, LIMITS, known) == {None: pytest.approx(program.totals.spray_s)}


def test_items_that_do_not_meet_are_refused() -> None:
    with pytest.raises(ValueError, match="s/pass: does not start where s/transfer ended"):
        time_plan(plan_of(transfer([[0, 0, 90], [0, 0, 50]]), spray([[1, 0, 50], [9, 0, 50]])), LIMITS)


def plate(segments: int) -> Plan:
    """The plate of Zaki and Eskander (Cairo, section 5): 60 x 40 cm at 10 cm, segments 5 cm apart, with links."""
    items = []
    for number in range(segments):
        y, ends = 50.0 * number, [0.0, 600.0] if number % 2 == 0 else [600.0, 0.0]
        items.append(spray([[x, y, 100.0] for x in ends], 600.0))
        if number < segments - 1:
            items.append(transfer([[ends[1], y, 100.0], [ends[1], y + 50.0, 100.0]], 600.0))
    return plan_of(*items)


@pytest.mark.parametrize(("segments", "seconds"), [(1, 1.2), (9, 12.866)])
def test_the_plate_of_the_cairo_paper_takes_its_time_by_trapezoids_of_speed(segments: int, seconds: float) -> None:
    """0.6 m/s and 3 m/s² from rest to rest: L/v + v/a on a segment, 2 sqrt(L/a) on a link, too short for 0.6 m/s."""
    changes = {"acceleration_mm_s2": 3000.0 / ACCELERATION_SHARE, "transfer_speed_mm_s": 600.0}
    limits = LIMITS.model_copy(update=changes)
    times, _, _ = columns(time_plan(plate(segments), limits))
    assert round(float(times[-1] - times[0]), 3) == seconds
