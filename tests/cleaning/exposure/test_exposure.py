"""What reaches surfaces: balances of volume and force, shadows, and what moves with the board."""

import tracemalloc
from dataclasses import replace

import numpy as np
import pytest
from jet_references import footprint
from rigid import Motion
from shapely import box
from small_boards import part
from small_sprays import (
    KNIFE,
    LOPSIDED,
    RING,
    downward,
    moved_board,
    moved_samples,
    samples_of,
    solid_board,
    sprayed,
    stage_of,
)

from cleaning.exposure.exposure import MakerVolumes, expose
from cleaning.surface.facets import build_facets, build_scene
from specs.source import Source

SQUARE = box(-60, -60, 60, 60, ccw=True)
PLATE = solid_board(outline=SQUARE)
PLATE_SCENE = build_scene(PLATE)
PLATE_FACETS = build_facets(PLATE, PLATE_SCENE)
LOADED = solid_board(part("U1", -7, -7, 14, 14, 4.0), part("T1", 25, -10, 10, 20, 18.0), outline=SQUARE)
LOADED_SCENE = build_scene(LOADED)
LOADED_FACETS = build_facets(LOADED, LOADED_SCENE)


def sweep(height=40.0, step=1.0, tilt=0.0):
    """A line over the middle of the plate, there and back."""
    x = np.arange(-30, 30, step)
    lines = [np.column_stack([x[::way], np.full(len(x), y), np.full(len(x), height)]) for way, y in ((1, -8), (-1, 8))]
    return samples_of(np.concatenate(lines), downward(tilt), seconds=0.05)


def on_plate(stage, rays=256):
    return expose(stage, sprayed(stage), PLATE_FACETS, PLATE_SCENE, rays)


def on_loaded(stage, rays=256):
    return expose(stage, sprayed(stage), LOADED_FACETS, LOADED_SCENE, rays)


def whole(values, facets=PLATE_FACETS):
    return float((values * facets.cell_areas_mm2).sum())


@pytest.mark.slow
@pytest.mark.parametrize("nozzle", [RING, LOPSIDED])
@pytest.mark.parametrize("tilt", [0, 15, 30])
def test_all_of_the_volume_lands(nozzle, tilt):
    stage = stage_of(samples_of([[-10.0, 0.0, 25.0]] * 60, downward(tilt)), nozzle)
    found = on_plate(stage)
    assert found.sprayed_mm3 == pytest.approx(sprayed(stage).flow_m3_s * 1e9 * 6.0)
    assert found.landed_mm3 == pytest.approx(found.sprayed_mm3, rel=5e-3)
    assert whole(found.volume_mm) == pytest.approx(found.landed_mm3)


def test_what_misses_the_board_is_not_counted():
    stage = stage_of(samples_of([[-60.0, 0.0, 25.0]] * 60))
    assert on_plate(stage).landed_mm3 == pytest.approx(on_plate(stage).sprayed_mm3 / 2, rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("tilt", [0, 15, 30])
def test_the_plate_takes_up_the_momentum(tilt):
    stage = stage_of(samples_of([[-10.0, 0.0, 25.0]] * 60, downward(tilt)))
    jet, found = sprayed(stage), on_plate(stage)
    forces = {0: 0.6824, 15: 0.6591, 30: 0.5910}
    assert whole(found.impulse_n_pa_s) * 1e-6 / 6.0 == pytest.approx(forces[tilt], rel=5e-3)
    momentum = jet.density_kg_m3 * jet.speed_m_s * jet.flow_m3_s * 6.0
    normal, along = whole(found.impulse_n_pa_s) * 1e-6, whole(found.impulse_t_pa_s) * 1e-6
    assert np.hypot(normal, along) <= momentum * 1.005
    assert normal + along > momentum


@pytest.mark.parametrize("tilt", [0, 20])
def test_time_in_the_cone_covers_its_ellipse(tilt):
    stage = stage_of(samples_of([[-10.0, 0.0, 25.0]] * 60, downward(tilt)))
    jet, found = sprayed(stage), on_plate(stage)
    ellipse = footprint(jet.half_angle + 2 * jet.sigma, np.radians(tilt), 25.0)
    area = np.pi * ellipse.semi_major * ellipse.semi_minor
    assert whole(found.cone_s) == pytest.approx(area * 6.0, rel=0.01)
    middle = np.array([-10.0 + ellipse.centre, 0.0, 0.0])
    inside = np.linalg.norm(PLATE_FACETS.cell_centres - middle, axis=1) < 0.8 * ellipse.semi_minor
    inside &= PLATE_FACETS.cell_normals[:, 2] > 0.9
    assert whole(found.cone_s * inside) == pytest.approx(whole(inside) * 6.0, rel=0.02)
    assert whole(found.front_s) < 0.85 * whole(found.cone_s)


def test_no_stress_is_above_the_peak_of_the_formula():
    found = on_plate(stage_of(samples_of([[0.0, 0.0, 50.0]] * 60)))
    assert 0.97 * 330 < found.peak_pa.max() <= 330.5


def test_more_spraying_never_gives_less():
    samples = sweep()
    half = len(samples.times) // 2
    fields = ("times", "seconds", "tcp", "axes", "made_by")
    shorter = replace(samples, **{name: getattr(samples, name)[:half] for name in fields})
    some, more = on_loaded(stage_of(shorter)), on_loaded(stage_of(samples))
    for name in ("volume_mm", "cone_s", "front_s", "peak_pa", "impulse_n_pa_s", "impulse_t_pa_s", "hits"):
        assert np.all(getattr(more, name) >= getattr(some, name) - 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("motion", [Motion(90.0, (0, 0, 0)), Motion(37.0, (40.0, -200.0, 5.0))])
def test_a_moved_board_under_a_moved_nozzle_gets_the_same(motion):
    samples = sweep(tilt=20.0)
    here = on_loaded(stage_of(samples))
    board = moved_board(LOADED, motion)
    scene = build_scene(board)
    stage = stage_of(moved_samples(samples, motion))
    there = expose(stage, sprayed(stage), build_facets(board, scene), scene, 256)
    assert there.landed_mm3 == pytest.approx(here.landed_mm3, rel=1e-4)
    sure = here.hits >= 30
    np.testing.assert_allclose(there.volume_mm[sure], here.volume_mm[sure], rtol=0.1)
    assert np.isclose(there.volume_mm[sure], here.volume_mm[sure], rtol=1e-6).mean() > 0.9


def test_behind_a_tall_part_it_stays_dry():
    stage = stage_of(samples_of([[0.0, 0.0, 12.0]] * 60, downward(45.0)))
    found = on_loaded(stage)
    centres, up = LOADED_FACETS.cell_centres, LOADED_FACETS.cell_normals[:, 2] > 0.9
    bare = up & (LOADED_FACETS.cell_component == -1) & (np.abs(centres[:, 1]) < 8)
    assert np.all(found.hits[bare & (centres[:, 0] > 37)] == 0)
    assert found.volume_mm[bare & (centres[:, 0] > 10) & (centres[:, 0] < 23)].mean() > 0.1
    assert found.volume_mm[LOADED_FACETS.cell_component == 1].sum() > 0


def test_nothing_gets_to_undersides_and_the_other_side():
    found = on_loaded(stage_of(sweep()))
    down = LOADED_FACETS.cell_normals[:, 2] < -0.9
    assert whole(np.where(down, found.volume_mm, 0), LOADED_FACETS) < 1e-3 * found.landed_mm3


def test_from_below_the_other_side_gets_the_same():
    flat = stage_of(samples_of([[0.0, 0.0, 40.0]] * 60))
    below = replace(flat, samples=samples_of([[0.0, 0.0, -41.6]] * 60, np.eye(3)))
    over, under = on_plate(flat), on_plate(below)
    up = PLATE_FACETS.cell_normals[:, 2] > 0.9
    down = PLATE_FACETS.cell_normals[:, 2] < -0.9
    assert whole(over.volume_mm * up) == pytest.approx(whole(under.volume_mm * down), rel=1e-3)
    assert whole(under.volume_mm * up) == 0


def test_the_volume_grows_to_what_it_is_in_the_end():
    stage = stage_of(sweep())
    found = on_loaded(stage)
    growth = found.growth
    assert len(growth.until_s) == 120  # one for each sample: there are fewer than blocks
    assert growth.until_s[-1] == pytest.approx(stage.end_s)
    assert np.all(np.diff(growth.until_s) > 0)
    assert growth.start[-1] == len(growth.cell)
    summed = np.bincount(growth.cell, growth.volume_mm, len(found.volume_mm))
    np.testing.assert_allclose(summed, found.volume_mm, rtol=1e-4, atol=1e-6)


def test_who_sprays_what():
    samples = sweep()
    first = np.arange(len(samples.times)) < len(samples.times) // 2
    samples = replace(
        samples, made_by=np.where(first, 1, 0), makers=tuple(map(Source.parse, ("later", "sooner", "never")))
    )
    found = on_loaded(stage_of(samples))
    by_maker = found.by_maker_mm3.toarray()
    assert by_maker.shape == (len(LOADED.components) + 1, 3)
    assert by_maker.sum() == pytest.approx(found.landed_mm3)
    assert np.all(by_maker[:, 2] == 0)
    for index, row in enumerate(by_maker[:-1]):
        mine = LOADED_FACETS.cell_component == index
        assert row.sum() == pytest.approx(whole(found.volume_mm * mine, LOADED_FACETS))
    # The lines are mirror images, and so is the part in the middle.
    assert by_maker[0, 0] == pytest.approx(by_maker[0, 1], rel=0.03)


def test_gas_presses_and_leaves_nothing():
    stage = stage_of(samples_of([[0.0, 0.0, 40.0]] * 60), KNIFE, "dry", 4.0)
    found = on_loaded(stage)
    assert found.landed_mm3 == 0
    assert np.all(found.volume_mm == 0)
    assert len(found.growth.cell) == 0
    top = (LOADED_FACETS.cell_component == 0) & (LOADED_FACETS.cell_normals[:, 2] > 0.9)
    assert found.peak_pa[top].max() > 500
    assert found.cone_s[top].max() > 1


def test_a_stage_without_spraying_leaves_nothing():
    found = on_loaded(stage_of(samples_of(np.empty((0, 3)))))
    assert found.rays == 0
    assert found.sprayed_mm3 == 0
    assert np.all(found.cone_s == 0)
    assert found.growth.start.tolist() == [0]


def test_the_same_again():
    stage = stage_of(sweep(tilt=10.0))
    one, other = on_loaded(stage, 64), on_loaded(stage, 64)
    for name in ("volume_mm", "cone_s", "front_s", "peak_pa", "hits"):
        assert np.array_equal(getattr(one, name), getattr(other, name))


def test_rows_go_on_where_they_stopped():
    volumes = MakerVolumes(makers=4, components=2)
    for makers, given in (([0, 2], [[1.0, 0.0, 2.0], [0.0, 3.0, 0.0]]), ([2, 3], [[0.5, 0.25, 0.0], [0.0, 0.0, 0.0]])):
        rows = volumes.of(np.array(makers))
        rows += given
        volumes.keep(np.array(makers), rows)
    expected = [[1.0, 0.0, 0.5, 0.0], [0.0, 0.0, 3.25, 0.0], [2.0, 0.0, 0.0, 0.0]]
    np.testing.assert_array_equal(volumes.by_component().toarray(), expected)


def test_makers_and_components_that_do_not_meet_take_no_memory():
    count, together = 3000, 50
    volumes = MakerVolumes(makers=count, components=count)
    tracemalloc.start()
    for first in range(0, count, together):
        makers = np.arange(first, first + together)
        rows = volumes.of(makers)
        rows[np.arange(together), makers] = 1.0
        volumes.keep(makers, rows)
    found = volumes.by_component()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.sum() == count
    assert peak < 8 * count * count / 10  # a tenth of a table of all
