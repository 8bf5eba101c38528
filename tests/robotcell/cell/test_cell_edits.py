"""Edits of a cell's file read back as what they state; tools grow and shrink in their longest rod."""

from pathlib import Path

import pytest

from robotcell.cell.cell_edits import CellEdit, apply_edits, lengthened_tool, moved_body_edits, tool_edits
from robotcell.cell.load import cell_library, read_cell, read_cell_text

FILE = cell_library()["kr6-bench"]
TEXT = FILE.read_text()


@pytest.mark.parametrize("by_mm", [-40.0, pytest.param(60.0, marks=pytest.mark.slow)])
def test_a_tool_of_another_length_reads_back_and_nothing_else_changes(by_mm: float) -> None:
    before = read_cell("kr6-bench").spec
    tool = lengthened_tool(before.tools[1], by_mm)
    assert tool is not None
    edits = tool_edits(1, before.tools[1], tool)
    after = read_cell_text(apply_edits(TEXT, edits, FILE), file=FILE).spec
    assert after.tools[1] == tool
    assert after.tools[1].tcp.xyz_mm == (50, 0, 150 + by_mm)
    assert after.model_copy(update={"tools": before.tools}) == before
    assert str(edits[0]) == f"tools.1.tcp.xyz_mm: [50, 0, {150 + by_mm:g}]"


def test_a_rod_that_is_too_short_is_not_shortened() -> None:
    tool = read_cell("kr6-bench").spec.tools[1]
    assert lengthened_tool(tool, -59.5) is None
    assert lengthened_tool(tool, -200.0) is None


def test_only_the_orifice_moves_where_all_bodies_end_before_it() -> None:
    tool = read_cell("ur5e-bench").spec.tools[1]
    far = tool.model_copy(update={"tcp": tool.tcp.model_copy(update={"xyz_mm": (0.0, 0.0, 600.0)})})
    short = lengthened_tool(far, -420.0)
    assert short == tool


def test_every_kind_of_body_moves() -> None:
    text = TEXT.replace(
        "margin_mm: 5",
        "  rod: {kind: cylinder, from_mm: [0, 400, 0], to_mm: [0, 400, 90], radius_mm: 5}\n"
        "  line: {kind: hose, along_mm: [[0, 500, 0], [0, 500, 50], [0, 520, 80]], radius_mm: 5}\nmargin_mm: 5",
    )
    before = read_cell_text(text, file=FILE).spec.fixtures
    edits = [edit for name in before for edit in moved_body_edits(("fixtures", name), before[name], (1, -2, 3.5))]
    after = read_cell_text(apply_edits(text, edits, FILE), file=FILE).cell.fixtures
    for old, new in zip(read_cell_text(text, file=FILE).cell.fixtures, after, strict=True):
        assert (new.T_carrier_shape - old.T_carrier_shape)[:3, 3] == pytest.approx([0.001, -0.002, 0.0035])


def test_a_joint_gets_limits_that_it_had_not() -> None:
    edit = CellEdit(("joints", "A5", "position_deg"), [-100, 100])
    assert str(edit) == "joints.A5.position_deg: [-100, 100]"
    limits = read_cell_text(apply_edits(TEXT, [edit], Path("cell.yaml")), file=FILE).spec.joints["A5"]
    assert limits.position_deg == (-100, 100)
