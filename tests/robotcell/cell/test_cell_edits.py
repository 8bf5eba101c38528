"""Edits of a cell's file read back as what they state; tools grow and shrink in their longest rod."""

from pathlib import Path

import pytest

from robotcell.cell.cell_edits import (
    CellEdit,
    apply_edits,
    describe_edits,
    lengthened_tool,
    moved_body_edits,
    parse_edit,
    tool_edits,
)
from robotcell.cell.load import CELL, cell_library, read_cell, read_cell_text
from robotcell.errors import CellError
from specs.yaml.located import Located, YamlPath, read_yaml

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


@pytest.mark.slow
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


def paths_of(node: Located, path: YamlPath = ()) -> list[YamlPath]:
    inner = node.value.items() if isinstance(node.value, dict) else ()
    items = enumerate(node.value) if isinstance(node.value, list) else inner
    return [path] * bool(path) + [each for key, value in items for each in paths_of(value, (*path, key))]


@pytest.mark.parametrize("name", ["kr6-bench", "gantry"])
def test_an_edit_is_read_as_it_is_written(name: str) -> None:
    root = read_yaml(cell_library()[name].read_text(), name, CELL)
    dotted = read_yaml("cell: dotted\nfixtures: {post: 1, post.left: {at: [2, 3]}, post.left.top: 4}\n", "x", CELL)
    for tree in (root, dotted):
        edits = [CellEdit(path, 7) for path in paths_of(tree)]
        assert len(edits) > 5
        assert [parse_edit(str(each), tree) for each in edits] == edits
    for value in (True, None, "clamp", "7", "a: b, [c]", "", [1, -2.5], {"xyz_mm": [1, 2, 3], "kind": "no"}):
        edit = CellEdit(("fixtures", "new", "at"), value)
        assert parse_edit(str(edit), root) == edit


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("board.pose", "is no edit; write KEY: VALUE"),
        (": 3", "is no edit; write KEY: VALUE"),
        ("margin_mm: [1, 2", "the value cannot be read"),
        ("margin_mm: 1\nrobot: 2", "on one line"),
        ("margin_mm: !!python/name:os.system x", "the value cannot be read"),
        ("tools[1.tcp.xyz_mm: [0, 0, 170]", "is no key"),
        ("tools[a]: 1", "is no key"),
        ("tools[1]x[: 1", "is no key"),
        ("board..pose: 1", "is no key"),
        ("board.: 1", "is no key"),
        ("." * 20_000 + ": 1", "is no key"),
        ("a.b" * 20_000 + ": 1", "is no key"),
        ("a" + "[1]" * 20_000 + ": 1", "is no key"),
    ],
)
def test_what_is_no_edit_is_refused(text: str, reason: str) -> None:
    with pytest.raises(CellError, match=reason):
        parse_edit(text, read_yaml(TEXT, FILE, CELL))


def test_edits_are_described_with_line_and_both_values() -> None:
    root = read_yaml("cell: small\nboard:\n  pose: {xyz_mm: [1, 2, 3]}\n", "small.yaml", CELL)
    edits = (CellEdit(("board", "pose", "xyz_mm"), [4, 2, 3]), CellEdit(("board", "hold"), "origin"))
    assert describe_edits(root, edits) == (
        "small.yaml:3: board.pose.xyz_mm: [1, 2, 3] -> [4, 2, 3]",
        "small.yaml:2: board.hold: not stated -> origin",
    )


def test_a_key_is_edited_once(tmp_path: Path) -> None:
    edits = [CellEdit(("name",), "a"), CellEdit(("name",), "b")]
    with pytest.raises(CellError, match="name is given twice; give it once"):
        apply_edits("cell: x\n", edits, tmp_path / "x.yaml")
