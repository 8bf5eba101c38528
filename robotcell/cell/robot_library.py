"""Robots, of the library by name or as a cell specifies them, by URDF or table of Denavit and Hartenberg. SI units."""

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from programs.motion.installation import JointConvention
from robotcell.cell.cell import place_pose
from robotcell.cell.spec import ControllerJoint, DhSpec, JointLimits, RobotFile, RobotSpec
from robotcell.errors import CellError, error_at, errors_at
from robotcell.robot.robot import Body, Capsule, Joint, Poses, Robot, pose
from robotcell.robot.urdf import read_urdf
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, parse_spec, read_text
from specs.yaml.located import Located, YamlPath, read_yaml
from specs.yaml.problems import Problem, raise_problems
from specs.yaml.schema import name_nearest

_LIBRARY = Path(__file__).parents[1] / "library" / "robots"


def robot_library() -> dict[str, Path]:
    """Give the robots that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*/*.yaml"))}


_SHORTEST_M = 1e-6
"""Lengths below have no rod."""
_RATES = (("speed", "s"), ("acceleration", "s2"))
ROBOT = FileKind("robot", "robot: NAME", "washboard cell", CellError, RobotFile, robot_library)


def load_robot(source: str | Path) -> Robot:
    """Read a robot with all its limits.

    Args:
        source: A name of the library such as ``ur5e``, or a robot's YAML file.

    Raises:
        CellError: it cannot be found or used; the message names the place and the remedy.
    """
    root, spec = read_robot_file(source)
    robot = build_robot(spec, Path(root.mark.file).parent, root, ())
    require_limits(robot, root, ("joints",))
    return replace(robot, name=spec.robot)


def read_robot_file(source: str | Path) -> tuple[Located, RobotFile]:
    """Read a robot's YAML file: its tree with lines, and its specification.

    Raises:
        CellError: it cannot be found or used.
    """
    path = find_file(source, ROBOT)
    root = read_yaml(read_text(path, ROBOT), path, ROBOT)
    return root, parse_spec(root, ROBOT)


def build_robot(spec: RobotSpec, folder: Path, root: Located, path: YamlPath) -> Robot:
    """Read a robot's URDF or its table, and set the limits that stand beside it.

    Args:
        spec: The robot as written.
        folder: Where a relative path to its URDF begins.
        root: The YAML file it stands in, for errors.
        path: Where in that file.

    Raises:
        CellError: the URDF or the table cannot be used, or the limits or the controller's counts do not fit its joints.
    """
    robot = limit_joints(_read_chain(spec, folder, root, path), spec.joints, root, (*path, "joints"))
    if spec.dh is not None:
        for joint in robot.joints:  # no table has a range and a greatest speed
            for key, value in (
                (f"position_{joint.unit.key}", joint.highest),
                (f"speed_{joint.unit.key}_s", joint.speed),
            ):
                if math.isinf(value):
                    message = f"a table has no limits: state {key} of {joint.name}, or of all, under joints beside it"
                    raise_problems([Problem((*path, "dh"), message)], root, ROBOT)
    convention = _read_convention(robot, spec.controller_joints, root, (*path, "controller_joints"))
    return replace(robot, maker=spec.maker, convention=convention)


def _read_chain(spec: RobotSpec, folder: Path, root: Located, path: YamlPath) -> Robot:
    """Read the joints and bodies of a robot, with the limits that its URDF has."""
    if spec.dh is not None:
        names = [row.name for row in spec.dh.table]
        repeated = [
            Problem((*path, "dh", "table", index, "name"), f"{name} is a joint above already; each has its own name")
            for index, name in enumerate(names)
            if name in names[:index]
        ]
        raise_problems(repeated, root, ROBOT)
        return build_dh_robot(spec.dh)
    file = spec.urdf or ""
    if "\0" in file:
        raise error_at(root, (*path, "urdf"), "cannot be the name of a file")
    with errors_at(root, (*path, "urdf")):
        return read_urdf(folder / file, base_link=spec.base_link, flange_link=spec.flange_link)


def _read_convention(
    robot: Robot, stated: Literal["same"] | dict[str, ControllerJoint] | None, root: Located, path: YamlPath
) -> JointConvention | None:
    """Give how the controller counts the joints of a robot; ``None`` where it counts them as the robot does."""
    if stated is None or stated == "same":
        return None
    joints = {joint.name: index for index, joint in enumerate(robot.joints)}
    raise_problems(list(_find_count_problems(robot, stated, path)), root, ROBOT)
    rows, zeros = np.eye(robot.dof), np.zeros(robot.dof)
    for name, count in stated.items():
        at = joints[name]
        rows[at, at], zeros[at] = count.sign, count.zero_deg + count.zero_mm
        for other, share in count.plus.items():
            rows[at, joints[other]] = share
    if abs(np.linalg.det(rows)) < 0.5:  # the entries are whole numbers
        raise error_at(root, path, "two joints would have the same count; let couplings go one way")
    return JointConvention(tuple(tuple(row) for row in rows.tolist()), tuple(zeros.tolist()))


def _find_count_problems(robot: Robot, stated: dict[str, ControllerJoint], path: YamlPath) -> Iterator[Problem]:
    """Find joints that are not there, couplings of a joint with itself or another kind, and zeros in the other unit."""
    kinds = {joint.name: joint.kind for joint in robot.joints}
    for name, count in stated.items():
        if name not in kinds:
            yield Problem((*path, name), f"no joint of {robot.name}; {name_nearest(name, kinds)}")
            continue
        wrong, right = ("zero_deg", "zero_mm") if kinds[name] == "prismatic" else ("zero_mm", "zero_deg")
        if getattr(count, wrong):
            yield Problem((*path, name, wrong), f"{name} takes {right}")
        for other in count.plus:
            if other not in kinds or other == name:
                known = name_nearest(other, [each for each in kinds if each != name])
                yield Problem((*path, name, "plus", other), f"no other joint of {robot.name}; {known}")
            elif kinds[other] != kinds[name]:
                yield Problem((*path, name, "plus", other), f"{other} and {name} do not both turn or both slide")


def limit_joints(robot: Robot, limits: dict[str, JointLimits], root: Located, path: YamlPath) -> Robot:
    """Set limits by joint; those of ``all`` come first, those of one joint override them.

    Raises:
        CellError: a joint is not there, or takes the other unit.
    """
    names = [joint.name for joint in robot.joints]
    problems = [
        Problem((*path, name), f"no joint of {robot.name}; {name_nearest(name, [*names, 'all'])}")
        for name in limits
        if name not in names and name != "all"
    ]
    for joint in robot.joints:
        if joint.name in limits:
            wrong, right, does = ("_deg", "mm", "slides") if joint.kind == "prismatic" else ("_mm", "degrees", "turns")
            problems += [
                Problem((*path, joint.name, key), f"{joint.name} {does}; state {right}")
                for key in JointLimits.model_fields
                if wrong in key and getattr(limits[joint.name], key) is not None
            ]
    raise_problems(problems, root, ROBOT)
    joints = [
        _limit(_limit(joint, limits.get("all", JointLimits())), limits.get(joint.name, JointLimits()))
        for joint in robot.joints
    ]
    return replace(robot, joints=tuple(joints))


def bound_turns(robot: Robot, turns: float) -> Robot:
    """Bound joints that turn to so many whole turns either way from zero, where their limits are wider."""
    most = 2.0 * math.pi * turns
    joints = (
        replace(joint, lowest=max(joint.lowest, -most), highest=min(joint.highest, most))
        if joint.kind == "revolute"
        else joint
        for joint in robot.joints
    )
    return replace(robot, joints=tuple(joints))


def require_limits(robot: Robot, root: Located, path: YamlPath) -> None:
    """Make sure that every joint has a greatest acceleration, which no URDF has.

    Raises:
        CellError: a joint has none.
    """
    for joint in robot.joints:
        if math.isinf(joint.acceleration):
            key = f"acceleration_{joint.unit.key}_s2"
            message = f"joint {joint.name} needs a greatest acceleration; state {key} for it or all"
            raise_problems([Problem(path, message)], root, ROBOT)


def _limit(joint: Joint, limits: JointLimits) -> Joint:
    unit = joint.unit
    position: tuple[float, float] | None = getattr(limits, f"position_{unit.key}")
    speed, acceleration = (getattr(limits, f"{key}_{unit.key}_{per}") for key, per in _RATES)
    lowest, highest = (joint.lowest, joint.highest) if position is None else (unit.si * each for each in position)
    return replace(
        joint,
        lowest=lowest,
        highest=highest,
        speed=joint.speed if speed is None else unit.si * speed,
        acceleration=joint.acceleration if acceleration is None else unit.si * acceleration,
    )


def build_dh_robot(spec: DhSpec) -> Robot:
    """Build a robot whose joints turn about or slide along the z axes of a table, with rods around their lengths.

    With Rz, Tz, Tx, Rx the turns and ways of a row, a step is Rz Tz Tx Rx in the standard convention, that of Denavit
    and Hartenberg, and Rx Tx Rz Tz in the modified one, that of Craig. Speeds, accelerations and limits are infinite
    until something else states them.
    """
    joints: list[Joint] = []
    bodies: list[list[Body]] = [[]]
    is_modified, carried = spec.convention == "modified", np.eye(4)  # the frame before the next joint, on its link
    for row in spec.table:
        d, a, radius = (1e-3 * each for each in (row.d_mm, row.a_mm, row.radius_mm))
        along = pose((0, 0, d), (0, 0, math.radians(row.theta_deg)))
        across = pose((a, 0, 0), (math.radians(row.alpha_deg), 0, 0))
        before, after = (across, along) if is_modified else (np.eye(4), along @ across)
        if is_modified:
            bodies[-1] += _rod(joints[-1].name if joints else "base", carried, (a, 0.0, 0.0), radius)
        axis = np.array([0.0, 0.0, 1.0])
        joints.append(Joint(row.name, row.kind, carried @ before, axis, -math.inf, math.inf, math.inf, math.inf))
        bodies.append(_rod(row.name, np.eye(4), (0.0, 0.0, d), radius))
        if not is_modified:
            bodies[-1] += _rod(row.name, along, (a, 0.0, 0.0), radius)
        carried = after
    T_last_flange = place_pose(spec.flange)
    x, y, z = T_last_flange[:3, 3].tolist()
    bodies[-1] += _rod(joints[-1].name, carried, (x, y, z), 1e-3 * spec.table[-1].radius_mm)
    return Robot(spec.name, tuple(joints), carried @ T_last_flange, tuple(tuple(each) for each in bodies))


def _rod(name: str, T_link_start: Poses, way: tuple[float, float, float], radius: float) -> list[Body]:
    """Give the rod along a way from a frame of its link; none where the way has no length."""
    length = float(np.linalg.norm(way))
    if length < _SHORTEST_M:
        return []
    x, y, z = (each / length for each in way)
    turned = pose([0.5 * each for each in way], (0.0, np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)))
    return [Body(name, Capsule(radius, length), T_link_start @ turned)]
