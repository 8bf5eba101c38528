"""What joints take of cells and of the ways between them."""

import numpy as np
import pytest
from brinkman_posts import brinkman_factor
from gap_references import duct_factor, plain_grid
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray
from stokes_posts import stokes_factor

from boards.undersides.underside import Joint
from cleaning.gap.hele_shaw import Rim, narrowed_grid, solve
from cleaning.gap.joint_lattice import (
    ROUND_SKIN,
    SQUARE_POSTS,
    STRAIGHT_SKIN,
    TOUCHING,
    Lattice,
    apertures,
    cover,
    covered_share,
    outlines_of,
    post_factor,
    round_posts,
    split_posts,
    square_posts,
    tall_posts,
    tiles_of,
)

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


def drawn_factor(side: float, cells: int, *, disc: bool) -> float:
    """K of one post (side or diameter, in pitches) in the middle of its own cell, solved on a grid."""
    lattice = Lattice(1e-3, 1e-3, cells, cells)
    post = outlines_of([Joint(0.0, 0.0, side, side, disc)])
    grid = narrowed_grid(np.ones((cells, cells)), lattice.dx_m, lattice.dy_m, apertures(post, lattice))
    return float(solve(grid, Rim(left=1.0, right=0.0)).inflow[0, 0])


def masked_factor(solid: float, cells: int) -> float:
    """The same of a quarter of a disc cut into whole cells."""
    places = (np.arange(cells) + 0.5) / cells
    radius = np.hypot(*np.meshgrid(places, places))
    grid = plain_grid((radius > 2 * np.sqrt(solid / np.pi)).astype(np.float64), 1.0, 1.0)
    return float(solve(grid, Rim(left=1.0, right=0.0)).inflow[0, 0])


SHARES = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)


def test_round_posts() -> None:
    np.testing.assert_allclose(round_posts(SHARES), [0.8182, 0.6665, 0.5376, 0.4254, 0.3247, 0.2304], atol=6e-5)
    # conductivities of Perrins and others (1979), table of the square array
    np.testing.assert_allclose(
        round_posts([0.7, 0.74, 0.76, 0.78]), 1 / np.array([7.433, 11.01, 15.44, 35.93]), rtol=0.01
    )
    assert round_posts(0.0) == 1.0
    np.testing.assert_array_equal(round_posts([TOUCHING, 0.9, 2.0]), 0.0)


@settings(max_examples=50)
@given(one=st.floats(0, 1), other=st.floats(0, 1))
def test_more_posts_let_less_through(one: float, other: float) -> None:
    low, high = min(one, other), max(one, other)
    for factor in (round_posts, square_posts):
        assert 0.0 <= factor(high) <= factor(low) <= 1.0
        assert factor(low) <= (1 - low) / (1 + low) + 0.06  # not much above the bound of Hashin and Shtrikman


@pytest.mark.parametrize("share", SHARES)
def test_drawn_posts_confirm_the_series(share: float) -> None:
    assert drawn_factor(2 * np.sqrt(share / np.pi), 128, disc=True) == pytest.approx(
        float(round_posts(share)), rel=0.015
    )


@pytest.mark.parametrize("share", SHARES)
def test_posts_of_whole_cells_confirm_the_series(share: float) -> None:
    assert masked_factor(share, 128) == pytest.approx(float(round_posts(share)), rel=0.015)


@pytest.mark.parametrize("cells", [6, 10, 16])
def test_coarsely_drawn_posts_are_not_far_off(cells: int) -> None:
    for share in SHARES[:5]:
        drawn = drawn_factor(2 * np.sqrt(share / np.pi), cells, disc=True)
        assert drawn == pytest.approx(float(round_posts(share)), rel=0.08)


@pytest.mark.parametrize("side", [0.2, 0.5, 0.7, 0.9])
def test_square_posts(side: float) -> None:
    assert SQUARE_POSTS[5] == pytest.approx(1 / np.sqrt(3), rel=2e-6)
    assert drawn_factor(side, 80, disc=False) == pytest.approx(float(square_posts(side**2)), rel=5e-3)


# solid share, height over pitch and K of a 3-D Stokes solution on 80 to 96 cells per pitch, good to some per cent
PUBLISHED = np.array(
    [
        (0.1, 0.3, 0.6388), (0.2, 0.1, 0.6126), (0.2, 0.3, 0.4634),
        (0.2, 0.5, 0.3342), (0.3, 0.2, 0.3975), (0.4, 0.3, 0.2197),
    ]
)  # fmt: skip


def diameter(share: ArrayLike) -> NDArray[np.float64]:
    """Of round posts of a solid share, in pitches."""
    return 2 * np.sqrt(np.asarray(share) / np.pi)


def test_posts_in_flat_gaps_against_given_flow_in_three_dimensions() -> None:
    share, height, stokes = PUBLISHED.T
    np.testing.assert_allclose(post_factor(diameter(share), 1.0, height), stokes, rtol=0.03)
    skin = round_posts(np.pi * (0.5 * diameter(share) + ROUND_SKIN * height) ** 2)
    np.testing.assert_allclose(skin, stokes, rtol=0.03)
    np.testing.assert_allclose(skin, [0.6441, 0.6037, 0.4738, 0.3407, 0.4059, 0.2206], atol=6e-5)
    assert (round_posts(share) > np.multiply(1.08, stokes)).all()  # posts of any height are no mere holes


CHECKED = [(0.05, 0.5), (0.1, 0.2), (0.2, 0.3), (0.3, 0.5), (0.4, 0.5), (0.5, 0.3), (0.6, 0.3)]


@pytest.mark.slow
@pytest.mark.parametrize(("share", "height"), CHECKED)
def test_posts_in_gaps_of_any_height_against_own_flow_in_three_dimensions(share: float, height: float) -> None:
    stokes = stokes_factor(share, height, 32, 5)
    assert float(post_factor(diameter(share), 1.0, height)) == pytest.approx(stokes, rel=0.04)


@pytest.mark.slow
@pytest.mark.parametrize("height", [0.1, 0.3, 0.7, 2.0])
@pytest.mark.parametrize("share", [0.05, 0.1, 0.2, 0.4, 0.6])
def test_more_posts_against_own_flow_in_three_dimensions(share: float, height: float) -> None:
    stokes = stokes_factor(share, height, 48, 8)
    assert float(post_factor(diameter(share), 1.0, height)) == pytest.approx(stokes, rel=0.04)


@pytest.mark.slow
def test_given_flow_lies_two_to_five_per_cent_above_own() -> None:
    own = [stokes_factor(share, height, 32, 5) for share, height in PUBLISHED[:, :2]]
    excess = PUBLISHED[:, 2] / own - 1.0
    assert excess.min() > 0.01
    assert excess.max() < 0.05


@pytest.mark.parametrize(("share", "exact"), [(0.2, 1 / 51.53), (0.4, 1 / 217.89)])
def test_tall_posts(share: float, exact: float) -> None:
    assert float(tall_posts(share)) == pytest.approx(exact, rel=2e-3)  # Sangani and Acrivos (1982)
    assert brinkman_factor(share, 100.0, 48) * 100.0**2 / 12.0 == pytest.approx(exact, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.05, 0.1, 0.3, 0.5, 0.6])
def test_brinkman_confirms_tall_posts(share: float) -> None:
    own = brinkman_factor(share, 100.0, 64) * 100.0**2 / 12.0
    assert float(tall_posts(share)) == pytest.approx(own, rel=0.015)


@settings(max_examples=60)
@given(share=st.floats(1e-4, 0.8), height=st.floats(0.0, 3.0), more=st.floats(1.01, 1.5))
def test_higher_gaps_and_thicker_posts_let_a_smaller_share_through(share: float, height: float, more: float) -> None:
    factor = float(post_factor(diameter(share), 1.0, height))
    assert 0.0 <= factor <= 1.0
    assert float(post_factor(diameter(share), 1.0, height * more)) <= factor
    assert float(post_factor(diameter(share * more), 1.0, height)) <= factor + 1e-9
    assert float(post_factor(diameter(share) * 0.3, 0.3, height * 0.3)) == pytest.approx(factor, rel=1e-9)
    assert float(post_factor(diameter(share), 1.0, 0.0)) == pytest.approx(float(round_posts(share)), rel=1e-9)


def test_no_post_and_no_room() -> None:
    np.testing.assert_array_equal(post_factor([0.0, 1.0, 1.5], 1.0, 0.3), [1.0, 0.0, 0.0])


def test_usual_ball_grids() -> None:
    factors = post_factor([0.5, 0.45, 0.3, 0.08], [1.0, 0.8, 0.5, 0.15], [0.35, 0.3, 0.2, 0.06])
    np.testing.assert_allclose(factors, [0.433, 0.343, 0.284, 0.360], atol=6e-4)
    np.testing.assert_allclose(factors, [0.446, 0.355, 0.293, 0.373], rtol=0.04)  # by the skin


def test_ducts() -> None:
    ratios = np.array([2.0, 3.0, 5.0, 10.0])
    np.testing.assert_allclose(duct_factor(ratios), [0.6860, 0.7900, 0.8740, 0.9370], atol=6e-5)
    np.testing.assert_allclose(1.0 - 2.0 * STRAIGHT_SKIN / ratios, duct_factor(ratios), rtol=0.005)
    assert duct_factor(1.0) == pytest.approx(0.421731, rel=1e-5)  # 12 x 0.0351443 of a square duct
    # a slit between walls much nearer than the plates resists as plates do
    assert duct_factor(1e-3) == pytest.approx(1e-6, rel=1e-3)
    assert duct_factor(1 - 1e-9) == pytest.approx(float(duct_factor(1 + 1e-9)), rel=1e-8)


@settings(max_examples=50)
@given(ratio=st.floats(2.0, 1e4))
def test_the_skin_stands_for_side_walls(ratio: float) -> None:
    assert 1.0 - 2.0 * STRAIGHT_SKIN / ratio == pytest.approx(float(duct_factor(ratio)), rel=0.005)


def balls(columns: int, rows: int, pitch: float, diameter: float) -> list[Joint]:
    return [
        Joint((i - (columns - 1) / 2) * pitch, (j - (rows - 1) / 2) * pitch, diameter, diameter, True)
        for i in range(columns)
        for j in range(rows)
    ]


def test_only_fine_arrays_become_tiles() -> None:
    array, pad, lead = balls(4, 4, 0.8, 0.4), Joint(3.0, 0.0, 1.0, 1.0), Joint(-3.0, 0.0, 0.2, 0.6)
    posts, walls = split_posts([*array, pad, lead], 1e-3)
    assert [post.joint for post in posts] == array
    assert {post.pitch_mm for post in posts} == {0.8}
    assert walls == (pad, lead)
    assert split_posts(array, 0.8e-3)[0] == ()
    assert split_posts(array[:3], 1e-3)[0] == ()
    assert split_posts([], 1e-3) == ((), ())


def test_tiles_fill_the_cells_they_cover() -> None:
    posts, _ = split_posts(balls(4, 4, 0.8, 0.4), 1e-3)
    whole = tiles_of(posts, 0.1e-3, Lattice(3.2e-3, 3.2e-3, 8, 8))
    np.testing.assert_allclose(whole.factor, post_factor(0.4, 0.8, 0.1), rtol=1e-9)
    np.testing.assert_allclose(whole.solid, np.pi / 16, rtol=1e-9)
    around = tiles_of(posts, 0.1e-3, Lattice(6.4e-3, 3.2e-3, 8, 16))
    np.testing.assert_allclose(around.factor[:, :4], 1.0)
    np.testing.assert_allclose(around.factor[:, 4:12], whole.factor)
    assert around.solid.mean() == pytest.approx(np.pi / 32)


def test_touching_posts_close_the_gap() -> None:
    posts, _ = split_posts(balls(4, 4, 0.5, 0.5), 1e-3)
    assert tiles_of(posts, 0.1e-3, Lattice(2e-3, 2e-3, 4, 4)).factor.max() < 1e-5
