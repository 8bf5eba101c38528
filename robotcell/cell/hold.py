"""The board in the cell: by which point it is held, and the pose of that: stated, measured at fiducials, or touched.

It is held by a corner or the centre of its outline, wherever the origin of its file is. Fiducials give a rigid, scaled
or affine fit with residuals and covariance, in millimetres.
"""

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from robotcell.cell.cell import place_pose
from robotcell.cell.spec import HeldBy, Hold, PointPair
from robotcell.errors import CellError
from robotcell.robot.robot import Poses

_MM = 1e-3


def held_frame(held_by: HeldBy, board: Workpiece | None) -> Poses:
    """Give (4, 4) T_board_held, metres: the held point, with the board's axes."""
    T_board_held = np.eye(4)
    if board is not None:
        T_board_held[:3, 3] = _MM * held_point_mm(held_by, board)
    return T_board_held


def held_point_mm(held_by: HeldBy, board: Workpiece) -> NDArray[np.float64]:
    """Give a point (3,) of the rectangle around a workpiece, as ``plan_bounds_mm`` has it, in its frame, mm."""
    if held_by == "origin":
        return np.zeros(3)
    left, front, right, back, level = plan_bounds_mm(board)
    if held_by == "centre":
        return np.array([0.5 * (left + right), 0.5 * (front + back), level])
    x = left if held_by.endswith("left") else right
    return np.array([x, front if held_by.startswith("front") else back, level])


def plan_bounds_mm(workpiece: Workpiece) -> tuple[float, float, float, float, float]:
    """Give left, front, right and back of a workpiece without its fixtures, and the z at which a cell holds it, mm.

    A board is held at its top surface, a part stands on its lowest point.
    """
    (left, front, _), (right, back, _) = (corner.tolist() for corner in workpiece.box)
    return left, front, right, back, workpiece.held_z_mm


def describe_held(held_by: HeldBy) -> str:
    """Name a held point, as in ``"front left corner"``."""
    if held_by == "origin":
        return "origin of its file"
    return "centre" if held_by == "centre" else f"{held_by.replace('_', ' ')} corner"


def board_pose(hold: Hold) -> Poses:
    """Give (4, 4) the pose in the cell of the point that the board is held by, with the board's axes, metres.

    Raises:
        CellError: measured points lie on a line, or do not fit those of the board; the reader adds file and line.
    """
    if hold.pose is not None:
        return place_pose(hold.pose)
    if hold.points is not None:
        fit = fit_fiducials(hold)
        return _assemble(fit.turn, fit.place_mm)
    if hold.touched is not None:
        points = np.array([hold.touched.origin_mm, hold.touched.on_x_mm, hold.touched.on_xy_mm])
        check_plane(points, "in the cell")
        x = points[1] - points[0]
        z = np.cross(x, points[2] - points[0])
        x /= np.linalg.norm(x)
        z /= np.linalg.norm(z)
        turn: NDArray[np.float64] = np.column_stack([x, np.cross(z, x), z])
        return _assemble(turn, points[0] - turn @ np.array(hold.touched.board_mm or (0.0, 0.0, 0.0)))
    raise AssertionError("a hold gives the pose in one of three ways")


def _assemble(turn: NDArray[np.float64], place_mm: NDArray[np.float64]) -> Poses:
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = turn, _MM * place_mm
    return result


FitKind: TypeAlias = Literal["rigid", "scaled", "affine"]
_Array: TypeAlias = NDArray[np.float64]

_THINNEST = 0.02
"""Height of the triangle of three points to its longest side, below which their plane is not known well."""
_LEAST_APART_MM = 1.0
_FLAT_MM = 0.5
"""Points of an affine fit lie in one plane of the board within this."""
_UNITS = ((1000.0, "metres"), (25.4, "inches"), (1 / 1000.0, "micrometres"), (1 / 25.4, "thousandths of an inch"))


@dataclass(frozen=True, slots=True, eq=False)
class FiducialFit:
    """Where measured points put a board. Millimetres and radians."""

    kind: FitKind
    turn: _Array
    """(3, 3) rotation of the board in the cell."""
    place_mm: _Array
    """(3,) of the origin of the board's file in the cell."""
    stretch: _Array
    """(2, 2) symmetric: by how much the board's x and y are stretched about the middle of the points; 1 if rigid."""
    middle_mm: _Array
    """(3,) of the points, in the cell."""
    residuals_mm: _Array
    """(n, 3) measured less fitted, in the cell."""
    covariance: _Array
    """(6, 6) of rotations about the cell's axes (rad) and the place of the middle (mm), for the stated noise.

    It is zero for what two points leave open and the stated normal gives.
    """
    redundancy: int
    """Measured coordinates less fitted parameters."""

    @property
    def distances_mm(self) -> _Array:
        """(n,) distance of each measured point from where the fit puts it."""
        return np.linalg.norm(self.residuals_mm, axis=1)

    @property
    def noise_mm(self) -> float:
        """Standard deviation of one coordinate by the residuals; NaN without redundancy."""
        if self.redundancy < 1:
            return math.nan
        return math.sqrt(float((self.residuals_mm**2).sum()) / self.redundancy)


def fit_fiducials(hold: Hold) -> FiducialFit:
    """Fit the pose of the board to the measured points of a hold.

    Rigid and scaled: Arun, Huang and Blostein (1987) and Umeyama (1991), by singular values of the covariance. Affine:
    least squares, whose polar decomposition gives the rotation and the stretch. Two points leave the board's normal
    open, which the hold states.

    Raises:
        CellError: points coincide, lie on a line, or do not fit; the outlying pair is named.
    """
    pairs = hold.points or []
    on_board, in_cell = (np.array([getattr(pair, key) for pair in pairs]) for key in ("board_mm", "cell_mm"))
    _check_spread(on_board, "on the board")
    _check_spread(in_cell, "in the cell")
    fit = _fit(on_board, in_cell, hold)
    if float(fit.distances_mm.max()) > hold.largest_residual_mm:
        raise _misfit(pairs, fit, hold)
    return fit


def check_plane(points: _Array, where: str) -> None:
    """Refuse three points on a line.

    Raises:
        CellError: They are.
    """
    doubled = float(np.linalg.norm(np.cross(points[1] - points[0], points[2] - points[0])))
    longest = max(math.dist(a, b) for a, b in combinations(points.tolist(), 2))
    if doubled <= _THINNEST * longest**2:
        raise CellError(f"the three points lie on one line {where}; choose three corners")


def _check_spread(points: _Array, where: str) -> None:
    if len(points) == 2:
        if math.dist(*points) < _LEAST_APART_MM:
            raise CellError(f"the two points are less than {_LEAST_APART_MM:g} mm apart {where}; choose two corners")
    elif len(points) == 3:
        check_plane(points, where)
    else:
        spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
        if spread[1] <= _THINNEST * spread[0]:
            raise CellError(f"the points lie on one line {where}; choose some beside it")


def _fit(on_board: _Array, in_cell: _Array, hold: Hold) -> FiducialFit:
    from_middle, to_middle = on_board.mean(axis=0), in_cell.mean(axis=0)
    here, there = on_board - from_middle, in_cell - to_middle
    stretch = np.eye(2)
    if len(on_board) == 2:
        turn = _turn_of_two(here[1] - here[0], there[1] - there[0], np.array(hold.normal or (0.0, 0.0, 1.0)))
    elif hold.fit == "affine":
        turn, stretch = _affine(here, there)
    else:
        left, _, right = np.linalg.svd(here.T @ there)  # three points fit a turn as well as its mirror image
        turn = (left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right).T
    if hold.fit == "scaled":
        turned = here @ turn.T
        stretch = np.eye(2) * float((turned * there).sum() / (turned**2).sum())
    shape = np.eye(3)
    shape[:2, :2] = stretch
    stretched = here @ shape.T
    jacobian = _jacobian(stretched @ turn.T, here, turn, hold, len(on_board))
    information = jacobian.T @ jacobian
    covariance = np.zeros((6, 6))
    free = [2, 3, 4, 5] if len(on_board) == 2 else list(range(6))
    inverse = np.linalg.inv(information) * hold.noise_mm**2
    covariance[np.ix_(free, free)] = inverse[: len(free), : len(free)]
    if len(on_board) == 2:  # the free rotation is about the normal
        axes = np.eye(6)
        axes[:3, 2] = turn[:, 2]
        covariance = axes @ covariance @ axes.T
    return FiducialFit(
        hold.fit,
        turn,
        to_middle - turn @ from_middle,
        stretch,
        to_middle,
        there - stretched @ turn.T,
        covariance,
        3 * len(on_board) - jacobian.shape[1],
    )


def _affine(here: _Array, there: _Array) -> tuple[_Array, _Array]:
    """Rotation and symmetric stretch (2, 2) of the board's plane: the polar factors of the best linear map."""
    if float(np.ptp(here[:, 2])) > _FLAT_MM:
        raise CellError("an affine fit needs points at one height on the board; give those of one side")
    linear = np.linalg.lstsq(here[:, :2], there, rcond=None)[0].T
    left, sizes, right = np.linalg.svd(linear, full_matrices=False)
    axes = left @ right
    turn = np.column_stack([axes, np.cross(axes[:, 0], axes[:, 1])])
    return turn, right.T @ np.diag(sizes) @ right


def _turn_of_two(here: _Array, there: _Array, normal: _Array) -> _Array:
    """Rotation that lays the board's +z on the normal, and its line of two points over the measured one."""
    up = normal / np.linalg.norm(normal)
    level = there - up * (up @ there)
    if np.hypot(here[0], here[1]) < _LEAST_APART_MM or np.linalg.norm(level) < _LEAST_APART_MM:
        raise CellError("the two points lie above one another; choose two corners")
    along = level / np.linalg.norm(level)
    across = np.cross(up, along)
    angle = math.atan2(here[1], here[0])
    x = math.cos(angle) * along - math.sin(angle) * across
    return np.column_stack([x, np.cross(up, x), up])


def _jacobian(placed: _Array, here: _Array, turn: _Array, hold: Hold, count: int) -> _Array:
    """(3n, k) change of the points with rotations about the middle, its place, and the stretch."""
    rotations = np.eye(3) if count > 2 else turn[:, 2:].T
    columns = [np.cross(axis, placed).ravel() for axis in rotations]
    columns += [np.tile(axis, (count, 1)).ravel() for axis in np.eye(3)]
    match hold.fit:
        case "rigid":
            shapes: list[_Array] = []
        case "scaled":
            shapes = [np.eye(2)]
        case "affine":
            shapes = [np.diag([1.0, 0.0]), np.diag([0.0, 1.0]), np.array([[0.0, 1.0], [1.0, 0.0]])]
    columns += [(here[:, :2] @ shape.T @ turn[:, :2].T).ravel() for shape in shapes]
    return np.column_stack(columns)


def _misfit(pairs: list[PointPair], fit: FiducialFit, hold: Hold) -> CellError:
    """Error that names the outlying pair where more points than needed decide, else two distances."""
    on_board, in_cell = (np.array([getattr(pair, key) for pair in pairs]) for key in ("board_mm", "cell_mm"))
    sides = list(combinations(range(len(pairs)), 2))  # distances can be checked with a ruler
    there, here = ([math.dist(points[a], points[b]) for a, b in sides] for points in (on_board, in_cell))
    ratio = sum(there) / sum(here)
    units = [unit for factor, unit in _UNITS if abs(ratio / factor - 1) < 0.02]
    hint = f"the cell's points look like {units[0]}" if units else "measure again, or raise largest_residual_mm"
    residual = float(fit.distances_mm.max())
    if len(pairs) > 3 and not units:
        kept = [np.delete(np.arange(len(pairs)), index) for index in range(len(pairs))]
        fits = [_fit(on_board[rows], in_cell[rows], hold) for rows in kept]
        outlier = min(range(len(pairs)), key=lambda index: round(float((fits[index].residuals_mm ** 2).sum()), 9))
        other = fits[outlier]
        if float(other.distances_mm.max()) <= hold.largest_residual_mm:
            shape = np.eye(3)
            shape[:2, :2] = other.stretch
            middle = on_board[kept[outlier]].mean(axis=0)
            expected = other.turn @ shape @ (on_board[outlier] - middle) + other.middle_mm
            off = math.dist(expected, in_cell[outlier])
            return CellError(
                f"point {outlier} was measured {off:.2f} mm from where the other {len(pairs) - 1} put it, which agree "
                f"within {float(other.distances_mm.max()):.2f} mm; measure it again or leave it out"
            )
    worst = max(range(len(sides)), key=lambda index: round(abs(there[index] - here[index]), 6))
    return CellError(
        f"points {sides[worst][0]} and {sides[worst][1]} are {there[worst]:.2f} mm apart on the board but "
        f"{here[worst]:.2f} mm in the cell; the best fit leaves {residual:.2f} mm; {hint}"
    )
