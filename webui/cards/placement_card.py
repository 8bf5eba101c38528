"""A placement as cards: box plots of the configurations, the map over the table."""

import base64
from html import escape
from io import BytesIO

import numpy as np

from reports.cards.placement import least_reached, value_text
from robotcell.placement.configurations import SHARES, ConfigurationValues, PlacementDetails
from robotcell.placement.placement_map import PlacementMap
from webui.theme.html import SQUARE, box_html, legend_html, small_html
from webui.theme.palette import (
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
)

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
    best = f"best node at x {node[0]:.0f}, y {node[1]:.0f} mm"
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
    file = BytesIO()
    Image.fromarray(pixels, "RGBA").save(file, "PNG")
    return base64.b64encode(file.getvalue()).decode()
