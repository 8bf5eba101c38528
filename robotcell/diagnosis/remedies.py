"""What would help when a cell cannot do a program: a classical mistake undone, else the smallest shift of the board."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from boards.board import Board
from geometry.arrays import Indices
from robotcell.cell.cell import Cell, Tool
from robotcell.collision.collision import Collider, build_collider, collides, with_board_at
from robotcell.kinematics.inverse import solve
from robotcell.motion.sampled_path import Course, Flags
from robotcell.robot.full_turns import is_inside, unwound
from robotcell.robot.poses import pose
from robotcell.robot.robot import Joints, Poses

_AZIMUTHS = 8
_SHIFTS_MM = (20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 800.0, 1200.0)
_YAWS_DEG = (15.0, 30.0, 45.0, 90.0, 135.0, 180.0)
_MOST_PLACES = 40


@dataclass(frozen=True, slots=True, eq=False)
class Places:
    """Some poses of a program that are to be reached: k of them."""

    T_board_tcp: Poses
    """(k, 4, 4)"""
    tool: Indices
    """(k,) index into the cell's tools."""
    free: Flags
    """(k,) whether the azimuth about the jet is free."""


@dataclass(frozen=True, slots=True, eq=False)
class _Change:
    """A cell that differs in one thing."""

    text: str
    """What is done, as a condition: ``"with the TCP turned ..."``."""
    cell: Cell


def places_of(course: Course, nodes: Indices, wrong: Indices) -> Places:
    """Choose some samples of a course: of those that are wrong, and of all; with the board as the cell holds it."""
    own = nodes[course.placement[nodes] == 0]
    bad = wrong[course.placement[wrong] == 0]
    chosen = np.unique(np.concatenate((_some(bad), _some(own))))
    T_board_tcp = np.linalg.inv(course.T_base_board[0]) @ course.T_base_tcp[chosen]
    return Places(T_board_tcp, course.tool[chosen], course.free[chosen])


def _some(samples: Indices) -> Indices:
    count = min(len(samples), _MOST_PLACES // 2)
    return samples[np.round(np.linspace(0, len(samples) - 1, count)).astype(np.int64)] if count else samples


def find_remedy(cell: Cell, board: Board | None, places: Places) -> str | None:
    """Say what would make every place reachable and clear; ``None`` if nothing that was tried does.

    Each place is looked at on its own: whether the robot can also go from one to the next is another question.
    """
    collider = build_collider(cell, board)
    for change in (*_mistakes(cell), *_shifts(cell)):
        rows = _postures(change.cell, places)
        if not all(len(each) > 0 for each in rows):
            continue
        moved_only = change.cell.tools is cell.tools and change.cell.T_cell_base is cell.T_cell_base
        there = with_board_at(collider, change.cell.T_cell_board) if moved_only else build_collider(change.cell, board)
        if _clear(there, rows, places, change.cell).all():
            return f"{change.text} every point would be reachable without collision"
    return None


def share_reached(cell: Cell, places: Places) -> float:
    """Share of the places that some posture within the limits reaches."""
    return float(np.mean(np.array([len(rows) > 0 for rows in _postures(cell, places)])))


def _clear(collider: Collider, rows: list[Joints], places: Places, cell: Cell) -> Flags:
    """(k,) which places have a posture, of those in ``rows``, that collides with nothing."""
    clear = np.zeros(len(rows), dtype=np.bool_)
    for tool in np.unique(places.tool).tolist():
        at = np.flatnonzero(places.tool == tool)
        owner = np.repeat(at, [len(rows[place]) for place in at.tolist()])
        q = np.concatenate([rows[place] for place in at.tolist()])
        clear[owner[~collides(collider, q, cell.tools[tool].number)]] = True
    return clear


def _postures(cell: Cell, places: Places) -> list[Joints]:
    """Give the postures (m, dof) of each place, at some azimuths where they are free."""
    T_base_tcp = np.linalg.inv(cell.T_cell_base) @ cell.T_cell_board @ places.T_board_tcp
    turns = np.stack([pose((0, 0, 0), (0, 0, 2.0 * np.pi * k / _AZIMUTHS)) for k in range(_AZIMUTHS)])
    result: list[Joints] = []
    asked = T_base_tcp[:, None] @ turns
    for index, tool in enumerate(places.tool.tolist()):
        T_flange_tcp = cell.tools[tool].T_flange_tcp
        wanted = asked[index] if places.free[index] else asked[index, :1]
        found = solve(cell.robot, wanted @ np.linalg.inv(T_flange_tcp), T_flange_tcp=T_flange_tcp)
        good = is_inside(cell.robot, found.q) & (places.free[index] | (np.abs(found.azimuth) < np.radians(0.5)))
        q = found.q[good]
        result.append(unwound(cell.robot, q, np.broadcast_to(cell.home, q.shape)))
    return result


def _mistakes(cell: Cell) -> Iterator[_Change]:
    """The classical mistakes, undone."""
    for axis, turn in (("X", (np.pi, 0.0, 0.0)), ("Y", (0.0, np.pi, 0.0))):
        turned = tuple(replace(tool, T_flange_tcp=tool.T_flange_tcp @ pose((0, 0, 0), turn)) for tool in cell.tools)
        yield from _with_tools(cell, turned, f"turned by 180 degrees about its own {axis}")
    for axis, turn in (("X", (np.pi, 0.0, 0.0)), ("Y", (0.0, np.pi, 0.0))):
        text = f"with the board turned over about its own {axis} (it may be upside down)"
        yield _Change(text, replace(cell, T_cell_board=cell.T_cell_board @ pose((0, 0, 0), turn)))
    for factor, text in ((1000.0, "metres were written for millimetres"), (1e-3, "millimetres were taken for metres")):
        yield _Change(f"with the board's place times {factor:g} ({text})", _scaled_board(cell, factor))
        scaled = tuple(replace(tool, T_flange_tcp=_scaled(tool.T_flange_tcp, factor)) for tool in cell.tools)
        yield from _with_tools(cell, scaled, f"{factor:g} times as far from the flange ({text})")
    for degrees in (180.0, 90.0, -90.0):
        turned = cell.T_cell_base @ pose((0, 0, 0), (0, 0, np.radians(degrees)))
        yield _Change(
            f"with the robot's base turned by {degrees:g} degrees about its axis", replace(cell, T_cell_base=turned)
        )


def _shifts(cell: Cell) -> Iterator[_Change]:
    """The board elsewhere, the smallest change first."""
    steps: list[tuple[float, str, Poses]] = []
    for size in _SHIFTS_MM:
        for axis, name in enumerate("xyz"):
            for sign in (1.0, -1.0):
                offset = np.zeros(3)
                offset[axis] = sign * size * 1e-3
                moved = cell.T_cell_board.copy()
                moved[:3, 3] += offset
                steps.append((size, f"with the board moved by {sign * size:+g} mm along the cell's {name}", moved))
    for degrees in _YAWS_DEG:
        for sign in (1.0, -1.0):
            moved = cell.T_cell_board @ pose((0, 0, 0), (0, 0, sign * np.radians(degrees)))
            steps.append(
                (2.0 * degrees, f"with the board turned by {sign * degrees:+g} degrees about its own z", moved)
            )
    for _, text, moved in sorted(steps, key=lambda step: step[0]):
        yield _Change(text, replace(cell, T_cell_board=moved))


def _with_tools(cell: Cell, others: tuple[Tool, ...], text: str) -> Iterator[_Change]:
    """All tools otherwise, and each of several alone."""
    yield _Change(f"with the TCP {text}", replace(cell, tools=others))
    for index, other in enumerate(others if len(others) > 1 else ()):
        tools = (*cell.tools[:index], other, *cell.tools[index + 1 :])
        yield _Change(f"with the TCP of tool {other.number} ({other.name}) {text}", replace(cell, tools=tools))


def _scaled_board(cell: Cell, factor: float) -> Cell:
    return replace(cell, T_cell_board=_scaled(cell.T_cell_board, factor))


def _scaled(T: Poses, factor: float) -> Poses:
    scaled = T.copy()
    scaled[:3, 3] *= factor
    return scaled
