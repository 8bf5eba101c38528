"""The flow under one component for a pascal on each edge segment."""

import numpy as np
import pytest
from gap_references import duct_factor
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from boards.undersides.underside import Joint
from cleaning.errors import CleaningError
from cleaning.gap.flow_field import GapField, solve_gap

HEIGHT = 50e-6
PAD = Joint(0.0, 0.0, 3.0, 3.0)


def leads(count: int = 12, pitch: float = 0.5, size: float = 7.0) -> tuple[Joint, ...]:
    places = [(index - (count - 1) / 2) * pitch for index in range(count)]
    end = size / 2 - 0.25
    upright = [Joint(place, side * end, 0.3, 0.5) for place in places for side in (-1, 1)]
    return (*upright, *(Joint(joint.y_mm, joint.x_mm, 0.5, 0.3) for joint in upright))


def grid_of(field: GapField, values: NDArray[np.float32]) -> NDArray[np.float64]:
    """Spread values of cells over the grid: (rows, columns, ...)."""
    rows, columns = field.shape
    spread = np.zeros((rows * columns, *values.shape[1:]))
    spread[field.cells] = values
    return spread.reshape(rows, columns, *values.shape[1:])


def test_a_plain_gap_lists_all_cells() -> None:
    field = solve_gap(7e-3, 5e-3, HEIGHT, (), 20)
    assert field.shape == (14, 20)
    np.testing.assert_array_equal(field.cells, np.arange(280))
    assert field.pressure.shape == (8, 280)
    assert field.velocity.shape == (8, 280, 2)
    assert field.coverage == 0.0
    assert field.open_share == 1.0
    assert field.weights.sum() == pytest.approx(1.0, rel=1e-6)
    np.testing.assert_allclose(field.centres[0], [-3.325e-3, -2.5e-3 * 13 / 14])


def test_the_same_pressure_all_around_moves_nothing() -> None:
    field = solve_gap(7e-3, 7e-3, HEIGHT, (*leads(), PAD), 20)
    np.testing.assert_allclose(field.pressure.sum(axis=0), 1.0, atol=1e-5)
    assert np.abs(field.velocity.sum(axis=0)).max() < 1e-4 * np.abs(field.velocity).max()


def test_walls_along_both_sides_leave_poiseuille_flow() -> None:
    walls = (Joint(0.0, 2.5, 8.0, 0.2), Joint(0.0, -2.5, 8.0, 0.2))
    field = solve_gap(7e-3, 5e-3, HEIGHT, walls, 20)
    across = field.velocity[6] + field.velocity[7] - field.velocity[2] - field.velocity[3]
    inner = np.abs(field.centres[:, 1]) < 2.1e-3
    np.testing.assert_allclose(across[inner, 0], 2 * HEIGHT**2 / (12 * 7e-3), rtol=1e-5)
    assert field.path_m == pytest.approx(7e-3, rel=1e-9)


def test_length_of_the_way() -> None:
    assert solve_gap(7e-3, 7e-3, HEIGHT, ()).path_m == pytest.approx(7e-3)
    assert solve_gap(7e-3, 5e-3, HEIGHT, ()).path_m == pytest.approx(7e-3 * 5 * 12 / 74)
    ends = (Joint(-0.4, 0.0, 0.25, 0.6), Joint(0.4, 0.0, 0.25, 0.6))
    assert solve_gap(1.05e-3, 0.5e-3, 20e-6, ends).path_m == pytest.approx(0.5e-3, rel=1e-6)
    # liquid has to go around what stands in the middle
    assert 7.2e-3 < solve_gap(7e-3, 7e-3, HEIGHT, (PAD,)).path_m < 9e-3


@pytest.mark.parametrize(
    ("segment", "place"), enumerate([(0, 2), (0, 7), (2, 9), (7, 9), (9, 7), (9, 2), (7, 0), (2, 0)])
)
def test_each_segment_presses_where_it_is(segment: int, place: tuple[int, int]) -> None:
    field = solve_gap(5e-3, 5e-3, HEIGHT, (), 10)
    pressure = grid_of(field, field.pressure[segment])
    assert np.unravel_index(pressure.argmax(), field.shape)[0 if place[0] in (0, 9) else 1] in (0, 9)
    assert pressure[place] > 0.7
    assert pressure[9 - place[0], 9 - place[1]] < 0.05


@settings(max_examples=10)
@given(
    x=st.floats(-2.5, 2.5), y=st.floats(-1.5, 1.5), length=st.floats(0.3, 3.0), width=st.floats(0.3, 2.0),
    turn=st.floats(-1.5, 1.5), disc=st.booleans(),
)  # fmt: skip
def test_mirrored_joints_give_a_mirrored_field(
    x: float, y: float, length: float, width: float, turn: float, disc: bool
) -> None:
    one = Joint(x, y, length, length if disc else width, disc, turn)
    other = Joint(-x, y, length, length if disc else width, disc, -turn)
    field, mirror = (solve_gap(6e-3, 4e-3, HEIGHT, (joint,), 12) for joint in (one, other))
    assert field.coverage == pytest.approx(mirror.coverage, rel=1e-9)
    swapped = [1, 0, 7, 6, 5, 4, 3, 2]
    for segment in range(8):
        here = grid_of(field, field.velocity[segment])
        there = grid_of(mirror, mirror.velocity[swapped[segment]])[:, ::-1]
        scale = np.abs(field.velocity).max()
        np.testing.assert_allclose(there[..., 0], -here[..., 0], atol=2e-5 * scale)
        np.testing.assert_allclose(there[..., 1], here[..., 1], atol=2e-5 * scale)


def through(field: GapField) -> float:
    """Mean speed from left to right, of the open area, times the share that is open."""
    return float((field.velocity[6, :, 0] + field.velocity[7, :, 0]) @ field.weights) * field.open_share


def test_joints_resist() -> None:
    free, with_pad = solve_gap(7e-3, 7e-3, HEIGHT, ()), solve_gap(7e-3, 7e-3, HEIGHT, (PAD,))
    with_leads = solve_gap(7e-3, 7e-3, HEIGHT, (*leads(), PAD))
    assert through(free) > through(with_pad) > through(with_leads) > 0
    assert with_pad.coverage == pytest.approx(9 / 49, rel=1e-9)
    assert with_leads.coverage == pytest.approx((9 + 48 * 0.15) / 49, rel=1e-9)
    np.testing.assert_allclose(with_leads.open_cells.sum() / 400, with_leads.open_share, rtol=0.02)


def test_a_ring_of_solder_makes_a_pocket_that_stays_in_sight() -> None:
    ring = tuple(Joint(x, y, 4.2 if y else 0.3, 4.2 if x else 0.3) for x, y in ((0, 2), (0, -2), (2, 0), (-2, 0)))
    field = solve_gap(7e-3, 7e-3, HEIGHT, ring, 28)
    inside = np.abs(field.centres).max(axis=1) < 1.7e-3
    assert inside.sum() > 100
    assert not field.velocity[:, inside].any()
    assert not field.pressure[:, inside].any()
    outside = np.abs(field.centres).max(axis=1) > 2.3e-3
    assert np.abs(field.velocity[:, outside]).max(axis=(0, 2)).min() > 0


def test_solder_everywhere_leaves_something_to_judge() -> None:
    field = solve_gap(2e-3, 1e-3, HEIGHT, (Joint(0.0, 0.0, 3.0, 3.0),))
    assert field.coverage == pytest.approx(1.0)
    assert len(field.cells) == 200
    assert not field.velocity.any()


def test_overlapping_joints_count_once() -> None:
    once = solve_gap(6e-3, 4e-3, HEIGHT, (Joint(0.5, 0.2, 2.0, 1.0),), 12)
    twice = solve_gap(6e-3, 4e-3, HEIGHT, (Joint(0.5, 0.2, 2.0, 1.0), Joint(0.5, 0.2, 2.0, 1.0)), 12)
    assert twice.coverage == once.coverage
    np.testing.assert_array_equal(twice.velocity, once.velocity)


def balls(count: int, pitch: float, diameter: float) -> tuple[Joint, ...]:
    places = [(index - (count - 1) / 2) * pitch for index in range(count)]
    return tuple(Joint(x, y, diameter, diameter, True) for x in places for y in places)


def test_fine_balls_become_a_permeability_that_drawn_balls_confirm() -> None:
    array = balls(4, 0.8, 0.35)
    lumped = solve_gap(3.2e-3, 3.2e-3, 0.1e-3, array, 16)  # 4 cells per pitch
    drawn = solve_gap(3.2e-3, 3.2e-3, 0.1e-3, array, 80)  # 20
    assert len(lumped.cells) == 256
    assert lumped.coverage == pytest.approx(16 * np.pi / 4 * 0.35**2 / 3.2**2, rel=1e-3)
    assert through(lumped) == pytest.approx(through(drawn), rel=0.05)


@settings(max_examples=10)
@given(shift=st.floats(-1e-10, 1e-10))
def test_the_last_digits_of_joints_change_nothing(shift: float) -> None:
    joints = (*leads(), PAD)
    moved = tuple(Joint(j.x_mm + shift, j.y_mm - shift, j.length_mm, j.width_mm, turn_rad=shift) for j in joints)
    one, other = solve_gap(7e-3, 7e-3, HEIGHT, joints), solve_gap(7e-3, 7e-3, HEIGHT, moved)
    np.testing.assert_array_equal(one.velocity, other.velocity)
    assert one.coverage == other.coverage


@pytest.mark.parametrize("sizes", [(0.0, 1e-3, 1e-4), (1e-3, -1.0, 1e-4), (1e-3, 1e-3, float("nan"))])
def test_bad_sizes_are_named(sizes: tuple[float, float, float]) -> None:
    with pytest.raises(CleaningError, match="must be a positive number"):
        solve_gap(*sizes, ())


def test_too_few_cells() -> None:
    with pytest.raises(CleaningError, match="at least 2 cells"):
        solve_gap(1e-3, 1e-3, 1e-4, (), 1)


@pytest.mark.parametrize("ratio", [2.0, 3.0, 5.0, 10.0])
def test_a_channel_between_pads_is_a_duct(ratio: float) -> None:
    height, width = 0.1, 0.1 * ratio
    pads = tuple(Joint(0.0, side * (width / 2 + 1.5), 9.0, 3.0) for side in (-1, 1))
    field = solve_gap(4e-3, 4e-3, height * 1e-3, pads, 24)
    speed = grid_of(field, (field.velocity[6, :, 0] + field.velocity[7, :, 0]) * field.open_cells)
    flow = speed.sum(axis=0) * (4e-3 / 24)
    exact = duct_factor(ratio) * width * 1e-3 * (height * 1e-3) ** 2 / (12 * 4e-3)
    np.testing.assert_allclose(flow, exact, rtol=0.005)


def test_a_part_turned_by_a_quarter_has_the_turned_field() -> None:
    joints = (Joint(0.5, -0.3, 1.5, 0.8, False, 0.3), Joint(-1.5, 0.9, 0.7, 0.7, True), *balls(3, 0.5, 0.2))
    turned = tuple(Joint(-j.y_mm, j.x_mm, j.length_mm, j.width_mm, j.round, j.turn_rad + np.pi / 2) for j in joints)
    field, other = solve_gap(6e-3, 4e-3, HEIGHT, joints, 12), solve_gap(4e-3, 6e-3, HEIGHT, turned, 12)
    assert other.path_m == pytest.approx(field.path_m, rel=1e-9)
    assert other.coverage == pytest.approx(field.coverage, rel=1e-9)
    scale = np.abs(field.velocity).max()
    for segment in range(8):
        here = grid_of(field, field.velocity[segment])
        there = grid_of(other, other.velocity[(segment + 2) % 8])  # what was in front is on the right now
        np.testing.assert_allclose(there[..., 1], here[..., 0].T[:, ::-1], atol=2e-5 * scale)
        np.testing.assert_allclose(there[..., 0], -here[..., 1].T[:, ::-1], atol=2e-5 * scale)


def test_coarse_grids_tell_much_the_same_of_fine_leads() -> None:
    joints = (*leads(), Joint(0.0, 0.0, 4.4, 4.4))
    coarse, fine = (solve_gap(7e-3, 7e-3, HEIGHT, joints, cells) for cells in (20, 84))
    assert coarse.path_m == pytest.approx(fine.path_m, rel=0.06)
    assert through(coarse) == pytest.approx(through(fine), rel=0.1)
