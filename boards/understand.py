"""From bodies to a board: its planes, its outline, what stands in the way, and the measures of its components."""

import hashlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from shapely import MultiPoint, Polygon, STRtree

from boards.board import NOMINAL_HEIGHT, STATED_HEIGHT, Board, Body, Component, Obstacle, Side, assumed_heights
from boards.bounds import check_bodies, check_crowds
from boards.errors import BoardError
from boards.formats.names import canonical_order, some
from boards.formats.tri.tri import write_tri
from boards.packages.families import pins_of
from boards.packages.undersides import gap_height
from boards.slab import Slab, find_slab
from geometry.gridframe import GridFrame, find_grid_frame
from geometry.mesh import areas_and_normals
from geometry.polygons import (
    GRID_MM,
    WIDEST_GAP_MM,
    bridge_pieces,
    canonical,
    close_gaps,
    drop_collinear,
    fill_holes,
    join_pieces,
    polygons_of,
    project,
    simplify_within,
    without_gaps,
)
from specs.finding import Finding, FindingRule, Severity, worst_first
from specs.finding_rules import (
    ALL_ON_BOTTOM,
    ASSUMED_HEIGHT,
    BOARD_IN_PIECES,
    COMPONENT_FLOATING,
    COMPONENT_OFF_PADS,
    COMPONENT_OUTSIDE,
    COMPONENT_SUNK,
    NO_COMPONENTS,
)

_OUTLINE_TOLERANCE_MM = 0.01
_LEAST_RISE_MM = 1e-3
_FAR_MM = 5.0
_ABSURD_MM = 1e9
_FLOATING_MM = 5.0
_OFF_PADS_MM = 0.5
_NAMES_IN_A_MESSAGE = 20
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


def understand(bodies: Iterable[Body], name: str, findings: Iterable[Finding] = (), *, is_panel: bool = False) -> Board:
    """Understand a board: every measure the planner needs, taken from the bodies alone.

    Args:
        bodies: One board and what stands on it, in any order. Board frame, mm.
        name: What to call the board.
        findings: What was noticed while reading; the board's own are added.
        is_panel: Whether the gaps between pieces of the board are none of it.

    Raises:
        BoardError: There is no board or more than one, it is not level, or a component cannot be understood.
    """
    bodies = canonical_order(bodies)
    check_bodies(bodies, _ABSURD_MM)
    slab = find_slab(_only_board(bodies))  # a board in wrong units is recognised, and the units named
    check_bodies(bodies)
    plans = (body.patches[:, :, :2] for body in bodies)
    check_crowds([np.concatenate([plan.min(axis=(0, 1)), plan.max(axis=(0, 1))]) for plan in plans])
    frame = find_grid_frame(slab.face)
    outline, pieces = _outline_of(_only_board(bodies), frame, is_panel=is_panel)
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
    found = list(findings)
    heard = {finding.rule for finding in found} & {NO_COMPONENTS, ASSUMED_HEIGHT, COMPONENT_OFF_PADS}
    judged = (*_check_places(parts, outline), *_check_pads(parts), *_check_heights(components))
    own = (finding for finding in judged if finding.rule not in heard)
    noticed = [*found, *pieces, *own]
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


def _only_board(bodies: Sequence[Body]) -> Body:
    boards = [body for body in bodies if body.role == "board"]
    if len(boards) == 1:
        return boards[0]
    if not boards:
        raise BoardError("there is no board among the objects. Give the bare board role=board.")
    names = ", ".join(body.name for body in boards[:_NAMES_IN_A_MESSAGE])
    raise BoardError(f"there are {len(boards)} boards ({names}). Give role=board to one of them.")


def _outline_of(board: Body, frame: GridFrame, *, is_panel: bool) -> tuple[Polygon, list[Finding]]:
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
    joined = canonical(drop_collinear(bridge_pieces(shadow, 0.0 if is_panel else WIDEST_GAP_MM)), anchors)
    simple = simplify_within(joined, _OUTLINE_TOLERANCE_MM)
    outline = frame.polygons_from_frame([simple], anchors, board.patches[:, :, :2].reshape(-1, 2))[0]
    count = len(polygons_of(shadow))
    if count == 1 or is_panel:
        return outline, []
    message = f"The bare board is in {count} pieces. Gaps of up to {WIDEST_GAP_MM:g} mm between them count as board."
    return outline, [Finding(BOARD_IN_PIECES, message)]


def _height_on(shape: Shape, side: Side) -> float:
    return shape.above_mm if side == "top" else shape.below_mm


def _check_places(parts: Sequence[Shape], outline: Polygon) -> Iterator[Finding]:
    """Find components beside the board, in the air, or sunk into it, one finding of a kind; all below; none at all."""
    if not parts:
        text = "There is no component on the board. Join a placement table (--parts TABLE.csv) if it has some."
        yield Finding(NO_COMPONENTS, text)
    if len(parts) > 1 and not any(shape.body.side is not None or side_of(shape) == "top" for shape in parts):
        message = f"All {len(parts)} components lie on the bottom. If the board is upside down, turn it over."
        yield Finding(ALL_ON_BOTTOM, message)
    inside = Polygon(outline.exterior)
    shapely.prepare(inside)
    outside = shapely.distance(np.array([shape.outline for shape in parts], dtype=object), inside) if parts else []
    away = [(round(float(mm), 4), shape) for mm, shape in zip(outside, parts, strict=True) if round(mm, 4) > _FAR_MM]
    floating = [(shape.gap_mm, shape) for shape in parts if shape.gap_mm > _FLOATING_MM]
    shares = ((shape.share_above if side_of(shape) == "top" else shape.share_below, shape) for shape in parts)
    sunk = [(1.0 - share, shape) for share, shape in shares if share < 0.5 and shape.gap_mm <= _FLOATING_MM]
    if away:
        worst, shape = max(away, key=lambda each: each[0])
        is_most = 2 * len(away) > len(parts) > 1
        advice = "Outline and places are not of one board: check both." if is_most else "Is its place right?"
        message = f"{_counted(away, shape, 'lies')} {worst:.1f} mm outside the board's outline. {advice}"
        yield _place_finding(COMPONENT_OUTSIDE, message, shape, "error" if is_most else None)
    if floating:
        worst, shape = max(floating, key=lambda each: each[0])
        message = f"{_counted(floating, shape, 'floats')} {worst:.1f} mm away from the board. "
        yield _place_finding(COMPONENT_FLOATING, f"{message}Is its model in the right place?", shape)
    if sunk:
        worst, shape = max(sunk, key=lambda each: each[0])
        share = f"only {100 * (1.0 - worst):.0f} % of its surface lies above the {side_of(shape)} side it belongs to."
        yield _place_finding(COMPONENT_SUNK, f"{_counted(sunk, shape, 'is sunk:')} {share}", shape)


def _check_pads(parts: Sequence[Shape]) -> Iterator[Finding]:
    """Find bodies that none of their pads lies under or around."""
    soldered = [shape for shape in parts if shape.body.pads]
    if not soldered:
        return
    pads = [MultiPoint([(pad.x_mm, pad.y_mm) for pad in shape.body.pads]).convex_hull for shape in soldered]
    apart = shapely.distance(np.array(pads, dtype=object), np.array([each.outline for each in soldered], dtype=object))
    off = [(round(float(mm), 4), shape) for mm, shape in zip(apart, soldered, strict=True) if mm > _OFF_PADS_MM]
    if off:
        worst, shape = max(off, key=lambda each: each[0])
        message = f"{_counted(off, shape, 'lies')} {worst:.1f} mm beside its pads. Is its model in the right place?"
        yield _place_finding(COMPONENT_OFF_PADS, message, shape)


def _check_heights(components: Sequence[Component]) -> Iterator[Finding]:
    """List the heights that nothing states, those first that matter most to a plan."""
    found = assumed_heights(components)
    if found:
        words = [f"{key} {own[0].height_mm:g} mm ({some([each.name for each in own])})" for key, own in found]
        count = sum(len(own) for _, own in found)
        text = (
            f"{count} components are of no known package family and are assumed tall, to stay clear of them; those "
            f"first whose heights matter most: {some(words)}. State them in columns.yaml beside the board, as "
            f"`heights_mm: {{{found[0][0]}: MM}}`, or in a parts table with a height column."
        )
        yield Finding(ASSUMED_HEIGHT, text)


def _counted(found: Sequence[tuple[float, Shape]], worst: Shape, verb: str) -> str:
    """Begin a sentence about the worst of several components."""
    name = worst.body.name
    return f"{name} {verb}" if len(found) == 1 else f"{len(found)} components, the worst {name}, which {verb}"


def _place_finding(rule: FindingRule, message: str, shape: Shape, severity: Severity | None = None) -> Finding:
    where = np.round(shape.body.patches.reshape(-1, 3).mean(axis=0), 3).tolist()
    return Finding(rule, message, where=(where[0], where[1], where[2]), override=severity)


def _obstacles(shapes: Sequence[Shape], side: Side) -> tuple[Obstacle, ...]:
    return tuple(
        Obstacle(shape.body.name, shape.prism, _height_on(shape, side))
        for shape in shapes
        if _height_on(shape, side) > _LEAST_RISE_MM
    )
