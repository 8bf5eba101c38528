"""Lines of a hollow cone lie where the board gets the most of what it gets least of."""

from dataclasses import replace

import numpy as np
import pytest
from shapely import box
from sites import CONE, site_on
from small_boards import board_of, l_shape

from recipes.nozzles import FullCone
from recipes.paths import FinalFlush, Raster, StepFunction
from rulesengine.paths.final_flush import plan_final_flush
from rulesengine.paths.parallel_lines import MOST_LINES
from rulesengine.paths.raster import plan_raster
from rulesengine.paths.step_function import plan_step_function
from rulesengine.strokes.stroke import PlanCache

BOARD = box(0, 0, 100, 80)
SWEEP = Raster(height_mm=54, speed_mm_s=60, margin_mm=3)


def lines_across(strokes, axis=1):
    return np.unique(np.round(np.concatenate([stroke.tcp[:, axis] for stroke in strokes]), 6))


def deposit(strokes, places):
    """Seconds times rays of an ideal ring per place, thrown one by one from poses along the strokes."""
    rng = np.random.default_rng(7)
    count, near_mm = 100_000, 4.0
    strokes = [stroke for stroke in strokes if len(stroke.tcp) > 1]
    begin = np.concatenate([stroke.tcp[:-1, :2] for stroke in strokes])
    end = np.concatenate([stroke.tcp[1:, :2] for stroke in strokes])
    lengths = np.linalg.norm(end - begin, axis=1)
    piece = rng.choice(len(lengths), count, p=lengths / lengths.sum())
    feet = begin[piece] + rng.random((count, 1)) * (end - begin)[piece]
    polar = np.radians(rng.normal(CONE.half_angle_deg, CONE.ring_sigma_deg, count))
    around = rng.uniform(0, 2 * np.pi, count)
    radius = strokes[0].tcp[0, 2] * np.tan(polar)
    spots = feet + radius[:, None] * np.column_stack([np.cos(around), np.sin(around)])
    weights = np.sin(polar) * lengths.sum() / count
    return np.array([weights[np.abs(spots - place).max(axis=1) < near_mm].sum() for place in places])


def least_tenth_and_evenness(strokes):
    x, y = np.meshgrid(np.arange(4, 100, 8.0), np.arange(4, 80, 8.0))
    got = np.sort(deposit(strokes, np.column_stack([x.ravel(), y.ravel()])))
    return got[: len(got) // 10].mean(), np.percentile(got, 5) / got.mean()


@pytest.mark.slow
@pytest.mark.parametrize("direction", [0.0, 90.0])
def test_the_least_tenth_of_the_board_gets_more_than_by_even_lines_and_it_is_more_even(direction):
    site = site_on(board_of(outline=BOARD))
    spec = SWEEP.model_copy(update={"direction_deg": direction})
    by_ring = plan_raster(spec, site).strokes
    # A stated pitch lays even lines; of these as many.
    axis = 1 if direction == 0 else 0
    count = len(lines_across(by_ring, axis))
    width = (74.0 if direction == 0 else 94.0) / count
    even = plan_raster(spec.model_copy(update={"pitch_mm": width}), site).strokes
    assert np.diff(lines_across(even, axis)) == pytest.approx(width)
    (least, evenness), (even_least, even_evenness) = map(least_tenth_and_evenness, (by_ring, even))
    assert least > 1.3 * even_least
    assert evenness > 1.2 * even_evenness


@pytest.mark.slow
def test_what_both_sides_and_several_templates_share_is_what_each_finds_alone():
    board, shared = board_of(outline=BOARD), PlanCache()
    for side in ("top", "bottom"):
        for height, direction in ((54.0, 0.0), (54.0, 30.0), (40.0, 30.0)):
            spec = SWEEP.model_copy(update={"height_mm": height, "direction_deg": direction})
            together, alone = (
                plan_raster(spec, replace(site_on(board, side=side), cache=cache)).strokes
                for cache in (shared, PlanCache())
            )
            assert [each.tcp.tolist() for each in together] == [each.tcp.tolist() for each in alone]
    assert len(shared.known) == 3


def test_lines_stay_symmetric_and_their_rings_reach_the_edge():
    lines = lines_across(plan_raster(SWEEP, site_on(board_of(outline=BOARD))).strokes)
    assert lines.mean() == pytest.approx(40)
    radius = 54 * np.tan(np.radians(30))
    assert lines.min() - radius <= 3 + 1e-6
    assert np.ptp(lines) < 37  # two even lines would lie half of the 74 mm apart


def test_step_function_goes_by_the_ring_and_a_flush_stays_even():
    site = site_on(board_of(outline=BOARD))
    keys = {"height_mm": 54, "speed_mm_s": 60}
    step = lines_across(plan_step_function(StepFunction(**keys), site).strokes)
    flush = lines_across(plan_final_flush(FinalFlush(**keys), site).strokes)
    assert len(step) == len(flush) == 2
    assert np.diff(flush) == pytest.approx(40)
    assert np.ptp(step) < 0.8 * np.ptp(flush)


@pytest.mark.parametrize(
    ("nozzle", "keys"),
    [
        (FullCone(half_angle_deg=30, flow_lpm=2), {}),
        (CONE, {"pitch_mm": 37}),
        (CONE, {"height_mm": 3.5}),  # too many lines for the rim to matter
    ],
)
def test_lines_are_even_for_other_nozzles_stated_pitches_and_many_lines(nozzle, keys):
    spec = SWEEP.model_copy(update=keys)
    lines = lines_across(plan_raster(spec, site_on(board_of(outline=BOARD), nozzle=nozzle)).strokes)
    gaps = np.diff(lines)
    assert gaps == pytest.approx(74.0 / len(lines))
    assert "height_mm" not in keys or len(lines) > MOST_LINES


def test_it_is_the_same_every_time_on_a_slanted_outline():
    site = site_on(board_of(outline=l_shape(100.0)))
    spec = Raster(height_mm=40, speed_mm_s=60, direction_deg=30)
    first, second = (plan_raster(spec, site).strokes for _ in range(2))
    assert [stroke.tcp.tobytes() for stroke in first] == [stroke.tcp.tobytes() for stroke in second]
