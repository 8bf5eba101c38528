"""A cell holds the board by a corner or the centre of its outline, wherever the origin of its CAD file is."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from rigid import Motion, moved_bodies
from small_cells import CELL

from boards.board import Board
from boards.load import load_board
from boards.understand import understand
from programs.native import parse, render
from recipes.load import load_recipe
from reports.files.robot_programs import CellExport, export_in_cell
from robotcell.cell.cell_edits import with_place
from robotcell.cell.hold import describe_held, held_point_mm
from robotcell.cell.load import cell_library, hold_board, read_cell, read_cell_text
from robotcell.cell.spec import HeldBy
from robotcell.diagnosis.plausibility import frame_card
from robotcell.diagnosis.remedies import find_remedies
from robotcell.errors import CellError
from robotcell.placement.reachability import Targets
from robotcell.robot.robot import pose
from rulesengine.planning.pipeline import run

FAR = Motion(0.0, (370.0, -250.0, 40.0))
POINTS: dict[HeldBy, tuple[float, float, float]] = {
    "front_left": (0, 0, 0), "front_right": (30, 0, 0), "back_left": (0, 20, 0), "back_right": (30, 20, 0),
    "centre": (15, 10, 0),
}  # fmt: skip


@cache
def tiny() -> Board:
    return load_board(Path("tiny"))


@cache
def far_tiny() -> Board:
    return understand(moved_bodies(tiny().bodies, FAR), "tiny", ())


def held(hold: str, board: Board | None, more: str = ""):
    text = CELL.replace("board:\n  pose", f"board:\n  hold: {hold}\n  pose") + more
    return hold_board(read_cell_text(text), board)


@pytest.mark.parametrize("held_by", POINTS)
def test_the_named_point_is_where_the_pose_is(held_by: HeldBy) -> None:
    for board, shift in ((tiny(), np.zeros(3)), (far_tiny(), np.array(FAR.shift))):
        point = np.array(POINTS[held_by]) + shift
        np.testing.assert_allclose(held_point_mm(held_by, board), point, atol=1e-9)
        cell = held(held_by, board).cell
        np.testing.assert_allclose(cell.T_cell_board @ [*point / 1e3, 1], [0.4, -0.05, 0.15, 1], atol=1e-12)
        np.testing.assert_allclose(cell.held_pose[:3, 3], [0.4, -0.05, 0.15], atol=1e-12)
        assert describe_held(held_by) in [each.what.removesuffix(", held")[8:] for each in frame_card(cell, board)]


def test_left_out_it_is_the_front_left_corner_and_origin_leaves_the_frame_as_it_is() -> None:
    loaded = read_cell_text(CELL)
    np.testing.assert_array_equal(hold_board(loaded, tiny()).cell.T_cell_board, loaded.cell.T_cell_board)
    np.testing.assert_array_equal(hold_board(loaded, None).cell.T_cell_board, loaded.cell.T_cell_board)
    np.testing.assert_array_equal(held("origin", far_tiny()).cell.T_cell_board, loaded.cell.T_cell_board)
    moved = hold_board(hold_board(loaded, far_tiny()), tiny())  # another board takes the place of the first
    np.testing.assert_array_equal(moved.cell.T_cell_board, loaded.cell.T_cell_board)


def test_a_board_that_was_turned_over_is_held_by_the_same_corner_of_it() -> None:
    turned = "pose: {xyz_mm: [400, 50, 150], rpy_deg: [180, 0, 0]}"
    flip = f"placements:\n  flip_to_bottom:\n    hold: back_left\n    {turned}\n"
    loaded = held("front_left", far_tiny(), flip)
    corner = np.append(held_point_mm("back_left", far_tiny()) / 1e3, 1.0)
    np.testing.assert_allclose(loaded.placements["flip_to_bottom"] @ corner, [0.4, 0.05, 0.15, 1], atol=1e-12)
    front = np.append(held_point_mm("front_left", far_tiny()) / 1e3, 1.0)
    np.testing.assert_allclose(loaded.placements["flip_to_bottom"] @ front, [0.4, 0.07, 0.15, 1], atol=1e-12)


def test_a_touched_corner_is_the_one_that_is_named_unless_its_coordinates_are_given() -> None:
    touched = "touched: {origin_mm: [400, -50, 150], on_x_mm: [500, -50, 150], on_xy_mm: [420, 0, 150]"
    corner = (370, -250, 40)
    for end, point in (("}", corner), (f", board_mm: {list(corner)}}}", corner), (", board_mm: [0, 0, 0]}", (0, 0, 0))):
        text = CELL.replace("pose: {xyz_mm: [400, -50, 150]}", touched + end)
        cell = hold_board(read_cell_text(text), far_tiny()).cell
        np.testing.assert_allclose(cell.T_cell_board @ [*np.array(point) / 1e3, 1], [0.4, -0.05, 0.15, 1], atol=1e-12)


def test_what_contradicts_itself_is_refused() -> None:
    pairs = ", ".join(3 * ["{board_mm: [9, 0, 0], cell_mm: [9, 0, 0]}"])
    points = f"hold: centre\n  points: [{pairs}]"
    with pytest.raises(CellError, match="leave out hold"):
        read_cell_text(CELL.replace("pose: {xyz_mm: [400, -50, 150]}", points))
    with pytest.raises(CellError, match="front_left"):
        held("left_front", None)


def test_a_place_is_written_for_the_point_that_the_file_names() -> None:
    text = CELL.replace("board:\n  pose", "board:\n  hold: centre # of the frame\n  pose")
    place = read_cell_text(text).spec.board.pose
    assert place is not None
    again = read_cell_text(with_place(text, place, Path("c.yaml"), "centre"))
    assert again.spec.board.held_by == "centre"
    assert "  hold: front_left # of the frame\n" in with_place(text, place, Path("c.yaml"))


@pytest.mark.slow
def test_what_would_help_does_not_depend_on_the_origin_of_the_file() -> None:
    """Upside down by mistake: turning over and turning about z are about the held point."""
    over = CELL.replace("[400, -50, 150]}", "[400, -50, 150], rpy_deg: [180, 0, 0]}")
    texts = []
    for board in (tiny(), far_tiny()):
        cell = hold_board(read_cell_text(over), board).cell
        corner = held_point_mm("front_left", board)
        places = [pose(tuple((corner + np.array([x, 0, 60])) / 1e3), (np.pi, 0, 0)) for x in (0.0, 30.0)]
        targets = Targets(np.array(places), np.zeros(2, dtype=np.int64), np.ones(2, dtype=bool))
        texts.append(find_remedies(cell, board, (targets, targets))[0].text)
    assert texts[0] == texts[1]
    assert "turned over" in texts[0]


@cache
def exported(board: Board, name: str, dialect: str) -> CellExport:
    return export_in_cell(run(load_recipe("rinse-only"), board).program, read_cell(name), dialect, board)


@pytest.mark.slow
def test_a_board_far_from_its_origin_is_reached_with_the_same_joints_and_the_same_exported_ones() -> None:
    near, far = (exported(board, "ur5e-bench", "joint-table") for board in (tiny(), far_tiny()))
    assert near.report.possible
    np.testing.assert_allclose(far.report.joints, near.report.joints, atol=2e-6)
    assert [each.rule for each in far.report.findings] == [each.rule for each in near.report.findings]
    tables = []
    for each in (near, far):
        (text,) = each.exported.files.values()
        rows = [line.split(",") for line in text.splitlines() if line[:1].isdigit()]
        joints = np.array([[float(value) for value in row[2:8]] for row in rows])
        tables.append(joints)
    assert len(tables[0]) > 100
    np.testing.assert_allclose(tables[1], tables[0], atol=2e-4)


@pytest.mark.slow
def test_an_export_states_the_held_point_in_the_frame_of_its_coordinates() -> None:
    (text,) = exported(far_tiny(), "ur5e-bench", "joint-table").exported.files.values()
    assert "by its front left corner, x 370.000 y -250.000 z 40.000 mm in its CAD frame" in text


@pytest.mark.slow
def test_without_the_board_an_export_is_forbidden_by_name() -> None:
    program = parse(render(run(load_recipe("rinse-only"), tiny()).program))
    stranger = replace(program, origin=replace(program.origin, board="mine"))
    done = export_in_cell(stranger, read_cell("ur5e-bench"), "ur", None)
    (found,) = (each for each in done.findings if each.rule.id == "board-place-unknown")
    assert found.severity == "error"
    assert "front left corner" in found.message
    assert "hold: origin" in found.message


@pytest.mark.parametrize("name", cell_library())
def test_every_cell_of_the_library_has_a_place_for_a_board_that_was_turned_over(name: str) -> None:
    loaded = hold_board(read_cell(name), tiny())
    left, front, right, back = tiny().outline.bounds
    corners = np.array([[x / 1e3, y / 1e3, 0, 1] for x in (left, right) for y in (front, back)])
    here, turned = (np.round(corners @ T.T, 9) for T in (loaded.cell.T_cell_board, loaded.placements["flip_to_bottom"]))
    assert {tuple(each[:2]) for each in turned} == {tuple(each[:2]) for each in here}
    assert (turned[:, 2] > here[:, 2]).all()  # what hangs down is clear of the holder
    np.testing.assert_allclose(loaded.placements["flip_to_bottom"][:3, 2], -loaded.cell.T_cell_board[:3, 2], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("name", cell_library())
def test_every_cell_of_the_library_serves_a_board_far_from_its_origin(name: str) -> None:
    near, far = (exported(board, name, "joint-table").report for board in (tiny(), far_tiny()))
    assert (near.possible, len(near.joints)) == (far.possible, len(far.joints))
    np.testing.assert_allclose(far.joints, near.joints, atol=2e-6)
