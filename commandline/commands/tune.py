"""``washboard tune``: change a recipe until what it can clean is predicted clean."""

from collections.abc import Generator
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import (
    BoardSource,
    CellOption,
    ParametersOption,
    Parts,
    RecipeSource,
    output_folder,
    output_option,
)
from specs.output_file import OutputFile, OutputFolder

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.parameters.model import Parameters
    from reports.files.tuning_state import TuningState
    from robotcell.cell.load import LoadedCell
    from rulesengine.tuning.trial.request import TuningRequest, TuningResult
    from rulesengine.tuning.trial.trial_runner import TrialRunner
    from washboard.inputs import OpenedRecipe

Goal: TypeAlias = Literal["clean", "clean-and-dry"]
_NOT_CLEAN = 1
"""Exit code where a requirement is not met."""
_LEAST_ANALYSES = 2


def tune(
    board: BoardSource,
    recipe: RecipeSource = "smt-aqueous",
    cell: CellOption = None,
    goal: Annotated[
        Goal, typer.Option("--for", help="clean; clean-and-dry also requires no water under parts.")
    ] = "clean",
    limit: Annotated[
        list[str] | None,
        typer.Option(
            "--limit", help="Most it takes: time=600 (s) or litres=20; may be repeated.", metavar="NAME=VALUE"
        ),
    ] = None,
    parameters: ParametersOption = "default",
    allow: Annotated[
        str,
        typer.Option(
            "--allow",
            help="What may change, separated by commas: speeds, tilts, passes, dwells, heights, sides (new paths and "
            "steps), wash_time (repeats of a step, or its least time), pressure, temperature.",
            metavar="KINDS",
        ),
    ] = "speeds,tilts,passes,dwells,heights,sides,wash_time",
    keep: Annotated[
        list[str] | None,
        typer.Option("--keep", help="Value that stays as it is, such as templates.around.speed_mm_s; may be repeated."),
    ] = None,
    analyses: Annotated[
        int, typer.Option("--analyses", min=_LEAST_ANALYSES, max=10_000, help="Most analyses to make.")
    ] = 40,
    worth: Annotated[
        list[str] | None,
        typer.Option(
            "--worth",
            help="When to stop: saving=1, percent of time and liquid that an analysis has to promise; "
            "requirement=1800, most seconds (and their liquid) for one more that is met; may be repeated.",
            metavar="NAME=VALUE",
        ),
    ] = None,
    output: Annotated[
        OutputFile | None,
        output_option(
            "--output -o", "NEW.yaml", "New recipe; the best so far is there while tuning goes on.", ".tuning"
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a tuning to the same -o that was interrupted.")
    ] = False,
    report: Annotated[OutputFile | None, output_option("--report", "JSON", "Changes and result, as data.")] = None,
    picture: Annotated[
        OutputFile | None, output_option("--picture", "PNG|SVG", "All analysed recipes, with the Pareto front.")
    ] = None,
    front: Annotated[
        OutputFolder | None,
        typer.Option(
            "--front",
            help="Folder for the recipes of the Pareto front, to choose from.",
            metavar="FOLDER",
            parser=output_folder(r"front-\d+\.yaml"),
        ),
    ] = None,
    parts: Parts = None,
) -> None:
    """Change a recipe until every component is predicted clean, in little time; or state why that cannot be.

    The changes with their effects and costs are shown, with the difference of the two recipes. The recipe itself is
    never touched: -o writes a new one. Pressure and temperature change only where --allow names them.

    An interrupt leaves the best recipe so far at -o; the same command with --resume goes on from there.

    Exit code 0: clean, within the limits. 1: requirements are not met, with the reasons. 2: the job could not be done.

    [dim]washboard tune board.step mine.yaml -o tuned.yaml
    washboard tune board.step mine.yaml --cell ur5e-bench -o tuned.yaml
    washboard tune board.step mine.yaml --limit time=600 --limit litres=20 --keep templates.around.tilt_deg
    washboard tune tiny smt-aqueous --allow speeds,passes --report tuned.json[/dim]
    """
    from boards.workpiece import load_workpiece
    from cleaning.parameters.load import load_parameters
    from commandline.loading import progress_bar
    from rulesengine.tuning.trial.request import AllowedChanges, TuningRequest, read_limits, read_worth
    from rulesengine.tuning.variables import read_kept, read_kinds
    from specs.progress import subprogress
    from washboard.inputs import open_cell, open_recipe
    from washboard.tuned import search_on

    opened = open_recipe(recipe)
    allowed = AllowedChanges(read_kinds(allow), read_kept(keep or [], opened.loaded.root))
    request = TuningRequest(goal, read_limits(limit or []), allowed, analyses, read_worth(worth or []))
    _check_output(output, opened, resume=resume)
    known, loaded = load_parameters(parameters), None if cell is None else open_cell(cell)
    with progress_bar() as progress:
        read = load_workpiece(board, parts, subprogress(progress, 0.0, 0.05)).require_board("tune")
        with _kept(output, (opened, read, known, loaded, request), resume=resume) as state:
            note = None if state is None or output is None else partial(_keep_best, output, opened, state)
            rest = subprogress(progress, 0.05, 1.0)
            tuned = search_on(read, opened, request, known, loaded, rest, store=state, observe=note)
            _write(tuned, opened, (output, report, picture, front), state)
    if not (tuned.last.clean and tuned.within_limits):
        raise typer.Exit(_NOT_CLEAN)


def _check_output(output: OutputFile | None, recipe: "OpenedRecipe", *, resume: bool) -> None:
    """Refuse what cannot be written before the long work begins.

    Raises:
        JobError: a recipe is there already, cannot be named after the file, or nothing names what to go on with.
    """
    from recipes.start import place_recipe
    from reports.files.tuning_state import state_place
    from specs.errors import JobError
    from specs.output_file import OutputError

    if output is None:
        if resume:
            raise JobError("--resume goes on with the recipe that -o names: name it.")
        return
    if output.path.exists() and not resume:  # recipes that others extend are not to be lost
        known = state_place(output.path).exists()
        advice = "Name a new file, or --resume to go on with the tuning that wrote it." if known else "Name a new file."
        raise OutputError(output.path, "it is there already", advice)
    place_recipe(recipe.text, recipe.file, output.path)


@contextmanager
def _kept(
    output: OutputFile | None,
    read: "tuple[OpenedRecipe, Board, Parameters, LoadedCell | None, TuningRequest]",
    *,
    resume: bool,
) -> "Generator[TuningState | None]":
    """Open the state beside the new recipe; ``None`` where none is written.

    Raises:
        JobError: there is no such state, or it is of something else.
    """
    from reports.files.tuning_state import check_output, fingerprints_of, open_state, state_place

    if output is None:
        yield None
        return
    opened, board, parameters, cell, request = read
    fingerprints = fingerprints_of((opened.file, opened.text), board, parameters, cell, request)
    with open_state(state_place(output.path), fingerprints, resume=resume) as state:
        if resume:
            check_output(state, output.path)
        yield state


def _keep_best(
    output: OutputFile, recipe: "OpenedRecipe", state: "TuningState", runner: "TrialRunner", so_far: "TuningResult"
) -> None:
    """Write the best recipe so far, and what an interrupt reports about it: how many analyses the runner counts."""
    from recipes.start import place_recipe
    from reports.tables.wording import amount
    from specs import ending

    content = place_recipe(so_far.last.text, recipe.file, output.path).encode()
    if not output.holds(content):
        state.note_output(content)
        output.write(content)
    figures = so_far.last.figures
    best = f"{figures.clean_components} of {so_far.last.total} clean, {figures.seconds:.0f} s, {figures.litres:.1f} l"
    ending.note_reached(lambda: f"the best of {amount(runner.used, 'analysis', 'analyses')}: {best}; --resume goes on")


def _write(
    tuned: "TuningResult",
    recipe: "OpenedRecipe",
    places: tuple[OutputFile | None, OutputFile | None, OutputFile | None, OutputFolder | None],
    state: "TuningState | None",
) -> None:
    """Write and print the result; then the state is not needed any more."""
    from commandline.loading import finish
    from recipes.start import place_recipe
    from reports.cards.recipe_search import tuned_card
    from reports.files.write_run import json_bytes
    from reports.pictures.charts import draw_tuning
    from rulesengine.tuning.report import explain, tuning_report
    from rulesengine.tuning.trial.request import pareto_front
    from rulesengine.tuning.variables import recipe_diff
    from specs import ending
    from specs.output_file import write_outputs

    (file, text), (output, report, picture, front) = (recipe.file, recipe.text), places
    reasons = explain(tuned)
    new = tuned.last.text if output is None else place_recipe(tuned.last.text, file, output.path)
    diff = recipe_diff(text, new, file.name, "tuned" if output is None else output.path.name)
    drawn = None if picture is None else draw_tuning(tuned, picture.path.suffix)
    is_there = output is not None and output.holds(new.encode())  # the best so far, which is the best
    if state is not None and not is_there:
        state.note_output(new.encode())
    write_outputs({
        output: None if is_there else new,
        report: None if report is None else json_bytes(tuning_report(tuned, reasons, diff)),
        picture: drawn,
    })  # fmt: skip
    if front is not None:
        chosen = {f"front-{number}.yaml": each for number, each in enumerate(pareto_front(tuned.trials), start=1)}
        front.write({
            name: place_recipe(each.text, file, front.path / name).encode() for name, each in chosen.items()
        })  # fmt: skip
    if state is not None:
        state.remove()
    ending.note_reached(None)
    finish(tuned_card(tuned, reasons, diff), recipe=output, report=report, picture=picture, front=front)
