"""From bodies to a board: its planes, its outline, its components and what stands in the way."""

import hashlib
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
import shapely
from shapely import Polygon

from boards.board import Board, Body, Obstacle, Side
from boards.bounds import check_bodies, check_crowds
from boards.components import Shape, component_of, shape_of, side_of, with_neighbours
from boards.errors import BoardError
from boards.formats.names import canonical_order
from boards.formats.tri.tri import write_tri
from boards.slab import find_slab
from geometry.arrays import Scalars
from geometry.gridframe import GridFrame, find_grid_frame
from geometry.polygons import GRID_MM, canonical, drop_collinear, join_pieces, polygons_of, project, simplify_within
from specs.finding import Finding, FindingRule, worst_first
from specs.finding_rules import ALL_ON_BOTTOM, BOARD_IN_PIECES, COMPONENT_FLOATING, COMPONENT_OUTSIDE, COMPONENT_SUNK

_OUTLINE_TOLERANCE_MM = 0.01
_LEAST_RISE_MM = 1e-3
_FAR_MM = 5.0
_ABSURD_MM = 1e9
_FLOATING_MM = 5.0
_NAMES_IN_A_MESSAGE = 20


def understand(bodies: Iterable[Body], name: str, findings: Iterable[Finding] = ()) -> Board:
    """Understand a board: every measure the planner needs, taken from the bodies alone.

    Args:
        bodies: One board and what stands on it, in any order. Board frame, mm.
        name: What to call the board.
        findings: What was noticed while reading; the board's own are added.

    Raises:
        BoardError: There is no board or more than one, it is not level, or a component cannot be understood.
    """
    bodies = canonical_order(bodies)
    check_bodies(bodies, _ABSURD_MM)
    slab = find_slab(_only_board(bodies))  # a board in wrong units is recognised, and the units named
    check_bodies(bodies)
    check_crowds([_plan_bounds(body) for body in bodies])
    frame = find_grid_frame(slab.face)
    outline, pieces = _outline_of(_only_board(bodies), frame)
    shapes = [shape_of(body, slab, frame) for body in bodies if body.role != "board"]
    parts = [shape for shape in shapes if shape.body.role == "component"]
    stated = [shape for shape in parts if shape.body.side is not None]
    wrong = [shape for shape in stated if _height_on(shape, side_of(shape)) < _LEAST_RISE_MM]
    if len(wrong) > 1 and 2 * len(wrong) > len(stated):
        raise BoardError(
            f"the board is upside down: {len(wrong)} of {len(stated)} components lie on the other side than the one "
            f"stated (such as {wrong[0].body.name}, side={wrong[0].body.side}). "
            "Turn the board over so that z points out of its top side, or correct the sides."
        )
    components = with_neighbours([component_of(shape) for shape in parts], [shape.framed[1] for shape in parts])
    points = np.asarray(outline.exterior.coords)[:, :2]
    edges = np.diff(points, axis=0)
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    longest = int(np.argmax(np.round(lengths / (128.0 * GRID_MM))))
    x, y = (edges[longest] / lengths[longest] + 0.0).tolist()
    noticed = [*findings, *pieces, *_check_places(parts, outline)]
    return Board(
        name=name,
        sha256=hashlib.sha256(write_tri(bodies).encode()).hexdigest(),
        bodies=bodies,
        outline=outline,
        axis=(x, y),
        top_z_mm=slab.top_z_mm,
        bottom_z_mm=slab.bottom_z_mm,
        components=components,
        top_obstacles=_obstacles(shapes, "top"),
        bottom_obstacles=_obstacles(shapes, "bottom"),
        findings=worst_first(noticed),
    )


def _plan_bounds(body: Body) -> Scalars:
    plan = body.patches[:, :, :2]
    return np.concatenate([plan.min(axis=(0, 1)), plan.max(axis=(0, 1))])


def _only_board(bodies: Sequence[Body]) -> Body:
    boards = [body for body in bodies if body.role == "board"]
    if len(boards) == 1:
        return boards[0]
    if not boards:
        raise BoardError("there is no board among the objects. Give the bare board role=board.")
    names = ", ".join(body.name for body in boards[:_NAMES_IN_A_MESSAGE])
    raise BoardError(f"there are {len(boards)} boards ({names}). Give role=board to one of them.")


def _outline_of(board: Body, frame: GridFrame) -> tuple[Polygon, list[Finding]]:
    """Project the bare board; holes and slots that go through it stay.

    Raises:
        BoardError: It covers nothing.
    """
    framed = frame.triangles_to_frame(board.patches)
    anchors = framed[:, :, :2].reshape(-1, 2)
    shadow = project(framed)
    if shadow.is_empty:
        raise BoardError(
            f"the board {board.name} has no area seen from above: it is thinner than a line. "
            "Check its model and the units."
        )
    joined = canonical(drop_collinear(join_pieces(shadow)), anchors)
    simple = simplify_within(joined, _OUTLINE_TOLERANCE_MM)
    outline = frame.polygons_from_frame([simple], anchors, board.patches[:, :, :2].reshape(-1, 2))[0]
    count = len(polygons_of(shadow))
    if count == 1:
        return outline, []
    message = f"The bare board is in {count} pieces: its outline joins them across the gaps."
    return outline, [Finding(BOARD_IN_PIECES, message)]


def _height_on(shape: Shape, side: Side) -> float:
    return shape.above_mm if side == "top" else shape.below_mm


def _check_places(parts: Sequence[Shape], outline: Polygon) -> Iterator[Finding]:
    """Find components beside the board, in the air, or sunk into it; all below where no side is stated."""
    if len(parts) > 1 and not any(shape.body.side is not None or side_of(shape) == "top" for shape in parts):
        message = f"All {len(parts)} components lie on the bottom. If the board is upside down, turn it over."
        yield Finding(ALL_ON_BOTTOM, message)
    inside = Polygon(outline.exterior)
    shapely.prepare(inside)
    shapes = np.array([shape.outline for shape in parts], dtype=object)
    outside = np.round(shapely.distance(shapes, inside), 4).tolist() if parts else []
    for shape, distance in zip(parts, outside, strict=True):
        name = shape.body.name
        side = side_of(shape)
        share = shape.share_above if side == "top" else shape.share_below
        if distance > _FAR_MM:
            message = f"{name} lies {distance:.1f} mm outside the board's outline. Is its place right?"
            yield _place_finding(COMPONENT_OUTSIDE, message, shape)
        if shape.gap_mm > _FLOATING_MM:
            message = f"{name} floats {shape.gap_mm:.1f} mm away from the board. Is its model in the right place?"
            yield _place_finding(COMPONENT_FLOATING, message, shape)
        elif share < 0.5:
            message = (
                f"{name} is sunk: only {100 * share:.0f} % of its surface lies above the {side} side it belongs to."
            )
            yield _place_finding(COMPONENT_SUNK, message, shape)


def _place_finding(rule: FindingRule, message: str, shape: Shape) -> Finding:
    where = np.round(shape.body.patches.reshape(-1, 3).mean(axis=0), 3).tolist()
    return Finding(rule, message, where=(where[0], where[1], where[2]))


def _obstacles(shapes: Sequence[Shape], side: Side) -> tuple[Obstacle, ...]:
    return tuple(
        Obstacle(shape.body.name, shape.prism, _height_on(shape, side))
        for shape in shapes
        if _height_on(shape, side) > _LEAST_RISE_MM
    )
