import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from brief_recipe import BRIEF
from installations import small_cell
from numpy.typing import NDArray
from robot_programs import PROGRAMS
from small_plans import LIMITS, leaning, moved, plan_of, random_plan, spray, transfer
from small_programs import program_of

from boards.load import board_library, load_board
from geometry.frames import rotation_angles
from programs.motion import tracks
from programs.motion.make_motion import make_motion
from programs.motion.steps import Line, MotionProgram
from programs.motion.tracks import Track, find_vertices
from programs.plan import Plan
from programs.playback import build_timeline, play
from programs.program import MoveTo, TimedProgram
from rulesengine.planning.pipeline import run
from rulesengine.timing.time_plan import time_plan
from specs.source import Source


def lines_of(*items: object) -> tuple[Line, ...]:
    return make_motion(time_plan(plan_of(*items), LIMITS), small_cell()).lines  # type: ignore[arg-type]


def track(times: list[float], x: list[float], y: list[float] | None = None) -> Track:
    tcp = np.column_stack((x, y or [0.0] * len(x), [50.0] * len(x)))
    quaternion = np.tile([0.0, 1.0, 0.0, 0.0], (len(x), 1))
    clock, maker = np.array(times), np.zeros(len(x), dtype=np.int64)
    return Track(clock, tcp, quaternion, maker, np.empty((len(x), 0)), clock, np.arange(len(x), dtype=np.float64), None)


def worst_miss(program: TimedProgram, motion: MotionProgram) -> tuple[float, float]:
    """How far the samples of a program are from its lines at the same moment: mm, degrees."""
    timeline = build_timeline(program)
    place, turn = [0.0], [0.0]
    for line in motion.lines:
        states = play(timeline, line.time_s + line.samples.seconds)
        poses = [line.pose_at(share) for share in line.samples.shares.tolist()]
        place.append(float(np.linalg.norm(states.tcp - [pose.position for pose in poses], axis=1).max()))
        aim = np.array([pose.quaternion for pose in poses])
        turn.append(float(np.degrees(rotation_angles(states.quaternion, aim)).max()))
    return max(place), max(turn)


@pytest.mark.slow
@pytest.mark.parametrize("made", list(PROGRAMS))
def test_every_sample_is_on_the_lines(made: str) -> None:
    program = PROGRAMS[made]()
    place_mm, turn_deg = worst_miss(program, make_motion(program, small_cell()))
    assert place_mm <= 0.061
    assert turn_deg <= 0.201


@pytest.mark.slow
@pytest.mark.parametrize("made", list(PROGRAMS))
def test_lines_meet_and_take_as_long_as_planned(made: str) -> None:
    program = PROGRAMS[made]()
    motion = make_motion(program, small_cell())
    for line, after in pairwise(motion.lines):
        assert math.dist(line.target.position, after.start.position) < 1e-9
        assert line.time_s + line.duration_s <= after.time_s + 1e-6


def test_a_plan_of_straight_strokes_needs_few_lines() -> None:
    program = run(BRIEF, load_board(board_library()["tiny"])).program
    moves = sum(isinstance(item, MoveTo) for item in program.instructions)
    assert len(make_motion(program, small_cell()).lines) < 0.06 * moves


def test_a_stroke_that_speeds_up_and_slows_down_is_one_line_at_its_plateau() -> None:
    (line,) = lines_of(spray([[0, 0, 50], [100, 30, 50]], 60.0))
    assert line.speed_mm_s == pytest.approx(60.0, abs=0.1)
    assert line.blend_mm == 0.0
    assert line.length_mm == pytest.approx(math.hypot(100, 30), abs=0.01)


def test_a_turn_on_the_spot_is_one_line_without_a_speed() -> None:
    approach, reference = leaning([0.0, math.pi / 2], 0.5)
    line, _ = lines_of(
        spray([[0, 0, 50], [0, 0, 50]], 60.0, (approach, reference)),
        spray([[0, 0, 50], [20, 0, 50]], 60.0, (approach[[1, 1]], reference[[1, 1]])),
    )
    assert line.speed_mm_s == 0.0
    assert 0.5 * math.pi < math.degrees(line.turn_rad_s) <= LIMITS.rotation_deg_s * 1.001
    assert line.angle_rad > 0.5


def test_the_commanded_speed_changes_where_the_level_begins_or_ends() -> None:
    """60 mm/s, 20 mm/s from x = 30 to 40, 60 mm/s again, on one straight line without a stop."""
    x = [0.0, 30.0, 30.4, 39.6, 40.0, 70.0]
    times = np.cumsum([0.0, 0.5, 0.01, 0.46, 0.01, 0.5]).tolist()
    vertices = find_vertices(track(times, x))
    kept = np.array(x)[vertices.kept].tolist()
    assert kept == [0.0, 30.4, 39.6, 70.0]
    assert vertices.rests.tolist() == [True, False, False, True]


def test_a_lower_level_before_the_stop_is_a_line_of_its_own() -> None:
    x = [0.0, 60.0, 61.0, 81.0]
    vertices = find_vertices(track([0.0, 1.0, 1.025, 2.025], x))
    assert np.array(x)[vertices.kept].tolist() == [0.0, 61.0, 81.0]


def test_a_dip_of_the_speed_is_kept() -> None:
    speeds = [60.0] * 10 + [50.0, 40.0, 30.0, 20.0, 30.0, 40.0, 50.0] + [60.0] * 10
    times = 0.01 * np.arange(len(speeds) + 1)
    x = np.concatenate(([0.0], np.cumsum(0.01 * np.array(speeds))))
    kept = find_vertices(track(times.tolist(), x.tolist())).kept
    inner = kept[1:-1].tolist()
    assert inner
    assert all(10 < at < 17 for at in inner)


def test_the_way_back_on_the_same_line_is_another_line() -> None:
    there, back = np.linspace(0.0, 20.0, 21), np.linspace(19.0, 0.0, 20)
    x = np.concatenate((there, back)).tolist()
    vertices = find_vertices(track((0.02 * np.arange(41)).tolist(), x))
    assert 20 in vertices.kept.tolist()


def test_a_stop_between_two_strokes_is_found_and_a_blended_corner_is_passed() -> None:
    stopped = lines_of(spray([[0, 0, 50], [40, 0, 50]]), transfer([[40, 0, 50], [80, 0, 50]], 60.0))
    assert [line.blend_mm == 0.0 for line in stopped] == [True, True]
    passed = lines_of(spray([[0, 0, 50], [40, 0, 50], [40, 40, 50]], 60.0))
    assert [line.blend_mm == 0.0 for line in passed] == [False] * (len(passed) - 1) + [True]


def test_a_zone_keeps_the_corner_within_the_blend_error_and_away_from_the_next_zone() -> None:
    passed = lines_of(spray([[0, 0, 50], [40, 0, 50], [40, 40, 50], [80, 40, 50]], 60.0))
    for line, after in pairwise(passed):
        assert line.blend_mm <= 0.41 * max(min(line.length_mm, after.length_mm), 0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_moving_the_board_moves_the_lines_and_changes_nothing_else(seed: int) -> None:
    def lines(plan: Plan) -> tuple[Line, ...]:
        return make_motion(time_plan(plan, LIMITS), small_cell()).lines

    plan = random_plan(seed, 6)
    here, there = lines(plan), lines(moved(plan, math.pi / 2, [100.0, -50.0, 7.0]))
    assert len(here) == len(there)
    for one, other in zip(here, there, strict=True):
        assert other.length_mm == pytest.approx(one.length_mm, abs=0.01)
        assert other.speed_mm_s == pytest.approx(one.speed_mm_s, abs=0.5)
        assert (one.blend_mm == 0.0) == (other.blend_mm == 0.0)


def test_the_last_bits_of_a_stop_do_not_matter() -> None:
    def rests(noise: NDArray[np.float64]) -> list[int]:
        seconds = np.linspace(0.0, 0.4, 41)
        ramp = np.where(seconds < 0.2, 250.0 * seconds**2, 20.0 - 250.0 * (0.4 - seconds) ** 2)
        x = np.concatenate((ramp, 20.0 + ramp[1:])) + noise
        times = np.concatenate((seconds, 0.4 + seconds[1:]))
        vertices = find_vertices(track(times.tolist(), x.tolist()))
        return vertices.kept[vertices.rests].tolist()

    rng = np.random.default_rng(3)
    assert rests(np.zeros(81)) == [0, 40, 80]
    assert rests(np.round(rng.uniform(-5e-4, 5e-4, 81), 4)) == [0, 40, 80]


def test_a_slow_start_behind_a_corner_is_no_second_stop() -> None:
    """Joint limits make a robot start gently: the first samples after the corner are slow and far apart in time."""
    y = [0.0, 0.0, 0.0, 0.0, 0.0, 0.015, 0.062, 0.139, 0.247, 0.385, 0.555, 0.755]
    x = [-0.9, -0.55, -0.25, -0.06, 0.0] + [0.0] * 7
    times = np.cumsum([0.0, 0.02, 0.02, 0.02, 0.026, 0.026, 0.016, 0.008, 0.008, 0.008, 0.008, 0.008])
    vertices = find_vertices(track(times.tolist(), x, y))
    assert vertices.kept[vertices.rests].tolist() == [0, 4, 11]


def test_half_a_turn_is_divided_so_that_its_way_is_stated() -> None:
    program = program_of(
        MoveTo(0.0, (0.0, 0.0, 50.0), (0.0, 1.0, 0.0, 0.0), 0.0, "s"),
        MoveTo(1.0, (0.0, 0.0, 50.0), (0.0, 0.0, 1.0, 0.0), 0.0, "s"),
    )
    one, other = make_motion(program, small_cell()).lines
    assert math.degrees(one.angle_rad) == pytest.approx(90.0)
    assert math.degrees(other.angle_rad) == pytest.approx(90.0)
    assert one.blend_mm > 0.0
    assert one.duration_s == pytest.approx(0.5)


def test_a_rounded_corner_is_driven_in_lines_that_are_no_short_moves() -> None:
    """A quarter of a circle of 6.5 mm, slower in its middle, sampled every 15 ms, that the jet turns about with."""
    shares = np.linspace(0.0, 1.0, 17)
    corner = 0.5 * np.pi * (shares - 0.05 * np.sin(2 * np.pi * shares))
    xy = 6.5 * np.column_stack((np.sin(corner), 1.0 - np.cos(corner)))
    tcp = np.vstack(([[-60.0, 0.0]], xy, [[6.5, 66.5]]))
    times = np.concatenate(([0.0], 1.2 + 0.015 * np.arange(17), [2.64]))
    half = 0.5 * np.concatenate(([0.0], corner, [0.5 * np.pi]))
    turned = np.column_stack((np.cos(half), 0 * half, 0 * half, np.sin(half)))
    whole = track(times.tolist(), tcp[:, 0].tolist())
    path = replace(whole, tcp=np.column_stack((tcp, np.full(19, 50.0))), quaternion=turned)
    lines = tracks.lines_of(path, ("",))
    assert len(lines) > 4
    assert min(line.length_mm / line.speed_mm_s for line in lines) >= 0.02
    for line in lines:  # the middle of the circle under each line is near its middle
        middle = np.array(line.pose_at(0.5).position[:2])
        assert abs(np.hypot(middle[0], middle[1] - 6.5) - 6.5) < 0.07 or line.length_mm > 10.0


def bent(times: list[float], x: list[float], y: list[float]) -> Track:
    """A track on which the robot keeps to lines between all samples, and no turning axis goes evenly."""
    return replace(
        track(times, x, y), corner=np.ones(len(x), dtype=np.bool_), share=np.full(len(x), np.nan, dtype=np.float64)
    )


def test_lines_that_a_robot_divides_are_joined_where_they_would_be_short() -> None:
    times = [0.0, 0.5, 0.512, 0.524, 1.0]
    path = bent(times, [0.0, 40.0, 41.0, 42.0, 82.0], [0.0, 0.0, 0.01, 0.03, 1.0])
    assert np.diff(np.array(times)[find_vertices(path).kept]).min() >= 0.02
    even = replace(path, share=np.array([np.nan, np.nan, 1.0, np.nan, np.nan]))
    assert {1, 2} <= set(find_vertices(even).kept.tolist())


def test_a_short_line_at_a_corner_has_time_from_the_long_one_beside_it() -> None:
    """No line may leave out either end of the corner; one that ends farther on may leave out the corner."""
    times = [0.0, 0.3, 0.313, 0.325, 0.36, 0.7]
    x, y = [0.0, 12.0, 12.5, 12.98, 14.38, 28.0], [0.0, 0.0, 0.1, 0.245, 0.665, 4.75]
    kept = find_vertices(bent(times, x, y)).kept
    assert np.diff(np.array(times)[kept]).min() >= 0.02
    assert len(kept) > 3


@pytest.mark.parametrize(("off_deg", "joined"), [(0.3, True), (0.7, False)])
def test_a_short_line_is_joined_where_the_jet_stays_within_half_a_degree(off_deg: float, joined: bool) -> None:
    """A robot that speeds up along a straight line turns the jet faster at first, so that its lines do not fit."""
    times = [0.0, 0.03, 0.047, 0.5]
    x = [0.0, 0.5, 1.0, 20.0]
    half = 0.5 * np.radians([0.0, 1.25 + off_deg, 2.5, 60.0])  # the first two lines as one would be at 1.25 there
    turned = np.column_stack((np.cos(half), np.sin(half), 0 * half, 0 * half))
    path = replace(bent(times, x, [0.0] * 4), quaternion=turned)
    lasting = np.diff(np.array(times)[find_vertices(path).kept])
    assert (lasting.min() >= 0.02) == joined


def test_a_line_of_20_ms_is_commanded_its_own_time() -> None:
    path = track([0.0, 0.4, 0.41, 0.4205, 0.9], [0.0, 20.0, 20.6, 21.0, 21.0], [0.0, 0.0, 0.0, 0.0, 20.0])
    path = replace(path, corner=np.array([True, True, False, True, True]))
    short = next(line for line in tracks.lines_of(path, (Source(0),)) if 0.02 < line.duration_s < 0.021)
    assert short.length_mm / short.speed_mm_s == pytest.approx(short.duration_s)
