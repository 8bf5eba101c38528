"""A cleaning report as plain data: what ``--json`` writes. Lengths are mm, times s, all else as the names say."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np

from boards.undersides.underside import Underside
from cleaning.exposure.exposure import Exposure
from cleaning.gap.flow_field import GapField
from cleaning.parameters.provenance import Assumption, assumptions_of
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult, GapStage
from cleaning.verdicts.cleanliness import cleanliness, count_cleanliness, stays_wet
from cleaning.verdicts.results import CleaningReport, ExposedPart, Judgement, Part
from cleaning.verdicts.rules import VERDICTS
from cleaning.verify import Verified
from specs.finding import finding_data
from specs.json import Json

VERSION = 1
"""Of the data: it changes when a key changes its meaning or goes."""
_DIGITS = 6
_SIDES = ("front", "right", "back", "left")


@dataclass(frozen=True, slots=True)
class Traceability:
    """What only the line knows: as it was entered, empty where it was not."""

    serial: str = ""
    detergent: str = ""
    bath_c: str = ""
    conductivity: str = ""
    date: str = ""
    program_sha256: str = ""
    """Of the program's file."""


_UNTRACED = Traceability()


def cleaning_report(
    report: CleaningReport, verified: Sequence[Verified] = (), trace: Traceability = _UNTRACED
) -> dict[str, Json]:
    """Collect verdicts with their numbers, stages, gaps and assumptions; the same report gives the same data.

    Args:
        report: What the analysis found.
        verified: Components that were worked out exactly besides.
        trace: What was entered about this board and its bath.
    """
    return {
        "washboard_cleaning_report": VERSION,
        **summarise_report(report),
        "traceability": asdict(trace),
        "stages": [_stage(stage, exposure) for stage, exposure in zip(report.stages, report.exposures, strict=True)],
        "process": [_judgement(each) for each in report.process],
        "bare_board": _part(report.bare),
        "components": [_part(part) for part in report.parts],
        "verified": [_verified(each) for each in verified],
        "worst_first": [part.component for part in report.worst_first()],
        "findings": [finding_data(finding) for finding in report.findings],
        "assumptions": [_assumption(each) for each in assumptions_of(report.parameters)],
    }


def summarise_report(report: CleaningReport) -> dict[str, Json]:
    """Collect what a report says of the whole: what it was made from, verdicts, time and litres."""
    origin, parameters = report.origin, report.parameters
    return {
        "board": {"name": origin.board, "sha256": origin.board_sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        "parameters": {
            "name": parameters.parameters,
            "sha256": report.parameters_sha256,
            "kinetics_calibrated": parameters.calibrated,
        },
        "verdict": report.verdict,
        "verdicts": {verdict: sum(part.verdict == verdict for part in report.parts) for verdict in VERDICTS},
        "cleanliness": {**count_cleanliness(report.parts)},
        "stay_wet": sum(map(stays_wet, report.parts)),
        "duration_s": _digits(report.duration_s),
        "litres": {name: _digits(litres) for name, litres in report.litres},
    }


def summarise_part(part: Part) -> dict[str, Json]:
    """Collect what a report says first of one component."""
    return {
        "component": part.component,
        "verdict": part.verdict,
        "grade": part.grade,
        "cleanliness": cleanliness(part),
        "stays_wet": stays_wet(part),
        "residue": None if part.residue is None else _digits(part.residue),
        "limiting": part.limiting,
    }


def _assumption(assumption: Assumption) -> Json:
    entry = assumption.provenance
    return {
        "path": assumption.path,
        "value": assumption.value,
        "known": assumption.known,
        "source": entry.source,
        "date": entry.date,
        "samples": entry.samples,
        "rms": entry.rms,
        "interval": None if entry.interval is None else _all(entry.interval),
    }


def _stage(stage: Stage, exposure: Exposure) -> Json:
    return {
        "made_by": stage.made_by,
        "function": stage.function,
        "use": stage.use,
        "nozzle": stage.nozzle_name,
        "solution": stage.solution,
        "pressure_pa": _digits(stage.pressure_pa),
        "temperature_c": _digits(stage.temperature_c),
        "begin_s": _digits(stage.begin_s),
        "end_s": _digits(stage.end_s),
        "spray_s": _digits(stage.spray_s),
        "samples": len(stage.samples.times),
        "rays": exposure.rays,
        "sprayed_mm3": _digits(exposure.sprayed_mm3),
        "landed_mm3": _digits(exposure.landed_mm3),
    }


def _part(part: Part) -> Json:
    return {
        **summarise_part(part),
        "judgements": [_judgement(each) for each in part.judgements],
        "exposed": [None if each is None else _exposed(each) for each in part.exposed],
        "underside": None if part.underside is None else _underside(part.underside),
        "gaps": [_gap(gap) for gap in part.gaps],
        "elasticity": {name: _digits(value) for name, value in part.elasticity.items()},
        "makers": [{"made_by": made_by, "share": _digits(share)} for made_by, share in part.makers],
    }


def _judgement(judgement: Judgement) -> Json:
    return {
        "rule": judgement.rule.id,
        "name": judgement.name,
        "verdict": judgement.verdict,
        "grade": judgement.grade,
        "numbers": [
            {
                "name": number.name,
                "value": _digits(number.value),
                "unit": number.unit,
                "limit": None if number.limit is None else _digits(number.limit),
            }
            for number in judgement.numbers
        ],
        "because": judgement.because,
        "advice": judgement.advice,
        "stage": judgement.stage,
        "where": None if judgement.where is None else _all(judgement.where),
        "sides": [_all(side) for side in judgement.sides],
    }


def _exposed(exposed: ExposedPart) -> Json:
    return {
        "area_mm2": _digits(exposed.area_mm2),
        "hidden_mm2": _digits(exposed.hidden_mm2),
        "missed_share": _digits(exposed.missed_share),
        "volume_mm": _spread(exposed.volume_mm),
        "front_s": _spread(exposed.front_s),
        "cone_s": _spread(exposed.cone_s),
        "peak_pa": _digits(exposed.peak_pa),
    }


def _spread(values: tuple[float, float, float]) -> Json:
    return dict(zip(("least", "p5", "mean"), map(_digits, values), strict=True))


def _underside(underside: Underside) -> Json:
    return {
        "x_mm": _digits(underside.x_mm),
        "y_mm": _digits(underside.y_mm),
        "turn_deg": _digits(math.degrees(underside.turn_rad)),
        "length_mm": _digits(underside.length_mm),
        "width_mm": _digits(underside.width_mm),
        "standoff_source": underside.gap_height_source,
        "joints_source": underside.joints_source,
        "cases": [{"standoff_mm": _digits(case.gap_height_mm), "joints": len(case.joints)} for case in underside.cases],
    }


def _gap(gap: GapResult) -> Json:
    return {
        "standoff_mm": _digits(gap.gap_height_mm),
        "coverage": _digits(gap.field.coverage),
        "fill": _digits(gap.fill),
        "exchanges_needed": _digits(gap.exchanges_needed),
        "residue": _digits(gap.residue),
        "residue_worst": _digits(gap.residue_worst),
        "worst_at_mm": _all(gap.worst_at),
        "ionic_ug_cm2": _digits(gap.ionic_ug_cm2),
        "blow_off_um": None if gap.blow_off_um is None else _digits(gap.blow_off_um),
        "dry_s": None if gap.dry_s is None else _digits(gap.dry_s),
        "stages": [None if each is None else _gap_stage(each, gap.field) for each in gap.stages],
    }


def _gap_stage(stage: GapStage, field: GapField) -> Json:
    return {
        "margin_pa": _digits(stage.margin_pa),
        "entered": stage.entered,
        "edge_pa": _all(stage.edge_pa),
        "side_shear_pa": dict(zip(_SIDES, map(_digits, stage.side_shear_pa), strict=True)),
        "greatest_shear_pa": _digits(float(stage.shear_pa.max(initial=0.0))),
        "weak_share": _digits(stage.weak_share),
        "exchanges": _digits(stage.exchanges),
        "reynolds": _digits(stage.reynolds),
        "wet_s": _digits(stage.wet_s),
        "residue": _digits(mean_residue(stage, field)),
    }


def mean_residue(stage: GapStage, field: GapField) -> float:
    """Give the share of residue that is left in a gap at the end of a stage."""
    return float(np.average(stage.residue, weights=field.weights)) if stage.residue.size else 0.0


def _verified(verified: Verified) -> Json:
    return {
        "component": verified.component,
        "function": verified.function,
        "made_by": verified.made_by,
        "rays_mm": _digits(verified.rays_mm),
        "exact_mm": _digits(verified.exact_mm),
        "worst_mm": _digits(verified.worst_mm),
        "cells": verified.cells,
    }


def _all(values: tuple[float, ...]) -> Json:
    return list[Json](map(_digits, values))


def _digits(value: float) -> float | None:
    """Round to six significant digits; JSON has no infinity."""
    return float(f"{value:.{_DIGITS}g}") if math.isfinite(value) else None
