import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from boards.part.cells import served_cells
from boards.part.load import load_part
from robotcell.placement.reachability import jet_frames, surface_targets

angles = st.floats(-3.2, 3.2)


def test_targets_stand_off_the_faces_that_are_sprayed_with_the_jet_against_the_normal() -> None:
    part = load_part("f-bracket")
    targets = surface_targets(part, 60.0, 50)
    cells = served_cells(part).cells
    assert len(targets.tool) == 50
    feet = 1e3 * (targets.T_board_tcp[:, :3, 3] + 0.06 * targets.T_board_tcp[:, :3, 2])
    for foot, jet in zip(feet, targets.T_board_tcp[:, :3, 2], strict=True):
        nearest = int(np.argmin(np.linalg.norm(cells.points - foot, axis=1)))
        np.testing.assert_allclose(cells.points[nearest], foot, atol=1e-6)
        np.testing.assert_allclose(cells.normals[nearest], -jet, atol=1e-9)
    assert targets.free.all()
    assert np.isclose(targets.weights.sum(), cells.areas_mm2.sum())


def test_every_face_that_is_sprayed_gets_a_target() -> None:
    part = load_part("f-bracket")
    jets = surface_targets(part, 60.0, 80).T_board_tcp[:, :3, 2]
    for face in part.served:
        assert (jets @ np.array(face.normal)).min() < -0.999


@pytest.mark.slow
@given(azimuth=angles, tilt=st.one_of(angles, st.sampled_from([0.0, np.pi])))
def test_frames_are_right_handed_on_flat_tops_too(azimuth: float, tilt: float) -> None:
    normal = np.array([[np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt)]])
    frame = jet_frames(np.zeros((1, 3)), normal)[0, :3, :3]
    np.testing.assert_allclose(frame @ frame.T, np.eye(3), atol=1e-6)
    np.testing.assert_allclose(np.cross(frame[:, 0], frame[:, 1]), frame[:, 2], atol=1e-6)
    np.testing.assert_allclose(frame[:, 2], -normal[0], atol=1e-12)
