"""What joints take of cells and of the ways between them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.undersides.underside import Joint
from cleaning.gap.joint_lattice import Lattice, apertures, cover, covered_share, outlines_of

SQUARE = Lattice(4e-3, 4e-3, 8, 8)


@settings(max_examples=40)
@given(
    x=st.floats(-1, 1), y=st.floats(-1, 1), length=st.floats(0.1, 1.2), width=st.floats(0.1, 1.2),
    turn=st.floats(-4, 4), disc=st.booleans(),
)  # fmt: skip
def test_cells_add_up_to_the_area(x: float, y: float, length: float, width: float, turn: float, disc: bool) -> None:
    joint = Joint(x, y, length, length if disc else width, disc, turn)
    area = np.pi / 4 * length**2 if disc else length * width
    assert covered_share([joint], SQUARE) == pytest.approx(area / 16, rel=1e-3)  # discs are polygons
    taken = cover(outlines_of([joint]), SQUARE)
    assert taken.min() >= 0
    assert taken.max() <= 1
    # half a line's distance along the outline is what lines can miss
    assert taken.sum() * 0.25 == pytest.approx(area, abs=0.0625 * (length + width))


def test_what_lies_outside_does_not_count() -> None:
    assert covered_share([Joint(2.0, 0.0, 2.0, 1.0)], SQUARE) == pytest.approx(1 / 16)
    assert covered_share([], SQUARE) == 0.0
    assert covered_share([Joint(0.0, 0.0, 9.0, 9.0)], SQUARE) == 1.0


def test_a_skin_widens_every_side() -> None:
    joints = [Joint(-1.0, 0.0, 1.0, 0.5), Joint(1.0, 0.0, 1.0, 1.0, True)]
    shapes = outlines_of(joints, 0.1e-3, 0.2e-3)
    np.testing.assert_allclose(shapes.half_length, [0.7e-3, 0.6e-3])
    np.testing.assert_allclose(shapes.half_width, [0.45e-3, 0.6e-3])


def test_a_thin_wall_inside_cells_closes_the_way_through_it() -> None:
    halves = apertures(outlines_of([Joint(0.25, 0.0, 0.1, 5.0)]), SQUARE)
    np.testing.assert_array_equal(halves.left[:, 4] * halves.right[:, 4], 0.0)
    np.testing.assert_allclose(halves.front[:, 4], 0.8)
    np.testing.assert_array_equal(halves.left[:, 3], 1.0)


def test_fine_leads_leave_their_gaps() -> None:
    comb = [Joint(-1.9 + 0.2 * index, 0.0, 0.1, 5.0) for index in range(20)]
    halves = apertures(outlines_of(comb), SQUARE)
    np.testing.assert_allclose(halves.front, 0.5, atol=0.101)
    assert halves.front.mean() == pytest.approx(0.5)
    np.testing.assert_array_equal(halves.left * halves.right, 0.0)


def test_outlines_are_seen_alike_from_both_axes() -> None:
    joints = [Joint(0.3, -0.7, 1.1, 0.4, False, 0.4), Joint(-1.0, 0.6, 0.8, 0.8, True)]
    swapped = [Joint(j.y_mm, j.x_mm, j.length_mm, j.width_mm, j.round, np.pi / 2 - j.turn_rad) for j in joints]
    one, other = apertures(outlines_of(joints), SQUARE), apertures(outlines_of(swapped), SQUARE)
    np.testing.assert_allclose(one.left, other.front.T, atol=1e-6)
    np.testing.assert_allclose(one.back, other.right.T, atol=1e-6)
    np.testing.assert_allclose(cover(outlines_of(joints), SQUARE), cover(outlines_of(swapped), SQUARE).T, atol=1e-6)
