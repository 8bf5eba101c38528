"""Which way is up for a part: away from what it stands on."""

import numpy as np
import pytest
import trimesh
from small_parts import block, moved, part_of

from rulesengine.surface.site import up_of

FOOT = np.array([[-30, -30, 0], [30, -30, 0], [30, 30, 0], [-30, 30, 0]], dtype=np.float64)
FRUSTUM = np.asarray(
    trimesh.convex.convex_hull(np.vstack((FOOT, FOOT * [0.5, 0.5, 1.0] + [0.0, 0.0, 15.0]))).triangles, dtype=np.float64
)
TURN = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])


@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["upright", "on its side"])
def test_a_closed_body_is_begun_from_above_its_broad_foot_wherever_that_looks(turn: np.ndarray) -> None:
    up = up_of(part_of(moved(FRUSTUM, turn, (5.0, 6.0, 7.0))))
    np.testing.assert_allclose(up, turn[2] if turn is not TURN else (0.0, 0.0, 1.0) @ turn.T, atol=1e-6)


def test_a_body_on_a_table_is_begun_away_from_the_table_whichever_face_is_the_broadest() -> None:
    upside_down = FRUSTUM * [1.0, 1.0, -1.0] + [0.0, 0.0, 15.0]
    table = block((-100.0, -100.0, -20.0), (100.0, 100.0, 0.0))
    for patches in (FRUSTUM, upside_down[:, ::-1]):
        np.testing.assert_allclose(up_of(part_of(patches, table=table)), (0.0, 0.0, 1.0), atol=1e-6)


def test_a_side_that_is_not_sprayed_is_what_it_stands_on() -> None:
    part = part_of(FRUSTUM)
    top = next(face.name for face in part.faces if face.normal[2] > 0.9)
    np.testing.assert_allclose(up_of(part_of(FRUSTUM, top)), (0.0, 0.0, -1.0), atol=1e-6)


def turned_profile(*profile: tuple[float, float]) -> np.ndarray:
    """Patches of a closed body of revolution about z, from radius and height of its profile."""
    return np.asarray(trimesh.creation.revolve(np.array(profile), sections=48).triangles, dtype=np.float64)


CONE = turned_profile((0.0, 0.0), (30.0, 0.0), (0.0, 50.0))
CUP = turned_profile((0.0, 0.0), (30.0, 0.0), (30.0, 40.0), (27.0, 40.0), (27.0, 4.0), (0.0, 4.0))


def upside_down(patches: np.ndarray) -> np.ndarray:
    turned = patches * [1.0, -1.0, -1.0]
    return turned - [0.0, 0.0, turned[..., 2].min()]


@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["upright", "on its side"])
@pytest.mark.parametrize(
    "patches", [CONE, CUP, upside_down(CUP), FRUSTUM], ids=["cone", "cup", "cup upside down", "frustum"]
)
def test_what_stands_on_a_table_is_begun_from_above(patches: np.ndarray, turn: np.ndarray) -> None:
    table = block((-100.0, -100.0, -20.0), (100.0, 100.0, 0.0))
    part = part_of(moved(patches, turn, (5.0, 6.0, 7.0)), table=moved(table, turn, (5.0, 6.0, 7.0)))
    np.testing.assert_allclose(up_of(part), turn @ (0.0, 0.0, 1.0), atol=1e-2)
