"""Reading cells: from the library by name, or from a file. Out come metres and radians."""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robotcell.cell.cell import Cell, Tool
from robotcell.cell.consistency import find_home_problems, find_problems
from robotcell.cell.measured_place import PlacingError, board_pose
from robotcell.cell.robot_library import build_robot, limit_joints, load_robot, require_limits
from robotcell.cell.shapes import build_bodies, place_pose
from robotcell.cell.spec import CellSpec, Hold
from robotcell.errors import CellError
from robotcell.robot.robot import Poses, Robot
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, parse_spec, read_text
from specs.yaml.located import Located, YamlPath, read_yaml, spell_path
from specs.yaml.problems import raise_problems

_LIBRARY = Path(__file__).parents[1] / "library" / "cells"


def cell_library() -> dict[str, Path]:
    """Give the cells that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


CELL = FileKind("cell", "cell: NAME", "washboard cell", CellError, CellSpec, cell_library)


@dataclass(frozen=True, slots=True, eq=False)
class LoadedCell:
    """A cell, what was written of it, and where."""

    cell: Cell
    spec: CellSpec
    root: Located
    placements: dict[str, Poses]
    """(4, 4) T_cell_board after ``CALL name``, by that name."""

    @property
    def round_nozzles(self) -> frozenset[str]:
        """Names of the nozzles that the robot may turn about their jets."""
        return frozenset(name for name, nozzle in self.spec.nozzles.items() if nozzle.round)


def load_cell(source: str | Path) -> Cell:
    """Read a cell.

    Args:
        source: A name of the library such as ``ur5e-bench``, or a file.

    Raises:
        CellError: it cannot be found or used; the message says where and what to do.
    """
    return read_cell(source).cell


def read_cell(source: str | Path) -> LoadedCell:
    """Read a cell as ``load_cell`` does and keep what was written, and where.

    Raises:
        CellError: it cannot be found or used.
    """
    path = find_file(source, CELL)
    return read_cell_text(read_text(path, CELL), file=path)


def describe_cell(source: str | Path) -> str:
    """Give what a cell's file says that it is, without reading the robot and the meshes that it names.

    Raises:
        CellError: the file cannot be found or read as a cell.
    """
    path = find_file(source, CELL)
    return _read_spec(read_yaml(read_text(path, CELL), path, CELL)).description


def read_cell_text(text: str, *, file: Path | str = "<cell>") -> LoadedCell:
    """Read a cell from its text.

    Args:
        text: YAML.
        file: What to call it in errors; what it names is looked for beside it.

    Raises:
        CellError: it cannot be used.
    """
    root = read_yaml(text, file, CELL)
    spec = _read_spec(root)
    robot = _build_robot(spec, root)
    raise_problems(find_home_problems(spec, robot), root, CELL)
    units = np.array([1e-3 if joint.kind == "prismatic" else math.pi / 180 for joint in robot.joints])
    cell = Cell(
        name=spec.cell,
        robot=robot,
        T_cell_base=place_pose(spec.base),
        T_cell_board=_place_board(spec.board, root, ("board",)),
        home=units * np.array(spec.home_deg_mm),
        tools=tuple(
            Tool(
                number=number,
                name=tool.name,
                T_flange_tcp=place_pose(tool.tcp),
                bodies=build_bodies(tool.bodies, root, ("tools", str(number), "bodies")),
            )
            for number, tool in sorted(spec.tools.items())
        ),
        fixtures=build_bodies(spec.fixtures, root, ("fixtures",)),
        margin=1e-3 * spec.margin_mm,
    )
    placements = {name: _place_board(hold, root, ("placements", name)) for name, hold in spec.placements.items()}
    return LoadedCell(cell, spec, root, placements)


def _read_spec(root: Located) -> CellSpec:
    spec = parse_spec(root, CELL)
    raise_problems(find_problems(spec), root, CELL)
    return spec


def _build_robot(spec: CellSpec, root: Located) -> Robot:
    if isinstance(spec.robot, str):
        mark = root.at(("robot",)).mark
        source = spec.robot if Path(spec.robot).suffix == "" else Path(mark.file).parent / spec.robot
        try:
            robot = load_robot(source)
        except CellError as error:
            raise CellError(str(error), path="robot", file=mark.file, line=mark.line) from None
    else:
        robot = build_robot(spec.robot, Path(root.mark.file).parent, root, ("robot",))
    robot = limit_joints(robot, spec.joints, root, ("joints",))
    require_limits(robot, root, ("robot",))
    return robot


def _place_board(hold: Hold, root: Located, path: YamlPath) -> Poses:
    try:
        return board_pose(hold)
    except PlacingError as error:
        mark = root.at(path).mark
        raise CellError(str(error), path=spell_path(path), file=mark.file, line=mark.line) from None
