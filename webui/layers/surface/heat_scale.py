"""Heat maps: measures of a cleaning report, their values in the cells, limits, colours and legend."""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cleaning.exposure.exposure import Exposure
from cleaning.gap.flow_field import GapField
from cleaning.parameters.model import Limits
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.verdicts.exposed_area import shown_on_side
from cleaning.verdicts.results import CleaningReport, Part, outcome
from cleaning.verdicts.rules import OUTCOMES
from geometry.arrays import Scalars
from reports.tables.cleaning_tables import OUTCOME_WORDS
from specs.errors import JobError
from webui.glb.glb import Colours
from webui.theme.html import SQUARE, box_html, legend_html, quiet_html
from webui.theme.palette import (
    BOARD,
    COMPONENT,
    VERDICT_COLOURS,
    of_values,
    tints_of_values,
    to_hex,
)

MeasureName: TypeAlias = Literal["cone", "front", "volume", "supply", "peak", "shear", "residue", "verdict"]
LEAST_RESIDUE_PCT = 10.0
"""Least top of the colours of residue."""


class LimitError(JobError):
    """A limit that was typed cannot be used."""


@dataclass(frozen=True, slots=True)
class Measure:
    """A quantity that a heat map shows."""

    name: MeasureName
    unit: str
    per: Literal["cell", "part"]
    better: Literal["more", "less"]
    limit: Callable[[Limits, Stage], float]
    """Limit of the parameter set, in this unit; a proposal where it has none."""
    most: float = np.inf
    """Greatest possible value."""
    least_top: float = 0.0
    """Least top of a gradient: values far from any limit are to look so."""

    def passes(self, values: Scalars, limit: float) -> NDArray[np.bool_]:
        """(c,) which values meet a limit; one that is not a number does not."""
        return values >= limit if self.better == "more" else values <= limit


def _least_volume(limits: Limits, stage: Stage) -> float:
    return limits.rinse_volume_mm if stage.use == "rinse" else limits.wash_volume_mm


MEASURES: dict[str, Measure] = {
    "Verdict": Measure("verdict", "", "part", "less", lambda _limits, _stage: 0.0),
    "Volume": Measure("volume", "mm", "cell", "more", _least_volume),
    "Volume with run-off": Measure("supply", "mm", "cell", "more", _least_volume),
    "Time in the wave front": Measure("front", "s", "cell", "more", lambda limits, _stage: limits.front_s or 1.0),
    "Time in the cone (1993)": Measure("cone", "s", "cell", "more", lambda _limits, _stage: 1.0),
    "Peak pressure": Measure("peak", "Pa", "cell", "less", lambda _limits, _stage: 1000.0),
    "Shear under parts": Measure("shear", "Pa", "part", "more", lambda limits, _stage: limits.weak_shear_pa),
    "Residue under parts": Measure(
        "residue", "%", "part", "less", lambda limits, _stage: 100 * limits.gap_marginal, 100.0, LEAST_RESIDUE_PCT
    ),
}
"""By their names on the page."""

Colouring: TypeAlias = Literal["gradient", "limit"]
COLOURINGS: dict[str, Colouring] = {"Gradient": "gradient", "Pass or fail": "limit"}
"""By their names on the page."""

PASSES = (58, 128, 176)
FAILS = (222, 150, 48)
"""Blue and orange: distinct to colour-blind eyes too."""
MISSED = (62, 52, 74)
"""Colour of exposed cells without any volume."""
_MOST_SHARE = 0.98
"""Of the area is within the gradient; the few cells above it look like its end."""
_SMALLEST = 1e-9
_STOPS = 9


@dataclass(frozen=True, slots=True)
class Scale:
    """Meaning of the colours."""

    measure: Measure
    colouring: Colouring
    top: float
    """Value at the light end of a gradient; its dark end is 0."""
    limit: float


def make_scale(report: CleaningReport, measure: Measure, values: Scalars, colouring: Colouring, limit: float) -> Scale:
    """Scale whose gradient ends at a round number that nearly all of the area stays below.

    Args:
        report: With the areas.
        measure: The measure.
        values: (c,) of the cells; not a number where there is none.
        colouring: Gradient, or pass and fail.
        limit: In the unit of the measure.
    """
    known = np.isfinite(values) & (values > 0)
    top = 1.0
    if known.any():
        order = np.argsort(values[known])
        areas = np.cumsum(report.facets.cell_areas_mm2[known][order])
        place = int(np.searchsorted(areas, _MOST_SHARE * areas[-1]))
        top = round_up(float(values[known][order][min(place, len(order) - 1)]))
    return Scale(measure, colouring, min(max(top, measure.least_top), measure.most), limit)


def tint_cells(facets: Facets, values: Scalars, scale: Scale) -> Colours:
    """(c, 3) colours of the cells.

    Args:
        facets: With the component of each cell.
        values: (c,) not a number where there is none.
        scale: Meaning of the colours.
    """
    bare = (facets.cell_component < 0)[:, None]
    colours = np.where(bare, np.array(BOARD), np.array(COMPONENT)).astype(np.uint8)
    known = np.isfinite(values)
    colours[known] = scale_colours(values[known], scale)
    return colours


def scale_colours(values: Scalars, scale: Scale) -> Colours:
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


def round_up(value: float) -> float:
    """Next of 1, 1.5, 2, 3, 5, 7 times a power of ten."""
    power = 10.0 ** np.floor(np.log10(max(value, _SMALLEST)))
    steps = np.array([1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0]) * power
    return float(steps[min(int(np.searchsorted(steps, value * (1 - _SMALLEST))), len(steps) - 1)])


def scale_html(report: CleaningReport, values: Scalars, scale: Scale) -> str:
    """Legend of the colours, with the share of the area that each covers."""
    known = np.isfinite(values) & report.facets.cell_exposed
    areas = report.facets.cell_areas_mm2
    total = float(areas[known].sum())
    if total <= 0:
        return quiet_html("Nothing to show here: this stage does not reach it, or no gap is known.")

    def share(cells: NDArray[np.bool_]) -> str:
        found = 100 * float(areas[known & cells].sum()) / total
        return f"{found:.1f} %" if 0 < found < 10 else f"{found:.0f} %"

    if scale.measure.name == "verdict":
        counts = Counter(map(outcome, report.parts))
        verdicts = [(f"{words}: {counts[each]}", VERDICT_COLOURS[each]) for each, words in OUTCOME_WORDS.items()]
        return legend_html(verdicts, SQUARE)
    if scale.colouring == "limit":
        passes, unit = scale.measure.passes(values, scale.limit), scale.measure.unit
        within, beyond = ("at least", "less than") if scale.measure.better == "more" else ("at most", "more than")
        limit = f"{scale.limit:g} {unit}".strip()
        of = "of the area" if scale.measure.per == "cell" else "of the parts' surface"
        sides = [
            (f"{within} {limit}: {share(passes)} {of}", PASSES),
            (f"{beyond} {limit}: {share(~passes)} {of}", FAILS),
        ]
        return legend_html(sides, SQUARE)
    bar = gradient_html(scale.top, scale.measure.unit, ends=scale.top >= scale.measure.most)
    if scale.measure.per == "part":
        return bar
    return bar + legend_html([(f"nothing landed: {share(values <= 0)} of the area", MISSED)], SQUARE)


def gradient_html(top: float, unit: str, *, ends: bool = False) -> str:
    """Gradient from 0 to a value.

    Args:
        top: Value at the light end.
        unit: Of the numbers.
        ends: Whether there are no values above.
    """
    colours = ",".join(map(to_hex, tints_of_values(np.linspace(0.0, 1.0, _STOPS), 0.0, 1.0)))
    marks = "".join(f"<span>{_number(top * share)}</span> " for share in (0.0, 0.25, 0.5, 0.75))
    return box_html(
        f'<div style="height:10px;border-radius:2px;background:linear-gradient(to right,{colours})"></div>'
        '<div style="display:flex;justify-content:space-between;font-variant-numeric:tabular-nums">'
        f"{marks}<span>{_number(top)} {escape(unit)}{'' if ends else ' or more'}</span></div>",
        "font-size:11px",
    )


def _number(value: float) -> str:
    """A number of four digits, never with an exponent where it is large."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.4g}"


def cell_values(report: CleaningReport, measure: Measure, stage: int) -> Scalars:
    """(c,) value of a measure in each cell; not a number where it has none, as on a side that is not sprayed.

    Args:
        report: The analysis.
        measure: The measure.
        stage: Counted from 0; the residue is that after the stage, the verdict that of all.
    """
    facets = report.facets
    if measure.per == "cell":
        shown = shown_on_side(facets, report.board, report.stages[stage].side)
        return np.where(shown, exposed_values(report.exposures[stage], measure.name), np.nan)
    parts = np.array([part_value(part, measure.name, stage) for part in report.parts])
    values = np.append(parts, np.nan)[facets.cell_component]  # -1, the bare board, is the last
    return np.where(facets.cell_exposed, values, np.nan)


def exposed_values(exposure: Exposure, name: MeasureName) -> Scalars:
    """(c,) value of each cell after one stage."""
    if name == "supply":
        return exposure.supply_mm
    fields = {"cone": exposure.cone_s, "front": exposure.front_s, "peak": exposure.peak_pa}
    return fields.get(name, exposure.volume_mm)


def part_value(part: Part, name: MeasureName, stage: int) -> float:
    """One number of a part: the rank of its outcome, or that of its harder gap; not a number where there is none.

    The shear is the median over the gap of the highest shear at each place, the residue the mean in percent.
    """
    if name == "verdict":
        return float(OUTCOMES.index(outcome(part)))
    harder = harder_gap(part, name, stage)
    if harder is None:
        return np.nan
    return float(np.median(harder.values) if name == "shear" else harder.values.mean())


@dataclass(frozen=True, slots=True, eq=False)
class GapValues:
    """A measure in the cells of one gap."""

    field: GapField
    values: Scalars
    """(c,) Pa or percent."""


def harder_gap(part: Part, name: MeasureName, stage: int) -> GapValues | None:
    """A measure over the gap of a part, of two bounds the harder; nothing if the stage does not act on it.

    Args:
        part: The part.
        name: ``"shear"`` or ``"residue"``.
        stage: Counted from 0.
    """
    after = [(gap.field, gap.stages[stage]) for gap in part.gaps]
    acted = [(field, each) for field, each in after if each is not None]
    if not acted:
        return None
    if name == "shear":
        field, least = min(acted, key=lambda item: float(np.median(item[1].shear_pa)))
        return GapValues(field, least.shear_pa.astype(np.float64))
    field, most = max(acted, key=lambda item: float(item[1].residue.mean()))
    return GapValues(field, 100.0 * most.residue.astype(np.float64))


def check_limit(measure: Measure, limit: float) -> float:
    """Check a limit that was typed.

    Raises:
        LimitError: it cannot be used.
    """
    if not np.isfinite(limit) or limit <= 0:
        raise LimitError(f"a limit of {limit:g} {measure.unit} separates nothing; give one above 0.")
    if limit > measure.most:
        raise LimitError(f"a limit of {limit:g} {measure.unit} cannot be reached; give at most {measure.most:g}.")
    return limit
