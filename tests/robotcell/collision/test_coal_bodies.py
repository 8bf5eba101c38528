"""Every shape meets what another computation finds that it meets, for random poses."""

import numpy as np
import pytest
from flying_cells import at, board_with, box_triangles, cell_of, flyer, flying_poses, mesh, scattered
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from trimesh.triangles import closest_point

from robotcell.collision.collision import build_collider, collides
from robotcell.robot.robot import Body, Box, Capsule

EXACT = 1e-5
SEEDS = st.integers(0, 2**32 - 1)


def axis_points(capsule, pose, parts):
    """Points on a capsule's axis, both ends included."""
    along = np.linspace(-capsule.length / 2, capsule.length / 2, parts)
    return pose[:3, 3] + along[:, None] * pose[:3, 2]


def capsule_to_box(capsule, pose, box):
    """Smallest distance from a capsule to a box about the origin; along the capsule's axis the distance is convex."""
    half = np.array(box.size) / 2

    def distance(along):
        return np.linalg.norm(np.maximum(np.abs(pose[:3, 3] + along * pose[:3, 2]) - half, 0.0))

    reach = capsule.length / 2
    return (
        minimize_scalar(distance, bounds=(-reach, reach), method="bounded", options={"xatol": 1e-9}).fun
        - capsule.radius
    )


def segment_to_segment(one, other):
    """Smallest distance of two segments (2, 3): inside both, or from an end to the other."""

    def to_point(segment, point):
        way = segment[1] - segment[0]
        along = np.clip((point - segment[0]) @ way / (way @ way), 0.0, 1.0)
        return np.linalg.norm(segment[0] + along * way - point)

    ends = [to_point(one, point) for point in other] + [to_point(other, point) for point in one]
    u, v, w = one[1] - one[0], other[1] - other[0], other[0] - one[0]
    s, t = np.linalg.lstsq(np.column_stack([u, -v]), w, rcond=None)[0]
    if 0 < s < 1 and 0 < t < 1:
        ends.append(np.linalg.norm(one[0] + s * u - other[0] - t * v))
    return min(ends)


def agrees(found, distances, margin, slack=EXACT):
    """No collision is missed, and none is reported beyond the margin."""
    distances = np.asarray(distances)
    assert found[distances < margin - EXACT].all()
    assert not found[distances > margin + slack].any()


@pytest.mark.slow
@settings(max_examples=25)
@given(seed=SEEDS, margin=st.sampled_from([0.0, 0.001, 0.02]))
def test_capsules_meet_where_their_axes_come_near(seed, margin):
    moving, still = Capsule(0.02, 0.1), Capsule(0.03, 0.08)
    stand = at(0.01, 0.02, -0.01, (0.3, -0.2, 0.5))
    q = scattered(seed)
    cell = cell_of(flyer([Body("arm", moving, at())]), [Body("post", still, stand)], margin=margin)
    post = axis_points(still, stand, 2)
    distances = [segment_to_segment(axis_points(moving, pose, 2), post) - 0.05 for pose in flying_poses(q)]
    agrees(collides(build_collider(cell, None), q, 1), distances, margin)


@pytest.mark.slow
@settings(max_examples=15)
@given(seed=SEEDS, margin=st.sampled_from([0.0, 0.01]))
def test_a_capsule_meets_a_box_and_the_same_box_as_a_mesh(seed, margin):
    capsule, box = Capsule(0.015, 0.09), Box((0.1, 0.06, 0.04))
    q = scattered(seed)
    distances = [capsule_to_box(capsule, pose, box) for pose in flying_poses(q)]
    robot = flyer([Body("arm", capsule, at())])
    for shape in (box, mesh(box_triangles(box.size))):
        cell = cell_of(robot, [Body("block", shape, at())], margin=margin)
        agrees(collides(build_collider(cell, None), q, 1), distances, margin)


@pytest.mark.slow
@settings(max_examples=10)
@given(seed=SEEDS, margin=st.sampled_from([0.0, 0.008]), scale=st.floats(1.0, 40.0))
def test_a_capsule_meets_a_board_that_is_a_soup_of_triangles(seed, margin, scale):
    rng = np.random.default_rng(seed)
    soup = rng.uniform(-60, 60, (40, 1, 3)) + rng.normal(0, scale, (40, 3, 3))
    soup[:3, 1] = soup[:3, 0]  # three of them have no area
    capsule, q = Capsule(0.012, 0.07), scattered(seed + 1, 30)
    place = at(0.02, -0.03, 0.01, (0.1, 0.9, -0.4))
    cell = cell_of(flyer([Body("arm", capsule, at())]), margin=margin, board_at=place)
    triangles = (soup / 1000) @ place[:3, :3].T + place[:3, 3]
    distances, step = [], 0.0005
    for pose in flying_poses(q):
        points = axis_points(capsule, pose, 1 + round(0.07 / step))
        pairs = np.repeat(triangles, len(points), axis=0), np.tile(points, (len(triangles), 1))
        sides = np.linalg.norm(pairs[0][:, 1] - pairs[0][:, 0], axis=1) > 0
        near = closest_point(pairs[0][sides], pairs[1][sides])
        distances.append(np.linalg.norm(near - pairs[1][sides], axis=1).min() - capsule.radius)
    found = collides(build_collider(cell, board_with(board=soup)), q, 1)
    assert found[np.array(distances) < margin - EXACT].all()
    flat = (soup[:3, [0, 2]] / 1000) @ place[:3, :3].T + place[:3, 3]
    thin = [
        min(segment_to_segment(axis_points(capsule, pose, 2), line) for line in flat) - capsule.radius
        for pose in flying_poses(q)
    ]
    agrees(found, np.minimum(distances, thin), margin, slack=step)


@pytest.mark.slow
@settings(max_examples=10)
@given(seed=SEEDS)
def test_a_mesh_link_meets_what_points_on_it_are_in(seed):
    """A U of three boxes is no convex body: what is in its mouth does not touch it."""
    walls = [
        ((0.02, 0.06, 0.06), (-0.05, 0, 0)),
        ((0.02, 0.06, 0.06), (0.05, 0, 0)),
        ((0.12, 0.06, 0.02), (0, 0, -0.0401)),
    ]
    u = np.concatenate([box_triangles(size, middle) for size, middle in walls])
    q, ball = scattered(seed), 0.012
    cell = cell_of(flyer([Body("u", mesh(u), at())]), [Body("ball", Box((2 * ball, 2 * ball, 2 * ball)), at())])
    collider = build_collider(cell, None)
    rng = np.random.default_rng(seed)
    weights = rng.dirichlet(np.ones(3), (len(u), 400))
    surface = np.concatenate([np.einsum("nk,ki->ni", w, t) for w, t in zip(weights, u, strict=True)])
    found = collides(collider, q, 1)
    for row, pose in enumerate(flying_poses(q)):
        points = surface @ pose[:3, :3].T + pose[:3, 3]
        deepest = np.max(np.abs(points), axis=1).min()
        if deepest < ball - EXACT:
            assert found[row]
        if deepest > ball + 0.01:
            assert not found[row]
    middle = np.zeros((1, 6))
    assert not collides(collider, middle, 1)[0]


def test_a_sheet_without_thickness_is_met():
    sheet = mesh([[[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0]], [[-0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]]])
    cell = cell_of(flyer([Body("arm", Capsule(0.01, 0.05), at())]), [Body("sheet", sheet, at())])
    q = np.zeros((3, 6))
    q[:, 2] = [0.0, 0.0349, 0.0351]
    assert collides(build_collider(cell, None), q, 1).tolist() == [True, True, False]
