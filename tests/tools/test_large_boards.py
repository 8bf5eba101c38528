"""The gantry in which large boards are measured: it grows with the board, frame and table as well as travel."""

from importlib import import_module
from itertools import product
from pathlib import Path

import numpy as np
import pytest

import robotcell
from robotcell.cell.load import read_cell
from robotcell.collision.collision import build_collider, collides

BENCHMARKS = Path(robotcell.__file__).parents[1] / "benchmarks"


@pytest.mark.parametrize("size", [(90.0, 60.0), (540.0, 450.0), (1100.0, 900.0)])
def test_the_whole_travel_is_clear(size: tuple[float, float], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    cell = read_cell(str(import_module("large_boards").write_cell(*size, tmp_path))).cell
    robot, collider = cell.robot, build_collider(cell, None)
    travel = zip(robot.lowest[:2].tolist(), robot.highest[:2].tolist(), strict=True)
    rows = np.array([[*place, *cell.home[2:]] for place in product(*travel)])
    np.testing.assert_allclose(np.abs(rows[:, :2]), np.tile(np.array(size) / 2e3 + 0.16, (4, 1)))
    for tool in cell.tools:
        assert not collides(collider, np.vstack((rows, cell.home, cell.change_place)), tool.number).any()
