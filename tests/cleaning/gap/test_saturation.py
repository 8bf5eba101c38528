"""What liquid carries at the end of its way."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.gap.grid import mobility_of, plain_grid
from cleaning.gap.hele_shaw import Flow, Rim, solve
from cleaning.gap.saturation import saturation, saturation_in

HEIGHT = 50e-6
VISCOSITY = 0.6e-3


def flow_at(speed: float, cells: int, length: float = 7e-3) -> tuple[Flow, float]:
    """Flow through a rectangle at a mean speed, and the area of one cell."""
    grid = plain_grid(np.full((4, cells), mobility_of(HEIGHT)), length / cells, 1e-3)
    return solve(grid, Rim(12 * VISCOSITY * length * speed / HEIGHT**2, 0.0)), grid.dx_m * grid.dy_m


@pytest.mark.parametrize(("speed", "expected"), [(0.248e-3, 0.9405), (2.48e-3, 0.2459), (24.8e-3, 0.0278)])
def test_slow_liquid_saturates(speed: float, expected: float) -> None:
    assert saturation(5e-6, 7e-3, speed, HEIGHT) == pytest.approx(expected, rel=2e-3)
    flow, area = flow_at(speed, 32)
    cells, end = saturation_in(flow, area, 5e-6, VISCOSITY)
    assert end == pytest.approx(saturation(5e-6, 7e-3, speed, HEIGHT), rel=1e-9)
    ways = (np.arange(32) + 1) * 7e-3 / 32
    np.testing.assert_allclose(cells[0], np.tile(saturation(5e-6, ways, speed, HEIGHT), (4, 1)), rtol=1e-9)


@settings(deadline=None, max_examples=20)
@given(
    speed=st.floats(1e-5, 1.0), dissolving=st.floats(1e-8, 1e-4), cells=st.integers(1, 30), length=st.floats(1e-3, 0.02)
)
def test_any_way(speed: float, dissolving: float, cells: int, length: float) -> None:
    flow, area = flow_at(speed, cells, length)
    _, end = saturation_in(flow, area, dissolving, VISCOSITY)
    assert end == pytest.approx(saturation(dissolving, length, speed, HEIGHT), rel=1e-7)


def test_every_flow_stays_between_fresh_and_saturated_and_faster_ones_are_fresher() -> None:
    drawn = np.random.default_rng(5)
    mobility = mobility_of(HEIGHT) * (drawn.random((15, 15)) > 0.2)
    grid = plain_grid(mobility, 0.3e-3, 0.3e-3)
    rim = np.array([[100.0], [1000.0]]) * drawn.random((1, 15))
    cells, ends = saturation_in(solve(grid, Rim(left=rim, back=0.0)), 0.09e-6, 5e-6, VISCOSITY)
    assert (cells >= -1e-12).all()
    assert (cells <= 1 + 1e-12).all()
    assert 0 < ends[1] < ends[0] < 1


def test_liquid_that_stands_still_is_saturated() -> None:
    cells, ends = saturation_in(solve(plain_grid(np.ones((3, 3)), 1.0, 1.0), Rim(left=2.0)), 1.0, 1.0, 1.0)
    assert (cells == 1).all()
    assert (ends == 1).all()
