"""Remedies for a cell that cannot do a program: a classical mistake undone, else the smallest shift of the board."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from boards.board import Board
from geometry.arrays import Indices
from robotcell.cell.cell import Cell, Tool
from robotcell.collision.collision import build_collider, with_board_at
from robotcell.motion.sampled_path import SampledPath
from robotcell.placement.reachability import Targets, clear_of, configurations_at
from robotcell.robot.poses import pose
from robotcell.robot.robot import Poses

_AZIMUTHS = 8
_SHIFTS_MM = (20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 800.0, 1200.0)
_YAWS_DEG = (15.0, 30.0, 45.0, 90.0, 135.0, 180.0)
_MOST_TARGETS = 40


@dataclass(frozen=True, slots=True, eq=False)
class _Change:
    """A cell that differs in one thing."""

    text: str
    """The change, as a condition: ``"with the TCP turned ..."``."""
    cell: Cell


def sample_targets(path: SampledPath, nodes: Indices, wrong: Indices) -> Targets:
    """Choose some samples of a path: of those that are wrong, and of all; with the board as the cell holds it."""
    chosen = [np.zeros(0, dtype=np.int64)]
    for samples in (wrong[path.placement[wrong] == 0], nodes[path.placement[nodes] == 0]):
        count = min(len(samples), _MOST_TARGETS // 2)
        chosen.append(samples[np.round(np.linspace(0, len(samples) - 1, count)).astype(np.int64)])
    at = np.unique(np.concatenate(chosen))
    return Targets(np.linalg.inv(path.T_base_board[0]) @ path.T_base_tcp[at], path.tool[at], path.free[at])


def find_remedy(cell: Cell, board: Board | None, targets: Targets) -> str | None:
    """Find a change that makes every target reachable and clear; ``None`` if nothing that was tried does.

    Each target is checked on its own, not the motion from one to the next.
    """
    collider = build_collider(cell, board)
    for change in (*_mistakes(cell), *_shifts(cell)):
        found = configurations_at(change.cell, change.cell.T_cell_board, targets, _AZIMUTHS)
        if len(np.unique(found.target)) < len(targets.tool):
            continue
        moved_only = change.cell.tools is cell.tools and change.cell.T_cell_base is cell.T_cell_base
        there = with_board_at(collider, change.cell.T_cell_board) if moved_only else build_collider(change.cell, board)
        if len(np.unique(clear_of(change.cell, there, targets, found).target)) == len(targets.tool):
            return f"{change.text} every point would be reachable without collision"
    return None


def share_reached(cell: Cell, targets: Targets) -> float:
    """Give the share of the targets that some configuration within the limits reaches."""
    found = configurations_at(cell, cell.T_cell_board, targets, _AZIMUTHS)
    return len(np.unique(found.target)) / len(targets.tool)


def _mistakes(cell: Cell) -> Iterator[_Change]:
    """Give the cell with each classical mistake undone."""
    for axis, turn in (("X", (np.pi, 0.0, 0.0)), ("Y", (0.0, np.pi, 0.0))):
        turned = tuple(replace(tool, T_flange_tcp=tool.T_flange_tcp @ pose((0, 0, 0), turn)) for tool in cell.tools)
        yield from _with_tools(cell, turned, f"turned by 180 degrees about its own {axis}")
    for axis, turn in (("X", (np.pi, 0.0, 0.0)), ("Y", (0.0, np.pi, 0.0))):
        text = f"with the board turned over about its own {axis} (it may be upside down)"
        yield _Change(text, cell.with_held_at(cell.held_pose @ pose((0, 0, 0), turn)))
    for factor, text in ((1000.0, "metres were written for millimetres"), (1e-3, "millimetres were taken for metres")):
        board = cell.with_held_at(_scaled(cell.held_pose, factor))
        yield _Change(f"with the board's place times {factor:g} ({text})", board)
        scaled = tuple(replace(tool, T_flange_tcp=_scaled(tool.T_flange_tcp, factor)) for tool in cell.tools)
        yield from _with_tools(cell, scaled, f"{factor:g} times as far from the flange ({text})")
    for degrees in (180.0, 90.0, -90.0):
        turned = cell.T_cell_base @ pose((0, 0, 0), (0, 0, np.radians(degrees)))
        yield _Change(
            f"with the robot's base turned by {degrees:g} degrees about its axis", replace(cell, T_cell_base=turned)
        )


def _shifts(cell: Cell) -> Iterator[_Change]:
    """Give the cell with the board elsewhere, the smallest change first."""
    steps: list[tuple[float, str, Cell]] = []
    for size in _SHIFTS_MM:
        for axis, name in enumerate("xyz"):
            for sign in (1.0, -1.0):
                offset = np.zeros(3)
                offset[axis] = sign * size * 1e-3
                T_cell_held = cell.held_pose.copy()
                T_cell_held[:3, 3] += offset
                moved = cell.with_held_at(T_cell_held)
                steps.append((size, f"with the board moved by {sign * size:+g} mm along the cell's {name}", moved))
    for degrees in _YAWS_DEG:
        for sign in (1.0, -1.0):
            moved = cell.with_held_at(cell.held_pose @ pose((0, 0, 0), (0, 0, sign * np.radians(degrees))))
            steps.append(
                (2.0 * degrees, f"with the board turned by {sign * degrees:+g} degrees about its own z", moved)
            )
    for _, text, moved in sorted(steps, key=lambda step: step[0]):
        yield _Change(text, moved)


def _with_tools(cell: Cell, others: tuple[Tool, ...], text: str) -> Iterator[_Change]:
    """Give the cell with all tools changed, and with each of several changed alone."""
    yield _Change(f"with the TCP {text}", replace(cell, tools=others))
    for index, other in enumerate(others if len(others) > 1 else ()):
        tools = (*cell.tools[:index], other, *cell.tools[index + 1 :])
        yield _Change(f"with the TCP of tool {other.number} ({other.name}) {text}", replace(cell, tools=tools))


def _scaled(T: Poses, factor: float) -> Poses:
    scaled = T.copy()
    scaled[:3, 3] *= factor
    return scaled
