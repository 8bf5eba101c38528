"""The gap under a component in plan: pressure, shear or residue in colours, flow as arrows, joints. SVG."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal, TypeAlias

import numpy as np

from boards.undersides.underside import Joint, Underside
from cleaning.gap.flow_field import GapField
from cleaning.undersides.gap_result import GapResult, GapStage
from cleaning.verdicts.results import Part
from geometry.arrays import Points2, Scalars
from webui.cards.component_card import facts_html
from webui.layers.surface.heat_scale import gradient_html, round_up
from webui.layers.surface.heat_values import LEAST_RESIDUE_PCT
from webui.theme.palette import ACCENT, INK, QUIET, of_values, to_hex

GapShown: TypeAlias = Literal["pressure", "shear", "residue"]
SHOWN: dict[str, GapShown] = {"Residue": "residue", "Pressure": "pressure", "Wall shear": "shear"}
"""As they are called on the page."""
UNITS: dict[GapShown, str] = {"pressure": "Pa", "shear": "Pa", "residue": "%"}
SIDES = ("front", "right", "back", "left")
"""As seen from above, with the board's y to the back."""
_LEVELS = 24
_ARROWS = 9
"""Along the longer side."""
_SLOWEST = 0.03
"""Of a fast flow: slower ones have no arrow."""
_JOINT = "#8d8f92"
_MM = 1000.0


@dataclass(frozen=True, slots=True, eq=False)
class GapPicture:
    """What is drawn of one gap in one stage."""

    underside: Underside
    gap: GapResult
    joints: tuple[Joint, ...]
    after: GapStage
    shown: GapShown
    side: int
    """At which of its own sides the jet is thought to be: front, right, back or left in the frame of the underside."""


def picture_of(part: Part, case: int, stage: int, shown: GapShown, side: str) -> GapPicture | None:
    """Choose what is drawn; nothing where the stage does not act on the gap.

    Args:
        part: One with an underside.
        case: Which of its gaps, the harder first.
        stage: Counted from 0.
        shown: What the colours mean.
        side: Where the jet is, as seen on the board; another word for where it presses most.
    """
    if part.underside is None or case >= len(part.gaps):
        return None
    gap = part.gaps[case]
    after = gap.stages[stage]
    if after is None:
        return None
    words = side_words(part.underside.turn_rad)
    chosen = words.index(side) if side in words else strongest_side(after)
    return GapPicture(part.underside, gap, part.underside.cases[case].joints, after, shown, chosen)


def side_words(turn_rad: float) -> tuple[str, ...]:
    """Say how its front, right, back and left side are called on the board when an underside is turned."""
    quarters = round(turn_rad / (np.pi / 2) + 1e-9)
    return tuple(SIDES[(side + quarters) % 4] for side in range(4))


def strongest_side(after: GapStage) -> int:
    """Say at which side the spray presses most, of two halves the mean."""
    return int(np.argmax(np.round(side_means(after), 3)))


def side_means(after: GapStage) -> Scalars:
    """(4,) highest pressure, Pa, at front, right, back and left side, each the mean of its halves."""
    return np.array(after.edge_pa).reshape(4, 2).mean(axis=1)


def pressures_at(after: GapStage, side: int) -> Scalars:
    """(8,) pressure on the edge segments, Pa, while the jet is at one side and nothing presses elsewhere."""
    held = np.zeros(8)
    held[2 * side : 2 * side + 2] = np.array(after.edge_pa)[2 * side : 2 * side + 2]
    return held


def cell_numbers(picture: GapPicture) -> Scalars:
    """(c,) what the colours say of each cell of the gap's field."""
    match picture.shown:
        case "pressure":
            return pressures_at(picture.after, picture.side) @ picture.gap.field.pressure.astype(np.float64)
        case "shear":
            return picture.after.shear_pa.astype(np.float64)
        case "residue":
            return 100.0 * picture.after.residue.astype(np.float64)


def top_of(picture: GapPicture, values: Scalars) -> float:
    """Value at the light end of the colours."""
    top = round_up(float(values.max(initial=0.0)))
    return min(max(top, LEAST_RESIDUE_PCT), 100.0) if picture.shown == "residue" else top


def gap_svg(picture: GapPicture) -> str:
    """Draw the gap as it is turned on the board, seen from above."""
    field, underside = picture.gap.field, picture.underside
    values = cell_numbers(picture)
    length, width = underside.length_mm, underside.width_mm
    reach = np.hypot(length, width) / 2 * 1.02
    frame = f'x="{-length / 2:.4f}" y="{-width / 2:.4f}" width="{length:.4f}" height="{width:.4f}"'
    inner = (
        f'<rect {frame} fill="{_JOINT}"/>'
        + _cells_svg(field, values, top_of(picture, values))
        + "".join(_joint_svg(joint) for joint in picture.joints)
        + _arrows_svg(field, pressures_at(picture.after, picture.side))
        + f'<rect {frame} fill="none" stroke="{to_hex(INK)}" stroke-width="{reach / 150:.4f}"/>'
        + _jet_svg(picture)
        + (_ring_svg(picture.gap.worst_at, reach / 14) if picture.shown == "residue" else "")
    )
    turn = np.degrees(underside.turn_rad)
    across, up = _room(length, width, underside.turn_rad)
    return (
        f'<svg viewBox="{-across:.4f} {-up:.4f} {2 * across:.4f} {2 * up:.4f}" role="img" '
        f'aria-label="Gap under {escape(underside.component)} from above" '
        'style="display:block;width:100%;max-height:300px;background:#f6f7f8">'
        f'<g transform="scale(1,-1) rotate({turn:.4f})">{inner}</g></svg>'
    )


def gap_html(picture: GapPicture) -> str:
    """Draw a gap, say what its colours mean, and write its numbers."""
    values = cell_numbers(picture)
    bar = gradient_html(top_of(picture, values), UNITS[picture.shown], ends=True)
    ring = " Ring: the worst tenth." if picture.shown == "residue" else ""
    return (
        f'<div style="margin:4px 12px">{gap_svg(picture)}</div>{bar}'
        f'<div style="margin:4px 12px;font-size:12px;color:{to_hex(INK)}">{facts_html(gap_facts(picture).items())}'
        f'<div style="color:{to_hex(QUIET)};font-size:11px;margin-top:2px">Arrows: the flow while the jet presses at '
        f"the marked side alone. Grey: joints.{ring}</div></div>"
    )


def gap_facts(picture: GapPicture) -> dict[str, str]:
    """Say what is known of a gap in one stage."""
    gap, after = picture.gap, picture.after
    words = side_words(picture.underside.turn_rad)
    pressures = ", ".join(f"{word} {value:.0f}" for word, value in zip(words, side_means(after), strict=True))
    entered = "opens" if after.entered else "stays dry"
    return {
        "Standoff": f"{_MM * gap.standoff_mm:.0f} µm, {picture.underside.standoff_source}",
        "Joints": picture.underside.joints_source,
        "Filled": f"{100 * gap.fill:.0f} % of its height before the wash",
        "Entry": f"{entered}: {after.margin_pa:+.0f} Pa with capillarity",
        "Edges": f"{pressures} Pa at most",
        "Renewed": f"{after.exchanges:.1f} times",
        "Weak": f"{100 * after.weak_share:.0f} % of the gap",
        "Residue": f"{100 * float(after.residue.mean()):.1f} % after this stage; in the end {100 * gap.residue:.1f} %, "
        f"worst tenth {100 * gap.residue_worst:.0f} %",
    }


def _cells_svg(field: GapField, values: Scalars, top: float) -> str:
    """One path for all cells of a colour: a gap has a thousand of them."""
    rows, columns = field.shape
    wide, high = _MM * field.length_m / columns, _MM * field.width_m / rows
    level = np.clip(np.round(values / top * (_LEVELS - 1)), 0, _LEVELS - 1).astype(int)
    colours = of_values(np.arange(_LEVELS, dtype=np.float64), 0.0, _LEVELS - 1.0)
    row, column = np.divmod(field.cells, columns)
    x, y = column * wide - _MM * field.length_m / 2, row * high - _MM * field.width_m / 2
    paths: list[str] = []
    for each in np.unique(level).tolist():
        mine = level == each
        corners = zip(x[mine].tolist(), y[mine].tolist(), strict=True)
        squares = "".join(f"M{a:.3f} {b:.3f}h{wide:.3f}v{high:.3f}h{-wide:.3f}z" for a, b in corners)
        red, green, blue = colours[each].tolist()
        paths.append(f'<path fill="{to_hex((red, green, blue))}" shape-rendering="crispEdges" d="{squares}"/>')
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


def _arrows_svg(field: GapField, pressures: Scalars) -> str:
    """Arrows on a coarse grid; longer where the flow is faster, by the square root, so that slow ones show too.

    The fastest tenth, mostly at corners, is drawn alike: it would leave all others too short to be seen.
    """
    flow = np.einsum("s,sck->ck", pressures, field.velocity.astype(np.float64))
    speed = np.hypot(flow[:, 0], flow[:, 1])
    fast = float(np.quantile(speed, 0.9)) if len(speed) else 0.0
    if fast <= 0:
        return ""
    pitch = _MM * max(field.length_m, field.width_m) / _ARROWS
    shown = _nearest_to_grid(_MM * field.centres, pitch)
    shown = shown[speed[shown] > _SLOWEST * fast]
    along = flow[shown] / speed[shown, None]
    length = 0.85 * pitch * np.sqrt(np.minimum(speed[shown] / fast, 1.0))
    middle = _MM * field.centres[shown]
    path = "".join(
        _arrow(at, to, size) for at, to, size in zip(middle.tolist(), along.tolist(), length.tolist(), strict=True)
    )
    return f'<path d="{path}" fill="none" stroke="#ffffff" stroke-width="{pitch / 12:.4f}" stroke-linecap="round"/>'


def _arrow(middle: Sequence[float], along: Sequence[float], size: float) -> str:
    (x, y), (dx, dy) = middle, along
    tip_x, tip_y, head = x + dx * size / 2, y + dy * size / 2, 0.3 * size
    return (
        f"M{x - dx * size / 2:.3f} {y - dy * size / 2:.3f}L{tip_x:.3f} {tip_y:.3f}"
        f"M{tip_x - head * (dx + 0.6 * dy):.3f} {tip_y - head * (dy - 0.6 * dx):.3f}L{tip_x:.3f} {tip_y:.3f}"
        f"L{tip_x - head * (dx - 0.6 * dy):.3f} {tip_y - head * (dy + 0.6 * dx):.3f}"
    )


def _nearest_to_grid(centres: Points2, pitch: float) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Of the cells in each square of a grid around the middle the one nearest to the square's own middle."""
    square = np.round(centres / pitch).astype(np.int64)
    away = np.round(np.hypot(*(centres - square * pitch).T) / pitch, 6)
    order = np.lexsort((away, square[:, 1], square[:, 0]))
    first = np.concatenate([[True], (np.diff(square[order], axis=0) != 0).any(axis=1)])
    return np.sort(order[first])


def _jet_svg(picture: GapPicture) -> str:
    """A thick line along the side at which the jet is."""
    x, y = picture.underside.length_mm / 2, picture.underside.width_mm / 2
    ends = ((-x, -y, x, -y), (x, -y, x, y), (x, y, -x, y), (-x, y, -x, -y))[picture.side]
    x1, y1, x2, y2 = ends
    return (
        f'<line x1="{x1:.4f}" y1="{y1:.4f}" x2="{x2:.4f}" y2="{y2:.4f}" stroke="{to_hex(ACCENT)}" '
        f'stroke-width="{np.hypot(x, y) / 22:.4f}"/>'
    )


def _ring_svg(place: tuple[float, float], radius: float) -> str:
    return (
        f'<circle cx="{place[0]:.4f}" cy="{place[1]:.4f}" r="{radius:.4f}" fill="none" stroke="{to_hex(ACCENT)}" '
        f'stroke-width="{radius / 4:.4f}"/>'
    )


def _room(length: float, width: float, turn_rad: float) -> tuple[float, float]:
    """Half of what the picture spans, mm: a turned rectangle and a little more."""
    cos, sin = abs(np.cos(turn_rad)), abs(np.sin(turn_rad))
    return 1.06 * (length * cos + width * sin) / 2, 1.06 * (length * sin + width * cos) / 2
