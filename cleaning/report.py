"""A cleaning report as plain data: what ``--json`` writes. Lengths are mm, times s, all else as named."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import cast

import numpy as np

from boards.undersides.underside import Underside
from cleaning.exposure.exposure import Exposure
from cleaning.gap.flow_field import GapField
from cleaning.parameters.provenance import assumptions_of
from cleaning.process.stages import Stage
from cleaning.undersides.residue import GapResult, GapStage
from cleaning.undersides.rinse import ionic_ug_cm2
from cleaning.verdicts.results import (
    Capability,
    CleaningReport,
    Judgement,
    Part,
    cleanliness,
    count_cleanliness,
    parts_by_instance,
    rests_on_uncalibrated_kinetics,
    stays_wet,
)
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
    instances: list[Json] = [  # of a panel
        {"board": name, "components": dict[str, Json](count_cleanliness(parts).items())}
        for name, parts in parts_by_instance(report).items()
    ]
    return {
        "washboard_cleaning_report": VERSION,
        **summarise_report(report),
        "traceability": asdict(trace),
        "stages": [_stage(stage, exposure) for stage, exposure in zip(report.stages, report.exposures, strict=True)],
        "rinse_water": summarise_rinse(report),
        "process": [_judgement(each) for each in report.process],
        "bare_board": _part(report.bare),
        "components": [_part(part) for part in report.parts],
        **({"boards": instances} if instances else {}),
        "verified": [plain_data(asdict(each) | {"made_by": str(each.made_by)}) for each in verified],
        "capability": _capability(report.capability),
        "worst_first": [part.component for part in report.worst_first()],
        "findings": [finding_data(finding) for finding in report.findings],
        "assumptions": [
            pick(each, "path value known")
            | pick(each.provenance, "source date samples")
            | {"rms": each.provenance.rms, "interval": plain_data(each.provenance.interval)}
            for each in assumptions_of(report.parameters)
        ],
    }


def pick(item: object, names: str) -> dict[str, Json]:
    """Give some attributes of an object as plain data, by their names with blanks in between."""
    return {name: plain_data(getattr(item, name)) for name in names.split()}


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
    return {
        "carried_ml": plain_data(1e6 * cascade.carried_m3),
        "fresh_l": plain_data(1e3 * cascade.fresh_m3),
        **pick(cascade, "counter_current"),
        **pick(water, "bath_g_m3"),
        "tanks": [
            {
                "solution": tank.solution,
                "volume_l": plain_data(1e3 * tank.volume_m3),
                **pick(tank, "content_g_m3 resistivity_mohm_cm kept on_board_g_m3"),
                "on_board_ug_cm2": plain_data(ionic_ug_cm2(tank.on_board_g_m3, film_um)),
            }
            for tank in water.tanks
        ],
    }


def summarise_part(part: Part) -> dict[str, Json]:
    """Collect the verdict on one component, its residue and what limits it."""
    outcome: dict[str, Json] = {
        "uncalibrated": rests_on_uncalibrated_kinetics(part),
        "cleanliness": cleanliness(part),
        "stays_wet": stays_wet(part),
    }
    return pick(part, "component verdict grade") | outcome | pick(part, "residue limiting")


def mean_residue(stage: GapStage, field: GapField) -> float:
    """Give the share of residue that is left in a gap at the end of a stage."""
    return float(np.average(stage.residue, weights=field.weights)) if stage.residue.size else 0.0


def _stage(stage: Stage, exposure: Exposure) -> Json:
    return {
        "made_by": str(stage.made_by),
        **pick(stage, "function use"),
        "nozzle": stage.nozzle_name,
        **pick(stage, "solution pressure_pa temperature_c begin_s end_s spray_s"),
        "samples": len(stage.samples.times),
        **pick(exposure, "rays sprayed_mm3 landed_mm3"),
    }


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
    return {
        **summarise_part(part),
        "judgements": [_judgement(each) for each in part.judgements],
        "exposed": [plain_data(fields) or None for fields in exposed],
        "underside": None if part.underside is None else _underside(part.underside),
        "gaps": [_gap(gap) for gap in part.gaps],
        "elasticity": plain_data(dict(part.elasticity)),
        "makers": [{"made_by": str(made_by), "share": plain_data(share)} for made_by, share in part.makers],
    }


def _underside(below: Underside) -> Json:
    return {
        **pick(below, "x_mm y_mm"),
        "turn_deg": plain_data(math.degrees(below.turn_rad)),
        **pick(below, "length_mm width_mm"),
        "standoff_source": below.gap_height_source,
        "joints_source": below.joints_source,
        "cases": [{"standoff_mm": plain_data(each.gap_height_mm), "joints": len(each.joints)} for each in below.cases],
    }


def _capability(capability: Capability | None) -> Json:
    """Write in which share of samples of the model's values each component comes out clean."""
    if capability is None:
        return None
    return {
        **pick(capability, "samples varied together left_out"),
        "components": [
            {
                **pick(each, "component clean_share"),
                "broken": {rule.id: plain_data(share) for rule, share in each.broken},
                "strongest": each.strongest,
            }
            for each in capability.parts
        ],
    }


def _judgement(judgement: Judgement) -> Json:
    return {
        "rule": judgement.rule.id,
        **pick(judgement, "name verdict grade"),
        "numbers": [plain_data(asdict(number)) for number in judgement.numbers],
        **pick(judgement, "because advice"),
        "stage": str(judgement.stage),
        **pick(judgement, "where sides"),
    }


def _gap(gap: GapResult) -> Json:
    return {
        "standoff_mm": plain_data(gap.gap_height_mm),
        **pick(gap.field, "coverage"),
        **pick(gap, "fill exchanges_needed residue residue_worst"),
        "worst_at_mm": plain_data(gap.worst_at),
        **pick(gap, "ionic_ug_cm2 blow_off_um dry_s"),
        "stages": [None if stage is None else _gap_stage(stage, gap.field) for stage in gap.stages],
    }


def _gap_stage(stage: GapStage, field: GapField) -> Json:
    return {
        **pick(stage, "margin_pa entered edge_pa"),
        "side_shear_pa": plain_data(dict(zip(_SIDES, stage.side_shear_pa, strict=True))),
        "greatest_shear_pa": plain_data(float(stage.shear_pa.max(initial=0.0))),
        **pick(stage, "weak_share exchanges reynolds wet_s"),
        "residue": plain_data(mean_residue(stage, field)),
    }


def to_error(value: float, error: float) -> float:
    """Round a value to the second digit of its error."""
    return round(value, 1 - math.floor(math.log10(error))) if error > 0 else value
