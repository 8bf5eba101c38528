"""Following rays and adding up exactly give the same."""

import numpy as np
import pytest
from shapely import box
from small_boards import part
from small_sprays import CONE, FAN, KNIFE, LOPSIDED, RING, downward, samples_of, solid_board, sprayed, stage_of

from cleaning.exposure.exact import exact_exposure
from cleaning.exposure.exposure import expose
from cleaning.surface.facets import build_facets, build_scene

SQUARE = box(-40, -40, 40, 40, ccw=True)
BOARD = solid_board(part("T1", 8, -6, 8, 12, 12.0), outline=SQUARE)
SCENE = build_scene(BOARD)
FACETS = build_facets(BOARD, SCENE)
UP = FACETS.cell_exposed & (FACETS.cell_normals[:, 2] > 0.9)
NAMES = ("volume_mm", "cone_s", "front_s", "impulse_n_pa_s", "impulse_t_pa_s")


def drift(tilt):
    """Poses that wander a little, so that no cell sees only the edge of the ring."""
    x = np.linspace(-12, 6, 120)
    return samples_of(np.column_stack([x, 3 * np.sin(x), np.full(120, 24.0)]), downward(tilt), seconds=0.05)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("nozzle", "use", "tilt"),
    [
        (RING, "wash", 0),
        (RING, "wash", 30),
        (LOPSIDED, "rinse", 15),
        (CONE, "wash", 20),
        (FAN, "wash", 10),
        (KNIFE, "dry", 20),
    ],
)
def test_rays_agree_with_the_integral(nozzle, use, tilt):
    stage = stage_of(drift(tilt), nozzle, use)
    jet = sprayed(stage)
    cells = np.flatnonzero(UP)
    rays = expose(stage, jet, FACETS, SCENE, 900)
    exact = exact_exposure(stage, jet, FACETS, SCENE, cells)
    areas = FACETS.cell_areas_mm2[cells]
    for name in NAMES:
        found, known = getattr(rays, name)[cells], getattr(exact, name)
        # A fan is half as thick here as the facets are wide: its integral is no better.
        close = 0.015 if nozzle is FAN else 6e-3
        assert (found * areas).sum() == pytest.approx((known * areas).sum(), rel=close)
        many = (rays.hits[cells] >= 150) & (known > 0.2 * known.max())
        if np.any(many):
            assert np.std(found[many] / known[many]) < 0.13


@pytest.mark.slow
def test_on_a_plate_there_is_no_bias():
    plate = solid_board(outline=SQUARE)
    scene = build_scene(plate)
    facets = build_facets(plate, scene)
    stage = stage_of(drift(0))
    jet = sprayed(stage)
    middle = np.hypot(*facets.cell_centres[:, :2].T) < 20
    cells = np.flatnonzero(facets.cell_exposed & (facets.cell_normals[:, 2] > 0.9) & middle)
    rays, exact = expose(stage, jet, facets, scene, 3000), exact_exposure(stage, jet, facets, scene, cells)
    areas = facets.cell_areas_mm2[cells]
    whole = (rays.volume_mm[cells] * areas).sum() / (exact.volume_mm * areas).sum()
    assert whole == pytest.approx(1.0, abs=1e-3)
    # No worse than rays that fall at random.
    errors = (rays.volume_mm[cells] / exact.volume_mm - 1) * np.sqrt(rays.hits[cells])
    assert np.sqrt(np.mean(errors**2)) < 1.1
    assert np.median(rays.peak_pa[cells] / exact.peak_pa) == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_both_see_the_same_shadow():
    stage = stage_of(samples_of([[-10.0, 0.0, 8.0]] * 40, downward(50.0)))
    jet = sprayed(stage)
    behind = UP & (FACETS.cell_component == -1) & (FACETS.cell_centres[:, 0] > 19)
    behind &= np.abs(FACETS.cell_centres[:, 1]) < 4
    cells = np.flatnonzero(behind)
    rays, exact = expose(stage, jet, FACETS, SCENE, 500), exact_exposure(stage, jet, FACETS, SCENE, cells)
    assert len(cells) > 30
    assert np.all(exact.volume_mm == 0)
    assert np.all(exact.cone_s == 0)
    assert np.all(rays.hits[cells] == 0)


def test_cells_are_given_in_the_order_that_they_were_chosen():
    stage = stage_of(drift(0))
    jet = sprayed(stage)
    cells = np.flatnonzero(UP)[::40]
    forth, back = (
        exact_exposure(stage, jet, FACETS, SCENE, cells),
        exact_exposure(stage, jet, FACETS, SCENE, cells[::-1]),
    )
    assert forth.volume_mm.max() > 0
    np.testing.assert_allclose(back.volume_mm[::-1], forth.volume_mm, rtol=1e-12)
    nothing = exact_exposure(stage, jet, FACETS, SCENE, np.empty(0, dtype=np.int64))
    assert len(nothing.volume_mm) == 0
