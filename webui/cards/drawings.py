"""Drawings on cards: the gap under a component, and a placement with its box plots and its map."""

import base64
from dataclasses import replace
from html import escape
from io import BytesIO

import numpy as np

from boards.undersides.underside import Joint
from cleaning.gap.flow_field import GapField
from cleaning.verdicts.results import Part
from geometry.arrays import Scalars
from reports.cards.placement import least_reached, value_text
from reports.pictures.gap_picture import SIDES, GapDrawing, Quantity, gap_drawing
from robotcell.placement.configurations import SHARES, ConfigurationValues, PlacementDetails
from robotcell.placement.placement_map import PlacementMap
from webui.layers.surface.heat_scale import LEAST_RESIDUE_PCT, gradient_html, round_up
from webui.theme.html import SQUARE, box_html, facts_html, legend_html, small_html
from webui.theme.palette import (
    ACCENT,
    COLLIDING,
    GROUND,
    INK,
    LINE_COLOUR,
    PAPER,
    QUIET,
    TRACK,
    css_colour,
    of_values,
    tints_of_values,
    to_hex,
)

SHOWN: dict[str, Quantity] = {"Residue": "residue", "Pressure": "pressure", "Wall shear": "shear"}
"""Names of the quantities on the page."""
UNITS: dict[Quantity, str] = {"pressure": "Pa", "shear": "Pa", "residue": "%"}
_LEVELS = 24
_JOINT = "#8d8f92"
_MM = 1000.0


def drawing_of(part: Part, case: int, stage: int, side: str) -> GapDrawing | None:
    """Drawing of a gap; nothing where the stage does not act on it.

    Args:
        part: A part with an underside.
        case: Which of its gaps, the harder first.
        stage: Counted from 0.
        side: Side of the jet on the board; any other word is the side with the most flow.
    """
    drawing = gap_drawing(part, case, stage)
    words = () if drawing is None else side_words(drawing.underside.turn_rad)
    return drawing if drawing is None or side not in words else replace(drawing, side=words.index(side))


def side_words(turn_rad: float) -> tuple[str, ...]:
    """Names on the board of the front, right, back and left side of a turned underside."""
    quarters = round(turn_rad / (np.pi / 2) + 1e-9)
    return tuple(SIDES[(side + quarters) % 4] for side in range(4))


def top_of(shown: Quantity, values: Scalars) -> float:
    """Value at the light end of the colours."""
    top = round_up(float(values.max(initial=0.0)))
    return min(max(top, LEAST_RESIDUE_PCT), 100.0) if shown == "residue" else top


def gap_svg(drawing: GapDrawing, shown: Quantity) -> str:
    """The gap in plan, turned as on the board, seen from above."""
    underside, values = drawing.underside, drawing.values(shown)
    x, y = underside.length_mm / 2, underside.width_mm / 2
    reach = 1.02 * np.hypot(x, y)
    frame = f'x="{-x:.4f}" y="{-y:.4f}" width="{2 * x:.4f}" height="{2 * y:.4f}"'
    x1, y1, x2, y2 = ((-x, -y, x, -y), (x, -y, x, y), (x, y, -x, y), (-x, y, -x, -y))[drawing.side]
    accent, inner = css_colour(ACCENT), ""
    if shown == "residue":
        (left, up), radius = drawing.gap.worst_at, reach / 14
        inner = (
            f'<circle cx="{left:.4f}" cy="{up:.4f}" r="{radius:.4f}" fill="none" stroke="{accent}" '
            f'stroke-width="{radius / 4:.4f}"/>'
        )
    inner = (
        f'<rect {frame} fill="{_JOINT}"/>'
        + _cells_svg(drawing.gap.field, values, top_of(shown, values))
        + "".join(map(_joint_svg, drawing.joints))
        + _arrows_svg(drawing)
        + f'<rect {frame} fill="none" stroke="{css_colour(INK)}" stroke-width="{reach / 150:.4f}"/>'
        f'<line x1="{x1:.4f}" y1="{y1:.4f}" x2="{x2:.4f}" y2="{y2:.4f}" stroke="{accent}" '
        f'stroke-width="{np.hypot(x, y) / 22:.4f}"/>{inner}'
    )
    cos, sin = abs(np.cos(underside.turn_rad)), abs(np.sin(underside.turn_rad))
    across, high = 1.06 * (x * cos + y * sin), 1.06 * (x * sin + y * cos)
    return (
        f'<svg viewBox="{-across:.4f} {-high:.4f} {2 * across:.4f} {2 * high:.4f}" role="img" '
        f'aria-label="Gap under {escape(underside.component)} from above" '
        f'style="display:block;width:100%;max-height:300px;background:{GROUND}">'
        f'<g transform="scale(1,-1) rotate({np.degrees(underside.turn_rad):.4f})">{inner}</g></svg>'
    )


def gap_html(drawing: GapDrawing, shown: Quantity) -> str:
    """The gap in plan, the scale of its colours, and its numbers."""
    bar = gradient_html(top_of(shown, drawing.values(shown)), UNITS[shown], ends=True)
    ring = " Ring: the worst tenth." if shown == "residue" else ""
    hint = f"Arrows: the flow while the jet presses at the marked side alone. Grey: joints.{ring}"
    numbers = box_html(facts_html(gap_facts(drawing)) + small_html(hint))
    return f'<div style="margin:4px 12px">{gap_svg(drawing, shown)}</div>{bar}{numbers}'


def gap_facts(drawing: GapDrawing) -> dict[str, str]:
    """Facts of a gap in one stage."""
    gap, result = drawing.gap, drawing.result
    words = side_words(drawing.underside.turn_rad)
    means = np.array(result.edge_pa).reshape(4, 2).mean(axis=1)  # of the two halves of each side
    pressures = ", ".join(f"{word} {value:.0f}" for word, value in zip(words, means, strict=True))
    entered = "opens" if result.entered else "stays dry"
    return {
        "Standoff": f"{_MM * gap.gap_height_mm:.0f} µm, {drawing.underside.gap_height_source}",
        "Joints": drawing.underside.joints_source,
        "Filled": f"{100 * gap.fill:.0f} % of its height before the wash",
        "Entry": f"{entered}: {result.margin_pa:+z.0f} Pa with capillarity",
        "Edges": f"{pressures} Pa at most",
        "Renewed": f"{result.exchanges:.1f} times",
        "Weak": f"{100 * result.weak_share:.0f} % of the gap",
        "Residue": f"{100 * float(result.residue.mean()):.1f} % after this stage; in the end {100 * gap.residue:.1f} "
        f"%, worst tenth {100 * gap.residue_worst:.0f} %",
    }


def _cells_svg(field: GapField, values: Scalars, top: float) -> str:
    """One path for all cells of a colour: a gap has a thousand of them."""
    rows, columns = field.shape
    wide, high = _MM * field.length_m / columns, _MM * field.width_m / rows
    level = np.clip(np.round(values / top * (_LEVELS - 1)), 0, _LEVELS - 1).astype(int)
    colours = tints_of_values(np.arange(_LEVELS, dtype=np.float64), 0.0, _LEVELS - 1.0)
    row, column = np.divmod(field.cells, columns)
    x, y = column * wide - _MM * field.length_m / 2, row * high - _MM * field.width_m / 2
    paths: list[str] = []
    for each in np.unique(level).tolist():
        mine = level == each
        corners = zip(x[mine].tolist(), y[mine].tolist(), strict=True)
        squares = "".join(f"M{a:.3f} {b:.3f}h{wide:.3f}v{high:.3f}h{-wide:.3f}z" for a, b in corners)
        paths.append(f'<path fill="{to_hex(colours[each])}" shape-rendering="crispEdges" d="{squares}"/>')
    return "".join(paths)


def _joint_svg(joint: Joint) -> str:
    if joint.round:
        return f'<circle cx="{joint.x_mm:.4f}" cy="{joint.y_mm:.4f}" r="{joint.length_mm / 2:.4f}" fill="{_JOINT}"/>'
    turn = np.degrees(joint.turn_rad)
    return (
        f'<rect x="{-joint.length_mm / 2:.4f}" y="{-joint.width_mm / 2:.4f}" width="{joint.length_mm:.4f}" '
        f'height="{joint.width_mm:.4f}" fill="{_JOINT}" '
        f'transform="translate({joint.x_mm:.4f} {joint.y_mm:.4f}) rotate({turn:.3f})"/>'
    )


def _arrows_svg(drawing: GapDrawing) -> str:
    """Arrows as one path: a shaft and two strokes of a head each."""
    tails, tips = drawing.arrows()
    if not len(tips):
        return ""
    path = ""
    for (x, y), (tip_x, tip_y) in zip(tails.tolist(), tips.tolist(), strict=True):
        dx, dy = 0.3 * (tip_x - x), 0.3 * (tip_y - y)
        path += (
            f"M{x:.3f} {y:.3f}L{tip_x:.3f} {tip_y:.3f}"
            f"M{tip_x - dx - 0.6 * dy:.3f} {tip_y - dy + 0.6 * dx:.3f}L{tip_x:.3f} {tip_y:.3f}"
            f"L{tip_x - dx + 0.6 * dy:.3f} {tip_y - dy - 0.6 * dx:.3f}"
        )
    width = np.hypot(*(tips - tails).T).max() / 10
    return f'<path d="{path}" fill="none" stroke="#ffffff" stroke-width="{width:.4f}" stroke-linecap="round"/>'


_ROW_PX, _ROOM = 16, 1.05
_MARKS = 4
_PLACED = "position:absolute;"


def boxes_html(details: PlacementDetails) -> str:
    """Box plots of the configurations, one below the other on one scale from 0; the dot is the worst point."""
    values = (value for each in details.configurations for value in (each.box[-1], least_reached(each)))
    scale = _ROOM * max([*filter(np.isfinite, values), details.goal.floor, 1e-9])
    rows = "".join(_row_html(details, each, scale) for each in details.configurations)
    metric = details.goal.metric
    note = (
        f"0 to {value_text(scale, metric)}. Box: the middle half of the points; lines: 5th to 95th percentile; "
        "dot: the worst."
    )
    return box_html(rows + small_html(escape(note)))


def _row_html(details: PlacementDetails, each: ConfigurationValues, scale: float) -> str:
    used = each.branch in details.score.branches
    metric, colour = details.goal.metric, css_colour(INK if used else QUIET)
    name = f"{each.name}, used" if used else each.name
    head = (
        '<div style="display:flex;justify-content:space-between;gap:8px;margin-top:5px">'
        f'<span style="color:{colour};font-weight:{600 if used else 400}">{escape(name)}</span>'
        f'<span style="color:{css_colour(QUIET)}">{each.reached:.0%} reached</span></div>'
    )
    if not np.isfinite(each.box).all():
        return head
    low, first, middle, third, high = (100.0 * value / scale for value in each.box.tolist())
    least = 100.0 * least_reached(each) / scale
    words = ", ".join(
        f"{100 * share:g} %: {value_text(value, metric)}"
        for share, value in zip(SHARES, each.box.tolist(), strict=True)
    )
    label = escape(f"{each.name}: least {value_text(least_reached(each), metric)}; {words}")
    half, dot = _ROW_PX / 2, css_colour(COLLIDING if used else QUIET)
    floor = ""
    if details.goal.floor > 0.0:
        floor = _bar(100.0 * details.goal.floor / scale, f"border-left:1px dashed {css_colour(COLLIDING)};")
    return (
        f'{head}<div role="img" aria-label="{label}" title="{label}" style="position:relative;height:{_ROW_PX}px;'
        f'background:{GROUND}">'
        f'<div style="{_PLACED}left:{low:.2f}%;width:{high - low:.2f}%;top:{half - 0.5}px;height:1px;'
        f'background:{colour}"></div>'
        f'<div style="{_PLACED}left:{first:.2f}%;width:{third - first:.2f}%;top:3px;height:{_ROW_PX - 8}px;'
        f'background:{TRACK};border:1px solid {colour}"></div>'
        f"{_bar(middle, f'border-left:2px solid {colour};')}{floor}"
        f'<div style="{_PLACED}left:calc({least:.2f}% - 3px);top:{half - 3}px;width:6px;height:6px;border-radius:3px;'
        f'background:{dot}"></div></div>'
    )


def _bar(left: float, looks: str) -> str:
    return f'<div style="{_PLACED}left:{left:.2f}%;top:1px;height:{_ROW_PX - 2}px;{looks}"></div>'


def map_html(details: PlacementDetails, mapped: PlacementMap) -> str:
    """The map from above, x to the right and y up: the best over the yaws; blank where none is feasible."""
    values = mapped.highest
    known = values[np.isfinite(values)]
    x, y = 1e3 * mapped.x, 1e3 * mapped.y
    if not len(known):
        return box_html("No node of the map is feasible at any yaw.")
    low, high = float(known.min()), float(known.max())
    marks = np.linspace(low, high, _MARKS)
    legend = dict(
        zip(
            (value_text(float(each), details.goal.metric) for each in marks),
            tints_of_values(marks, low, high),
            strict=True,
        )
    )
    node = 1e3 * mapped.x[mapped.best[0]], 1e3 * mapped.y[mapped.best[1]]
    marked = node if mapped.refined_at is None else tuple(1e3 * each for each in mapped.refined_at[:2])
    best = f"best node at x {node[0]:z.0f}, y {node[1]:z.0f} mm"
    best += "" if mapped.refined_at is None else f", refined to x {marked[0]:.0f}, y {marked[1]:.0f} mm"
    label = escape(f"Map of placements, {len(x)} by {len(y)} nodes, {best}")
    base = 1e3 * details.cell.T_cell_base[:2, 3]
    signs = _sign(mapped, float(base[0]), float(base[1]), "&#9632;", css_colour(INK))
    if mapped.score.value >= 0.0:
        signs += _sign(mapped, float(marked[0]), float(marked[1]), "&#10010;", css_colour(INK))
    picture = (
        f'<div style="position:relative;margin:4px 0;border:1px solid {LINE_COLOUR};background:{GROUND}">'
        f'<img alt="{label}" src="data:image/png;base64,{_png(values, low, high)}" '
        f'style="display:block;width:100%;image-rendering:pixelated">{signs}</div>'
    )
    words = (
        f"x {x[0]:.0f} to {x[-1]:.0f} mm to the right, y {y[0]:.0f} to {y[-1]:.0f} mm up; the best of "
        f"{len(mapped.yaw)} yaws. Without the bodies, but for the best node. Square: base; cross: {best}."
    )
    return box_html(picture) + legend_html(legend.items(), SQUARE) + box_html(small_html(escape(words)))


def _sign(mapped: PlacementMap, x: float, y: float, sign: str, colour: str) -> str:
    """A sign at a place of the map, mm; none where that is beyond its edge."""
    shares = list[float]()
    for at, nodes in ((x, 1e3 * mapped.x), (y, 1e3 * mapped.y)):
        half = 0.5 * (nodes[1] - nodes[0]) if len(nodes) > 1 else 1.0
        shares.append(float((at - nodes[0] + half) / (nodes[-1] - nodes[0] + 2.0 * half)))
    if not all(0.0 <= share <= 1.0 for share in shares):
        return ""
    return (
        f'<div style="{_PLACED}left:{100.0 * shares[0]:.2f}%;top:{100.0 * (1.0 - shares[1]):.2f}%;'
        f"transform:translate(-50%,-50%);font-size:14px;line-height:1;color:{colour};"
        f'text-shadow:0 0 3px {PAPER},0 0 3px {PAPER}">{sign}</div>'
    )


def _png(values: np.ndarray, low: float, high: float) -> str:
    """A picture with a pixel for each node, transparent where there is no value; base64."""
    from PIL import Image

    shown = values.T[::-1]
    there = np.isfinite(shown)
    colours = of_values(np.where(there, shown, low).ravel(), low, high).reshape(*shown.shape, 3)
    pixels = np.dstack([colours, np.where(there, 255, 0).astype(np.uint8)])
    out = BytesIO()
    Image.fromarray(pixels, "RGBA").save(out, "PNG")
    return base64.b64encode(out.getvalue()).decode()
