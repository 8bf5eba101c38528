"""The judge must catch what is wrong before its silence means anything."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from judge import (
    Track,
    jet_on_at_end,
    read_track,
    spraying_in_transfers,
    times_running_back,
    too_fast,
    too_sharp,
    turning_too_fast,
    turning_too_sharply,
    wrong_stated_speeds,
    wrong_totals,
)
from judge_space import covered_share, segment_triangle_distances, too_close, turns_around, wrong_pauses
from shapely import box
from small_programs import DOWN, hand_program

from programs import native

HAND = native.render(hand_program())
HEAD = "WASHBOARD 1\nTOTALS duration_s 0 spray_s 0 travel_mm 0 moves 0\nBEGIN\n"
PLATE = np.array([[[0, 0, 0], [100, 0, 0], [100, 100, 0]], [[0, 0, 0], [100, 100, 0], [0, 100, 0]]], dtype=float)


def track_of(*lines: str) -> Track:
    return read_track(HEAD + "\n".join(lines) + "\nEND\n")


def move(time_s: float, x: float, y: float = 0.0, z: float = 50.0, speed: float = 0.0, maker: str = "m") -> str:
    return f"{time_s:.4f} MOVE {x:.3f} {y:.3f} {z:.3f} 0 1 0 0 {speed:.3f} ; {maker}"


def trapezoid(acceleration: float, length: float = 60.0, top: float = 60.0) -> list[str]:
    """Rest to rest along x, sampled every 10 ms with times and places as the file rounds them."""
    ramp = top / acceleration
    total = length / top + ramp
    times = np.append(np.arange(0, total, 0.01), np.round(total, 4))
    rising = 0.5 * acceleration * np.minimum(times, ramp) ** 2
    level = top * np.clip(times - ramp, 0, total - 2 * ramp)
    left = np.clip(times - (total - ramp), 0, ramp)
    x = rising + level + top * left - 0.5 * acceleration * left**2
    return [move(t, at) for t, at in zip(times.tolist(), x.tolist(), strict=True)]


def test_a_good_program_passes_every_check() -> None:
    track = read_track(HAND)
    assert times_running_back(track) == []
    assert wrong_totals(track) == []
    assert too_fast(track, {"clean": 51.0}) == []
    assert wrong_stated_speeds(track) == []
    assert turning_too_fast(track, 15.0) == []
    assert spraying_in_transfers(track) == []
    assert jet_on_at_end(track) == []


def test_time_running_back_is_caught() -> None:
    assert times_running_back(read_track(HAND.replace("3.2000 SPRAY OFF", "3.1000 SPRAY OFF")))
    assert times_running_back(read_track(HAND.replace("WAIT 0.2000", "WAIT 1.4000")))


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("duration_s 4.2", "duration_s 4.3"),
        ("spray_s 2.2", "spray_s 2.3"),
        ("mm 150", "mm 151"),
        ("moves 5", "moves 6"),
    ],
)
def test_wrong_totals_are_caught(before: str, after: str) -> None:
    assert len(wrong_totals(read_track(HAND.replace(before, after)))) == 1


def test_speed_above_the_functions_maximum_is_caught() -> None:
    lines = ["0.0 FUNCTION clean ; s", move(0, 0), move(1, 100.2), "1.0 FUNCTION dry ; s", move(2, 280.2)]
    assert len(too_fast(track_of(*lines), {"clean": 100, "dry": 180})) == 1
    assert too_fast(track_of(*lines), {"clean": 100.15, "dry": 180}) == []
    assert len(too_fast(track_of(move(0, 0), move(0, 5)), {"": 100})) == 1, "a jump is infinitely fast"


def test_a_pause_does_not_make_a_segment_slower() -> None:
    lines = ["0.0 FUNCTION clean ; s", move(0, 0), "0.0 WAIT 1.0 ; s", move(2, 100)]
    assert too_fast(track_of(*lines), {"clean": 99}), "100 mm in the one second that is left"


def test_a_wrong_stated_speed_is_caught() -> None:
    assert len(wrong_stated_speeds(read_track(HAND.replace(" 20.000   ;", " 19.900   ;")))) == 1


@pytest.mark.parametrize("acceleration", [100.0, 500.0, 2000.0])
def test_acceleration_is_measured_through_the_rounding(acceleration: float) -> None:
    track = track_of(*trapezoid(acceleration))
    assert too_sharp(track, acceleration) == []
    assert too_sharp(track, 0.85 * acceleration) != []


def test_a_corner_taken_at_speed_is_caught() -> None:
    track = track_of(move(0, 0), move(1, 60), move(2, 60, 60))
    assert too_sharp(track, 50.0)
    assert too_sharp(track, 150.0) == [], "poses a second apart do not say more"


def turn(time_s: float, degrees: float) -> str:
    half = math.radians(degrees) / 2
    return f"{time_s:.4f} MOVE 0 0 50 {math.sin(half):.7f} {math.cos(half):.7f} 0 0 0 ; m"


def test_turning_too_fast_is_caught() -> None:
    track = track_of(turn(0, 0), turn(0.5, 30))
    assert turning_too_fast(track, 61) == []
    assert len(turning_too_fast(track, 59)) == 1


def test_turning_too_sharply_is_caught() -> None:
    times = np.arange(0, 1.0001, 0.02)
    degrees = np.where(times < 0.5, 100 * times**2, 50 - 100 * (1 - times) ** 2)
    track = track_of(*(turn(t, d) for t, d in zip(times.tolist(), degrees.tolist(), strict=True)))
    assert turning_too_sharply(track, 200) == []
    assert turning_too_sharply(track, 180) != []


def test_a_jet_that_is_on_in_a_transfer_is_caught() -> None:
    wet = read_track(HAND.replace("1.0000 SPRAY ON", "0.5000 SPRAY ON").replace("1.0000 MOVE 10", "1.0000 MOVE 10"))
    assert len(spraying_in_transfers(wet)) == 1
    late = HAND.replace("3.2000 SPRAY OFF                                        ; sequence[0]/edge\n", "")
    assert len(spraying_in_transfers(read_track(late))) == 1
    assert jet_on_at_end(read_track(late)) == ["the jet is on at the end"]


def test_the_orifice_too_close_to_a_triangle_is_caught() -> None:
    above = track_of(move(0, -50, 50, 10), move(1, 150, 50, 10))
    assert too_close(above, PLATE, 9.99) == []
    assert too_close(above, PLATE, 10.01) != []
    through = track_of(move(0, 30, 50, 10), move(1, 30, 50, -10))
    assert too_close(through, PLATE, 0.1) != []
    beside = track_of(move(0, 105, 50, -30), move(1, 105, 50, 30))
    assert too_close(beside, PLATE, 4.99) == []
    assert len(too_close(beside, PLATE, 5.01)) == 2, "both pieces that touch the height of the plate"


def test_below_the_board_counts_as_above() -> None:
    below = track_of(move(0, 10, 50, -8), move(1, 90, 50, -8))
    assert too_close(below, PLATE, 7.9) == []
    assert too_close(below, PLATE, 8.1) != []


COORDINATES = st.lists(st.floats(-10, 10), min_size=15, max_size=15)


@pytest.mark.slow
@settings(max_examples=60)
@given(numbers=COORDINATES)
def test_the_distance_is_that_of_the_closest_samples(numbers: list[float]) -> None:
    points = np.array(numbers).reshape(5, 3)
    distance = segment_triangle_distances(points[None, 0], points[None, 1], points[None, 2:])[0]
    share = np.linspace(0, 1, 41)
    on_segment = points[0] + share[:, None] * (points[1] - points[0])
    u, v = (part.ravel() for part in np.meshgrid(share, share))
    u, v = u[u + v <= 1], v[u + v <= 1]
    on_triangle = points[2] + u[:, None] * (points[3] - points[2]) + v[:, None] * (points[4] - points[2])
    sampled = np.linalg.norm(on_segment[:, None] - on_triangle[None], axis=2).min()
    spacing = np.linalg.norm(np.ptp(points, axis=0)) / 40
    assert distance <= sampled + 1e-6
    assert distance >= sampled - 2 * spacing - 1e-6


def ring(laps: float, maker: str, sense: float = 1.0) -> list[str]:
    angles = np.linspace(0, laps * 2 * math.pi, int(24 * laps) + 1) * sense
    return [move(i, 10 * math.cos(a), 10 * math.sin(a), maker=maker) for i, a in enumerate(angles.tolist())]


def test_turns_around_a_component_are_counted() -> None:
    lines = [move(0, 10, maker="s/around/U1/transfer"), *ring(2, "s/around/U1+C3")]
    centres = {"U1": (2.0, 1.0), "C3": (30.0, 0.0), "R1": (0.0, 0.0)}
    turns = turns_around(track_of(*lines), "s/around", centres)
    assert turns["U1"] == pytest.approx(2.0, abs=1e-6)
    assert turns["C3"] == pytest.approx(0.0, abs=1e-6), "named, but not circled"
    assert "R1" not in turns


def test_a_ring_that_is_not_closed_is_no_turn() -> None:
    assert turns_around(track_of(*ring(1.75, "s/around/U1")), "s/around", {"U1": (0, 0)})["U1"] < 1.8


def raster(pitch: float) -> Track:
    lines = ["0 SPRAY ON ; s/sweep"]
    for row, y in enumerate(np.arange(pitch / 2, 100, pitch).tolist()):
        ends = (0, 100) if row % 2 == 0 else (100, 0)
        lines += [move(2 * row + i, x, y, maker="s/sweep") for i, x in enumerate(ends)]
    return track_of(*lines)


def test_a_raster_without_gaps_covers_and_one_with_gaps_does_not() -> None:
    reach = 50 * math.tan(math.radians(15))  # the cone's radius on the plate

    def share(pitch: float) -> float:
        return covered_share(raster(pitch), lambda maker: maker == "s/sweep", 15.0, 0.0, box(0, 0, 100, 100))

    assert share(20.0) == pytest.approx(1.0, abs=1e-9)
    # Rows at 30 and 90 mm: two stripes of 2 r and, between them, the way from one row to the next at the right end.
    stripes = (2 * reach + min(100 - 90, reach) + reach) / 100
    assert stripes <= share(60.0) < 0.9


def test_what_is_dry_covers_nothing() -> None:
    dry = replace(raster(20.0), on=[])
    assert covered_share(dry, lambda _: True, 15.0, 0.0, box(0, 0, 100, 100)) == 0.0


def step_line(*pauses: float) -> Track:
    lines = [move(0, 0, maker="s/step"), "0 SPRAY ON ; s/step"]
    for number, x in enumerate(pauses, start=1):
        lines += [move(2 * number, x, maker="s/step"), f"{2 * number}.0 WAIT 0.5 ; s/step/U1"]
    return track_of(*lines, move(60, 100, maker="s/step"))


def test_a_pause_at_each_edge_crossed_is_right_and_nothing_else() -> None:
    outlines = {"U1": box(20, -5, 40, 5), "U2": box(60, -5, 61, 5), "far": box(0, 50, 100, 60)}
    assert wrong_pauses(step_line(20, 40, 60, 61), "s/step", outlines, 0.0) == []
    assert len(wrong_pauses(step_line(20, 40, 60), "s/step", outlines, 0.0)) == 1, "one is missing"
    assert len(wrong_pauses(step_line(20, 40, 50, 60, 61), "s/step", outlines, 0.0)) == 1, "one too many"
    assert len(wrong_pauses(step_line(20, 45, 60, 61), "s/step", outlines, 0.0)) == 1, "one elsewhere"


def test_a_line_along_an_edge_may_count_it_or_not() -> None:
    outlines = {"U1": box(20, -5, 40, 5), "along": box(60, 0, 70, 5)}
    assert wrong_pauses(step_line(20, 40), "s/step", outlines, 0.0) == []
    assert wrong_pauses(step_line(20, 40, 60, 70), "s/step", outlines, 0.0) == []


def test_the_fixed_pose_of_these_tests_points_down() -> None:
    assert DOWN == (0.0, 1.0, 0.0, 0.0)
    np.testing.assert_allclose(track_of(move(0, 0)).approach, [[0, 0, -1]])
