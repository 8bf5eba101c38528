"""What stands in a cell is edited in a form, and is in its file at once."""

from dataclasses import replace

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session

from robotcell.cell.cell_edits import CellEdit, apply_edits
from robotcell.cell.load import cell_library, hold_board, read_cell, read_cell_text
from webui.page.project import open_project
from webui.panels.robot.robot import CellForm, fields_of, places_of

TEXT = cell_library()["ur5e-bench"].read_text()


@pytest.fixture
def page(tmp_path):
    (tmp_path / "mine.yaml").write_text(TEXT)
    loaded = hold_board(read_cell(tmp_path / "mine.yaml"), tiny_session().board)
    session = replace(tiny_session(), cell_name="mine.yaml", cell=loaded)
    with small_page(session, open_project(tmp_path)) as page:
        page.form = CellForm(page)
        page.open()
        yield page


def apply(page, label, value):
    find(page, label).value = value
    press(page, "Apply")


@pytest.mark.slow
def test_each_of_board_base_tool_and_fixture_is_edited_and_saved(page, tmp_path):
    edits = (
        ("Board", "X, y, z (mm)", "410, -50, 150", ("board", "pose", "xyz_mm")),
        ("Base of the robot", "Roll, pitch, yaw (\N{DEGREE SIGN})", "0 0 170", ("base", "rpy_deg")),
        ("Tool 2: knife", "Mass (kg)", "1.5", ("tools", "2", "mass_kg")),
        ("Fixture: table", "Size (mm)", "1000, 900, 40", ("fixtures", "table", "size_mm")),
        ("Margin", "Margin (mm)", "6", ("margin_mm",)),
    )
    read = []
    for what, label, value, path in edits:
        press(page, "Edit", what)
        apply(page, label, value)
        read.append(read_cell(tmp_path / "mine.yaml").root.find(path).plain())
    assert read == [[410, -50, 150], [0, 0, 170], 1.5, [1000, 900, 40], 6]
    assert page.session.cell.spec.margin_mm == 6
    for _ in edits:
        page.attempt(lambda session: session.undone())
    assert (tmp_path / "mine.yaml").read_text() == TEXT


@pytest.mark.slow
def test_an_optional_value_that_is_emptied_is_taken_out_and_its_default_holds(page, tmp_path):
    cases = (
        ("Tool 2: knife", "Mass (kg)", "1.5", ("tools", "2", "mass_kg")),
        ("Board", "Roll, pitch, yaw (\N{DEGREE SIGN})", "0 0 90", ("board", "pose", "rpy_deg")),
        ("Margin", "Margin (mm)", "6", ("margin_mm",)),
    )
    for what, label, value, path in cases:
        press(page, "Edit", what)
        for typed, found in ((value, True), ("", False), ("", False)):
            apply(page, label, typed)
            assert page.form._form._remark is None
            assert (read_cell(tmp_path / "mine.yaml").root.find(path) is not None) is found
    assert page.session.cell.spec.tools[2].mass_kg == 1.0
    assert page.session.cell.spec.board.pose.rpy_deg == (0, 0, 0)


@pytest.mark.slow
def test_a_value_that_cannot_be_is_refused_at_its_field_and_writes_nothing(page, tmp_path):
    press(page, "Edit", "Fixture: table")
    apply(page, "Size (mm)", "1000, -1, 40")
    assert (tmp_path / "mine.yaml").read_text() == TEXT
    assert "-1" in page.form._form._remark.content
    assert page.client.said == []  # it stands at the field, not in a notification
    apply(page, "Size (mm)", "")
    assert (tmp_path / "mine.yaml").read_text() == TEXT
    assert page.form._form._remark.content


def test_a_cell_of_the_library_is_copied_first(page, tmp_path):
    page.show(page.session.with_cell("ur5e-bench", read_cell("ur5e-bench")))
    press(page, "Edit", "Margin")
    apply(page, "Margin (mm)", "7")
    assert page.session.cell_name == "my-ur5e-bench.yaml"
    assert read_cell(tmp_path / "my-ur5e-bench.yaml").spec.margin_mm == 7
    assert cell_library()["ur5e-bench"].read_text() == TEXT


@pytest.mark.parametrize("name", cell_library())
def test_every_cell_of_the_library_has_a_form_for_all_that_stands_in_it(name):
    cell = read_cell(name)
    labels = [each.label for each in places_of(cell)]
    assert len(labels) == len(set(labels))
    for each in places_of(cell):
        fields, _ = fields_of(cell, each)
        assert fields
        assert not any(field.label == "Kind" for field in fields)


def test_a_board_held_by_measured_points_is_not_edited_here():
    points = [{"board_mm": [x, y, 0], "cell_mm": [400 + x, y, 150]} for x, y in ((0, 0), (50, 0), (0, 40))]
    cell = read_cell_text(apply_edits(TEXT, [CellEdit(("board",), {"points": points})], cell_library()["ur5e-bench"]))
    assert "Board" not in [each.label for each in places_of(cell)]
