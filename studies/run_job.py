"""A job of a study: what ``washboard plan``, ``analyse`` and ``check`` do, one after the other, in a worker."""

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from boards.board import Part, Workpiece
from boards.workpiece import load_workpiece
from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters, parameters_sha256
from cleaning.parameters.model import Parameters
from cleaning.part_faces import judge_faces, times_in_cone, weigh_faces
from cleaning.prepared_board import PreparedBoard, prepare
from cleaning.report import Traceability
from cleaning.threads import limit_threads
from cleaning.verdicts.results import CleaningReport, cleanliness, report_cleanliness, stays_wet
from programs import native
from programs.program import Command, Instruction, MoveTo, TimedProgram
from recipes.load import RECIPE, parse_recipe, recipe_sha256
from recipes.recipe import Recipe
from reports.files.write_run import cleaning_bytes, export_refusal, program_bytes
from reports.tables.cleaning_tables import this_producer
from rulesengine.surface.part_job import Survey, survey_part
from rulesengine.tuning.report import advise
from rulesengine.tuning.variables import Edits, apply_edits
from specs.errors import JobError
from specs.finding import blocking
from specs.progress import no_progress
from specs.yaml.load import read_text
from studies.errors import StudyError
from studies.fingerprint import program_version
from studies.job import CellResult, Input, Job, JobResult
from studies.study import Deviation, Quantity

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell

_T = TypeVar("_T")

_PRESSURE, _TEMPERATURE = "pressure_bar", "temperature_c"
_KEPT = 4
"""Boards and plans that a worker keeps for its next job."""


def run_job(job: Job, threads: int = 1) -> JobResult:
    """Plan, analyse, and check in a cell if there is one; what a recipe or a board refuses is the result's error.

    Args:
        job: What is computed.
        threads: That its analysis may take; the result is the same with any number.

    Raises:
        StudyError: a file is not there, or has changed since the study began; or the worker's Washboard is another.
    """
    if job.version != program_version():
        raise StudyError(f"a worker has Washboard {program_version()}, and the study {job.version}. Install one.")
    board = _board(job.board)
    _parameters(job.parameters)
    try:
        recipe, content = _planned(job.board, job.recipe, job.edits)
        program = native.parse(content.decode())
        if isinstance(board, Part):
            return _judge_part(job, program, board, recipe, content)
        board = board.require_board("an analysis")
        with limit_threads(threads):
            prepared = _prepared(job.board, job.parameters)
            if job.deviation:
                done, sprayed = deviate(program, recipe, board, job.deviation)
                return _result(job, analyse_on(prepared, done, sprayed, job.effort, sensitivity=False))
            report = advise(analyse_on(prepared, program, recipe, job.effort), program, recipe)
            program_sha256 = hashlib.sha256(content).hexdigest()
            written = cleaning_bytes(report, this_producer(job.effort), Traceability(program_sha256=program_sha256))
            cell = None if job.cell is None else _check(program, board, job.cell)
            return replace(
                _result(job, report),
                program_sha256=program_sha256,
                analysis_sha256=hashlib.sha256(written).hexdigest(),
                cell=cell,
            )
    except StudyError:
        raise
    except JobError as error:
        return JobResult(job.key, error=str(error))


def _judge_part(job: Job, program: TimedProgram, part: Part, recipe: Recipe, content: bytes) -> JobResult:
    """Judge the faces of a part, and all by their area, and check in a cell if there is one.

    Raises:
        JobError: the program cannot be judged, or the cell cannot be used with it.
    """
    done, sprayed = deviate(program, recipe, part, job.deviation) if job.deviation else (program, recipe)
    survey = _survey(job.board, job.recipe, job.edits)
    verdicts = judge_faces(part, times_in_cone(done, part, sprayed), survey.visible, survey.hider)
    faces = dict.fromkeys(each.face for each in verdicts)
    return JobResult(
        job=job.key,
        seconds=done.totals.duration_s,
        litres=sum(litres for _, litres in done.totals.liquid_l),
        verdict=weigh_faces(verdicts).verdict,
        components={face: weigh_faces([each for each in verdicts if each.face == face]).verdict for face in faces},
        program_sha256="" if job.deviation else hashlib.sha256(content).hexdigest(),
        cell=None if job.cell is None else _check(program, part, job.cell),
    )


@lru_cache(maxsize=_KEPT)
def _survey(part: Input, recipe: Input, edits: Edits) -> Survey:
    return survey_part(_planned(part, recipe, edits)[0], _board(part).require_part("a verdict on faces"))


def _result(job: Job, report: CleaningReport) -> JobResult:
    return JobResult(
        job=job.key,
        seconds=report.duration_s,
        litres=sum(litres for _, litres in report.litres),
        verdict=report_cleanliness(report),
        components={part.component: verdict for part in report.parts if (verdict := cleanliness(part)) != "avoided"},
        stay_wet=sum(map(stays_wet, report.parts)),
    )


@lru_cache(maxsize=_KEPT)
def _planned(board: Input, recipe: Input, edits: Edits) -> tuple[Recipe, bytes]:
    """Plan a recipe with its edits; the recipe, and the program's file.

    Raises:
        StudyError: the recipe, or one that it extends, has changed since the study began.
        JobError: something is refused, or findings forbid the export.
    """
    text, file = _read(recipe, partial(read_text, kind=RECIPE)), Path(recipe.file)
    own = _read(recipe, lambda path: parse_recipe(text, file=path))
    _require(recipe, recipe_sha256(own))
    edited = parse_recipe(apply_edits(text, file, edits), file=file) if edits else own
    from rulesengine.levelling.film_run import run_levelled  # late: few need it

    done = run_levelled(edited, _board(board))
    stops = blocking(done.findings, [])
    if stops:
        raise JobError(export_refusal(stops))
    return edited, program_bytes(done)


def _require(given: Input, sha256: str) -> None:
    if sha256 != given.sha256:
        raise StudyError("has changed since the study began. Start the study again.", file=given.file)


@lru_cache(maxsize=_KEPT)
def _board(given: Input) -> Workpiece:
    parts = Path(given.parts) if given.parts else None
    board = _read(given, lambda path: load_workpiece(path, parts, over_faces=given.is_part))
    _require(given, board.sha256)
    return board


@lru_cache(maxsize=_KEPT)
def _parameters(given: Input) -> Parameters:
    parameters = _read(given, load_parameters)
    _require(given, parameters_sha256(parameters))
    return parameters


@lru_cache(maxsize=_KEPT)
def _prepared(board: Input, parameters: Input) -> PreparedBoard:
    return prepare(_board(board).require_board("an analysis"), _parameters(parameters), no_progress)


@lru_cache(maxsize=_KEPT)
def _cell(given: Input) -> "LoadedCell":
    from robotcell.cell.load import cell_sha256, read_cell

    cell = _read(given, read_cell)
    _require(given, cell_sha256(cell))
    return cell


def _read(given: Input, read: Callable[[Path], _T]) -> _T:
    """Read a file of the study that could be read when the study began.

    Raises:
        StudyError: it cannot be read here.
    """
    try:
        return read(Path(given.file))
    except JobError as error:
        raise StudyError(f"a worker cannot read it: {error}", file=given.file) from None


def _check(program: TimedProgram, board: Workpiece, given: Input) -> CellResult:
    """Do what ``washboard check`` does.

    Raises:
        JobError: the cell cannot be used with this program.
    """
    from robotcell.cell.load import hold_board
    from robotcell.track import terms_of, track

    held = hold_board(_cell(given), board)
    done = track(program, held.cell, board, terms=terms_of(held))
    rules = tuple(dict.fromkeys(each.rule.id for each in blocking(done.findings, [])))
    return CellResult(done.possible, done.program.totals.duration_s if done.possible else 0.0, rules)


def deviate(
    program: TimedProgram, recipe: Recipe, board: Workpiece, deviation: Deviation
) -> tuple[TimedProgram, Recipe]:
    """Give the program as it meets a displaced board, and the recipe with the pressure, flow and warmth there is.

    The program keeps its times. Liquid goes with the square root of the pressure, as in planning, and with the wear.
    """
    of = dict(deviation)
    pressure = 1.0 + of.get("pressure_pct", 0.0) / 100.0
    flow = 1.0 + of.get("nozzle_wear_pct", 0.0) / 100.0
    warmer = of.get("temperature_c", 0.0)

    def changed(setting: Instruction) -> Instruction:
        """Change the pressure and the temperature that a program sets."""
        if not (isinstance(setting, Command) and setting.keyword == "SET"):
            return setting
        key, value = setting.arguments[0], setting.arguments[1]
        if key == _PRESSURE:
            return replace(setting, arguments=(key, f"{float(value) * pressure:.6g}"))
        return replace(setting, arguments=(key, f"{float(value) + warmer:.6g}")) if key == _TEMPERATURE else setting

    instructions = tuple(map(changed, _moved(program, board, of)))
    litres = tuple((name, amount * flow * math.sqrt(pressure)) for name, amount in program.totals.liquid_l)
    functions = {
        name: each.model_copy(
            update={
                _PRESSURE: each.pressure_bar * pressure,
                _TEMPERATURE: None if each.temperature_c is None else each.temperature_c + warmer,
            }
        )
        for name, each in recipe.functions.items()
    }
    nozzles = {
        name: each.model_copy(update={"flow_lpm": each.flow_lpm * flow}) for name, each in recipe.nozzles.items()
    }
    done = replace(program, instructions=instructions, totals=replace(program.totals, liquid_l=litres))
    return done, recipe.model_copy(update={"functions": functions, "nozzles": nozzles})


def _moved(program: TimedProgram, board: Workpiece, of: Mapping[Quantity, float]) -> list[Instruction]:
    """Move the orifice back along its jet, and look at it from the board that is displaced."""
    instructions = list(program.instructions)
    rows = [row for row, each in enumerate(instructions) if isinstance(each, MoveTo)]
    moves = [each for each in instructions if isinstance(each, MoveTo)]
    if not moves:
        return instructions
    turned = Rotation.from_quat([each.quaternion for each in moves], scalar_first=True)
    places = np.array([each.position for each in moves])
    places -= of.get("standoff_mm", 0.0) * turned.apply([0.0, 0.0, 1.0])
    centre = np.mean(board.box, axis=0) * [1.0, 1.0, 0.0]
    back_turn = Rotation.from_euler("z", -of.get("turn_deg", 0.0), degrees=True)
    shift = np.array([of.get("shift_x_mm", 0.0), of.get("shift_y_mm", 0.0), 0.0])
    places = back_turn.apply(places - shift - centre) + centre
    poses = (back_turn * turned).as_quat(scalar_first=True)
    for row, each, place, pose in zip(rows, moves, places.tolist(), poses.tolist(), strict=True):
        instructions[row] = replace(each, position=(place[0], place[1], place[2]), quaternion=tuple(pose))
    return instructions
