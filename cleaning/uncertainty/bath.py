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
from cleaning.report import summarise_report, summarise_rinse
from cleaning.undersides.residue import GapResult
from cleaning.undersides.rinse import first_count
from cleaning.verdicts.results import CleaningReport
from specs.json import Json, plain_data

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
    def carried_g_m3(self) -> tuple[float, float, float]:
        """What it carries at first, how many times that it carries with each board, and what each board adds."""
        each, kept = 10.0 * self.density_kg_m3, 1.0 - self._share
        added_pct = kept * self._brought_pct + self._share * self.fresh_pct
        return each * self.residue_pct(0), kept, each * added_pct

    @property
    def settles_pct(self) -> float:
        """Where the residue settles; infinite where nothing leaves the bath and something comes in."""
        if self._brought_pct == 0.0:
            return self.fresh_pct
        if self._share < _NOTHING:
            return math.inf
        return self.fresh_pct + self._brought_pct * (1.0 - self._share) / self._share

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
        if self.residue_pct(0) <= limit_pct and self.settles_pct <= limit_pct:
            return None
        return first_count(lambda boards: self.residue_pct(boards) > limit_pct)


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

    def removed_g(gap: GapResult) -> float:
        field = gap.field
        volume_m3 = gap.fill * _MM * gap.gap_height_mm * field.length_m * field.width_m * (1.0 - field.coverage)
        return 1000.0 * density * volume_m3 * (1.0 - gap.residue)

    return sum(max(map(removed_g, part.gaps), default=0.0) for part in report.parts)


def drag_out_ml(report: CleaningReport) -> float:
    """Solution that one board takes along: the film that stays on all its surfaces (``rinse.final_film_um``)."""
    area_m2 = float(report.facets.areas_mm2.sum()) * _MM**2
    return 1e6 * area_m2 * _UM * report.parameters.rinse.final_film_um


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
    report = boards[0].report
    water, least = report.rinse_water, report.parameters.limits.rinse_warn_mohm
    return {
        "washboard_bath": 1,
        "liquid": liquid,
        "volume_l": bath.volume_l,
        "flux_g": plain_data(bath.flux_g),
        "drag_out_ml": plain_data(bath.drag_out_ml),
        "fresh_pct": bath.fresh_pct,
        "begin_pct": bath.residue_pct(0),
        "limit_pct": limit_pct,
        "settles_pct": plain_data(bath.settles_pct),
        "change_after": bath.boards_until(limit_pct),
        "rinse_limit_mohm_cm": least,
        "rinse_below_after": None if water is None else water.cascade.boards_until(least, *bath.carried_g_m3),
        "boards": [
            {
                "number": each.number,
                "residue_pct": plain_data(each.residue_pct),
                "rinse_water": summarise_rinse(each.report),
                **summarise_report(each.report),
            }
            for each in boards
        ],
    }
