"""A program on a board in, what it cleans out."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal, TypeAlias

import numpy as np

from boards.board import Board
from cleaning.exposure.exposure import expose
from cleaning.exposure.sparse_cells import refine_sparse_cells
from cleaning.film.run_off import film_supply
from cleaning.jet.jet import jet_of
from cleaning.judge_component import Sprayed, bare_part, component_part, gaps_of, spraying_of
from cleaning.parameters.chemistries import with_chemistries
from cleaning.parameters.load import parameters_sha256
from cleaning.parameters.model import Parameters
from cleaning.prepared_board import PreparedBoard, prepare
from cleaning.process.stages import Stage, stages_of
from cleaning.uncertainty.capability import capability_of
from cleaning.undersides.rinse import RinseWater, bath_g_m3, cascade_of
from cleaning.verdicts.exposed_area import cells_of_side
from cleaning.verdicts.process_rules import judge_process, judge_range
from cleaning.verdicts.results import CleaningReport, Judgement, Part
from cleaning.verdicts.rules import VERDICTS, Verdict
from programs.program import TimedProgram
from recipes.classes import match_masks
from recipes.recipe import Recipe
from specs.finding import Finding, FindingRule, Severity, worst_first
from specs.progress import Progress, no_progress, subprogress

Effort: TypeAlias = Literal["sketch", "fast", "full"]
_RAYS: dict[Effort, int] = {"sketch": 300_000, "fast": 4_000_000, "full": 8_000_000}
"""Per stage, at least: a short stage places more of them at each sample."""
_RAYS_PER_CELL = 1000
"""Where that is less, in a fast analysis: the cells of a small board are hit as often as those of a large one."""
_RAYS_EACH: dict[Effort, int] = {"sketch": 16, "fast": 64, "full": 256}
"""Per sample, at least."""
_SEVERITY: dict[Verdict, Severity] = {"dirty": "warning"}
"""Of findings; of other verdicts they are notes."""
_SHARE_BEFORE_CAPABILITY = 0.25
"""Of the time of an analysis with capability."""
_WAY_MM: dict[Effort, float] = {"sketch": 6.0, "fast": 3.0, "full": 1.5}


def analyse(
    program: TimedProgram,
    board: Board,
    recipe: Recipe,
    parameters: Parameters,
    effort: Effort = "fast",
    progress: Progress = no_progress,
) -> CleaningReport:
    """Predict what a program cleans.

    Args:
        program: Any program made for the board.
        board: Where.
        recipe: The recipe it was planned with: it has the nozzles.
        parameters: The model's.
        effort: How finely the way is sampled and how many rays are cast.
        progress: Receives the stage and the share done.

    Raises:
        CleaningError: the program and the recipe do not belong together, or nothing is sprayed.
        ProgramError: the program has no move.
    """
    prepared = prepare(board, parameters, subprogress(progress, 0.0, 0.2))
    return analyse_on(prepared, program, recipe, effort, subprogress(progress, 0.2, 1.0))


def analyse_on(
    prepared: PreparedBoard,
    program: TimedProgram,
    recipe: Recipe,
    effort: Effort = "fast",
    progress: Progress = no_progress,
    *,
    sensitivity: bool = True,
) -> CleaningReport:
    """Predict what a program cleans as ``analyse`` does, on a board that was made ready before.

    Without ``sensitivity`` parts have no elasticities, which take longer than the residue itself.
    """
    cascade = prepared.parameters.rinse.cascade
    named = [*(function.solution for function in recipe.functions.values())]
    named += [] if cascade is None else [tank.solution for tank in cascade.tanks]
    parameters = with_chemistries(prepared.parameters, named)
    prepared = replace(prepared, parameters=parameters)
    staged = stages_of(program, recipe, parameters, _WAY_MM[effort])
    sprayed = _spray(staged.stages, prepared, effort, subprogress(progress, 0.0, 0.5))
    rinse_water = _rinse_water(prepared, sprayed)
    if rinse_water is not None:  # each rinse sprays what its tank holds
        held = dict(zip(rinse_water.cascade.solutions, rinse_water.contents_g_m3, strict=True))
        sprayed = tuple(
            replace(each, stage=replace(each.stage, water_g_m3=held[each.stage.solution]))
            if each.stage.use == "rinse" and each.stage.solution in held
            else each
            for each in sprayed
        )
    stages = tuple(each.stage for each in sprayed)
    undersides = gaps_of(prepared, sprayed, subprogress(progress, 0.5, 0.9), sensitivity=sensitivity)
    progress("judging", 0.9)
    rows, spraying = range(len(prepared.board.components)), spraying_of(prepared, sprayed)
    masks = match_masks(recipe.masks, prepared.board.own_names)
    parts = tuple(component_part(row, prepared, spraying, undersides.get(row), masks) for row in rows)
    bare = bare_part(prepared, spraying, masks)
    process = (*judge_process(stages, parameters), *judge_range(stages, prepared.board))
    progress("done", 1.0)
    return CleaningReport(
        origin=program.origin,
        board=prepared.board,
        parameters=parameters,
        parameters_sha256=parameters_sha256(parameters),
        stages=stages,
        facets=prepared.facets,
        exposures=tuple(each.exposure for each in sprayed),
        run_off=prepared.run_off,
        bare=bare,
        parts=parts,
        process=process,
        verdict=min(
            [*(part.verdict for part in (bare, *parts)), *(each.verdict for each in process)], key=VERDICTS.index
        ),
        duration_s=program.totals.duration_s,
        litres=program.totals.liquid_l,
        findings=worst_first((*staged.findings, *_findings(parts, bare, process))),
        rinse_water=rinse_water,
    )


def analyse_with_capability(
    prepared: PreparedBoard,
    program: TimedProgram,
    recipe: Recipe,
    effort: Effort = "fast",
    progress: Progress = no_progress,
) -> CleaningReport:
    """Predict what a program cleans as ``analyse_on`` does, and judge it under the ranges of the parameters too."""
    report = analyse_on(prepared, program, recipe, effort, subprogress(progress, 0.0, _SHARE_BEFORE_CAPABILITY))
    varying = subprogress(progress, _SHARE_BEFORE_CAPABILITY, 1.0)
    return replace(report, capability=capability_of(report, prepared, varying))


def _rinse_water(prepared: PreparedBoard, sprayed: Sequence[Sprayed]) -> RinseWater | None:
    """Follow what boards carry over from the bath into the rinse tanks, if any: as it settles, or as it is given."""
    stages = [each.stage for each in sprayed]
    gaps_mm3 = sum(
        underside.cases[-1].gap_height_mm * underside.length_mm * underside.width_mm * (1.0 - fields[-1].coverage)
        for underside, fields in zip(prepared.undersides, prepared.fields, strict=True)
    )  # of unknown heights the upper bound: what is carried over is not made light of
    area_mm2 = float(prepared.facets.areas_mm2.sum())
    landed_mm3 = [each.exposure.landed_mm3 for each in sprayed]
    cascade = cascade_of(prepared.parameters, stages, landed_mm3, area_mm2, gaps_mm3)
    if cascade is None:
        return None
    washing = next(bath_g_m3(stage.liquid) for stage in stages if stage.use == "wash")
    return RinseWater(cascade, washing, prepared.tanks_g_m3 or cascade.steady_g_m3(washing))


def _spray(stages: Sequence[Stage], prepared: PreparedBoard, effort: Effort, progress: Progress) -> tuple[Sprayed, ...]:
    done: list[Sprayed] = []
    total = sum(len(stage.samples.times) for stage in stages)
    begin = 0
    for stage in stages:
        end = begin + len(stage.samples.times)
        jet = jet_of(stage, prepared.parameters.spray)
        part = subprogress(progress, begin / total, end / total)
        refined = effort != "sketch" and stage.use != "dry"  # of gas, which leaves nothing, only times are looked at
        least = _RAYS[effort if refined else "sketch"]
        if effort == "fast":
            least = min(least, max(_RAYS["sketch"], _RAYS_PER_CELL * len(prepared.facets.cell_areas_mm2)))
        rays = max(_RAYS_EACH[effort], -(-least // len(stage.samples.times)))
        exposure = expose(stage, jet, prepared.facets, prepared.scene, rays, part)
        if refined:
            judged = cells_of_side(prepared.facets, prepared.board, stage.side)
            exposure = refine_sparse_cells(exposure, stage, jet, prepared.facets, prepared.scene, judged)
        if stage.use != "dry":
            run_off = prepared.run_off[stage.side]
            film_mm = film_supply(stage, jet, run_off, prepared.parameters.film, exposure.growth.until_s)
            flown_mm = run_off.on_cells(exposure.volume_mm, film_mm.sum(axis=0, dtype=np.float64))
            exposure = replace(exposure, run_off_mm=flown_mm, growth=replace(exposure.growth, film_mm=film_mm))
        done.append(Sprayed(stage, jet, exposure))
        begin = end
    return tuple(done)


def _findings(parts: Sequence[Part], bare: Part, process: Sequence[Judgement]) -> list[Finding]:
    """One finding for each judgement that is not clean; none of what is avoided."""
    found = [(part.component, each) for part in (bare, *parts) for each in part.judgements]
    found += [("process", each) for each in process]
    findings: list[Finding] = []
    for name, each in found:
        if each.verdict not in ("clean", "avoided"):
            rule, kind = each.rule, f"{each.rule} {each.name}".lower().replace(" ", "-")
            page = rule.page.partition("/")[2]
            finding_rule = FindingRule(kind, "info", rule.meaning, page, also="warning", verdict=rule.id)
            message, severity = f"{name}: {each.because} {each.advice}".rstrip(), _SEVERITY.get(each.verdict, "info")
            findings.append(Finding(finding_rule, message, each.stage, each.where, override=severity))
    return findings
