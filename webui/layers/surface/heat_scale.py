"""What a heat map shows: which number of the report, its limit, its colours and their legend."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cleaning.surface.facets import Facets
from cleaning.verdicts.cleanliness import outcome
from cleaning.verdicts.results import CleaningReport
from geometry.arrays import Scalars
from webui.glb.glb import Colours
from webui.layers.surface.heat_values import Measure
from webui.theme.palette import BOARD, COMPONENT, INK, QUIET, of_values, to_hex
from webui.theme.verdict_colours import VERDICT_COLOURS, VERDICT_WORDS

Colouring: TypeAlias = Literal["gradient", "limit"]
COLOURINGS: dict[str, Colouring] = {"Gradient": "gradient", "Pass or fail": "limit"}
"""As they are called on the page."""

PASSES = (58, 128, 176)
FAILS = (222, 150, 48)
"""Blue and orange: told apart by all eyes."""
MISSED = (62, 52, 74)
"""Exposed, and nothing landed."""
_MOST_SHARE = 0.98
"""Of the area is within the gradient; the few cells above it look like its end."""
_SMALLEST = 1e-9
_STOPS = 9


@dataclass(frozen=True, slots=True)
class Scale:
    """What colours mean."""

    measure: Measure
    colouring: Colouring
    top: float
    """Value at the light end of a gradient; its dark end is 0."""
    limit: float


def make_scale(report: CleaningReport, measure: Measure, values: Scalars, colouring: Colouring, limit: float) -> Scale:
    """Choose where a gradient ends: at a round number that nearly all of the area stays below.

    Args:
        report: Knows the areas.
        measure: What is shown.
        values: (c,) of the cells; not a number where nothing is said.
        colouring: Gradient, or on which side of the limit.
        limit: In the unit of the measure.
    """
    said = np.isfinite(values) & (values > 0)
    top = 1.0
    if said.any():
        order = np.argsort(values[said])
        areas = np.cumsum(report.facets.cell_areas_mm2[said][order])
        place = int(np.searchsorted(areas, _MOST_SHARE * areas[-1]))
        top = round_up(float(values[said][order][min(place, len(order) - 1)]))
    return Scale(measure, colouring, min(max(top, measure.least_top), measure.most), limit)


def tint_cells(facets: Facets, values: Scalars, scale: Scale) -> Colours:
    """(c, 3) colours of the cells.

    Args:
        facets: Which belong to a component.
        values: (c,) not a number where nothing is said.
        scale: What colours mean.
    """
    colours = plain_cells(facets)
    said = np.isfinite(values)
    colours[said] = tint_values(values[said], scale)
    return colours


def tint_values(values: Scalars, scale: Scale) -> Colours:
    """(n, 3) colours of numbers."""
    if scale.measure.name == "verdict":
        return np.array(list(VERDICT_COLOURS.values()), dtype=np.uint8)[values.astype(int)]
    if scale.colouring == "limit":
        passes = scale.measure.passes(values, scale.limit)
        return np.where(passes[:, None], np.array(PASSES), np.array(FAILS)).astype(np.uint8)
    colours = of_values(values, 0.0, scale.top)
    if scale.measure.per == "cell":
        colours[values <= 0] = MISSED
    return colours


def plain_cells(facets: Facets) -> Colours:
    """(c, 3) colours of cells of which nothing is said."""
    bare = (facets.cell_component < 0)[:, None]
    return np.where(bare, np.array(BOARD), np.array(COMPONENT)).astype(np.uint8)


def round_up(value: float) -> float:
    """Next of 1, 1.5, 2, 3, 5, 7 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(max(value, _SMALLEST)))
    steps = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0]) * power
    return float(steps[min(int(np.searchsorted(steps, value * (1 - _SMALLEST))), len(steps) - 1)])


def scale_html(report: CleaningReport, values: Scalars, scale: Scale) -> str:
    """Say what the colours mean, and how much of the area they cover."""
    said = np.isfinite(values) & report.facets.cell_exposed
    areas = report.facets.cell_areas_mm2
    total = float(areas[said].sum())
    if total <= 0:
        return _note("Nothing to show here: this stage does not reach it, or no gap is known.")

    def share(cells: NDArray[np.bool_]) -> str:
        return _percent(float(areas[said & cells].sum()) / total)

    if scale.measure.name == "verdict":
        counts = Counter(map(outcome, report.parts))
        return _swatches([(VERDICT_COLOURS[each], f"{words}: {counts[each]}") for each, words in VERDICT_WORDS.items()])
    if scale.colouring == "limit":
        passes, unit = scale.measure.passes(values, scale.limit), scale.measure.unit
        within, beyond = ("at least", "less than") if scale.measure.better == "more" else ("at most", "more than")
        limit = f"{scale.limit:g} {unit}".strip()
        of = "of the area" if scale.measure.per == "cell" else "of the parts' surface"
        return _swatches(
            [
                (PASSES, f"{within} {limit}: {share(passes)} {of}"),
                (FAILS, f"{beyond} {limit}: {share(~passes)} {of}"),
            ]
        )
    missed = [(MISSED, f"nothing landed: {share(values <= 0)} of the area")] if scale.measure.per == "cell" else []
    ends = scale.top >= scale.measure.most
    return gradient_html(scale.top, scale.measure.unit, ends=ends) + (_swatches(missed) if missed else "")


def gradient_html(top: float, unit: str, *, ends: bool = False) -> str:
    """Draw a gradient from 0 to a value.

    Args:
        top: At the light end.
        unit: Of the numbers.
        ends: Nothing can be above.
    """
    stops = of_values(np.linspace(0.0, 1.0, _STOPS), 0.0, 1.0)
    colours = ",".join(to_hex((int(r), int(g), int(b))) for r, g, b in stops)
    marks = "".join(f"<span>{top * share:.4g}</span>" for share in (0.0, 0.25, 0.5, 0.75))
    return (
        f'<div style="margin:4px 12px 0;font-size:11px;color:{to_hex(INK)}">'
        f'<div style="height:10px;border-radius:2px;background:linear-gradient(to right,{colours})"></div>'
        '<div style="display:flex;justify-content:space-between;font-variant-numeric:tabular-nums">'
        f"{marks}<span>{top:.4g} {escape(unit)}{'' if ends else ' or more'}</span></div></div>"
    )


def _swatches(items: Sequence[tuple[tuple[int, int, int], str]]) -> str:
    rows = "".join(
        '<div style="display:flex;align-items:center"><span style="width:12px;height:12px;border-radius:2px;'
        f'background:{to_hex(colour)};margin-right:7px"></span>{escape(text)}</div>'
        for colour, text in items
    )
    return f'<div style="margin:4px 12px;font-size:12px;color:{to_hex(INK)};line-height:1.6">{rows}</div>'


def _note(text: str) -> str:
    return f'<div style="margin:4px 12px;font-size:12px;color:{to_hex(QUIET)}">{escape(text)}</div>'


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %" if 0 < share < 0.1 else f"{100 * share:.0f} %"
