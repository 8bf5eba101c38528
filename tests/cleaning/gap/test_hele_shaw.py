"""The flow between given pressures, against exact solutions."""

import numpy as np
import pytest
from gap_references import plain_grid
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from cleaning.errors import CleaningError
from cleaning.gap.hele_shaw import Apertures, Grid, Rim, mobility_of, narrowed_grid, solve

HEIGHT = 50e-6
VISCOSITY = 0.6e-3


def even_grid(length: float, width: float, rows: int, columns: int, height: float = HEIGHT) -> Grid:
    return plain_grid(np.full((rows, columns), mobility_of(height)), length / columns, width / rows)


@pytest.mark.parametrize(("rows", "columns"), [(4, 4), (20, 20), (7, 33), (64, 64)])
def test_a_rectangle_fed_from_one_end_is_poiseuille_flow(rows: int, columns: int) -> None:
    flow = solve(even_grid(7e-3, 5e-3, rows, columns), Rim(left=500.0, right=0.0))
    volume_flow = flow.inflow[0, 0] / VISCOSITY
    assert volume_flow == pytest.approx(6.200396825396825e-9, rel=1e-9)
    velocity = volume_flow / (5e-3 * HEIGHT)
    assert velocity == pytest.approx(0.0248015873, rel=1e-9)
    assert 6.0 * VISCOSITY * velocity / HEIGHT == pytest.approx(1.785714286, rel=1e-9)


@settings(max_examples=25)
@given(
    length=st.floats(0.2e-3, 50e-3),
    width=st.floats(0.2e-3, 50e-3),
    height=st.floats(10e-6, 250e-6),
    pressure=st.floats(-5e3, 5e3).filter(lambda value: abs(value) > 1e-3),
    columns=st.integers(1, 30),
)
def test_any_rectangle(length: float, width: float, height: float, pressure: float, columns: int) -> None:
    flow = solve(even_grid(length, width, 5, columns, height), Rim(front=pressure, back=0.0))
    exact = height**3 * pressure * length / (12.0 * width)
    assert flow.inflow[0] == pytest.approx([0.0, 0.0, exact, -exact], rel=1e-9, abs=1e-9 * abs(exact))


@pytest.mark.parametrize("cells", [8, 40])
def test_pressure_linear_on_the_rim_is_linear_inside(cells: int) -> None:
    def pressure(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        return 100.0 + 3e4 * x + 2.2e4 * y

    grid = even_grid(7e-3, 5e-3, cells, cells)
    x, y = grid.centres
    edge, end = np.full(cells, 3.5e-3), np.full(cells, 2.5e-3)
    rim = Rim(pressure(-edge, y[:, 0]), pressure(edge, y[:, 0]), pressure(x[0], -end), pressure(x[0], end))
    assert np.abs(solve(grid, rim).pressure[0] - pressure(x, y)).max() < 1e-6


def sine_error(cells: int, length: float, width: float, waves: int) -> float:
    grid = even_grid(length, width, cells, cells)
    x, y = grid.centres
    wave = waves * np.pi / length
    rim = Rim(left=0.0, right=0.0, front=0.0, back=np.sin(wave * (x[0] + length / 2)))
    exact = np.sin(wave * (x + length / 2)) * np.sinh(wave * (y + width / 2)) / np.sinh(wave * width)
    return float(np.sqrt(np.mean((solve(grid, rim).pressure[0] - exact) ** 2)))


@pytest.mark.parametrize(("length", "width", "waves"), [(1.0, 1.0, 1), (7e-3, 5e-3, 1), (9e-3, 2e-3, 2)])
def test_the_error_falls_with_the_square_of_the_cell(length: float, width: float, waves: int) -> None:
    errors = [sine_error(cells, length, width, waves) for cells in (16, 32, 64, 128)]
    assert (np.log2(np.divide(errors[:-1], errors[1:])) > 1.9).all()
    assert errors[-1] < 5e-5


def blocked_grid(seed: int) -> Grid:
    drawn = np.random.default_rng(seed)
    mobility = drawn.uniform(0.2, 1.0, (12, 9)) * (drawn.random((12, 9)) > 0.25)
    return plain_grid(mobility, 0.3, 0.2)


@settings(max_examples=25)
@given(seed=st.integers(0, 10**6))
def test_what_enters_leaves(seed: int) -> None:
    drawn = np.random.default_rng(seed)
    rim = Rim(drawn.random((3, 12)), None, drawn.random((3, 9)), 0.4)
    flow = solve(blocked_grid(seed), rim)
    turnover = np.abs(flow.inflow).sum(axis=1) + 1e-300
    assert (np.abs(flow.inflow.sum(axis=1)) <= 1e-12 * np.maximum(turnover, 1.0)).all()
    sources = np.diff(flow.along, axis=2) + np.diff(flow.across, axis=1)
    assert np.abs(sources).max() < 1e-12
    assert (flow.pressure <= 1.0 + 1e-12).all()  # a steady pressure has no peak inside
    assert (flow.pressure >= -1e-12).all()


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6))
def test_mirrored_rims_give_mirrored_flows_and_sums_add(seed: int) -> None:
    drawn = np.random.default_rng(seed)
    mobility = drawn.uniform(0.2, 1.0, (8, 8))
    left, right = drawn.random(8), drawn.random(8)
    flow = solve(plain_grid(mobility, 1.0, 1.0), Rim(left=left, right=right))
    mirrored = solve(plain_grid(mobility[:, ::-1], 1.0, 1.0), Rim(left=right, right=left))
    np.testing.assert_allclose(mirrored.pressure[:, :, ::-1], flow.pressure, atol=1e-12)
    np.testing.assert_allclose(mirrored.along[:, :, ::-1], -flow.along, atol=1e-12)
    turned = solve(plain_grid(mobility.T, 1.0, 1.0), Rim(front=left, back=right))
    np.testing.assert_allclose(turned.pressure.transpose(0, 2, 1), flow.pressure, atol=1e-12)
    twice = solve(plain_grid(mobility, 1.0, 1.0), Rim(left=2 * left, right=2 * right))
    np.testing.assert_allclose(twice.along, 2 * flow.along, atol=1e-12)
    parts = solve(plain_grid(mobility, 1.0, 1.0), Rim(np.stack([left, 0 * left]), np.stack([0 * right, right])))
    np.testing.assert_allclose(parts.along.sum(axis=0), flow.along[0], atol=1e-12)


def test_pockets_stand_still() -> None:
    mobility = np.ones((9, 9))
    mobility[3:6, 3:6] = 0.0
    mobility[4, 4] = 1.0
    flow = solve(plain_grid(mobility, 1.0, 1.0), Rim(left=1.0, right=0.0))
    assert not flow.reached[4, 4]
    assert flow.pressure[0, 4, 4] == 0.0
    assert flow.reached.sum() == 81 - 9
    assert solve(plain_grid(np.ones((3, 3)), 1.0, 1.0), Rim()).reached.sum() == 0


def test_a_wall_that_leaves_half_open_doubles_the_resistance_there() -> None:
    mobility, opened = np.ones((1, 4)), np.ones((1, 4))
    half = np.array([[1.0, 1.0, 0.5, 1.0]])
    grid = narrowed_grid(mobility, 1.0, 1.0, Apertures(half, half, opened, opened))
    assert solve(grid, Rim(left=1.0, right=0.0)).inflow[0, 0] == pytest.approx(1.0 / 5.0)


def test_bad_input_is_named() -> None:
    with pytest.raises(CleaningError, match="positive size"):
        plain_grid([[1.0]], 0.0, 1.0)
    with pytest.raises(CleaningError, match="mobility"):
        plain_grid([[-1.0]], 1.0, 1.0)
    with pytest.raises(CleaningError, match="do not fit"):
        solve(plain_grid(np.ones((3, 4)), 1.0, 1.0), Rim(left=np.ones(4)))
    with pytest.raises(CleaningError, match="finite"):
        solve(plain_grid(np.ones((3, 4)), 1.0, 1.0), Rim(left=np.inf))
