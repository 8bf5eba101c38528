"""A job of a study: what ``washboard plan``, ``analyse`` and ``check`` do, one after the other, in a worker."""

import hashlib
from collections.abc import Callable
from functools import lru_cache, partial
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from boards.board import Board
from boards.load import load_board
from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters, parameters_sha256
from cleaning.parameters.model import Parameters
from cleaning.prepared_board import PreparedBoard, prepare
from cleaning.report import Traceability
from cleaning.threads import limit_threads
from cleaning.verdicts.cleanliness import cleanliness, report_cleanliness, stays_wet
from cleaning.verdicts.results import CleaningReport
from programs import native
from programs.program import TimedProgram
from recipes.load import RECIPE, parse_recipe, recipe_sha256
from recipes.recipe import Recipe
from reports.files.write_run import cleaning_bytes, export_refusal, program_bytes
from reports.tables.cleaning_tables import this_producer
from rulesengine.planning.pipeline import run
from rulesengine.tuning.suggest import advise
from rulesengine.tuning.variables.recipe_edits import Edits, apply_edits
from specs.errors import JobError
from specs.finding import blocking
from specs.progress import no_progress
from specs.yaml.load import read_text
from studies.deviation import deviate
from studies.errors import StudyError
from studies.job import CellResult, Input, Job, JobResult

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell

_T = TypeVar("_T")

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
    if job.version != version("washboard"):
        raise StudyError(f"a worker has Washboard {version('washboard')}, and the study {job.version}. Install one.")
    board, parameters = _board(job.board), _parameters(job.parameters)
    try:
        recipe, content = _planned(job.board, job.recipe, job.edits)
        with limit_threads(threads):
            if job.deviation:
                return _deviating(job, board, parameters, recipe, native.parse(content.decode()))
            return _as_planned(job, board, parameters, recipe, content)
    except StudyError:
        raise
    except JobError as error:
        return JobResult(job.key, error=str(error))


def _as_planned(job: Job, board: Board, parameters: Parameters, recipe: Recipe, content: bytes) -> JobResult:
    """Do what the commands do, with the file that ``plan`` writes as their input.

    Raises:
        JobError: something is refused.
    """
    program, program_sha256 = native.parse(content.decode()), hashlib.sha256(content).hexdigest()
    report = analyse_on(_prepared(job.board, job.parameters), program, recipe, job.effort)
    report = advise(report, program, recipe)
    written = cleaning_bytes(report, this_producer(job.effort), Traceability(program_sha256=program_sha256))
    cell = None if job.cell is None else _check(program, board, job.cell)
    hashes = program_sha256, hashlib.sha256(written).hexdigest()
    return _result(job, report, hashes, cell)


def _deviating(job: Job, board: Board, parameters: Parameters, recipe: Recipe, program: TimedProgram) -> JobResult:
    done, sprayed = deviate(program, recipe, board, job.deviation)
    report = analyse_on(_prepared(job.board, job.parameters), done, sprayed, job.effort, sensitivity=False)
    return _result(job, report, ("", ""), None)


def _result(job: Job, report: CleaningReport, hashes: tuple[str, str], cell: CellResult | None) -> JobResult:
    return JobResult(
        job=job.key,
        seconds=report.duration_s,
        litres=sum(litres for _, litres in report.litres),
        verdict=report_cleanliness(report),
        components={part.component: verdict for part in report.parts if (verdict := cleanliness(part)) != "avoided"},
        stay_wet=sum(map(stays_wet, report.parts)),
        program_sha256=hashes[0],
        analysis_sha256=hashes[1],
        cell=cell,
    )


@lru_cache(maxsize=_KEPT)
def _planned(board: Input, recipe: Input, edits: Edits) -> tuple[Recipe, bytes]:
    """Plan a recipe with its edits; the recipe, and the program's file.

    Raises:
        StudyError: the recipe, or one that it extends, has changed since the study began.
        JobError: something is refused, or findings forbid the export.
    """
    _require(recipe, recipe_sha256(_read(recipe, partial(edited_recipe, edits=()))))
    edited = edited_recipe(Path(recipe.file), edits)
    done = run(edited, _board(board))
    stops = blocking(done.findings, [])
    if stops:
        raise JobError(export_refusal(stops))
    return edited, program_bytes(done)


def edited_recipe(file: Path, edits: Edits) -> Recipe:
    """Read a recipe as if its owner had written the values into it.

    Raises:
        JobError: it cannot be used with them.
    """
    return parse_recipe(apply_edits(read_text(file, RECIPE), file, edits), file=file)


def _require(given: Input, sha256: str) -> None:
    if sha256 != given.sha256:
        raise StudyError("has changed since the study began. Start the study again.", file=given.file)


@lru_cache(maxsize=_KEPT)
def _board(given: Input) -> Board:
    board = _read(given, partial(load_board, parts=Path(given.parts) if given.parts else None))
    _require(given, board.sha256)
    return board


@lru_cache(maxsize=_KEPT)
def _parameters(given: Input) -> Parameters:
    parameters = _read(given, load_parameters)
    _require(given, parameters_sha256(parameters))
    return parameters


@lru_cache(maxsize=_KEPT)
def _prepared(board: Input, parameters: Input) -> PreparedBoard:
    return prepare(_board(board), _parameters(parameters), no_progress)


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


def _check(program: TimedProgram, board: Board, given: Input) -> CellResult:
    """Do what ``washboard check`` does.

    Raises:
        JobError: the cell cannot be used with this program.
    """
    from robotcell.cell.hold import hold_board
    from robotcell.track import terms_of, track

    held = hold_board(_cell(given), board)
    done = track(program, held.cell, board, terms=terms_of(held))
    rules = tuple(dict.fromkeys(each.rule.id for each in blocking(done.findings, [])))
    return CellResult(done.possible, done.program.totals.duration_s if done.possible else 0.0, rules)
