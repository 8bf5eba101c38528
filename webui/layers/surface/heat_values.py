"""Numbers of a cleaning report, spread over the cells of the board's surface."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from cleaning.exposure.exposure import Exposure
from cleaning.gap.flow_field import GapField
from cleaning.parameters.model import Limits
from cleaning.process.stages import Stage
from cleaning.verdicts.cleanliness import OUTCOMES, outcome
from cleaning.verdicts.exposed_area import shown_on_side
from cleaning.verdicts.results import CleaningReport, Part
from geometry.arrays import Scalars
from specs.errors import JobError

MeasureName: TypeAlias = Literal["cone", "front", "volume", "peak", "shear", "residue", "verdict"]


LEAST_RESIDUE_PCT = 10.0
"""Where colours of residue end at least."""


class LimitError(JobError):
    """A limit that somebody typed makes no sense."""


@dataclass(frozen=True, slots=True)
class Measure:
    """Something that a heat map shows."""

    name: MeasureName
    unit: str
    per: Literal["cell", "part"]
    better: Literal["more", "less"]
    limit: Callable[[Limits, Stage], float]
    """Of the parameter set, in this unit; a proposal where it has none."""
    most: float = np.inf
    """Greatest value that there can be."""
    least_top: float = 0.0
    """Where a gradient ends at least: what is far from any limit shall look so."""

    def passes(self, values: Scalars, limit: float) -> NDArray[np.bool_]:
        """(c,) which values are on the good side of a limit; one that is not a number is not."""
        return values >= limit if self.better == "more" else values <= limit


def _volume(limits: Limits, stage: Stage) -> float:
    return limits.rinse_volume_mm if stage.use == "rinse" else limits.wash_volume_mm


MEASURES: dict[str, Measure] = {
    "Verdict": Measure("verdict", "", "part", "less", lambda _limits, _stage: 0.0),
    "Volume": Measure("volume", "mm", "cell", "more", _volume),
    "Time in the wave front": Measure("front", "s", "cell", "more", lambda limits, _stage: limits.front_s or 1.0),
    "Time in the cone (1993)": Measure("cone", "s", "cell", "more", lambda _limits, _stage: 1.0),
    "Peak pressure": Measure("peak", "Pa", "cell", "less", lambda _limits, _stage: 1000.0),
    "Shear under parts": Measure("shear", "Pa", "part", "more", lambda limits, _stage: limits.weak_shear_pa),
    "Residue under parts": Measure(
        "residue", "%", "part", "less", lambda limits, _stage: 100 * limits.gap_marginal, 100.0, LEAST_RESIDUE_PCT
    ),
}
"""As they are called on the page."""


def cell_values(report: CleaningReport, measure: Measure, stage: int) -> Scalars:
    """(c,) what a measure says of each cell; not a number where it says nothing, as of a side that is not sprayed.

    Args:
        report: What was analysed.
        measure: What to give.
        stage: Which stage, counted from 0; the residue is what is left after it, the verdict that of all.
    """
    facets = report.facets
    if measure.per == "cell":
        shown = shown_on_side(facets, report.board, report.stages[stage].side)
        return np.where(shown, exposed_values(report.exposures[stage], measure.name), np.nan)
    said = np.array([part_value(part, measure.name, stage) for part in report.parts])
    values = np.append(said, np.nan)[facets.cell_component]  # -1, the bare board, is the last
    return np.where(facets.cell_exposed, values, np.nan)


def exposed_values(exposure: Exposure, name: MeasureName) -> Scalars:
    """(c,) of one stage."""
    match name:
        case "cone":
            return exposure.cone_s
        case "front":
            return exposure.front_s
        case "peak":
            return exposure.peak_pa
        case _:
            return exposure.volume_mm


def part_value(part: Part, name: MeasureName, stage: int) -> float:
    """Say one number of a part: the rank of its outcome, or that of its harder gap; not a number where there is none.

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
    """A measure over the cells of one gap."""

    field: GapField
    values: Scalars
    """(c,) Pa or percent."""


def harder_gap(part: Part, name: MeasureName, stage: int) -> GapValues | None:
    """Give a measure over the gap of a part, of two bounds the harder; nothing if the stage does not act on it.

    Args:
        part: Which part.
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
    """Take a limit that somebody typed.

    Raises:
        LimitError: it makes no sense.
    """
    if not np.isfinite(limit) or limit <= 0:
        raise LimitError(f"a limit of {limit:g} {measure.unit} parts nothing from nothing; give one above 0.")
    if limit > measure.most:
        raise LimitError(f"a limit of {limit:g} {measure.unit} cannot be reached; give at most {measure.most:g}.")
    return limit
