"""Library cells made hostile: each variation is an edit of the cell's text, as a user would write it."""

from pathlib import Path
from typing import Any

from robotcell.cell.cell_edits import CellEdit, apply_edits
from robotcell.cell.load import LoadedCell, cell_library, read_cell, read_cell_text

TIGHT = {
    "ur5e-bench": ("wrist_1", "position_deg", [-100, -80]),
    "kr6-bench": ("A5", "position_deg", [64, 68]),
    "irb1200-bench": ("joint_5", "position_deg", [102, 106]),
    "lrmate-bench": ("J5", "position_deg", [-118, -112]),
    "cairo-bench": ("J4", "position_deg", [60, 68]),
    "gantry": ("Z", "position_mm", [0, 50]),
}
KINDS = ("far", "long-tool", "tight", "upside-down", "table-through-base", "shadow", "post")


def hostile_text(name: str, kind: str) -> str:
    """Give the text of a library cell made hostile in one way."""
    loaded = read_cell(name)
    text = cell_library()[name].read_text()
    return apply_edits(text, _edits(name, kind, loaded), Path(name))


def read_text(text: str) -> LoadedCell:
    return read_cell_text(text, file=cell_library()["ur5e-bench"])


def _edits(name: str, kind: str, loaded: LoadedCell) -> list[CellEdit]:
    held = loaded.spec.board.pose
    assert held is not None
    x, y, z = held.xyz_mm
    match kind:
        case "far":
            return [_board([x + 1500, y, z])]
        case "shadow":
            return [_board([-80, -50, z])]
        case "upside-down":
            return [CellEdit(("board", "pose"), {"xyz_mm": [x, y, z], "rpy_deg": [180, 0, 0]})]
        case "tight":
            joint, key, limits = TIGHT[name]
            return [CellEdit(("joints", joint, key), limits)]
        case "long-tool":
            return [edit for number in (1, 2) for edit in _long_tool(number)]
        case "table-through-base":
            table: Any = loaded.spec.fixtures["table"]
            tx, ty, tz = table.at.xyz_mm
            return [CellEdit(("fixtures", "table", "at", "xyz_mm"), [tx, ty, tz + 200])]
        case _:
            size = [40, 40, 600]
            post = {"kind": "box", "size_mm": size, "at": {"xyz_mm": [x + 20, y + 20, z + 310]}}
            return [CellEdit(("fixtures", "post"), post)]


def _board(xyz_mm: list[float]) -> CellEdit:
    return CellEdit(("board", "pose"), {"xyz_mm": xyz_mm})


def _long_tool(number: int) -> list[CellEdit]:
    lance = {"kind": "capsule", "from_mm": [0, 0, 40], "to_mm": [0, 0, 680], "radius_mm": 9}
    at = ("tools", str(number))
    return [CellEdit((*at, "tcp"), {"xyz_mm": [0, 0, 700]}), CellEdit((*at, "bodies"), {"lance": lance})]
