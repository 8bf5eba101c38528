"""``washboard tune``: change a recipe until what it can clean is predicted clean."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import BoardSource, Parts, RecipeSource
from commandline.commands.analyse import ParametersOption
from commandline.errors import job_errors

if TYPE_CHECKING:
    from rulesengine.tuning.trial.request import TuningRequest
    from rulesengine.tuning.trial.result import TuningResult
    from rulesengine.tuning.variables.design_variables import ChangeKind

Goal: TypeAlias = Literal["clean", "clean-and-dry"]
_NOT_CLEAN = 1
"""Exit code where requirements are not met; the reasons are printed."""
_LEAST_ANALYSES = 2


def tune(
    board: BoardSource,
    recipe: RecipeSource = "smt-aqueous",
    goal: Annotated[
        Goal, typer.Option("--for", help="clean; clean-and-dry also requires no water under parts.")
    ] = "clean",
    limit: Annotated[
        list[str] | None,
        typer.Option("--limit", help="Most it may take: time=600 (s) or litres=20; repeatable.", metavar="NAME=VALUE"),
    ] = None,
    parameters: ParametersOption = "default",
    allow: Annotated[
        str,
        typer.Option(
            "--allow",
            help="What may change, by commas: speeds, tilts, passes, dwells, heights, sides (new paths and steps), "
            "wash_time (repeats of a step), pressure, temperature.",
            metavar="KINDS",
        ),
    ] = "speeds,tilts,passes,dwells,heights,sides,wash_time",
    keep: Annotated[
        list[str] | None,
        typer.Option("--keep", help="What stays as it is, such as templates.around.speed_mm_s; repeatable."),
    ] = None,
    analyses: Annotated[
        int, typer.Option("--analyses", min=_LEAST_ANALYSES, max=10_000, help="Most analyses to make.")
    ] = 40,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="New recipe.", metavar="NEW.yaml")] = None,
    report: Annotated[Path | None, typer.Option("--report", help="What was done, as data.", metavar="JSON")] = None,
    parts: Parts = None,
) -> None:
    """Change a recipe until every component is predicted clean, in little time; or state why that cannot be.

    What it changes, what that does and what it costs are shown, with the difference of the two recipes. The recipe
    itself is never touched: -o writes a new one. Pressure and temperature change only where --allow names them.

    Exit code 0: clean, within the limits. 1: requirements are not met, with the reasons. 2: the job could not be done.

    [dim]washboard tune board.step mine.yaml -o tuned.yaml
    washboard tune board.step mine.yaml --limit time=600 --limit litres=20 --keep templates.around.tilt_deg
    washboard tune tiny smt-aqueous --allow speeds,passes --report tuned.json[/dim]
    """
    with job_errors():
        from reports.files.write_run import check_apart
        from reports.terminal.console import open_console, print_files
        from reports.terminal.tune_card import print_tuned
        from rulesengine.tuning.report import explain

        check_apart((board, recipe, parameters, parts), [path for path in (output, report) if path is not None])
        file, text, request = _read(recipe, (goal, limit or [], allow, keep or []), analyses)
        _check_new(output, file, text)
        tuned = _tune((board, parts), (file, text), parameters, request)
        reasons = explain(tuned)
        diff = _write(tuned, (file, text), output, report)
        console = open_console()
        print_tuned(console, tuned, reasons, diff)
        print_files(console, recipe=output, report=report)
        if not (tuned.last.clean and tuned.within_limits):
            raise typer.Exit(_NOT_CLEAN)


def _check_new(output: Path | None, file: Path, text: str) -> None:
    """Refuse a place for the new recipe before the long work begins.

    Raises:
        OutputError: a file is there already: recipes that others extend are not to be lost.
        RecipeError: its name cannot be a recipe's.
    """
    from recipes.start import place_recipe
    from reports.files.atomic_write import OutputError

    if output is None:
        return
    if output.exists():
        raise OutputError(output, "it is there already", "Name a new file.")
    place_recipe(text, file, output)


def _read(
    recipe: str, words: tuple[Goal, list[str], str, list[str]], analyses: int
) -> "tuple[Path, str, TuningRequest]":
    """Read the recipe and the request.

    Raises:
        RecipeError: the recipe cannot be used, or a path to be kept is not in it.
        JobError: a word is unknown.
    """
    from recipes.load import RECIPE, read_recipe_text
    from rulesengine.tuning.trial.request import AllowedChanges, TuningRequest, read_limits
    from rulesengine.tuning.variables.design_variables import read_kinds
    from rulesengine.tuning.variables.recipe_edits import read_kept
    from specs.yaml.load import find_file, read_text

    goal, limits, kinds, keep = words
    known: frozenset[ChangeKind] = read_kinds(kinds)
    most = read_limits(limits)
    file = find_file(recipe, RECIPE)
    text = read_text(file, RECIPE)
    kept = read_kept(keep, read_recipe_text(text, file=file).root)
    return file, text, TuningRequest(goal, most, AllowedChanges(known, kept), analyses)


def _tune(
    source: tuple[str, Path | None], recipe: tuple[Path, str], parameters: str, request: "TuningRequest"
) -> "TuningResult":
    """Load the board, make it ready, and tune, showing progress.

    Raises:
        JobError: something cannot be used.
    """
    from boards.load import load_board
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from commandline.loading import progress_bar
    from rulesengine.tuning.trial.trial_runner import TrialRunner
    from rulesengine.tuning.tune import tune as search
    from specs.progress import subprogress

    known = load_parameters(parameters)
    with progress_bar() as progress:
        board = load_board(Path(source[0]), source[1], subprogress(progress, 0.0, 0.05))
        prepared = prepare(board, known, subprogress(progress, 0.05, 0.1))
        tuning = subprogress(progress, 0.1, 1.0)
        runner = TrialRunner(recipe[0], prepared, request.goal, request.max_analyses, tuning)
        return search(runner, recipe[1], request)


def _write(tuned: "TuningResult", recipe: tuple[Path, str], output: Path | None, report: Path | None) -> str:
    """Render everything, then write it; return the difference of the recipes.

    Raises:
        RecipeError: the file's name cannot be a recipe's.
        OutputError: a file cannot be written.
    """
    from recipes.start import place_recipe
    from reports.files.atomic_write import write_text_atomically
    from rulesengine.tuning.report import explain, tuning_report
    from rulesengine.tuning.variables.recipe_edits import recipe_diff

    file, text = recipe
    new = tuned.last.text if output is None else place_recipe(tuned.last.text, file, output)
    diff = recipe_diff(text, new, file.name, "tuned" if output is None else output.name)
    contents = [] if output is None else [(output, new)]
    if report is not None:
        data = tuning_report(tuned, explain(tuned), diff)
        contents.append((report, json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"))
    for path, content in contents:
        write_text_atomically(path, content)
    return diff
