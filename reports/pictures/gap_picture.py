"""The gap under one component in plan: where it is pressed, how it flows, what stays."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.undersides.underside import GapCase, Underside
from cleaning.gap.flow_field import GapField
from cleaning.undersides.gap_result import GapResult, GapStage
from cleaning.verdicts.results import CleaningReport, Part
from geometry.arrays import Scalars
from reports.pictures.cleaning_pictures import WIDTH_MM
from reports.pictures.html_page import Picture
from reports.pictures.sheet import ACCENT, FAINT, INK, sheet, to_bytes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SIDES = ("front", "right", "back", "left")
_PANEL_MM = 52.0
_TITLE_MM = 13.0
_MOST_ARROWS = 11
"""Along each side."""


def draw_gaps(report: CleaningReport, part: Part) -> Picture:
    """Draw every case of a part's underside: pressure, wall shear with the flow, and the residue that is left.

    Pressure and flow are those of one moment that may never be: the side that drives most flow, at its highest
    pressures, the others at rest.
    """
    underside = part.underside
    assert underside is not None
    rows = len(part.gaps)
    panel_mm = max(20.0, min(_PANEL_MM * underside.width_mm / underside.length_mm, 90.0)) + _TITLE_MM
    with sheet(rows * panel_mm, WIDTH_MM) as figure:
        grid = figure.add_gridspec(
            rows, 3, left=0.01, right=0.94, bottom=0.03, top=1 - _TITLE_MM / (rows * panel_mm), wspace=0.22, hspace=0.34
        )
        for row, (gap, case) in enumerate(zip(part.gaps, underside.cases, strict=True)):
            panels = [figure.add_subplot(grid[row, column]) for column in range(3)]
            _draw_case(panels, report, gap)
            for axes in panels:
                _draw_joints(axes, underside, case)
        says = f"Pressure, flow and residue in the gap under {part.component}"
        return Picture(".svg", to_bytes(figure, ".svg"), says)


def strongest_stage(report: CleaningReport, gap: GapResult) -> tuple[str, GapStage] | None:
    """Give the function and the result of the stage that presses a gap hardest; washing goes first."""
    wet = [(stage, result) for stage, result in zip(report.stages, gap.stages, strict=True) if result is not None]
    ranked = sorted(wet, key=lambda pair: (pair[0].use != "wash", -round(max(pair[1].edge_pa), 3)))
    return (ranked[0][0].function, ranked[0][1]) if ranked else None


def pressed_side(field: GapField, result: GapStage) -> tuple[int, Scalars]:
    """Give the side that drives most flow at its highest pressures, and (8,) pressures with those of the others gone.

    A side that joints close drives none, however hard it is pressed.
    """
    edge = np.array(result.edge_pa)
    alone = np.where(np.arange(8) // 2 == np.arange(4)[:, None], edge, 0.0)
    flow = np.linalg.norm(np.einsum("as,sck->ack", alone, field.velocity), axis=2).mean(axis=1)
    side = int(np.argmax(np.round(flow / max(float(flow.max(initial=0.0)), 1e-300), 6)))
    return side, alone[side]


def _draw_case(panels: list[Axes], report: CleaningReport, gap: GapResult) -> None:
    height = f"{1000 * gap.standoff_mm:.0f} µm"
    found = strongest_stage(report, gap)
    left = next((result.residue for result in reversed(gap.stages) if result is not None), None)
    if found is not None:
        function, result = found
        side, edge = pressed_side(gap.field, result)
        pressure = edge @ gap.field.pressure
        flow = np.einsum("s,sck->ck", edge, gap.field.velocity)
        shear = 6 * np.linalg.norm(flow, axis=1) / gap.field.height_m
        title = f"{height}: pressure, Pa\n{function}, from the {_SIDES[side]}"
        _draw_values(panels[0], gap.field, pressure, "cividis", title)
        _draw_values(panels[1], gap.field, shear, "viridis", f"{height}: wall shear, Pa\nand the way of the flow")
        _draw_flow(panels[1], gap.field, flow)
    if left is not None:
        share = 100 * left.astype(np.float64)
        title = f"{height}: residue left, %\nmean {100 * gap.residue:.3g}, worst tenth {100 * gap.residue_worst:.3g}"
        _draw_values(panels[2], gap.field, share, "magma_r", title, least_top=1.0)
        panels[2].plot(*gap.worst_at, marker="+", markersize=8, color=ACCENT, zorder=5)


def _draw_values(
    axes: Axes, field: GapField, values: Scalars, scale: str, title: str, *, least_top: float = 1e-6
) -> None:
    image = np.full(field.shape[0] * field.shape[1], np.nan)
    image[field.cells] = values
    x, y = 500 * field.length_m, 500 * field.width_m
    drawn = axes.imshow(
        np.ma.masked_invalid(image.reshape(field.shape)), origin="lower", extent=(-x, x, -y, y), cmap=scale, vmin=0,
        vmax=max(float(values.max(initial=0.0)), least_top), interpolation="nearest",
    )  # fmt: skip
    bar = axes.figure.colorbar(drawn, ax=axes, fraction=0.046, pad=0.03)
    bar.outline.set_visible(False)
    axes.set_title(title, loc="left", fontsize=7.5)


def _draw_flow(axes: Axes, field: GapField, flow: NDArray[np.float64]) -> None:
    """Draw arrows at every few cells, as long as the root of the speed, so that slow places show their way too."""
    rows, columns = np.divmod(field.cells, field.shape[1])
    step = [max(1, -(-count // _MOST_ARROWS)) for count in field.shape]
    shown = (rows % step[0] == step[0] // 2) & (columns % step[1] == step[1] // 2)
    shown &= field.weights > 0.5 * field.weights.max(initial=0.0)  # joints cover the others
    speed = np.linalg.norm(flow, axis=1, keepdims=True)
    arrows = flow / np.sqrt(np.maximum(speed, 1e-12 * max(float(speed.max(initial=0.0)), 1e-30)))
    longest = float(np.linalg.norm(arrows[shown], axis=1).max(initial=0.0)) or 1.0
    cell_mm = 1000 * field.length_m / field.shape[1] * step[1]
    axes.quiver(
        *(1000 * field.centres[shown]).T, *arrows[shown].T, color="white", angles="xy", scale_units="xy",
        scale=longest / (1.1 * cell_mm), width=0.008, zorder=4,
    )  # fmt: skip


def _draw_joints(axes: Axes, underside: Underside, case: GapCase) -> None:
    from matplotlib.patches import Circle, Rectangle

    for joint in case.joints:
        place = (joint.x_mm, joint.y_mm)
        if joint.round:
            shape: Circle | Rectangle = Circle(place, joint.length_mm / 2)
        else:
            corner = (joint.x_mm - joint.length_mm / 2, joint.y_mm - joint.width_mm / 2)
            shape = Rectangle(
                corner, joint.length_mm, joint.width_mm, angle=float(np.degrees(joint.turn_rad)), rotation_point=place
            )
        shape.set(facecolor="#dfe3e6", edgecolor=INK, linewidth=0.4, zorder=3)
        axes.add_patch(shape)
    x, y = underside.length_mm / 2, underside.width_mm / 2
    axes.add_patch(Rectangle((-x, -y), 2 * x, 2 * y, facecolor="none", edgecolor=FAINT, linewidth=0.8))
    axes.set_xlim(-1.02 * x, 1.02 * x)
    axes.set_ylim(-1.02 * y, 1.02 * y)
    axes.set_aspect("equal", anchor="NW")
    axes.set_axis_off()
