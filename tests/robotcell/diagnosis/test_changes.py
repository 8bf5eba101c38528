"""Changes of a cell are what they state: turned by degrees, moved by millimetres, in the cell and in its file alike."""

import re
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_cells import CELL

from robotcell.cell.cell_edits import apply_edits
from robotcell.cell.load import read_cell_text
from robotcell.diagnosis.changes import Remedy, mistakes, small_changes
from robotcell.robot.robot import Poses, inverse

FILE = Path("small.yaml")
TEXT = CELL


@pytest.fixture(scope="module")
def changes() -> list[Remedy]:
    loaded = read_cell_text(TEXT, file=FILE)
    targets = SimpleNamespace(tool=np.zeros(1, dtype=np.int64))
    case: Any = SimpleNamespace(cell=loaded.cell, loaded=loaded, targets=targets, blamed=())
    return [*chain(mistakes(case), small_changes(case))]


def turned_deg(before: Poses, after: Poses) -> float:
    """By how much a pose is turned about its own z."""
    turn = inverse(before) @ after
    assert turn[2, 2] == pytest.approx(1.0)
    return float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0])))


def test_what_is_turned_by_degrees_is_turned_by_so_many(changes: list[Remedy]) -> None:
    cell = read_cell_text(TEXT, file=FILE).cell
    for name, words in (("T_cell_base", "the robot's base"), ("held_pose", "the board")):
        found = [each for each in changes if re.search(rf"{words} turned by .* about its (own z|axis)", each.text)]
        stated = [float(re.search(r"turned by ([-+\d]+) degrees", each.text)[1]) for each in found]  # type: ignore[index]
        measured = [turned_deg(getattr(cell, name), getattr(each.cell, name)) for each in found]
        assert len(found) >= 3
        np.testing.assert_allclose(np.mod(np.subtract(measured, stated) + 180.0, 360.0), 180.0, atol=0.01)


def test_what_is_moved_by_millimetres_is_moved_by_so_many(changes: list[Remedy]) -> None:
    cell = read_cell_text(TEXT, file=FILE).cell
    found = [each for each in changes if "the board moved by" in each.text]
    for each in found:
        stated = re.search(r"moved by ([-+\d]+) mm along the cell's (.)", each.text)
        assert stated is not None
        moved = 1e3 * (each.cell.held_pose - cell.held_pose)[:3, 3]
        expected = np.zeros(3)
        expected["xyz".index(stated[2])] = float(stated[1])
        np.testing.assert_allclose(moved, expected, atol=0.051)
    assert len(found) == 60


def test_a_change_is_that_of_its_edits(changes: list[Remedy]) -> None:
    stated = (
        "base turned by 90 degrees",
        "the TCP turned by 180 degrees about its own X",
        "board turned by +30 degrees",
    )
    found = [each for each in changes if any(text in each.text for text in stated)]
    assert len(found) == len(stated)
    for each in found:
        read = read_cell_text(apply_edits(TEXT, each.edits, FILE), file=FILE).cell
        for name in ("T_cell_base", "T_cell_board"):
            np.testing.assert_allclose(getattr(read, name), getattr(each.cell, name), atol=1e-4)
        for tool, other in zip(read.tools, each.cell.tools, strict=True):
            np.testing.assert_allclose(tool.T_flange_tcp, other.T_flange_tcp, atol=1e-4)
