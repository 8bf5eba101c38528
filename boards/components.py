"""Components of a board: shadow, side, height, pins, gap and neighbours of each body."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import Polygon, STRtree

from boards.board import NOMINAL_HEIGHT, STATED_HEIGHT, Body, Component, Side
from boards.errors import BoardError
from boards.packages.families import pins_of
from boards.packages.gap_height import gap_height
from boards.slab import Slab
from geometry.gridframe import GridFrame
from geometry.mesh import areas_and_normals
from geometry.polygons import (
    GRID_MM,
    canonical,
    close_gaps,
    drop_collinear,
    fill_holes,
    join_pieces,
    project,
    simplify_within,
    without_gaps,
)

PIN_GAP_MM = 2.0
"""Gaps between pins narrower than this are closed in an outline."""

TOLERANCE_MM = 0.05
_SIMPLER_MM = 0.98 * TOLERANCE_MM
_LEAST_HEIGHT_MM = 1e-3
_NEIGHBOURS = 6
_DISTANCE_MM = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A body seen from the top, and how it stands to the slab."""

    body: Body
    framed: tuple[Polygon, ...]
    """Footprint, outline and prism on the grid of the board's frame: for measuring distances."""
    footprint: Polygon
    outline: Polygon
    prism: Polygon
    """The whole shadow without its holes, not simplified."""
    above_mm: float
    """Highest point above the top surface, negative when it lies below."""
    below_mm: float
    """Lowest point below the bottom surface, negative when it lies above."""
    share_above: float
    """Part of the body's surface that lies above the board's top surface, 0 to 1."""
    share_below: float
    gap_mm: float
    """Lowest point above the top surface, or for a body below the board, highest point below the bottom."""


def shape_of(body: Body, slab: Slab, frame: GridFrame) -> Shape:
    """Measure one body.

    Raises:
        BoardError: Seen from the top it has no area.
    """
    framed = frame.triangles_to_frame(body.patches)
    anchors = framed[:, :, :2].reshape(-1, 2)
    joined = _with_area(join_pieces(project(framed)), body.name)
    seen = canonical(drop_collinear(joined), anchors)
    footprint = simplify_within(seen, _SIMPLER_MM)
    plain = without_gaps(footprint, _SIMPLER_MM)
    if plain is not None:
        outline = canonical(plain, anchors)
    else:
        # The corners of a sliver fall into one line on the grid.
        closed = fill_holes(_with_area(join_pieces(close_gaps(footprint, PIN_GAP_MM)), body.name))
        outline = simplify_within(canonical(drop_collinear(closed), anchors), _SIMPLER_MM)
    prism = canonical(drop_collinear(fill_holes(joined)), anchors) if joined.interiors else seen
    polygons = [footprint, outline, prism]
    moved = frame.polygons_from_frame(polygons, anchors, body.patches[:, :, :2].reshape(-1, 2))
    areas = areas_and_normals(body.patches)[0]
    middle = body.patches[:, :, 2].mean(axis=1)
    low, high = float(body.patches[:, :, 2].min()), float(body.patches[:, :, 2].max())
    above = float(areas[np.round((middle - slab.top_z_mm) / GRID_MM) > 0].sum() / areas.sum())
    below = float(areas[np.round((slab.bottom_z_mm - middle) / GRID_MM) > 0].sum() / areas.sum())
    return Shape(
        body=body,
        framed=tuple(polygons),
        footprint=moved[0],
        outline=moved[1],
        prism=moved[2],
        above_mm=round(high - slab.top_z_mm, 9),
        below_mm=round(slab.bottom_z_mm - low, 9),
        share_above=round(above, 9),
        share_below=round(below, 9),
        gap_mm=round(max(low - slab.top_z_mm, slab.bottom_z_mm - high), 9),
    )


def _with_area(seen: Polygon, name: str) -> Polygon:
    if seen.is_empty:
        message = f"{name} has no area as seen from the top. Correct its model or leave it out."
        raise BoardError(message)
    return seen


def side_of(shape: Shape) -> Side:
    """Return the stated side, or else the one on which more of the body's surface lies, or else its height."""
    if shape.body.side is not None:
        return shape.body.side
    if shape.share_above != shape.share_below:
        return "top" if shape.share_above > shape.share_below else "bottom"
    return "top" if shape.above_mm >= shape.below_mm else "bottom"


def component_of(shape: Shape) -> Component:
    """Describe one component; its neighbours come later.

    Raises:
        BoardError: It does not rise above the surface of its side.
    """
    body = shape.body
    side = side_of(shape)
    height = shape.above_mm if side == "top" else shape.below_mm
    if height < _LEAST_HEIGHT_MM:
        message = f"{body.name} has no height above the {side} surface of the board (it ends at {height:.3f} mm). "
        raise BoardError(message + "Correct its side or its model, or leave it out.")
    named = pins_of(body.package) if body.pins is None and body.package else None
    source = "unknown" if named is None else f"package {body.package}"
    gap = gap_height(body.package or "", body.gap_height_mm)
    return Component(
        name=body.name,
        package=body.package or "",
        part=body.part or "",
        value=body.value or "",
        pins=named or 0 if body.pins is None else body.pins,
        pins_source=source if body.pins is None else "stated",
        side=side,
        footprint=shape.footprint,
        outline=shape.outline,
        height_mm=height,
        area_mm2=shape.footprint.area,
        gap_height_mm=gap.nominal_mm,
        gap_height_source=gap.source,
        neighbours=(),
        height_source=next((text for key, text in body.extra if key == NOMINAL_HEIGHT), STATED_HEIGHT),
    )


def with_neighbours(components: Sequence[Component], framed: Sequence[Polygon]) -> tuple[Component, ...]:
    """Add to each component the nearest others of its side.

    Args:
        components: In the order of their board.
        framed: Their outlines on the grid of the board's frame, in which distances are measured.
    """
    found: dict[int, tuple[tuple[str, float], ...]] = {}
    for side in ("top", "bottom"):
        members = [place for place, component in enumerate(components) if component.side == side]
        if len(members) > 1:
            nearest = _nearest([framed[place] for place in members])
            for place, row in zip(members, nearest, strict=True):
                found[place] = tuple((components[members[other]].name, distance) for other, distance in row)
    return tuple(replace(component, neighbours=found.get(place, ())) for place, component in enumerate(components))


def _nearest(outlines: list[Polygon]) -> list[list[tuple[int, float]]]:
    """For each outline the nearest others with their distances; equal ones in the order of the board."""
    shapes = np.array(outlines, dtype=object)
    tree = STRtree(shapes)
    count = min(_NEIGHBOURS, len(shapes) - 1)
    rows: list[list[tuple[int, float]]] = [[] for _ in outlines]
    left = np.arange(len(shapes))
    reach = 2.0
    while left.size:
        whose, other = tree.query(shapes[left], predicate="dwithin", distance=reach)
        whose = left[whose]
        whose, other = whose[whose != other], other[whose != other]
        counts = np.bincount(whose, minlength=len(shapes))
        full = counts >= count
        take = full[whose]
        whose, other = whose[take], other[take]
        steps = np.round(shapely.distance(shapes[whose], shapes[other]) / _DISTANCE_MM)
        for place in np.lexsort((other, steps, whose)).tolist():
            row = rows[int(whose[place])]
            if len(row) < count:
                row.append((int(other[place]), round(float(steps[place]) * _DISTANCE_MM, 4)))
        left = left[~full[left]]
        reach *= 2.0
    return rows
