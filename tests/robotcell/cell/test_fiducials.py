"""Two, three or more fiducials give the board's pose with its stretch, its accuracy, and the pair that is wrong."""

import io
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from installations import ARM_LANGUAGES, for_language, small_cell
from pydantic import ValidationError
from rich.console import Console
from robot_programs import PROGRAMS, joints_of
from scipy.spatial.transform import Rotation
from scipy.stats import chi2
from small_cells import CELL

from programs.export import export
from programs.foreign import read_files, rebuild_program
from programs.pose import Pose
from programs.posts.dialects import DIALECTS
from programs.program import MoveTo, TimedProgram
from reports.cards.robot import cell_card
from reports.terminal.console import print_card
from robotcell.cell.hold import FiducialFit, board_pose, fit_fiducials
from robotcell.cell.load import read_cell_text
from robotcell.cell.spec import Hold
from robotcell.errors import CellError

MARKS = np.array([[5.0, 5.0, 1.6], [155.0, 7.0, 1.6], [8.0, 95.0, 1.6], [150.0, 92.0, 1.6], [80.0, 50.0, 1.6]])
NOISE_MM = 0.05
PLACE = np.array([400.0, -120.0, 80.0])


def held(on_board: np.ndarray, in_cell: np.ndarray, **keys: object) -> Hold:
    points = [
        {"board_mm": tuple(b), "cell_mm": tuple(c)} for b, c in zip(on_board.tolist(), in_cell.tolist(), strict=True)
    ]
    return Hold.model_validate({"points": points, **keys})


def moved(
    points: np.ndarray, turn: Rotation, stretch: Sequence[Sequence[float]] = ((1.0, 0.0), (0.0, 1.0))
) -> np.ndarray:
    shape = np.eye(3)
    shape[:2, :2] = stretch
    return turn.apply(points @ shape.T) + PLACE


TURN = Rotation.from_euler("zyx", [30.0, 1.2, -0.7], degrees=True)
LEVEL = Rotation.from_euler("z", 30.0, degrees=True)


@pytest.mark.parametrize("count", [2, 3, 5])
def test_exact_marks_give_back_the_pose(count: int) -> None:
    turn = LEVEL if count == 2 else TURN
    fit = fit_fiducials(held(MARKS[:count], moved(MARKS[:count], turn)))
    np.testing.assert_allclose(fit.turn, turn.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(fit.place_mm, [400.0, -120.0, 80.0], atol=1e-9)
    assert fit.distances_mm.max() < 1e-9


def test_two_marks_of_a_board_that_was_turned_over_take_the_stated_normal() -> None:
    turn = Rotation.from_euler("x", 180.0, degrees=True) * LEVEL
    there = moved(MARKS[:2], turn)
    fit = fit_fiducials(held(MARKS[:2], there, normal=(0, 0, -1)))
    np.testing.assert_allclose(fit.turn, turn.as_matrix(), atol=1e-12)
    np.testing.assert_allclose(fit.turn @ MARKS[1] + fit.place_mm, there[1], atol=1e-9)


def test_a_scaled_fit_finds_the_scale_and_keeps_the_pose_rigid() -> None:
    there = moved(MARKS, TURN, [[1.002, 0.0], [0.0, 1.002]])
    there -= there.mean(axis=0) - moved(MARKS, TURN).mean(axis=0)
    fit = fit_fiducials(held(MARKS, there, fit="scaled"))
    np.testing.assert_allclose(fit.stretch, 1.002 * np.eye(2), atol=1e-9)
    np.testing.assert_allclose(fit.turn, TURN.as_matrix(), atol=1e-12)
    assert fit.distances_mm.max() < 1e-9
    assert fit_fiducials(held(MARKS, there)).distances_mm.max() > 0.1


def test_an_affine_fit_finds_stretch_and_shear() -> None:
    stretch = np.array([[1.001, 0.0004], [0.0004, 0.9985]])
    fit = fit_fiducials(held(MARKS, moved(MARKS, TURN, stretch), fit="affine"))
    np.testing.assert_allclose(fit.stretch, stretch, atol=1e-9)
    np.testing.assert_allclose(fit.turn, TURN.as_matrix(), atol=1e-9)
    assert fit.distances_mm.max() < 1e-9
    np.testing.assert_allclose(board_pose(held(MARKS, moved(MARKS, TURN, stretch), fit="affine"))[:3, :3], fit.turn)


def error_of(fit: FiducialFit, turn: Rotation, middle: np.ndarray) -> np.ndarray:
    """Rotation about the cell's axes and place of the middle, fitted less true."""
    return np.concatenate([(Rotation.from_matrix(fit.turn) * turn.inv()).as_rotvec(), fit.middle_mm - middle])


@pytest.mark.parametrize(
    ("count", "kind"), [(2, "rigid"), (2, "scaled"), (3, "rigid"), (5, "rigid"), (4, "scaled"), (4, "affine")]
)
def test_the_covariance_holds_with_noise(count: int, kind: str) -> None:
    """The squared errors of 200 trials, weighted by the stated covariance, are those of a chi-squared variable."""
    random = np.random.default_rng(11 * count + len(kind))
    turn = LEVEL if count == 2 else TURN
    exact = moved(MARKS[:count], turn)
    total, rank = 0.0, 4 if count == 2 else 6
    noises: list[float] = []
    for _ in range(200):
        there = exact + NOISE_MM * random.standard_normal(exact.shape)
        fit = fit_fiducials(held(MARKS[:count], there, fit=kind, noise_mm=NOISE_MM))
        assert np.linalg.matrix_rank(fit.covariance, tol=1e-16) == rank
        error = error_of(fit, turn, exact.mean(axis=0))
        total += float(error @ np.linalg.pinv(fit.covariance, rcond=1e-9) @ error)
        noises.append(fit.noise_mm)
    assert chi2.ppf(0.05, 200 * rank) < total < chi2.ppf(0.95, 200 * rank)
    if fit.redundancy > 0:
        assert math.sqrt(np.mean(np.square(noises))) == pytest.approx(NOISE_MM, rel=0.1)


@pytest.mark.parametrize("wrong", range(4))
def test_the_outlying_pair_is_named(wrong: int) -> None:
    there = moved(MARKS[:4], TURN)
    there[wrong] += [2.0, -1.5, 0.0]
    with pytest.raises(CellError, match=rf"points? {wrong} was measured [\d.]+ mm from where the other 3 put it"):
        fit_fiducials(held(MARKS[:4], there + 0.01 * np.arange(12).reshape(4, 3) % 0.02))


def test_two_marks_that_are_too_far_apart_are_named_with_both_distances() -> None:
    there = moved(MARKS[:2], LEVEL)
    there[1] += LEVEL.apply([4.0, 0.0, 0.0])
    with pytest.raises(CellError, match=r"points 0 and 1 are 150\.01 mm apart on the board but 154\.01 mm in the"):
        fit_fiducials(held(MARKS[:2], there))


@pytest.mark.parametrize(
    ("keys", "count"),
    [({"fit": "affine"}, 2), ({"normal": (0, 0, 1)}, 3), ({"normal": (0, 0, 0)}, 2), ({}, 1)],
)
def test_what_does_not_go_together_is_refused(keys: dict[str, object], count: int) -> None:
    with pytest.raises(ValidationError):
        held(MARKS[:count], MARKS[:count], **keys)


@pytest.mark.parametrize("marks", [MARKS[[0, 0]], MARKS[[0, 0, 0, 0]], np.outer(np.arange(5.0), [10.0, 5.0, 0.0])])
def test_marks_that_leave_the_pose_open_are_refused(marks: np.ndarray) -> None:
    with pytest.raises(CellError, match=r"apart|on one line"):
        fit_fiducials(held(marks, moved(marks, LEVEL)))


def places(program: TimedProgram) -> np.ndarray:
    return np.array([item.position for item in program.instructions if isinstance(item, MoveTo)])


@pytest.mark.parametrize("dialect", [name for name in ARM_LANGUAGES if name != "linuxcnc"])
def test_the_work_frame_of_every_language_is_the_fitted_place(dialect: str, tmp_path: Path) -> None:
    """A program that is read back in a cell with that place goes where it was planned on the board."""
    place = board_pose(held(MARKS, moved(MARKS, TURN, [[1.0002, 0.0], [0.0, 1.0001]]), fit="affine"))
    x, y, z = (1e3 * place[:3, 3]).tolist()
    turn = tuple(Rotation.from_matrix(place[:3, :3]).as_quat(scalar_first=True).tolist())
    cell = replace(for_language(small_cell(), dialect), T_base_board=Pose((x, y, z), turn))  # type: ignore[arg-type]
    program = PROGRAMS["three_speeds"]()
    joints = joints_of(program) if DIALECTS[dialect].needs_joints else None
    for name, text in export(program, cell, dialect, joints).files.items():
        (tmp_path / name).write_text(text, "ascii")
    shown = rebuild_program(*read_files(tmp_path), cell)
    np.testing.assert_allclose(places(shown).min(axis=0), places(program).min(axis=0), atol=0.01)
    np.testing.assert_allclose(places(shown).max(axis=0), places(program).max(axis=0), atol=0.01)


def test_the_card_of_a_cell_lists_residuals_accuracy_and_stretch() -> None:
    there = moved(MARKS[:4], TURN, [[1.0003, 0.0], [0.0, 1.0002]])
    there[0] += [0.02, 0.0, 0.0]
    points = ", ".join(
        f"{{board_mm: {b}, cell_mm: {c}}}" for b, c in zip(MARKS[:4].tolist(), there.tolist(), strict=True)
    )
    text = CELL.replace("board:\n  pose: {xyz_mm: [400, -50, 150]}", f"board: {{fit: affine, points: [{points}]}}")
    assert text != CELL
    out = io.StringIO()
    print_card(Console(file=out, width=200), cell_card(read_cell_text(text), []))
    shown = out.getvalue()
    assert "measured point" in shown
    assert "affine fit with 0.05 mm a coordinate" in shown
    assert "stretched by" in shown
