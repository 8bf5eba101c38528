"""Three measured points give the pose of the board; points that cannot be right are refused with the reason."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from robotcell.cell.hold import board_pose
from robotcell.cell.spec import Hold
from robotcell.errors import CellError

CORNERS = [(0.0, 0.0, 0.0), (157.48, 0.0, 0.0), (0.0, 91.44, 0.0)]


def measured(cell_points: np.ndarray, board_points: list[tuple[float, float, float]] = CORNERS, **keys: float) -> Hold:
    points = [{"board_mm": b, "cell_mm": tuple(c)} for b, c in zip(board_points, cell_points.tolist(), strict=True)]
    return Hold.model_validate({"points": points, **keys})


angles = st.floats(-180, 180)


@given(angles, angles, angles, st.tuples(*[st.floats(-2000, 2000)] * 3))
@settings(max_examples=60)
def test_exact_points_give_back_the_pose_that_they_were_made_with(
    roll: float, pitch: float, yaw: float, place: tuple[float, float, float]
) -> None:
    turn = Rotation.from_euler("xyz", [roll, pitch, yaw], degrees=True)
    stated = board_pose(Hold.model_validate({"pose": {"xyz_mm": place, "rpy_deg": (roll, pitch, yaw)}}))
    np.testing.assert_allclose(stated[:3, :3], turn.as_matrix(), atol=1e-12)
    there = turn.apply(np.array(CORNERS)) + place
    np.testing.assert_allclose(board_pose(measured(there)), stated, atol=1e-9)
    touched = {"origin_mm": tuple(there[0]), "on_x_mm": tuple(there[1]), "on_xy_mm": tuple(there[2])}
    np.testing.assert_allclose(board_pose(Hold.model_validate({"touched": touched})), stated, atol=1e-9)


def test_a_touched_corner_need_not_be_the_origin_of_the_cad_file() -> None:
    touched = {
        "origin_mm": (500, 0, 80),
        "on_x_mm": (600, 0, 80),
        "on_xy_mm": (520, 30, 80),
        "board_mm": (141, -120, 1.6),
    }
    pose = board_pose(Hold.model_validate({"touched": touched}))
    np.testing.assert_allclose(pose @ [0.141, -0.120, 0.0016, 1], [0.5, 0, 0.08, 1], atol=1e-12)
    np.testing.assert_allclose(pose[:3, :3], np.eye(3), atol=1e-12)


def test_small_errors_are_shared_out_and_leave_a_rigid_pose() -> None:
    there = np.array(CORNERS) + np.array([[500.2, 100, 80], [500, 99.9, 80.1], [499.9, 100.1, 80]])
    pose = board_pose(measured(there))
    np.testing.assert_allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_allclose(pose[:3, 3], [0.5, 0.1, 0.08], atol=3e-4)


@pytest.mark.parametrize(
    ("factor", "shift", "message"),
    [
        (1.0, 3.0, r"points 0 and 1 are 157\.48 mm apart on the board but 160\.48 mm in the cell.*measure again"),
        (1e-3, 0.0, "the cell's points look like metres"),
        (1 / 25.4, 0.0, "the cell's points look like inches"),
    ],
)
def test_points_that_do_not_fit_are_named_with_both_distances(factor: float, shift: float, message: str) -> None:
    there = factor * (np.array(CORNERS) + np.array([[0, 0, 0], [shift, 0, 0], [0, 0, 0]])) + 500.0
    with pytest.raises(CellError, match=message):
        board_pose(measured(there))


def test_a_coarser_measurement_may_be_allowed() -> None:
    there = np.array(CORNERS) + np.array([[0, 0, 0], [3, 0, 0], [0, 0, 0]])
    assert board_pose(measured(there, largest_residual_mm=2.5))[0, 0] == pytest.approx(1.0, abs=1e-3)


def test_points_on_a_line_tell_no_plane() -> None:
    line = [(0.0, 0.0, 0.0), (50.0, 0.0, 0.0), (100.0, 0.0, 0.0)]
    with pytest.raises(CellError, match="on one line on the board"):
        board_pose(measured(np.array(CORNERS), line))
    with pytest.raises(CellError, match="on one line in the cell"):
        board_pose(measured(np.array(line)))
    with pytest.raises(CellError, match="on one line"):
        board_pose(measured(np.zeros((3, 3))))
    touched = {"origin_mm": (0, 0, 0), "on_x_mm": (50, 0, 0), "on_xy_mm": (80, 0, 0)}
    with pytest.raises(CellError, match="on one line"):
        board_pose(Hold.model_validate({"touched": touched}))
