"""The gap under a component in plan, as it is turned on the board: SVG, with the meaning of its colours and facts."""

from dataclasses import replace
from html import escape

import numpy as np

from boards.undersides.underside import Joint
from cleaning.gap.flow_field import GapField
from cleaning.verdicts.results import Part
from geometry.arrays import Scalars
from reports.pictures.gap_picture import SIDES, GapDrawing, Quantity, gap_drawing
from webui.layers.surface.heat_scale import LEAST_RESIDUE_PCT, gradient_html, round_up
from webui.theme.html import box_html, facts_html, small_html
from webui.theme.palette import ACCENT, GROUND, INK, css_colour, tints_of_values, to_hex

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
        "Entry": f"{entered}: {result.margin_pa:+.0f} Pa with capillarity",
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
