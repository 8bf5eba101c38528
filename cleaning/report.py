"""A cleaning report as plain data: what ``--json`` writes. Lengths are mm, times s, all else as named."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import cast

import numpy as np

from cleaning.exposure.exposure import Exposure
from cleaning.gap.flow_field import GapField
from cleaning.parameters.provenance import assumptions_of
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult, GapStage
from cleaning.undersides.rinse import ionic_ug_cm2
from cleaning.verdicts.cleanliness import cleanliness, count_cleanliness, parts_by_instance, stays_wet
from cleaning.verdicts.results import Capability, CleaningReport, Judgement, Part
from cleaning.verdicts.rules import VERDICTS
from cleaning.verify import Verified
from specs.finding import finding_data
from specs.json import Json, plain_data

VERSION = 1
"""Of the data: it changes when a key changes its meaning or goes."""
_SIDES = ("front", "right", "back", "left")
_SPREAD = ("least", "low", "mean")


@dataclass(frozen=True, slots=True)
class Traceability:
    """What was entered about a board and its bath; empty where nothing was."""

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
    provenance = [(each, each.provenance) for each in assumptions_of(report.parameters)]
    return {
        "washboard_cleaning_report": VERSION,
        **summarise_report(report),
        "traceability": asdict(trace),
        "stages": [_stage(stage, exposure) for stage, exposure in zip(report.stages, report.exposures, strict=True)],
        "rinse_water": summarise_rinse(report),
        "process": [_judgement(each) for each in report.process],
        "bare_board": _part(report.bare),
        "components": [_part(part) for part in report.parts],
        **_instances(report),
        "verified": [plain_data(asdict(each) | {"made_by": str(each.made_by)}) for each in verified],
        "capability": _capability(report.capability),
        "worst_first": [part.component for part in report.worst_first()],
        "findings": [finding_data(finding) for finding in report.findings],
        "assumptions": [
            {
                "path": each.path,
                "value": each.value,
                "known": each.known,
                "source": entry.source,
                "date": entry.date,
                "samples": entry.samples,
                "rms": entry.rms,
                "interval": plain_data(entry.interval),
            }
            for each, entry in provenance
        ],
    }


def _instances(report: CleaningReport) -> dict[str, Json]:
    """How many components of each board of a panel have which verdict; nothing of a single board."""
    rows: list[Json] = [
        {"board": name, "components": dict[str, Json](count_cleanliness(parts).items())}
        for name, parts in parts_by_instance(report).items()
    ]
    return {"boards": rows} if rows else {}


def summarise_report(report: CleaningReport) -> dict[str, Json]:
    """Collect what a report is made from, its verdicts, time and litres."""
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
        "duration_s": plain_data(report.duration_s),
        "litres": plain_data(dict(report.litres)),
    }


def summarise_rinse(report: CleaningReport) -> Json:
    """Collect what the rinse tanks carry and what boards leave them with; nothing where there are none."""
    water = report.rinse_water
    if water is None:
        return None
    cascade, film_um = water.cascade, report.parameters.rinse.final_film_um
    return plain_data(
        {
            "carried_ml": 1e6 * cascade.carried_m3,
            "fresh_l": 1e3 * cascade.fresh_m3,
            "counter_current": cascade.counter_current,
            "bath_g_m3": water.bath_g_m3,
            "tanks": [
                {
                    "solution": tank.solution,
                    "volume_l": 1e3 * tank.volume_m3,
                    "content_g_m3": tank.content_g_m3,
                    "resistivity_mohm_cm": tank.resistivity_mohm_cm,
                    "kept": tank.kept,
                    "on_board_g_m3": tank.on_board_g_m3,
                    "on_board_ug_cm2": ionic_ug_cm2(tank.on_board_g_m3, film_um),
                }
                for tank in water.tanks
            ],
        }
    )


def summarise_part(part: Part) -> dict[str, Json]:
    """Collect the verdict on one component, its residue and what limits it."""
    return {
        "component": part.component,
        "verdict": part.verdict,
        "grade": part.grade,
        "cleanliness": cleanliness(part),
        "stays_wet": stays_wet(part),
        "residue": plain_data(part.residue),
        "limiting": part.limiting,
    }


def mean_residue(stage: GapStage, field: GapField) -> float:
    """Give the share of residue that is left in a gap at the end of a stage."""
    return float(np.average(stage.residue, weights=field.weights)) if stage.residue.size else 0.0


def _stage(stage: Stage, exposure: Exposure) -> Json:
    return plain_data(
        {
            "made_by": str(stage.made_by),
            "function": stage.function,
            "use": stage.use,
            "nozzle": stage.nozzle_name,
            "solution": stage.solution,
            "pressure_pa": stage.pressure_pa,
            "temperature_c": stage.temperature_c,
            "begin_s": stage.begin_s,
            "end_s": stage.end_s,
            "spray_s": stage.spray_s,
            "samples": len(stage.samples.times),
            "rays": exposure.rays,
            "sprayed_mm3": exposure.sprayed_mm3,
            "landed_mm3": exposure.landed_mm3,
        }
    )


def _part(part: Part) -> Json:
    exposed = [{} if each is None else asdict(each) for each in part.exposed]
    for fields in filter(None, exposed):
        error = cast(float, fields["cone_error_s"])
        fields["cone_error_s"] = to_error(error, error)
        fields["cone_s"] = tuple(to_error(each, error) for each in cast("tuple[float, ...]", fields["cone_s"]))
    for fields in exposed:  # least, low and mean by name
        fields |= {
            key: dict(zip(_SPREAD, each, strict=True)) for key, each in fields.items() if isinstance(each, tuple)
        }
    below = part.underside
    return {
        **summarise_part(part),
        "judgements": [_judgement(each) for each in part.judgements],
        "exposed": [plain_data(fields) or None for fields in exposed],
        "underside": None
        if below is None
        else plain_data(
            {
                "x_mm": below.x_mm,
                "y_mm": below.y_mm,
                "turn_deg": math.degrees(below.turn_rad),
                "length_mm": below.length_mm,
                "width_mm": below.width_mm,
                "standoff_source": below.gap_height_source,
                "joints_source": below.joints_source,
                "cases": [{"standoff_mm": each.gap_height_mm, "joints": len(each.joints)} for each in below.cases],
            }
        ),
        "gaps": [_gap(gap) for gap in part.gaps],
        "elasticity": plain_data(dict(part.elasticity)),
        "makers": [{"made_by": str(made_by), "share": plain_data(share)} for made_by, share in part.makers],
    }


def _capability(capability: Capability | None) -> Json:
    """Write in which share of samples of the model's values each component comes out clean."""
    if capability is None:
        return None
    return {
        "samples": capability.samples,
        "varied": list(capability.varied),
        "together": plain_data(capability.together),
        "left_out": list(capability.left_out),
        "components": [
            {
                "component": each.component,
                "clean_share": plain_data(each.clean_share),
                "broken": {rule.id: plain_data(share) for rule, share in each.broken},
                "strongest": each.strongest,
            }
            for each in capability.parts
        ],
    }


def _judgement(judgement: Judgement) -> Json:
    return plain_data(
        {
            "rule": judgement.rule.id,
            "name": judgement.name,
            "verdict": judgement.verdict,
            "grade": judgement.grade,
            "numbers": [asdict(number) for number in judgement.numbers],
            "because": judgement.because,
            "advice": judgement.advice,
            "stage": str(judgement.stage),
            "where": judgement.where,
            "sides": judgement.sides,
        }
    )


def _gap(gap: GapResult) -> Json:
    return plain_data(
        {
            "standoff_mm": gap.gap_height_mm,
            "coverage": gap.field.coverage,
            "fill": gap.fill,
            "exchanges_needed": gap.exchanges_needed,
            "residue": gap.residue,
            "residue_worst": gap.residue_worst,
            "worst_at_mm": gap.worst_at,
            "ionic_ug_cm2": gap.ionic_ug_cm2,
            "blow_off_um": gap.blow_off_um,
            "dry_s": gap.dry_s,
            "stages": [
                None
                if stage is None
                else {
                    "margin_pa": stage.margin_pa,
                    "entered": stage.entered,
                    "edge_pa": stage.edge_pa,
                    "side_shear_pa": dict(zip(_SIDES, stage.side_shear_pa, strict=True)),
                    "greatest_shear_pa": float(stage.shear_pa.max(initial=0.0)),
                    "weak_share": stage.weak_share,
                    "exchanges": stage.exchanges,
                    "reynolds": stage.reynolds,
                    "wet_s": stage.wet_s,
                    "residue": mean_residue(stage, gap.field),
                }
                for stage in gap.stages
            ],
        }
    )


def to_error(value: float, error: float) -> float:
    """Round a value to the second digit of its error."""
    return round(value, 1 - math.floor(math.log10(error))) if error > 0 else value
