"""The installation that posts need of a cell: millimetres, quaternions, channels by name."""

import math
from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from geometry.arrays import Points, Quaternions
from programs.motion import installation
from programs.pose import Pose
from robotcell.cell.cell import Cell
from robotcell.cell.hold import describe_held
from robotcell.cell.load import LoadedCell, places_sha256
from robotcell.cell.spec import CellSpec, Outputs, ToolSpec, Wait
from robotcell.robot.robot import Joints, Poses, Robot, flange_poses, inverse, link_poses

_MM, _ARM, _APART_M = 1e3, 6, 1e-3
_UPRIGHT = math.cos(math.radians(0.5))


def installation_of(loaded: LoadedCell) -> installation.Installation:
    """Convert a cell to the installation that the posts need."""
    cell, spec, robot = loaded.cell, loaded.spec, loaded.cell.robot
    channels = {
        name: installation.Channel(output.kind, name, output.number, output.full_scale, output.unit, output.counts)
        for name, output in spec.io.outputs.items()
    }

    sensors = {
        key: installation.Sensor(
            each.input, each.number, each.scale, each.offset, each.full_scale, each.unit, each.counts
        )
        for key, each in spec.io.sensors.items()
    }
    T_base_cell = inverse(cell.T_cell_base)
    return installation.Installation(
        cell=cell.name,
        cell_sha256=places_sha256(loaded),
        robot=robot.name,
        T_base_board=to_pose(T_base_cell @ cell.T_cell_board),
        tools={
            tool.number: installation.Tool(tool.name, to_pose(tool.T_flange_tcp), _payload_of(spec.tools[tool.number]))
            for tool in cell.tools
        },
        valves={
            name: installation.Valve(channels[nozzle.valve], nozzle.open_lag_s, nozzle.close_lag_s, nozzle.min_pulse_s)
            for name, nozzle in spec.nozzles.items()
        },
        functions={name: _assign(channels, outputs) for name, outputs in spec.io.functions.items()},
        solutions={name: _assign(channels, outputs) for name, outputs in spec.io.solutions.items()},
        settings={
            key: installation.Setting(channels[each.output], each.scale, each.offset)
            for key, each in spec.io.settings.items()
        },
        grips={name: _assign(channels, getattr(spec.io.grip, name)) for name in ("open", "close")},
        sensors=sensors,
        waits=tuple(_wait_of(name, wait, spec, sensors) for name, wait in spec.io.waits.items()),
        held=_describe_held_point(cell),
        placements={name: to_pose(T_base_cell @ placed) for name, placed in loaded.placements.items()},
        joints=_joints_of(robot),
        home=tuple(exported_joints(robot, cell.home).tolist()),
        is_upright=bool(cell.T_cell_base[2, 2] > _UPRIGHT),
        maker=robot.maker,
        convention=robot.convention,
        controller=spec.controller.model_dump(exclude_none=True, exclude={"source"}),
        controller_source=spec.controller.source,
        tool_point=cell.tool_point,
        branch_at=branch_of(robot),
        handshake=_handshake_of(spec, channels),
        lamp=channels[spec.io.first_run_lamp] if spec.io.first_run_lamp is not None else None,
        tool_routine="" if spec.at_tool_change == "stop" else spec.at_tool_change.routine,
    )


def _payload_of(tool: ToolSpec) -> installation.Payload:
    inertia = tool.inertia_kg_m2 or (0.0, 0.0, 0.0)
    return installation.Payload(tool.mass_kg, tool.centre_mm, inertia, "mass_kg" in tool.model_fields_set)


def _handshake_of(spec: CellSpec, channels: dict[str, installation.Channel]) -> installation.Handshake | None:
    """Give the signals of the line, with the input that shows that a part is there; ``None`` where there are none."""
    stated = {key: name for key, name in spec.io.handshake if name is not None}
    if not stated:
        return None
    start, wait = stated.pop("start", None), spec.io.waits.get("part_present")
    here = wait.input if wait is not None else None
    begins, present = (
        installation.Contact(name, spec.io.inputs[name].number) if name is not None else None for name in (start, here)
    )
    outputs = {key: channels[name] for key, name in stated.items()}
    return installation.Handshake(begins, present=present, state=wait is None or wait.state == 1, **outputs)


def branch_of(robot: Robot) -> Callable[[tuple[float, ...]], installation.ArmBranch] | None:
    """Give the branch of an arm by its joints, radians; ``None`` where it has others than six that turn.

    An arm reaches forth to the side of the first axis on which its shoulder is, else its wrist amid its limits.
    """
    if robot.dof != _ARM or not robot.turning.all():
        return None
    middle = robot.middle * [0.0, *[1.0] * (_ARM - 1)]
    first, shoulder, _, wrist = _points_of(robot, middle)
    turn = link_poses(robot, middle[None])[0]
    level = np.cross(turn[2, :3, :3] @ robot.joints[1].axis, [0.0, 0.0, 1.0])
    sides = ((point - first) @ level for point in (shoulder, wrist))
    side = next((math.copysign(1.0, each) for each in sides if abs(each) > _APART_M), math.copysign(1.0, level[0]))
    ahead = turn[1, :3, :3].T @ (side * level / np.linalg.norm(level))

    def branch_at(joints: tuple[float, ...]) -> installation.ArmBranch:
        row = np.array(joints)
        first, shoulder, elbow, wrist = _points_of(robot, row)
        forward = link_poses(robot, row[None])[0, 1, :3, :3] @ ahead
        x, z = (wrist - shoulder) @ forward, wrist[2] - shoulder[2]
        bent = (elbow[2] - shoulder[2]) * x - (elbow - shoulder) @ forward * z
        is_front = bool((wrist - first) @ forward >= 0.0)
        return installation.ArmBranch(is_front, bool(bent * (1.0 if is_front else -1.0) >= 0.0))

    return branch_at


def _points_of(robot: Robot, joints: Joints) -> Poses:
    """Give points (4, 3) on the axes of joints 1, 2, 3 and 5, which meet the wrist's centre, at joints (dof,)."""
    return link_poses(robot, joints[None])[0, [1, 2, 3, 5], :3, 3]


def _assign(channels: dict[str, installation.Channel], outputs: Outputs) -> tuple[installation.Assignment, ...]:
    return tuple(installation.Assignment(channels[name], value) for name, value in outputs.items())


def _joints_of(robot: Robot) -> tuple[installation.Joint, ...]:
    rates = (exported_joints(robot, each).tolist() for each in (robot.speed, robot.acceleration))
    rows = zip(robot.joints, *rates, strict=True)
    return tuple(installation.Joint(joint.name, joint.kind, *most) for joint, *most in rows)


def _wait_of(name: str, wait: Wait, spec: CellSpec, sensors: dict[str, installation.Sensor]) -> installation.Wait:
    """Give a condition for the start with the channel that shows it."""
    contact = installation.Contact(wait.input, spec.io.inputs[wait.input].number) if wait.input is not None else None
    sensor = sensors[wait.sensor] if wait.sensor is not None else None
    shown = (contact, wait.state == 1, sensor, wait.least or 0.0)
    return installation.Wait(name, *shown, wait.timeout_s, wait.message, wait.watched, wait.sensor or "")


def _describe_held_point(cell: Cell) -> str:
    """Give the held point and its place in the board's CAD frame; empty for the origin of that."""
    if cell.held_by == "origin":
        return ""
    x, y, z = (round(float(value) * _MM, 3) + 0.0 for value in cell.T_board_held[:3, 3])
    return f"by its {describe_held(cell.held_by)}, x {x:.3f} y {y:.3f} z {z:.3f} mm in its CAD frame"


def flange_of(cell: Cell) -> Callable[[tuple[float, ...]], Pose]:
    """Give the forward kinematics of a cell's robot in the units of programs.

    Returns:
        The flange's pose seen from the base, by joints in radians, or millimetres where they are prismatic.
    """
    return lambda joints: to_pose(flange_poses(cell.robot, np.array([joints]) / _units_of(cell.robot))[0])


def places_of_tool(cell: Cell) -> Callable[[Joints, Pose, Pose], tuple[Points, Quaternions]]:
    """Give the forward kinematics of a cell's robot for many rows of joints, seen from the board.

    Returns:
        A function of joints (n, dof) in radians, or millimetres where they are prismatic, T_flange_tcp and
        T_base_board, that gives the orifices (n, 3) in mm and the tool's orientations (n, 4) w, x, y, z on the board.
    """

    def places(joints: Joints, tool: Pose, board: Pose) -> tuple[Points, Quaternions]:
        T_base_flange = flange_poses(cell.robot, joints / _units_of(cell.robot))
        flange = Rotation.from_matrix(T_base_flange[:, :3, :3])
        mounted, lies = (Rotation.from_quat(each.quaternion, scalar_first=True) for each in (tool, board))
        tcp = flange.apply(tool.position) + _MM * T_base_flange[:, :3, 3] - np.array(board.position)
        return lies.inv().apply(tcp), np.asarray((lies.inv() * flange * mounted).as_quat(scalar_first=True))

    return places


def exported_joints(robot: Robot, joints: Joints) -> Joints:
    """Give joints (..., dof) in the units of programs: radians, and millimetres where they are prismatic."""
    return joints * _units_of(robot)


def _units_of(robot: Robot) -> Joints:
    return np.where(robot.turning, 1.0, _MM)


def to_pose(T: Poses) -> Pose:
    """Give a (4, 4) pose in mm with a quaternion w, x, y, z whose first component that is not zero is positive."""
    w, x, y, z = (float(value) for value in Rotation.from_matrix(T[:3, :3]).as_quat(scalar_first=True))
    leading = next(value for value in (w, x, y, z) if abs(value) > 1e-9)
    sign = math.copysign(1.0, leading)
    a, b, c = (float(value) for value in np.asarray(T[:3, 3]) * _MM)
    return Pose((a, b, c), (sign * w, sign * x, sign * y, sign * z))
