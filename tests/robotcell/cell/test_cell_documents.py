"""What docs/cells.md shows is what Washboard does."""

import re
from pathlib import Path

import pytest
from small_cells import CELL, urdf

from robotcell.cell.load import cell_library, read_cell_text

PAGE = (Path(__file__).parents[3] / "docs" / "cells.md").read_text("utf-8")
EXAMPLES = re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL)


@pytest.mark.parametrize("example", [each for each in EXAMPLES if each.startswith("board:")])
def test_every_way_to_hold_a_board_that_is_shown_works(example: str) -> None:
    place = read_cell_text(re.sub(r"board:\n  pose.*\n", example, CELL)).cell.T_cell_board
    assert place[:3, 3] == pytest.approx([0.4, -0.05, 0.15], abs=1e-3)


def test_the_robot_of_ones_own_that_is_shown_works(tmp_path: Path) -> None:
    (example,) = (each for each in EXAMPLES if each.startswith("robot:") and "urdf:" in each)
    text = urdf().replace('"foot"', '"base_link"').replace('"hand"', '"tool0"').replace('"T"', '"joint_1"')
    (tmp_path / "my-arm.urdf").write_text(text.replace('type="prismatic"', 'type="revolute"'), "utf-8")
    cell = re.sub(r"robot: ur5e\n", example, CELL).replace("[-16, -94, 97, -93, -90, -106]", "[0, 0]")
    robot = read_cell_text(cell, file=tmp_path / "a.yaml").cell.robot
    assert [joint.name for joint in robot.joints] == ["S", "joint_1"]


def test_the_page_names_every_library_cell() -> None:
    for word in cell_library():
        assert f"`{word}`" in PAGE


def test_the_table_of_joints_that_is_shown_works(tmp_path: Path) -> None:
    (example,) = (each for each in EXAMPLES if each.startswith("robot:") and "dh:" in each)
    cell = re.sub(r"robot: ur5e\n", example, CELL).replace("[-16, -94, 97, -93, -90, -106]", "[0, 0]")
    robot = read_cell_text(cell, file=tmp_path / "a.yaml").cell.robot
    assert [joint.name for joint in robot.joints] == ["joint_1", "joint_2"]
