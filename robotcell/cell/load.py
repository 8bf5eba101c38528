"""Reading cells, from the library by name or from a file, as metres and radians; their schema and key tables."""

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from boards.board import Workpiece
from robotcell.cell.cell import Cell, Tool, build_bodies, place_pose, tool_point_machine
from robotcell.cell.hold import board_pose, held_frame
from robotcell.cell.robot_library import bound_turns, build_robot, limit_joints, load_robot, require_limits
from robotcell.cell.spec import CellSpec, InputOutput, Output, Outputs, ToolSpec
from robotcell.errors import CellError, errors_at
from robotcell.robot.robot import Poses, Robot
from specs.json import content_sha256
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, is_bare, parse_spec, read_text
from specs.yaml.located import Located, YamlPath, read_yaml
from specs.yaml.problems import Problem, raise_problems
from specs.yaml.schema import DIALECT, key_tables, name_nearest, schema_parts

_LIBRARY = Path(__file__).parents[1] / "library" / "cells"
_SLACK = 1e-9
_SHAPES = ("BoxSpec", "CapsuleSpec", "CylinderSpec", "HoseSpec", "MeshSpec")
_SECTIONS = {
    "The cell": ("CellSpec",),
    "base, tcp, pose, at": ("Place",),
    "robot, where it is not of the library": ("RobotSpec",),
    "robot: dh": ("DhSpec",),
    "robot: dh: table": ("DhJoint",),
    "joints": ("JointLimits",),
    "controller_joints": ("ControllerJoint",),
    "board, placements": ("Hold",),
    "board: points": ("PointPair",),
    "board: touched": ("Touched",),
    "tools": ("ToolSpec",),
    "at_tool_change": ("ToolChangeRoutine",),
    "tools: bodies, and fixtures": _SHAPES,
    "nozzles": ("NozzleSpec",),
    "controller": ("ControllerSpec",),
    "io": ("InputOutput",),
    "io: outputs": ("Output",),
    "io: settings": ("OutputSetting",),
    "io: sensors": ("Sensor",),
    "io: inputs": ("DigitalInput",),
    "io: waits": ("Wait",),
    "io: handshake": ("Handshake",),
    "io: grip": ("Grip",),
    "operate": ("OperateSpec",),
    "operate: link": ("ModbusLink", "OpcuaLink", "LinuxcncLink"),
    "operate: interlocks, sensors": ("Condition",),
    "operate: sensors": ("OperateSensors",),
}


def cell_library() -> dict[str, Path]:
    """Give the cells that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


CELL = FileKind("cell", "cell: NAME", "washboard cell", CellError, CellSpec, cell_library)


def cell_schema() -> str:
    """Write the JSON schema of a cell's file, with a line feed at the end."""
    schema = {
        "$schema": DIALECT,
        "title": "Washboard cell",
        **{key: value for key, value in CELL.schema().items() if key not in ("title", "$defs")},
        "$defs": schema_parts(CELL),
    }
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def cell_keys() -> str:
    """Write every key of a cell as Markdown."""
    return key_tables(CELL, _SECTIONS)


@dataclass(frozen=True, slots=True, eq=False)
class LoadedCell:
    """A cell, its specification, and the file it was read from."""

    cell: Cell
    spec: CellSpec
    root: Located
    placements: dict[str, Poses]
    """(4, 4) T_cell_board after ``CALL name``, by that name; like ``cell.T_cell_board`` without a board."""
    unlimited: Robot
    """The robot with its own limits, which those under ``joints`` of the cell's file may tighten."""

    @property
    def round_nozzles(self) -> frozenset[str]:
        """Names of the nozzles that the robot may turn about their jets."""
        return frozenset(name for name, nozzle in self.spec.nozzles.items() if nozzle.round)


def read_cell(source: str | Path) -> LoadedCell:
    """Read a cell with its specification and file.

    Args:
        source: A name of the library such as ``ur5e-bench``, or a file.

    Raises:
        CellError: it cannot be found or used; the message gives the place and what to do.
    """
    path = find_file(source, CELL)
    return read_cell_text(read_text(path, CELL), file=path)


def cell_sha256(loaded: LoadedCell) -> str:
    """Hash the content of a cell, however its file was written."""
    return content_sha256(loaded.spec.model_dump(mode="json", by_alias=True))


def places_sha256(loaded: LoadedCell) -> str:
    """Hash what a joint table depends on in a cell: all but its description, and how it is operated."""
    content = loaded.spec.model_dump(mode="json", by_alias=True, exclude={"description", "operate"})
    return content_sha256(content)


def describe_cell(source: str | Path) -> str:
    """Give the description in a cell's file, without reading the robot and the meshes that it names.

    Raises:
        CellError: the file cannot be found or read as a cell.
    """
    path = find_file(source, CELL)
    return _read_spec(read_yaml(read_text(path, CELL), path, CELL)).description


def read_cell_text(text: str, *, file: Path | str = "<cell>") -> LoadedCell:
    """Read a cell from its text.

    Args:
        text: YAML.
        file: Name in errors; files that it names are looked for beside it.

    Raises:
        CellError: it cannot be used.
    """
    root = read_yaml(text, file, CELL)
    spec = _read_spec(root)
    unlimited = _build_robot(spec, root)
    robot = bound_turns(limit_joints(unlimited, spec.joints, root, ("joints",)), spec.hose_turns)
    require_limits(robot, root, ("robot",))
    raise_problems(find_home_problems(spec, robot), root, CELL)
    units = np.array([joint.unit.si for joint in robot.joints])
    with errors_at(root, ("board",)):
        T_cell_board = board_pose(spec.board)
    cell = Cell(
        name=spec.cell,
        robot=robot,
        T_cell_base=place_pose(spec.base),
        T_cell_board=T_cell_board,
        home=units * np.array(spec.home_deg_mm),
        tool_change=None if spec.tool_change_deg_mm is None else units * np.array(spec.tool_change_deg_mm),
        tools=tuple(build_tool(number, tool, root) for number, tool in sorted(spec.tools.items())),
        fixtures=build_bodies(spec.fixtures, root, ("fixtures",)),
        margin=1e-3 * spec.margin_mm,
        held_by=spec.board.held_by,
    )
    placements: dict[str, Poses] = {}
    for name, hold in spec.placements.items():
        with errors_at(root, ("placements", name)):
            placements[name] = board_pose(hold)
    if spec.kinematics != "trivial":
        with errors_at(root, ("kinematics",)):
            cell = replace(cell, tool_point=tool_point_machine(cell))
    return LoadedCell(cell, spec, root, placements, unlimited)


def hold_board(loaded: LoadedCell, board: Workpiece | None) -> LoadedCell:
    """Give a cell that holds a board, in its first place and in those after ``CALL name``.

    Args:
        loaded: The cell; the board that it holds already, if any, is replaced.
        board: ``None`` where it is not known: the origin of its file is taken for the held point.
    """
    spec = loaded.spec
    T_board_held = held_frame(spec.board.held_by, board)
    cell = replace(loaded.cell, T_board_held=T_board_held).with_held_at(board_pose(spec.board))
    placements = {
        name: board_pose(hold) @ np.linalg.inv(held_frame(hold.held_by, board))
        for name, hold in spec.placements.items()
    }
    return replace(loaded, cell=cell, placements=placements)


def build_tool(number: int, spec: ToolSpec, root: Located) -> Tool:
    """Make a tool of a cell's file as metres.

    Raises:
        CellError: a body cannot be made; the message gives its place in the file.
    """
    bodies = build_bodies(spec.bodies, root, ("tools", str(number), "bodies"))
    return Tool(number, spec.name, place_pose(spec.tcp), bodies)


def _read_spec(root: Located) -> CellSpec:
    spec = parse_spec(root, CELL)
    raise_problems(find_problems(spec), root, CELL)
    return spec


def _build_robot(spec: CellSpec, root: Located) -> Robot:
    if not isinstance(spec.robot, str):
        return build_robot(spec.robot, Path(root.mark.file).parent, root, ("robot",))
    folder = Path(root.at(("robot",)).mark.file).parent
    with errors_at(root, ("robot",)):
        return load_robot(spec.robot if is_bare(spec.robot) else folder / spec.robot)


def find_problems(spec: CellSpec) -> list[Problem]:
    """Find channels that are missing, values that a channel cannot take, numbers that are used twice."""
    io, outputs, valves = spec.io, spec.io.outputs, {nozzle.valve for nozzle in spec.nozzles.values()}
    problems = [*_check_channels(io), *_check_inputs(spec)]
    digital: dict[YamlPath, str | None] = {
        ("nozzles", name, "valve"): nozzle.valve for name, nozzle in spec.nozzles.items()
    }
    digital[("io", "first_run_lamp")] = io.first_run_lamp
    digital |= {("io", "handshake", key): getattr(io.handshake, key) for key in ("busy", "done", "fault")}
    for path, name in digital.items():
        if name is not None:
            problems += _check_name(name, outputs, path)
            if name in outputs and outputs[name].kind != "digital":
                noun = "a valve" if path[0] == "nozzles" else "this"
                problems.append(Problem(path, f"{name} is {outputs[name].kind}; {noun} needs a digital output"))
    named = Counter(name for path, name in digital.items() if path[0] == "io")
    problems += (
        Problem(path, f"{name} is used for another signal; each has an output of its own")
        for path, name in digital.items()
        if name is not None and path[0] == "io" and (named[name] > 1 or name in valves)
    )
    for key, setting in io.settings.items():
        problems += _check_name(setting.output, outputs, ("io", "settings", key, "output"))
    sets = {
        "functions": io.functions,
        "solutions": io.solutions,
        "grip": {"open": io.grip.open, "close": io.grip.close},
    }
    for kind, by_name in sets.items():
        for name, values in by_name.items():
            problems += _check_values(values, outputs, ("io", kind, name))
    return problems


def find_home_problems(spec: CellSpec, robot: Robot) -> list[Problem]:
    """Find a home, or a place to change the tool, that has too many or too few values, or lies outside the limits."""
    places = {"home_deg_mm": spec.home_deg_mm}
    if spec.tool_change_deg_mm is not None:
        places["tool_change_deg_mm"] = spec.tool_change_deg_mm
    bounded = {
        key for key, each in spec.joints.items() if each.position_deg is not None or each.position_mm is not None
    }
    problems: list[Problem] = []
    for key, place in places.items():
        if len(place) != robot.dof:
            names = ", ".join(joint.name for joint in robot.joints)
            message = f"has {len(place)} values; {robot.name} has {robot.dof} joints: {names}"
            problems.append(Problem((key,), message))
            continue
        for index, (value, joint) in enumerate(zip(place, robot.joints, strict=True)):
            unit = joint.unit
            if not joint.lowest - _SLACK <= unit.si * value <= joint.highest + _SLACK:
                limits = f"{joint.lowest / unit.si:g} to {joint.highest / unit.si:g} {unit.word}"
                stated = [name for name in (joint.name, "all") if name in bounded]
                by = f" (joints.{stated[0]})" if stated else ""
                message = f"{joint.name} goes from {limits}{by}, not to {value:g}; put it within, or widen the limits"
                problems.append(Problem((key, index), message, tuple(("joints", name) for name in stated)))
    return problems


def _check_channels(io: InputOutput) -> Iterator[Problem]:
    taken: dict[tuple[str, int], str] = {}
    channels = [("outputs", name, (f"{each.kind} output", each.number)) for name, each in io.outputs.items()]
    channels += [("inputs", name, ("digital input", each.number)) for name, each in io.inputs.items()]
    for kind, name, channel in channels:
        if (other := taken.setdefault(channel, name)) != name:
            message = f"{channel[0]} {channel[1]} is {other} already; each has its own number"
            yield Problem(("io", kind, name, "number"), message)
    for kind, analog in (("outputs", io.outputs), ("sensors", io.sensors)):
        for name, each in analog.items():
            if each.unit == "mA" and "full_scale" not in each.model_fields_set:  # the default is that of volts
                yield Problem(("io", kind, name, "unit"), "mA needs a full_scale too, such as full_scale: 20")


def _check_inputs(spec: CellSpec) -> Iterator[Problem]:
    """Find waits, and conditions of the operation, for inputs and sensors that there are none of."""
    io, operate = spec.io, spec.operate
    used: list[tuple[YamlPath, str | None]] = []
    for name, wait in io.waits.items():
        used += [(("io", "waits", name, "input"), wait.input), (("io", "waits", name, "sensor"), wait.sensor)]
    for name, condition in {} if operate is None else operate.conditions.items():
        group = "interlocks" if operate is not None and name in operate.interlocks else "sensors"
        used.append((("operate", group, name, "input"), condition.input))
    used.append((("io", "handshake", "start"), io.handshake.start))
    for path, channel in used:
        known, kind = (io.sensors, "sensors") if path[-1] == "sensor" else (io.inputs, "inputs")
        if channel is not None and channel not in known:
            yield Problem(path, f"{channel!r} is not under io.{kind}; {name_nearest(channel, known)}")


def _check_name(name: str, outputs: dict[str, Output], path: YamlPath) -> Iterator[Problem]:
    if name not in outputs:
        yield Problem(path, f"{name!r} is no output; {name_nearest(name, outputs)}")


def _check_values(values: Outputs, outputs: dict[str, Output], path: YamlPath) -> Iterator[Problem]:
    for name, value in values.items():
        yield from _check_name(name, outputs, (*path, name))
        kind = outputs[name].kind if name in outputs else "analog"
        if kind == "digital" and value not in (0, 1):
            yield Problem((*path, name), f"is digital: 0 or 1, not {value:g}")
        if kind == "group" and (value < 0 or value != int(value)):
            yield Problem((*path, name), f"is a group of bits: a whole number from 0, not {value:g}")
