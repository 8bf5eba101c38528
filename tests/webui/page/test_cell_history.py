"""Edits of a cell are in its file at once, and are undone in turn with those of the recipe."""

import pytest
from small_boards import board_of, part
from small_cells import CELL

from robotcell.cell.cell_edits import CellEdit
from robotcell.cell.load import cell_library, read_cell
from robotcell.errors import CellError
from webui.page.document import open_document
from webui.page.project import open_project
from webui.page.session import Session

MOVED = (CellEdit(("board", "pose", "xyz_mm"), [300, -50, 150]),)
NEARER = (CellEdit(("board", "pose", "xyz_mm"), [350, -50, 150]),)
SPEED = ("templates", "around", "speed_mm_s")


@pytest.fixture
def project(tmp_path):
    (tmp_path / "cells").mkdir()
    (tmp_path / "cells" / "mine.yaml").write_text("# ours\n" + CELL)
    return open_project(tmp_path)


@pytest.fixture
def session(project):
    document = open_document("smt-aqueous")
    board = board_of(part("U1", 20, 20, 10, 10, pins=64))
    empty = Session(workpiece_name="small", workpiece=board, document=document, loaded=document.read())
    return empty.with_cell("cells/mine.yaml", project.open_cell("cells/mine.yaml"))


def x_of(session):
    return session.cell.spec.board.pose.xyz_mm[0]


def file_of(project, name="cells/mine.yaml"):
    return project.folder / name


def test_an_edit_is_in_the_file_at_once_and_undo_takes_it_back(session, project):
    text = file_of(project).read_text()
    edited = session.edit_cell(MOVED, project)
    assert (edited.cell_name, x_of(edited), x_of(session)) == ("cells/mine.yaml", 300, 400)
    assert file_of(project).read_text() == text.replace("[400, -50, 150]", "[300, -50, 150]")
    undone = edited.undone()
    assert x_of(undone) == 400
    assert file_of(project).read_text() == text
    again = undone.redone()
    assert x_of(again) == 300
    assert "[300, -50, 150]" in file_of(project).read_text()


def test_edits_of_recipe_and_cell_are_undone_and_redone_in_their_order(session, project):
    steps = [session]
    for number, edit in enumerate((MOVED, None, NEARER)):
        now = steps[-1]
        steps.append(now.set_value(SPEED, 20 + number) if edit is None else now.edit_cell(edit, project))
    seen = [(x_of(each), each.document.text) for each in steps]
    assert len(set(seen)) == len(seen)
    now, back = steps[-1], [seen[-1]]
    for _ in steps[1:]:
        now = now.undone()
        back.append((x_of(now), now.document.text))
    assert back[::-1] == seen
    assert (x_of(now.undone()), now.undone().document.text) == seen[0]
    forth = [seen[0]]
    for _ in steps[1:]:
        now = now.redone()
        forth.append((x_of(now), now.document.text))
    assert forth == seen


def test_what_was_undone_is_not_redone_after_another_edit(session, project):
    undone = session.edit_cell(MOVED, project).undone()
    assert x_of(undone.set_value(SPEED, 21).undone().redone()) == 400
    assert x_of(undone.edit_cell(NEARER, project).redone()) == 350


def test_a_library_cell_is_copied_and_undo_removes_the_copy(session, project):
    (project.folder / "my-ur5e-bench.yaml").write_text("taken\n")
    library = cell_library()["ur5e-bench"]
    text = library.read_text()
    edited = session.with_cell("ur5e-bench", project.open_cell("ur5e-bench")).edit_cell(MOVED, project)
    assert edited.cell_name == "my-ur5e-bench-2.yaml"
    assert edited.cell_name in project.cells()
    assert x_of(edited) == 300
    assert library.read_text() == text
    undone = edited.undone()
    assert (undone.cell_name, x_of(undone)) == ("ur5e-bench", 400)
    assert "my-ur5e-bench-2.yaml" not in project.cells()
    assert (project.folder / "my-ur5e-bench.yaml").read_text() == "taken\n"


def test_a_file_that_was_changed_elsewhere_is_left_alone(session, project):
    other = "# theirs\n" + CELL.replace("-94, 97", "-95, 97")
    edited = session.edit_cell(MOVED, project)
    file_of(project).write_text(other)
    for act in (edited.undone, lambda: edited.edit_cell(NEARER, project), lambda: session.edit_cell(NEARER, project)):
        with pytest.raises(CellError, match="changed"):
            act()
        assert file_of(project).read_text() == other


def test_what_is_no_cell_is_not_written(session, project):
    text = file_of(project).read_text()
    with pytest.raises(CellError, match="margin_mm"):
        session.edit_cell((CellEdit(("margin_mm",), -1),), project)
    assert file_of(project).read_text() == text


def test_a_cell_from_elsewhere_is_copied(session, project, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere") / "far.yaml"
    elsewhere.write_text(CELL)
    edited = session.with_cell(str(elsewhere), read_cell(elsewhere)).edit_cell(MOVED, project)
    assert edited.cell_name == "my-far.yaml"
    assert elsewhere.read_text() == CELL


def test_another_cell_ends_the_history(session, project):
    edited = session.edit_cell(MOVED, project)
    other = edited.with_cell("", None)
    assert other.undone().cell is None
    assert "[300, -50, 150]" in file_of(project).read_text()
