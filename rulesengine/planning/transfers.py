"""Moves with the jet off: up, over, down; around the edge when the board is turned over."""

from dataclasses import dataclass
from typing import assert_never

import numpy as np

from boards.board import Board, Side
from geometry.arrays import Directions, Directions2, Points
from programs.plan import Transfer
from recipes.recipe import Limits
from rulesengine.strokes.safe_height import Floors
from rulesengine.strokes.stroke import Retract, reference_axes, reference_azimuth
from specs.source import Source

_SAME = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """Where the orifice is and how it points; side frame, mm."""

    tcp: Points
    approach: Directions
    azimuth: Directions2

    def same_as(self, other: "Pose") -> bool:
        """Whether nothing has to move to get from one to the other."""
        mine, theirs = (np.concatenate([p.tcp, p.approach, p.azimuth]) for p in (self, other))
        return bool(np.allclose(mine, theirs, rtol=0, atol=_SAME))


def parked(board: Board, limits: Limits, floors: Floors) -> Pose:
    """Above the middle of the board, or at the recipe's place, pointing down, above everything."""
    centre = board.outline.centroid
    place = np.array([centre.x, centre.y]) if limits.park_mm is None else np.array(limits.park_mm)
    height = max(limits.park_height_mm, floors.highest)
    return Pose(np.append(place, height), np.array([0.0, 0.0, -1.0]), reference_azimuth(board, limits))


def transfer(start: Pose, end: Pose, floors: Floors, retract: Retract) -> list[Pose]:
    """Poses of a move that keeps clear: straight if it may, else up, across and down; none if it is there already."""
    if start.same_as(end):
        return []
    match retract:
        case "corridor":
            level = floors.over(np.array([start.tcp[:2], end.tcp[:2]]))
        case "everything":
            level = floors.highest
        case _:
            assert_never(retract)
    if np.allclose(start.tcp[:2], end.tcp[:2], rtol=0, atol=_SAME):
        level = 0.0
    poses = [start]
    if level > min(start.tcp[2], end.tcp[2]) + _SAME:
        level = max(level + floors.corner_mm, start.tcp[2], end.tcp[2])
        if level > start.tcp[2] + _SAME:
            poses.append(Pose(np.append(start.tcp[:2], level), start.approach, start.azimuth))
        if level > end.tcp[2] + _SAME:
            poses.append(Pose(np.append(end.tcp[:2], level), end.approach, end.azimuth))
    return [*poses, end]


def to_board(board: Board, side: Side, poses: list[Pose], speed_mm_s: float, made_by: Source) -> Transfer:
    """Transform a transfer from the side frame into the board frame."""
    tcp, approach, reference = board_frame(
        board,
        side,
        np.array([pose.tcp for pose in poses]),
        np.array([pose.approach for pose in poses]),
        np.array([pose.azimuth for pose in poses]),
    )
    return Transfer(tcp, approach, reference, speed_mm_s, made_by)


def board_frame(
    board: Board, side: Side, tcp: Points, approach: Directions, azimuth: Directions2
) -> tuple[Points, Directions, Directions]:
    """Side frame to board frame: (n, 3) orifice, jet and tool +X; the bottom side's heights count downwards."""
    up = np.array([1.0, 1.0, 1.0 if side == "top" else -1.0])
    place = tcp * up
    place[:, 2] += board.surface_z_mm(side)
    return place, approach * up, reference_axes(approach, azimuth) * up


def around_edge(
    board: Board, limits: Limits, start: Transfer, end: Transfer, speed_mm_s: float, made_by: Source
) -> Transfer:
    """Transfer from above one side to above the other past the edge, as turning the board over looks from the board.

    It runs from the end of ``start`` to the beginning of ``end`` and clears all bodies, overhanging ones too.
    """
    along = reference_azimuth(board, limits)
    out = np.array([-along[1], along[0]])
    corners = np.concatenate([body.patches.reshape(-1, 3)[:, :2] for body in board.bodies])
    reach = (
        float((corners @ out).max())
        + limits.clearance_mm
        + limits.blend_mm
        + float(np.ptp([start.tcp[-1, 2], end.tcp[0, 2]])) / 4
    )
    first, last = start.tcp[-1], end.tcp[0]

    def beside(place: Points, height: float) -> Points:
        return np.append(place[:2] + out * (reach - float(place[:2] @ out)), height)

    middle = beside((first + last) / 2, float((first[2] + last[2]) / 2))
    inward = np.append(-out, 0.0)
    flat = np.append(along, 0.0)
    return Transfer(
        tcp=np.array([first, beside(first, first[2]), middle, beside(last, last[2]), last]),
        approach=np.array([start.approach[-1], start.approach[-1], inward, end.approach[0], end.approach[0]]),
        reference=np.tile(flat, (5, 1)),
        speed_mm_s=speed_mm_s,
        made_by=made_by,
    )
