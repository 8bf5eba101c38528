"""The gap under one component in plan: pressure, wall shear or residue in colours, the flow as arrows, the joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

import numpy as np

from boards.undersides.underside import Joint, Underside
from cleaning.gap.flow_field import GapField
from cleaning.undersides.residue import GapResult, GapStage
from cleaning.verdicts.results import CleaningReport, Part
from geometry.arrays import Points2, Scalars
from reports.pictures.cleaning_pictures import WIDTH_MM
from reports.pictures.sheet import ACCENT, FAINT, INK, Picture, draw_image, open_sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Quantity: TypeAlias = Literal["pressure", "shear", "residue"]
SIDES = ("front", "right", "back", "left")
"""Of an underside in its own frame."""
_PANEL_MM = 52.0
_TITLE_MM = 13.0
_MM = 1000.0
_ARROWS = 9
"""Along the longer side."""
_SLOWEST = 0.03
"""Of a fast flow: slower ones have no arrow."""


@dataclass(frozen=True, slots=True, eq=False)
class GapDrawing:
    """What is drawn of one gap in one stage, in the frame of the underside."""

    underside: Underside
    gap: GapResult
    joints: tuple[Joint, ...]
    result: GapStage
    side: int
    """Index into ``SIDES`` of the side at which the jet presses, the others at rest."""

    @property
    def pressures(self) -> Scalars:
        """(8,) pressure on the edge segments, Pa, while the jet presses at one side."""
        return np.where(np.arange(8) // 2 == self.side, self.result.edge_pa, 0.0)

    def values(self, quantity: Quantity) -> Scalars:
        """(cells,) value of a quantity in each cell of the gap's field; Pa or %."""
        match quantity:
            case "pressure":
                return self.pressures @ self.gap.field.pressure.astype(np.float64)
            case "shear":
                return self.result.shear_pa.astype(np.float64)
            case "residue":
                return 100.0 * self.result.residue.astype(np.float64)

    def arrows(self) -> tuple[Points2, Points2]:
        """(n, 2) tails and tips of arrows along the flow on a coarse grid, mm.

        Their length goes with the square root of the speed, so that slow places show their direction. The fastest
        tenth, mostly at corners, is drawn alike: it would leave all others too short to be seen.
        """
        field = self.gap.field
        flow = np.einsum("s,sck->ck", self.pressures, field.velocity.astype(np.float64))
        speed = np.hypot(flow[:, 0], flow[:, 1])
        fast = float(np.quantile(speed, 0.9)) if len(speed) else 0.0
        if fast <= 0:
            return np.empty((0, 2)), np.empty((0, 2))
        pitch = _MM * max(field.length_m, field.width_m) / _ARROWS
        # Of the cells in each square of a grid around the middle, the one nearest to the square's own middle.
        square = np.round(_MM * field.centres / pitch).astype(np.int64)
        away = np.round(np.hypot(*(_MM * field.centres - square * pitch).T) / pitch, 6)
        order = np.lexsort((away, square[:, 1], square[:, 0]))
        first = np.concatenate([[True], (np.diff(square[order], axis=0) != 0).any(axis=1)])
        shown = np.sort(order[first])
        shown = shown[speed[shown] > _SLOWEST * fast]
        lengths = 0.85 * pitch * np.sqrt(np.minimum(speed[shown] / fast, 1.0))
        half = flow[shown] * (lengths / speed[shown] / 2)[:, None]
        return _MM * field.centres[shown] - half, _MM * field.centres[shown] + half


def pressed_side(field: GapField, result: GapStage) -> int:
    """Index of the side that drives the most flow when it alone is pressed at its highest pressures.

    A side that joints close drives none, however hard it is pressed.
    """
    edge = np.array(result.edge_pa)
    alone = np.where(np.arange(8) // 2 == np.arange(4)[:, None], edge, 0.0)
    flow = np.linalg.norm(np.einsum("as,sck->ack", alone, field.velocity), axis=2).mean(axis=1)
    return int(np.argmax(np.round(flow / max(float(flow.max(initial=0.0)), 1e-300), 6)))


def strongest_stage(report: CleaningReport, gap: GapResult) -> int | None:
    """Index of the stage that presses a gap hardest; washing goes first."""
    wet = [
        (stage.use != "wash", -round(max(result.edge_pa), 3), index)
        for index, (stage, result) in enumerate(zip(report.stages, gap.stages, strict=True))
        if result is not None
    ]
    return min(wet)[2] if wet else None


def gap_drawing(part: Part, case: int, stage: int) -> GapDrawing | None:
    """Collect what is drawn of a gap, pressed at the side that drives the most flow.

    Args:
        part: One with an underside.
        case: Index of the gap, the harder first.
        stage: Index of the stage.

    Returns:
        The drawing; ``None`` where there is no such gap, or the stage does not act on it.
    """
    result = part.gaps[case].stages[stage] if case < len(part.gaps) else None
    if part.underside is None or result is None:
        return None
    gap, joints = part.gaps[case], part.underside.cases[case].joints
    return GapDrawing(part.underside, gap, joints, result, pressed_side(gap.field, result))


def draw_gaps(report: CleaningReport, part: Part) -> Picture:
    """Draw every case of a part's underside: pressure, wall shear with the flow, and the residue that is left.

    Pressure and flow are those of one moment that may never occur: the side that drives the most flow, at its highest
    pressures, the others at rest.
    """
    underside = part.underside
    assert underside is not None
    rows = len(part.gaps)
    panel_mm = max(20.0, min(_PANEL_MM * underside.width_mm / underside.length_mm, 90.0)) + _TITLE_MM
    with open_sheet(".svg", rows * panel_mm, WIDTH_MM) as sheet:
        panels = sheet.grid(3 * rows, 3, (0.01, 0.03, 0.94, 1 - _TITLE_MM / (rows * panel_mm)), (0.22, 0.34))
        for row in range(rows):
            _draw_case(panels[3 * row : 3 * row + 3], report, part, row)
            for axes in panels[3 * row : 3 * row + 3]:
                _draw_joints(axes, underside, underside.cases[row].joints)
        return sheet.picture(f"Pressure, flow and residue in the gap under {part.component}")


def _draw_case(panels: list[Axes], report: CleaningReport, part: Part, case: int) -> None:
    gap = part.gaps[case]
    height = f"{_MM * gap.gap_height_mm:.0f} µm"
    stage = strongest_stage(report, gap)
    drawing = None if stage is None else gap_drawing(part, case, stage)
    if stage is None or drawing is None:
        return
    title = f"{height}: pressure, Pa\n{report.stages[stage].function}, from the {SIDES[drawing.side]}"
    _draw_values(panels[0], gap.field, drawing.values("pressure"), "cividis", title)
    title = f"{height}: highest wall shear, Pa\nand direction of the flow"
    _draw_values(panels[1], gap.field, drawing.values("shear"), "viridis", title)
    tails, tips = drawing.arrows()
    style: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1, "width": 0.008, "zorder": 4}
    panels[1].quiver(*tails.T, *(tips - tails).T, color="white", **style)
    last = max(index for index, result in enumerate(gap.stages) if result is not None)
    left = gap_drawing(part, case, last)
    assert left is not None
    title = f"{height}: residue left, %\nmean {100 * gap.residue:.3g}, worst tenth {100 * gap.residue_worst:.3g}"
    dirty = 100.0 * report.parameters.limits.gap_dirty
    _draw_values(panels[2], gap.field, left.values("residue"), "magma_r", title, dirty)
    panels[2].plot(*gap.worst_at, marker="+", markersize=8, color=ACCENT, zorder=5)


def _draw_values(axes: Axes, field: GapField, values: Scalars, scale: str, title: str, least_top: float = 1e-6) -> None:
    image = np.full(field.shape[0] * field.shape[1], np.nan)
    image[field.cells] = values
    x, y = _MM * field.length_m / 2, _MM * field.width_m / 2
    top, place = max(float(values.max(initial=0.0)), least_top), {"fraction": 0.046, "pad": 0.03}
    draw_image(axes, image.reshape(field.shape), (-x, x, -y, y), scale, place, origin="lower", vmin=0, vmax=top)
    axes.set_title(title, loc="left", fontsize=7.5)


def _draw_joints(axes: Axes, underside: Underside, joints: tuple[Joint, ...]) -> None:
    """Draw joints and the outline of the underside, and show just that."""
    from matplotlib.patches import Circle, Rectangle

    for joint in joints:
        place = (joint.x_mm, joint.y_mm)
        if joint.round:
            shape: Circle | Rectangle = Circle(place, joint.length_mm / 2)
        else:
            corner = (joint.x_mm - joint.length_mm / 2, joint.y_mm - joint.width_mm / 2)
            turn_deg = float(np.degrees(joint.turn_rad))
            shape = Rectangle(corner, joint.length_mm, joint.width_mm, angle=turn_deg, rotation_point=place)
        shape.set(facecolor="#dfe3e6", edgecolor=INK, linewidth=0.4, zorder=3)
        axes.add_patch(shape)
    x, y = underside.length_mm / 2, underside.width_mm / 2
    axes.add_patch(Rectangle((-x, -y), 2 * x, 2 * y, facecolor="none", edgecolor=FAINT, linewidth=0.8))
    axes.set_xlim(-1.02 * x, 1.02 * x)
    axes.set_ylim(-1.02 * y, 1.02 * y)
    axes.set_aspect("equal", anchor="NW")
    axes.set_axis_off()
