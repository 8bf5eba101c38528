"""What is beneath a component: the gap, and the joints that stand in it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import shapely
from shapely import Polygon
from shapely.affinity import rotate

from boards.board import Board, Body, Component
from boards.packages.families import FINEST_MM, package_family, package_sizes, pins_of
from boards.packages.undersides import UndersideFamily, gap_height, underside_family
from boards.undersides.body_rectangle import (
    Rectangle,
    body_rectangle,
    frame_of,
    lying_along,
    outline_rectangle,
    shrink_between_leads,
    shrink_to,
)
from boards.undersides.joints import (
    Joint,
    Package,
    body_between,
    joints_amid,
    joints_at_ends,
    joints_of,
    joints_under,
    many_joints,
)
from geometry.gridframe import GridFrame

__all__ = ["MOST_MM", "GapCase", "Joint", "Underside", "Undersides", "coverage", "undersides_of"]

MOST_MM = 1.0
"""A higher gap is no thin gap: the spray reaches into it."""

_LEAST_MM = 0.005
_WIDE = 0.8
_LARGE = 1.15
_TWO = 2
_UNKNOWN = "unknown: none and many"


@dataclass(frozen=True, slots=True)
class GapCase:
    """One way in which the gap may look."""

    gap_height_mm: float
    joints: tuple[Joint, ...]


@dataclass(frozen=True, slots=True)
class Underside:
    """The gap under one component. Board frame, mm; both sides as seen from the top."""

    component: str
    x_mm: float
    y_mm: float
    """Middle of the underside."""
    turn_rad: float
    """From the board's x to the direction of the length."""
    length_mm: float
    width_mm: float
    cases: tuple[GapCase, ...]
    """One if everything is known; else the two bounds, the harder to clean first."""
    gap_height_source: str
    """``"stated"``, the family and its document, or how the bounds were assumed."""
    joints_source: str
    """``"board file"``, the family and its document, or ``"unknown: none and many"``."""


Undersides: TypeAlias = tuple[Underside, ...]


def undersides_of(board: Board, known_mm: Mapping[str, tuple[float, float]] | None = None) -> Undersides:
    """Give the undersides of the components over a thin gap, in the board's order.

    Left out are through-hole parts, connectors and switches, parts that lie flat (a stated gap height of zero) or stand
    higher than 1 mm, and packages whose gap height neither the board file nor a document gives.

    Args:
        board: The board.
        known_mm: Least and largest gap height by component, as a parameter set states them.
    """
    known = known_mm or {}
    frame = frame_of(board)
    bodies = {body.name: body for body in board.bodies}
    pairs = ((bodies.get(component.name), component) for component in board.components)
    found = (
        _underside_of(body, component, board, frame, known.get(component.name))
        for body, component in pairs
        if body is not None
    )
    return tuple(underside for underside in found if underside is not None)


def coverage(case: GapCase, underside: Underside) -> float:
    """Share of the underside that its joints take; what several of them cover counts once."""
    rectangle = shapely.box(
        -underside.length_mm / 2.0, -underside.width_mm / 2.0, underside.length_mm / 2.0, underside.width_mm / 2.0
    )
    covered = shapely.union_all([joint_polygon(joint) for joint in case.joints]).intersection(rectangle)
    return float(covered.area / rectangle.area)


def joint_polygon(joint: Joint) -> Polygon:
    """Outline of a joint in the frame of the underside, mm."""
    if joint.round:
        return shapely.Point(joint.x_mm, joint.y_mm).buffer(joint.length_mm / 2.0, quad_segs=32)
    half = joint.length_mm / 2.0, joint.width_mm / 2.0
    box = shapely.box(joint.x_mm - half[0], joint.y_mm - half[1], joint.x_mm + half[0], joint.y_mm + half[1])
    return box if joint.turn_rad == 0.0 else rotate(box, joint.turn_rad, use_radians=True)


def _underside_of(
    body: Body, component: Component, board: Board, frame: GridFrame, known_mm: tuple[float, float] | None
) -> Underside | None:
    row = underside_family(package_family(component.package) if component.package else None)
    heights = gap_height(component.package, body.gap_height_mm).bounds_mm
    if row.joints == "none" or heights is None or heights[0] > MOST_MM or heights[1] < _LEAST_MM:
        return None  # whether there is a thin gap is a matter of the board alone
    rectangle = _rectangle(body, component, row, board.surface_z_mm(component.side), frame)
    if rectangle is None:
        return None
    joints, joints_source = _joints(body, component, row, rectangle)
    gap = gap_height(component.package, body.gap_height_mm, known_mm)
    hard, easy = (GapCase(*case) for case in zip(gap.bounds_mm or heights, joints, strict=True))
    return Underside(
        component=component.name,
        x_mm=rectangle.x_mm,
        y_mm=rectangle.y_mm,
        turn_rad=rectangle.turn_rad,
        length_mm=rectangle.length_mm,
        width_mm=rectangle.width_mm,
        cases=(hard,) if hard == easy else (hard, easy),
        gap_height_source=gap.bounds_source,
        joints_source=joints_source,
    )


def _rectangle(
    body: Body, component: Component, row: UndersideFamily, surface_z_mm: float, frame: GridFrame
) -> Rectangle | None:
    """Where the body is: leads that stand beside it are left out, terminations at its ends are part of it."""
    outline = outline_rectangle(component, frame)
    if outline is None:
        return None
    stated, nominal = package_sizes(component.package).body_mm, row.body_mm
    if row.joints in ("outside", "tab", "unknown"):
        found = body_rectangle(body, component, surface_z_mm, frame) or outline
        found = body_between(body.pads, found, frame) if row.joints == "outside" else found
        sizes = stated or nominal
        if sizes is None:
            return found
        at_ends = pins_of(component.package) == _TWO
        return shrink_to(found, sizes) if at_ends else shrink_between_leads(found, sizes, frame)
    found = outline
    if row.joints == "folded":  # what is flat may be only what lies between the terminals
        flat = body_rectangle(body, component, surface_z_mm, frame)
        is_most = flat is not None and flat.length_mm > _WIDE * outline.length_mm
        found = lying_along(flat, outline) if flat is not None and is_most else outline
    if stated is not None:
        return shrink_to(found, stated)
    if nominal is not None and (found.length_mm > _LARGE * max(nominal) or found.width_mm > _LARGE * min(nominal)):
        return shrink_to(found, nominal)
    return found


def _joints(
    body: Body, component: Component, row: UndersideFamily, rectangle: Rectangle
) -> tuple[tuple[tuple[Joint, ...], tuple[Joint, ...]], str]:
    """The joints of the harder and of the easier case, and where they are from."""
    length, width = rectangle.length_mm, rectangle.width_mm
    named = pins_of(component.package)
    pins = component.pins if named is None else named
    most = (length / FINEST_MM + 1.0) * (width / FINEST_MM + 1.0)  # more than the underside has room for do not count
    package = Package(package_sizes(component.package), pins if pins <= most else 0, length, width)
    if row.joints == "outside":
        stated = joints_amid(body.pads, rectangle) if body.pads else None
    elif row.joints == "ends" and package.pins <= _TWO:
        stated = joints_at_ends(body.pads, rectangle) or None
    else:  # where no pad is near a body that needs some, the family decides
        stated = joints_under(body.pads, rectangle) or None
    if stated is not None:
        return (stated, stated), "board file"
    joints = joints_of(row, package)
    if joints is None:
        return (many_joints(package), ()), _UNKNOWN
    family = package_family(component.package)
    return (joints, joints), f"family {family.name}" if family is not None else "no family"
