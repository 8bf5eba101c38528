"""``washboard tune``: change a recipe until what it can clean is predicted clean."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import BoardSource, CellOption, ParametersOption, Parts, RecipeSource

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.parameters.model import Parameters
    from reports.files.tuning_state import TuningState
    from robotcell.cell.load import LoadedCell
    from rulesengine.tuning.trial.request import TuningRequest, TuningResult
    from rulesengine.tuning.trial.trial_runner import TrialRunner

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
        Path | None,
        typer.Option(
            "--output", "-o", help="New recipe; the best so far is there while tuning goes on.", metavar="NEW.yaml"
        ),
    ] = None,
    resume: Annotated[
        bool, typer.Option("--resume", help="Go on with a tuning to the same -o that was interrupted.")
    ] = False,
    report: Annotated[
        Path | None, typer.Option("--report", help="Changes and result, as data.", metavar="JSON")
    ] = None,
    picture: Annotated[
        Path | None,
        typer.Option("--picture", help="All analysed recipes, with the Pareto front.", metavar="PNG|SVG"),
    ] = None,
    front: Annotated[
        Path | None,
        typer.Option("--front", help="Folder for the recipes of the Pareto front, to choose from.", metavar="FOLDER"),
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
    from recipes.load import RECIPE
    from reports.files.write_run import check_folder, check_places
    from specs.yaml.load import find_file, read_text

    check_places(
        (board, recipe, parameters, parts, cell),
        {"a YAML file": output, "a report": report, "a picture": picture},
    )
    if front is not None:
        check_folder(front)
    file = find_file(recipe, RECIPE)
    text = read_text(file, RECIPE)
    request = _request((file, text), (goal, limit or [], allow, keep or [], worth or []), analyses)
    _check_output(output, (file, text), resume=resume)
    inputs = _Inputs((board, parts), (file, text), (parameters, cell), request)
    tuned = _tune(inputs, _Places(output, report, picture, front), resume=resume)
    if not (tuned.last.clean and tuned.within_limits):
        raise typer.Exit(_NOT_CLEAN)


@dataclass(frozen=True, slots=True)
class _Inputs:
    """What is tuned."""

    source: tuple[str, Path | None]
    recipe: tuple[Path, str]
    names: tuple[str, str | None]
    """Of the parameter set and the cell."""
    request: "TuningRequest"


@dataclass(frozen=True, slots=True)
class _Places:
    """Where results go."""

    output: Path | None
    report: Path | None
    picture: Path | None
    front: Path | None


def _check_output(output: Path | None, recipe: tuple[Path, str], *, resume: bool) -> None:
    """Refuse what cannot be written before the long work begins.

    Raises:
        JobError: a recipe is there already, cannot be named after the file, or nothing names what to go on with.
    """
    from recipes.start import place_recipe
    from reports.files.atomic_write import OutputError
    from reports.files.tuning_state import state_place
    from specs.errors import JobError

    if output is None:
        if resume:
            raise JobError("--resume goes on with the recipe that -o names: name it.")
        return
    if output.exists() and not resume:  # recipes that others extend are not to be lost
        known = state_place(output).exists()
        advice = "Name a new file, or --resume to go on with the tuning that wrote it." if known else "Name a new file."
        raise OutputError(output, "it is there already", advice)
    place_recipe(recipe[1], recipe[0], output)


def _request(
    recipe: tuple[Path, str], words: tuple[Goal, list[str], str, list[str], list[str]], analyses: int
) -> "TuningRequest":
    """Read the goal, the limits, the kinds of change that are allowed, the paths that are kept, and when to stop.

    Raises:
        RecipeError: the recipe cannot be used, or a path to be kept is not in it.
        JobError: a word is unknown.
    """
    from recipes.load import read_recipe_text
    from rulesengine.tuning.trial.request import AllowedChanges, TuningRequest, read_limits, read_worth
    from rulesengine.tuning.variables.design_variables import read_kinds
    from rulesengine.tuning.variables.recipe_edits import read_kept

    (file, text), (goal, limits, kinds, keep, worth) = recipe, words
    known = read_kinds(kinds)
    most = read_limits(limits)
    kept = read_kept(keep, read_recipe_text(text, file=file).root)
    return TuningRequest(goal, most, AllowedChanges(known, kept), analyses, read_worth(worth))


def _tune(inputs: _Inputs, places: _Places, *, resume: bool) -> "TuningResult":
    """Load and prepare the board, tune with the best recipe so far kept on disk, and write and print the result.

    Raises:
        JobError: something cannot be used.
    """
    from boards.workpiece import load_workpiece
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from commandline.loading import progress_bar
    from robotcell.cell.load import hold_board
    from rulesengine.tuning.trial.trial_runner import TrialRunner
    from rulesengine.tuning.tune import tune as search
    from specs.progress import subprogress
    from washboard.inputs import open_cell

    (parameters, cell), request, (file, text) = inputs.names, inputs.request, inputs.recipe
    known = load_parameters(parameters)
    loaded = None if cell is None else open_cell(cell)
    with progress_bar() as progress:
        board = load_workpiece(*inputs.source, subprogress(progress, 0.0, 0.05)).require_board("tune")
        with _kept(inputs, places.output, (board, known, loaded), resume=resume) as state:
            prepared = prepare(board, known, subprogress(progress, 0.05, 0.1))
            tuning = subprogress(progress, 0.1, 1.0)
            held = None if loaded is None else hold_board(loaded, board)
            runner = TrialRunner(file, prepared, request.goal, request.max_analyses, tuning, cell=held)
            if state is None or places.output is None:
                tuned = search(runner, text, request)
            else:
                runner.keep_in(state)
                tuned = search(runner, text, request, partial(_keep_best, (places.output, file), runner, state))
            _write(tuned, inputs, places, state)
    return tuned


@contextmanager
def _kept(
    inputs: _Inputs, output: Path | None, read: "tuple[Board, Parameters, LoadedCell | None]", *, resume: bool
) -> "Generator[TuningState | None]":
    """Open the state beside the new recipe; ``None`` where none is written.

    Raises:
        JobError: there is no such state, or it is of something else.
    """
    from reports.files.tuning_state import check_output, fingerprints_of, open_state, state_place

    if output is None:
        yield None
        return
    fingerprints = fingerprints_of(inputs.recipe, *read, inputs.request)
    with open_state(state_place(output), fingerprints, resume=resume) as state:
        if resume:
            check_output(state, output)
        yield state


def _keep_best(place: tuple[Path, Path], runner: "TrialRunner", state: "TuningState", so_far: "TuningResult") -> None:
    """Write the best recipe so far, and what an interrupt reports about it.

    Args:
        place: The new recipe's file, and that of the recipe that is tuned.
        runner: Counts the analyses.
        state: Keeps in mind what is written.
        so_far: The result.
    """
    from recipes.start import place_recipe
    from reports.files.atomic_write import write_bytes_atomically
    from reports.tables.wording import amount
    from specs import ending

    output, file = place
    content = place_recipe(so_far.last.text, file, output).encode()
    if not (output.exists() and output.read_bytes() == content):
        state.note_output(content)
        write_bytes_atomically(output, content)
    figures = so_far.last.figures
    best = f"{figures.clean_components} of {so_far.last.total} clean, {figures.seconds:.0f} s, {figures.litres:.1f} l"
    ending.note_reached(lambda: f"the best of {amount(runner.used, 'analysis', 'analyses')}: {best}; --resume goes on")


def _write(tuned: "TuningResult", inputs: _Inputs, places: _Places, state: "TuningState | None") -> None:
    """Write and print the result; then the state is not needed any more."""
    from recipes.start import place_recipe
    from reports.cards.tuning import tuned_card
    from reports.files.atomic_write import write_files, write_outputs
    from reports.files.write_run import json_bytes
    from reports.pictures.tuning_picture import draw_tuning
    from reports.terminal.console import open_console, print_card, print_files
    from rulesengine.tuning.front import pareto_front
    from rulesengine.tuning.report import explain, tuning_report
    from rulesengine.tuning.variables.recipe_edits import recipe_diff
    from specs import ending

    (file, text), (output, report, picture) = inputs.recipe, (places.output, places.report, places.picture)
    reasons = explain(tuned)
    new = tuned.last.text if output is None else place_recipe(tuned.last.text, file, output)
    diff = recipe_diff(text, new, file.name, "tuned" if output is None else output.name)
    drawn = None if picture is None else draw_tuning(tuned, picture.suffix)
    if state is not None:
        state.note_output(new.encode())
    write_outputs({
        output: new,
        report: None if report is None else json_bytes(tuning_report(tuned, reasons, diff)),
        picture: drawn,
    })  # fmt: skip
    if places.front is not None:
        names = [places.front / f"front-{number}.yaml" for number in range(1, len(pareto_front(tuned.trials)) + 1)]
        texts = [
            place_recipe(each.text, file, name) for each, name in zip(pareto_front(tuned.trials), names, strict=True)
        ]
        write_files(places.front, {name.name: each.encode() for name, each in zip(names, texts, strict=True)})
    if state is not None:
        state.remove()
    ending.note_reached(None)
    console = open_console()
    print_card(console, tuned_card(tuned, reasons, diff))
    print_files(console, recipe=output, report=report, picture=picture, front=places.front)
