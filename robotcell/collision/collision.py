"""Whether a robot in its cell touches anything: the board, what stands around, or itself. Metres, radians.

What counts as a collision:

- a link nearer to the board or to a fixture than the cell's margin;
- a body of the tool nearer to a fixture than the margin, or to the board than ``CONTACT``: how high the nozzle flies
  above the board is the recipe's business (``robotcell.clearance`` says how near it comes);
- two bodies of robot and tool nearer to each other than ``CONTACT``.

What does not: a link with its neighbours; bodies of robot and tool that touch each other at home (they are made so);
the base, which stands still; the first link with a fixture that the base stands on.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from boards.board import Board
from robotcell.cell.cell import Cell
from robotcell.collision.body_pairs import (
    CONTACT,
    RESOLUTION,
    Items,
    Places,
    Scene,
    all_pairs,
    near_items,
    place,
    without,
)
from robotcell.collision.coal_bodies import Solid, board_solid, fixture_solids, robot_solids, tool_solids
from robotcell.collision.contacts import Touch, probe_of, touch_of
from robotcell.collision.contacts import distances as contact_distances
from robotcell.errors import CellError
from robotcell.robot.robot import Joints, Poses

_AT_ONCE = 100_000
"""Pairs looked at in one array: bounds the memory."""


@dataclass(frozen=True, slots=True, eq=False)
class Collider:
    """A cell and a board, ready to be asked."""

    scenes: Mapping[int, Scene]
    """By the number of the tool that is carried."""
    T_cell_board: Poses


def build_collider(cell: Cell, board: Board | None) -> Collider:
    """Prepare a cell for questions about collisions; without a board only the cell itself is checked.

    Raises:
        CellError: Coal is not installed.
    """
    around = (*fixture_solids(cell), *robot_solids(cell))
    above = () if board is None else (board_solid(board, cell.T_cell_board),)
    scenes = {tool.number: _scene(cell, (*around, *tool_solids(cell, tool), *above)) for tool in cell.tools}
    return Collider(MappingProxyType(scenes), cell.T_cell_board)


def with_board_at(collider: Collider, T_cell_board: Poses) -> Collider:
    """Move the board to another place, without preparing anything anew."""
    moved = T_cell_board @ np.linalg.inv(collider.T_cell_board)
    scenes = {number: replace(scene, solids=_moved(scene.solids, moved)) for number, scene in collider.scenes.items()}
    return Collider(MappingProxyType(scenes), T_cell_board)


def collides(collider: Collider, q: Joints, tool: int) -> NDArray[np.bool_]:
    """Say (n,) for each of (n, dof) rows of joints whether anything collides.

    Raises:
        CellError: The cell has no such tool.
    """
    scene = scene_of(collider, tool)
    hit = np.zeros(len(q), np.bool_)
    for start, places in in_chunks(scene, q):
        items = near_items(scene, places, scene.margins)
        found = contact_distances(scene, places, items, items.rows)
        hit[start + items.rows[np.isfinite(found)]] = True
    return hit


def first_pairs(collider: Collider, q: Joints, tool: int) -> tuple[Touch | None, ...]:
    """Name for each of (n, dof) rows the first pair that collides: fixtures, then the robot itself, then the board.

    Raises:
        CellError: The cell has no such tool.
    """
    scene = scene_of(collider, tool)
    touches: list[Touch | None] = [None] * len(q)
    for start, places in in_chunks(scene, q):
        items, probe = near_items(scene, places, scene.margins), probe_of(scene, places)
        for row, pair in zip(items.rows.tolist(), items.pairs.tolist(), strict=True):
            if touches[start + row] is not None:
                continue
            contact = probe(row, pair, float(scene.margins[pair]))
            if contact is not None:
                touches[start + row] = touch_of(scene, pair, contact)
    return tuple(touches)


def scene_of(collider: Collider, tool: int) -> Scene:
    """Give the scene with a tool.

    Raises:
        CellError: The cell has no such tool.
    """
    if tool not in collider.scenes:
        known = ", ".join(str(number) for number in collider.scenes) or "none"
        raise CellError(
            f"the cell has no tool {tool} (it has {known}); add it to the cell, or correct the nozzle's tool"
        )
    return collider.scenes[tool]


def in_chunks(scene: Scene, q: Joints) -> Iterator[tuple[int, Places]]:
    """Place the bodies at (n, dof) rows, some rows at a time: the first row's index, and the places.

    Raises:
        ValueError: The rows are not (n, dof) finite numbers.
    """
    if q.ndim != 2 or q.shape[1] != scene.robot.dof or not np.isfinite(q).all():
        raise ValueError(f"joints must be finite and of shape (n, {scene.robot.dof}), not {q.shape}")
    step = max(1, _AT_ONCE // max(1, len(scene.first)))
    for start in range(0, len(q), step):
        yield start, place(scene, q[start : start + step])


def _scene(cell: Cell, solids: tuple[Solid, ...]) -> Scene:
    scene = all_pairs(cell, solids)
    return without(scene, _made_to_touch(scene, cell.home) | _under_the_base(scene))


def _made_to_touch(scene: Scene, home: Joints) -> NDArray[np.bool_]:
    """(pairs,) bodies of robot and tool that are at home as near as a swept check could mistake for touching."""
    places = place(scene, home[None])
    items = near_items(scene, places, np.where(scene.outside, -np.inf, CONTACT + RESOLUTION))
    found = contact_distances(scene, places, items, np.arange(len(items.rows)))
    dropped = np.zeros(len(scene.first), np.bool_)
    dropped[items.pairs[np.isfinite(found)]] = True
    return dropped


def _under_the_base(scene: Scene) -> NDArray[np.bool_]:
    """(pairs,) the first link with every fixture that the base touches."""
    solids = scene.solids
    fixtures = [index for index, solid in enumerate(solids) if solid.part == "fixture"]
    bases = [index for index, solid in enumerate(solids) if solid.part == "robot" and solid.link == 0]
    first, second = (grid.ravel() for grid in np.meshgrid(fixtures, bases, indexing="ij"))
    standing = replace(
        scene, first=first.astype(np.int64), second=second.astype(np.int64), margins=np.full(len(first), CONTACT)
    )
    places = place(standing, np.zeros((1, scene.robot.dof)))
    items = Items(np.zeros(len(first), np.int64), np.arange(len(first)), standing.margins)
    met = np.isfinite(contact_distances(standing, places, items, np.arange(len(first))))
    carrying = set(first[met].tolist())
    return np.array(
        [one in carrying and solids[other].link == 1 for one, other in zip(scene.first, scene.second, strict=True)],
        np.bool_,
    )


def _moved(solids: tuple[Solid, ...], by: Poses) -> tuple[Solid, ...]:
    return tuple(
        replace(solid, T_link_solid=by @ solid.T_link_solid) if solid.part == "board" else solid for solid in solids
    )
