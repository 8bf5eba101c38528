"""Drawn lines of a KiCad board or footprint, as polylines with y up."""

import math
from itertools import pairwise

import numpy as np

from boards.formats.kicad.kicad_items import Item
from boards.formats.loops import arc, arc_through
from geometry.arrays import Points2

_CURVE_STEPS = 32


def polyline(item: Item) -> Points2 | None:
    """Points of a drawn item ``(n, 2)``, mm, y up; closed shapes end on their first point.

    Args:
        item: ``gr_line``, ``fp_arc`` and so on; the part before the underscore does not matter.

    Returns:
        ``None`` for what is not a line: text, dimensions.

    Raises:
        BoardError: A point of it is missing.
    """
    match item.head.partition("_")[2]:
        case "line":
            return np.array([item.point("start"), item.point("end")])
        case "arc":
            return _arc(item)
        case "circle":
            centre = item.point("center")
            return arc(item.point("end"), centre, 2.0 * math.pi)
        case "rect":
            (ax, ay), (bx, by) = item.point("start"), item.point("end")
            return np.array([[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]])
        case "poly":
            points = _listed(item)
            return np.concatenate([points, points[:1]])
        case "curve":
            return _bezier(item)
        case _:
            return None


def _arc(item: Item) -> Points2:
    """Since version 6 by three points; before by centre (called start), first point (called end) and angle.

    The old angle turns clockwise on the screen: negative once y points up.
    """
    if item.first("mid") is not None:
        return arc_through(item.point("start"), item.point("mid"), item.point("end"))
    angle = item.first("angle")
    if angle is None:
        raise item.error(f"({item.head} …) has neither a mid point nor an angle. Save the board in KiCad again.")
    return arc(item.point("end"), item.point("start"), -math.radians(angle.number(0)))


def _listed(item: Item) -> Points2:
    """Corners of a polygon; since version 7 an arc may stand among them."""
    points = item.first("pts")
    pieces: list[Points2] = []
    for part in points.items if points is not None else ():
        if part.head == "xy":
            pieces.append(part.here()[None, :])
        elif part.head == "arc":
            pieces.append(arc_through(part.point("start"), part.point("mid"), part.point("end")))
    if not pieces:
        raise item.error(f"({item.head} …) has no points. Save the board in KiCad again.")
    return np.concatenate(pieces)


def _bezier(item: Item) -> Points2:
    """A cubic curve by its four control points."""
    control = _listed(item)
    if len(control) != 4:
        raise item.error(f"({item.head} …) has {len(control)} control points; four are needed.")
    t = np.linspace(0.0, 1.0, _CURVE_STEPS + 1)[:, None]
    while len(control) > 1:
        # De Casteljau: between neighbours, again and again, until one point is left for every t.
        control = np.array([(1.0 - t) * a + t * b for a, b in pairwise(control)])
    return control[0]
