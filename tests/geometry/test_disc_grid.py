import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.disc_grid import build_disc_grid

COUNT = 40


@given(seed=st.integers(0, 2**32 - 1), reach=st.floats(0.01, 300.0), share_open=st.sampled_from([0.0, 0.2, 1.0]))
@settings(max_examples=60)
def test_every_disc_that_reaches_a_place_is_found_there_in_order(seed, reach, share_open):
    rng = np.random.default_rng(seed)
    places = rng.uniform(-50, 70, (30, 2)) * [1.0, rng.choice([0.0, 0.3, 2.0])]
    centres, radii = rng.uniform(-150, 170, (COUNT, 2)), rng.uniform(0, reach, COUNT)
    radii[rng.random(COUNT) < share_open] = np.inf
    radii[::7] = -1.0
    centres[np.isinf(radii)] = np.nan  # a disc without end has no middle
    grid = build_disc_grid(centres, radii, places)
    for x, y in places:
        found = grid.near(x, y)
        assert np.all(np.diff(found) > 0)
        away = np.hypot(centres[:, 0] - x, centres[:, 1] - y)
        needed = np.flatnonzero((away <= radii) | np.isinf(radii))
        assert set(needed) <= set(found.tolist()) <= set(np.flatnonzero(radii >= 0.0).tolist())


def test_small_discs_on_a_large_plane_are_not_looked_at_from_everywhere():
    """What a place costs depends on the discs around it, not on how many there are."""
    side = np.arange(0.0, 1000.0, 5.0)
    centres = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    grid = build_disc_grid(centres, np.full(len(centres), 40.0), centres)
    around = np.pi * 40.0**2 / 25.0
    assert len(grid.near(500.0, 500.0)) < 2.5 * around
    assert len(grid.disc) < 30 * len(centres)


@pytest.mark.parametrize("count", [0, 3])
def test_one_place_and_discs_beside_it(count):
    grid = build_disc_grid(np.full((count, 2), 9.0), np.ones(count), np.zeros((1, 2)))
    assert len(grid.near(0.0, 0.0)) == 0
