"""Where liquid has got to, against exact fronts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cleaning.errors import CleaningError
from cleaning.gap.fill_front import fill, front_m
from cleaning.gap.grid import Grid, mobility_of, plain_grid
from cleaning.gap.hele_shaw import Held, Rim

HEIGHT = 50e-6
VISCOSITY = 0.6e-3


def even_grid(length: float, width: float, rows: int, columns: int, height: float = HEIGHT) -> Grid:
    return plain_grid(np.full((rows, columns), mobility_of(height)), length / columns, width / rows)


@pytest.mark.parametrize("cells", [20, 40, 80])
def test_a_straight_front_obeys_washburn(cells: int) -> None:
    exact = front_m(1128.0 * 0.02, HEIGHT, VISCOSITY)
    assert exact == pytest.approx(3.9581e-3, rel=1e-4)
    filling = fill(even_grid(7e-3, 5e-3, 3, cells), Rim(left=1128.0 * 0.02), HEIGHT, VISCOSITY)
    assert filling.wet.sum(axis=1) * 7e-3 / cells == pytest.approx(np.full(3, exact), rel=1e-3)


@settings(deadline=None, max_examples=20)
@given(
    reach=st.floats(0.2, 0.9), height=st.floats(10e-6, 250e-6), length=st.floats(0.5e-3, 30e-3),
    viscosity=st.floats(2e-4, 5e-3),
)  # fmt: skip
def test_any_straight_front(reach: float, height: float, length: float, viscosity: float) -> None:
    impulse = 6.0 * viscosity * (reach * length / height) ** 2
    assert front_m(impulse, height, viscosity) == pytest.approx(reach * length)
    grid = even_grid(length, length, 40, 2, height)
    for rim, columns in ((Rim(front=impulse), 0), (Rim(back=impulse), 1)):
        wet = fill(grid, rim, height, viscosity).wet[:, columns]
        assert wet.sum() / 40 == pytest.approx(reach, rel=4e-3)
        assert ((wet > 0) & (wet < 1)).sum() <= 1


def disc_share(radius: float, dry: float, cells: int) -> float:
    """Wet share of a disc that fills from its rim until only ``dry`` of its radius is left."""
    size = 2 * radius / cells
    grid = plain_grid(np.full((cells + 2, cells + 2), mobility_of(HEIGHT)), size, size)
    level = radius - np.hypot(*grid.centres)
    impulse = 12 * VISCOSITY * (radius / HEIGHT) ** 2 * (0.25 * (1 - dry**2) + 0.5 * dry**2 * np.log(dry))
    wet = fill(grid, Rim(), HEIGHT, VISCOSITY, Held(level, impulse)).wet
    return float(wet.sum() / (level > 0).sum())


@pytest.mark.parametrize("dry", [0.7, 0.55, 0.4, 0.1])
def test_a_disc_fills_from_its_rim(dry: float) -> None:
    assert disc_share(3.5e-3, dry, 40) == pytest.approx(1 - dry**2, rel=0.01)
    assert disc_share(1.2e-3, dry, 60) == pytest.approx(1 - dry**2, rel=0.01)


def test_more_pressure_wets_more_and_the_balance_closes() -> None:
    drawn = np.random.default_rng(3)
    mobility = mobility_of(HEIGHT) * (drawn.random((20, 20)) > 0.15)
    grid = plain_grid(mobility, 0.2e-3, 0.2e-3)
    fillings = [fill(grid, Rim(left=w, front=0.5 * w), HEIGHT, VISCOSITY) for w in (1.0, 5.0, 25.0)]
    volumes = [filling.wet.sum() for filling in fillings]
    assert volumes[0] < volumes[1] < volumes[2]
    assert (np.diff([filling.wet for filling in fillings], axis=0) >= -1e-9).all()
    for w, filling in zip((1.0, 5.0, 25.0), fillings, strict=True):
        entered = (grid.left[:, 0] * (w - filling.impulse_pa_s[:, 0])).sum()
        entered += (grid.front[0] * (0.5 * w - filling.impulse_pa_s[0])).sum()
        wet_volume = filling.wet.sum() * 0.2e-3**2 * HEIGHT
        assert entered / VISCOSITY == pytest.approx(wet_volume, rel=1e-9)
        assert (filling.impulse_pa_s >= 0).all()


def test_without_pressure_all_stays_dry_and_with_much_all_gets_wet() -> None:
    grid = even_grid(5e-3, 5e-3, 10, 10)
    assert not fill(grid, Rim(left=0.0, right=0.0), HEIGHT, VISCOSITY).wet.any()
    assert (fill(grid, Rim(left=1e6), HEIGHT, VISCOSITY).wet == 1).all()


def test_a_gap_does_not_fill_backwards() -> None:
    with pytest.raises(CleaningError, match="not negative"):
        fill(even_grid(5e-3, 5e-3, 4, 4), Rim(left=-1.0), HEIGHT, VISCOSITY)
    with pytest.raises(CleaningError, match="one set"):
        fill(even_grid(5e-3, 5e-3, 4, 4), Rim(left=np.ones((2, 4))), HEIGHT, VISCOSITY)
