"""A washing bath over many boards: flux goes in with each, solution leaves on each, fresh solution makes up for it.

The balance after each board, of a bath that is well mixed: it takes up what the wash removed, then loses what the board
takes along, at the concentration of that moment, and is filled up with fresh solution. With d the share of the bath
that a board takes along and m what it brings, over the bath's own mass,

    c(n+1) = (1 - d) (c(n) + m) + d c0        c(n) = c_end + (c(0) - c_end) (1 - d)^n

where c0 is what fresh solution brings, and c_end = c0 + m (1 - d) / d is where it settles.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from cleaning.errors import CleaningError, require_not_negative, require_positive
from cleaning.parameters.model import Parameters
from cleaning.report import summarise_report, summarise_rinse
from cleaning.undersides.gap_result import GapResult
from cleaning.undersides.rinse_cascade import Cascade
from cleaning.verdicts.results import CleaningReport
from specs.json import Json

_NEVER = 10**9
"""Boards beyond which a bath counts as one that never reaches its limit."""
_NOTHING = 1e-15
"""Share of the bath below which what a board takes along does not count."""
_MM = 1e-3
_UM = 1e-6


@dataclass(frozen=True, slots=True)
class Bath:
    """A bath and what each board does to it."""

    volume_l: float
    density_kg_m3: float
    fresh_pct: float
    """Non-volatile residue that fresh solution brings, by weight."""
    flux_g: float
    """That one board brings."""
    drag_out_ml: float
    """That one board takes along, made up with fresh solution."""
    begin_pct: float | None = None
    """At the first board; left out: that of fresh solution."""

    def __post_init__(self) -> None:
        require_positive(volume_l=self.volume_l, density_kg_m3=self.density_kg_m3)
        require_not_negative(
            fresh_pct=self.fresh_pct, flux_g=self.flux_g, drag_out_ml=self.drag_out_ml, begin_pct=self.begin_pct or 0.0
        )
        if self.drag_out_ml >= 1000.0 * self.volume_l:
            raise CleaningError(
                f"a board takes {self.drag_out_ml:g} ml along, which is all of a bath of {self.volume_l:g} l. State "
                "more litres, or less drag-out."
            )

    @property
    def _share(self) -> float:
        return self.drag_out_ml / (1000.0 * self.volume_l)

    @property
    def _brought_pct(self) -> float:
        return 100.0 * self.flux_g / (self.volume_l * self.density_kg_m3)

    @property
    def kept(self) -> float:
        """With each board the residue becomes so many times what it was, and ``added_pct`` more."""
        return 1.0 - self._share

    @property
    def added_pct(self) -> float:
        """What each board and what makes up for it bring."""
        return self.kept * self._brought_pct + self._share * self.fresh_pct

    @property
    def settles_pct(self) -> float:
        """Where the residue settles; infinite where nothing leaves the bath and something comes in."""
        if self._brought_pct == 0.0:
            return self.fresh_pct
        return (
            math.inf
            if self._share < _NOTHING
            else self.fresh_pct + self._brought_pct * (1.0 - self._share) / self._share
        )

    def residue_pct(self, boards: int) -> float:
        """Give the non-volatile residue of the bath after so many boards, % by weight."""
        begin = self.fresh_pct if self.begin_pct is None else self.begin_pct
        share = self._share
        if share < _NOTHING:
            return begin + boards * self._brought_pct
        replaced = -math.expm1(boards * math.log1p(-share))  # 1 - (1 - d)^n
        return begin + replaced * (self.fresh_pct - begin + self._brought_pct * (1.0 - share) / share)

    def boards_until(self, limit_pct: float) -> int | None:
        """Count the boards after which the residue is above a limit for the first time; ``None`` if it never is."""
        if self.residue_pct(0) > limit_pct:
            return 0
        if self.settles_pct <= limit_pct:
            return None
        low, high = 0, 1
        while self.residue_pct(high) <= limit_pct:
            low, high = high, 2 * high
            if high > _NEVER:
                return None
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (middle, high) if self.residue_pct(middle) <= limit_pct else (low, middle)
        return high


def washing_liquid(report: CleaningReport) -> str:
    """Name the solution of the bath: the first that washes.

    Raises:
        CleaningError: nothing washes, or the parameter set does not have its solution.
    """
    for stage in report.stages:
        if stage.use == "wash":
            if stage.solution not in report.parameters.liquids:
                known = report.parameters.parameters
                raise CleaningError(f"{stage.solution} is not in the parameter set {known}: add it under liquids.")
            return stage.solution
    raise CleaningError("the program does not wash, so that there is no bath.")


def flux_g(report: CleaningReport) -> float:
    """Flux that the wash takes out of the gaps of one board: f0 of their open volume, less what stays there.

    Of a gap of unknown height the bound that holds more counts. What lies outside of gaps is not known, and not in it.
    """
    density = report.parameters.soil.density_kg_m3
    return sum(max((_removed_g(gap, density) for gap in part.gaps), default=0.0) for part in report.parts)


def _removed_g(gap: GapResult, density_kg_m3: float) -> float:
    field = gap.field
    volume_m3 = gap.fill * _MM * gap.gap_height_mm * field.length_m * field.width_m * (1.0 - field.coverage)
    return 1000.0 * density_kg_m3 * volume_m3 * (1.0 - gap.residue)


def drag_out_ml(report: CleaningReport) -> float:
    """Solution that one board takes along: the film that stays on all its surfaces (``rinse.final_film_um``)."""
    area_m2 = float(report.facets.areas_mm2.sum()) * _MM**2
    return 1e6 * area_m2 * _UM * report.parameters.rinse.final_film_um


def with_bath(parameters: Parameters, liquid: str, residue_pct: float) -> Parameters:
    """Give the parameters with another residue in a bath, for the analysis of a later board."""
    changed = parameters.liquids[liquid].model_copy(update={"bath_nvr_pct": residue_pct})
    return parameters.model_copy(update={"liquids": {**parameters.liquids, liquid: changed}})


def tanks_before(bath: Bath, cascade: Cascade, number: int) -> tuple[float, ...]:
    """Give what the rinse tanks carry when a board comes to them, g/m³; both they and the bath began with the first."""
    return cascade.after_g_m3(number - 1, *_in_g_m3(bath))


def rinse_until(bath: Bath, cascade: Cascade, limit_mohm_cm: float) -> int | None:
    """Count the boards after which the last rinse tank is below a resistivity; ``None`` if it never is."""
    return cascade.boards_until(limit_mohm_cm, *_in_g_m3(bath))


def _in_g_m3(bath: Bath) -> tuple[float, float, float]:
    """Give what the bath carries at first, which share of it stays with each board, and what each board adds."""
    each = 10.0 * bath.density_kg_m3
    return each * bath.residue_pct(0), bath.kept, each * bath.added_pct


@dataclass(frozen=True, slots=True, eq=False)
class BoardInBath:
    """One of many boards, as it comes out of the bath of that moment."""

    number: int
    """From 1."""
    residue_pct: float
    """Non-volatile residue of the bath that washes it."""
    report: CleaningReport


def bath_report(bath: Bath, liquid: str, limit_pct: float, boards: Sequence[BoardInBath]) -> dict[str, Json]:
    """Collect a bath and what comes out of it as plain data: ``--json`` of ``washboard bath``."""
    settles, report = bath.settles_pct, boards[0].report
    water, least = report.rinse_water, report.parameters.limits.rinse_warn_mohm
    return {
        "washboard_bath": 1,
        "liquid": liquid,
        "volume_l": bath.volume_l,
        "flux_g": _digits(bath.flux_g),
        "drag_out_ml": _digits(bath.drag_out_ml),
        "fresh_pct": bath.fresh_pct,
        "begin_pct": bath.residue_pct(0),
        "limit_pct": limit_pct,
        "settles_pct": None if math.isinf(settles) else _digits(settles),
        "change_after": bath.boards_until(limit_pct),
        "rinse_limit_mohm_cm": least,
        "rinse_below_after": None if water is None else rinse_until(bath, water.cascade, least),
        "boards": [
            {
                "number": each.number,
                "residue_pct": _digits(each.residue_pct),
                "rinse_water": summarise_rinse(each.report),
                **summarise_report(each.report),
            }
            for each in boards
        ],
    }


def _digits(value: float) -> float:
    return float(f"{value:.6g}")
