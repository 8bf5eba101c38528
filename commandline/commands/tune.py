"""``washboard tune``, ``level`` and ``spacing``: better recipes, speeds along passes, spacings of passes."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import typer

from commandline.arguments import BoardSource, CellOption, ParametersOption, Parts, Picture, RecipeSource
from commandline.errors import job_errors

if TYPE_CHECKING:
    from rulesengine.tuning.trial.request import TuningRequest, TuningResult

Goal: TypeAlias = Literal["clean", "clean-and-dry"]
FilmGoal: TypeAlias = Literal["least-time", "even-film"]
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
    output: Annotated[Path | None, typer.Option("--output", "-o", help="New recipe.", metavar="NEW.yaml")] = None,
    report: Annotated[
        Path | None, typer.Option("--report", help="Changes and result, as data.", metavar="JSON")
    ] = None,
    parts: Parts = None,
) -> None:
    """Change a recipe until every component is predicted clean, in little time; or state why that cannot be.

    The changes with their effects and costs are shown, with the difference of the two recipes. The recipe itself is
    never touched: -o writes a new one. Pressure and temperature change only where --allow names them.

    Exit code 0: clean, within the limits. 1: requirements are not met, with the reasons. 2: the job could not be done.

    [dim]washboard tune board.step mine.yaml -o tuned.yaml
    washboard tune board.step mine.yaml --cell ur5e-bench -o tuned.yaml
    washboard tune board.step mine.yaml --limit time=600 --limit litres=20 --keep templates.around.tilt_deg
    washboard tune tiny smt-aqueous --allow speeds,passes --report tuned.json[/dim]
    """
    with job_errors():
        from recipes.load import RECIPE
        from recipes.start import place_recipe
        from reports.files.atomic_write import OutputError, write_outputs
        from reports.files.write_run import check_apart, json_bytes
        from reports.terminal.console import open_console, print_files
        from reports.terminal.tune_card import print_tuned
        from rulesengine.tuning.report import explain, tuning_report
        from rulesengine.tuning.variables.recipe_edits import recipe_diff
        from specs.yaml.load import find_file, read_text

        check_apart((board, recipe, parameters, parts, cell), [output, report])
        file = find_file(recipe, RECIPE)
        text = read_text(file, RECIPE)
        request = _request((file, text), (goal, limit or [], allow, keep or []), analyses)
        if output is not None:  # refused before the long work begins
            if output.exists():  # recipes that others extend are not to be lost
                raise OutputError(output, "it is there already", "Name a new file.")
            place_recipe(text, file, output)
        tuned = _tune((board, parts), (file, text), (parameters, cell), request)
        reasons = explain(tuned)
        new = tuned.last.text if output is None else place_recipe(tuned.last.text, file, output)
        diff = recipe_diff(text, new, file.name, "tuned" if output is None else output.name)
        write_outputs({
            output: new,
            report: None if report is None else json_bytes(tuning_report(tuned, reasons, diff)),
        })  # fmt: skip
        console = open_console()
        print_tuned(console, tuned, reasons, diff)
        print_files(console, recipe=output, report=report)
        if not (tuned.last.clean and tuned.within_limits):
            raise typer.Exit(_NOT_CLEAN)


def _request(recipe: tuple[Path, str], words: tuple[Goal, list[str], str, list[str]], analyses: int) -> "TuningRequest":
    """Read the goal, the limits, the kinds of change that are allowed and the paths that are kept.

    Raises:
        RecipeError: the recipe cannot be used, or a path to be kept is not in it.
        JobError: a word is unknown.
    """
    from recipes.load import read_recipe_text
    from rulesengine.tuning.trial.request import AllowedChanges, TuningRequest, read_limits
    from rulesengine.tuning.variables.design_variables import read_kinds
    from rulesengine.tuning.variables.recipe_edits import read_kept

    (file, text), (goal, limits, kinds, keep) = recipe, words
    known = read_kinds(kinds)
    most = read_limits(limits)
    kept = read_kept(keep, read_recipe_text(text, file=file).root)
    return TuningRequest(goal, most, AllowedChanges(known, kept), analyses)


def _tune(
    source: tuple[str, Path | None],
    recipe: tuple[Path, str],
    names: tuple[str, str | None],
    request: "TuningRequest",
) -> "TuningResult":
    """Load and prepare the board, and tune, with a parameter set and for the robot of a cell, if one is named.

    Raises:
        JobError: something cannot be used.
    """
    from boards.load import load_board
    from cleaning.parameters.load import load_parameters
    from cleaning.prepared_board import prepare
    from commandline.loading import progress_bar, read_named_cell
    from robotcell.cell.hold import hold_board
    from rulesengine.tuning.trial.trial_runner import TrialRunner
    from rulesengine.tuning.tune import tune as search
    from specs.progress import subprogress

    parameters, cell = names
    known = load_parameters(parameters)
    loaded = None if cell is None else read_named_cell(cell)
    with progress_bar() as progress:
        board = load_board(Path(source[0]), source[1], subprogress(progress, 0.0, 0.05))
        prepared = prepare(board, known, subprogress(progress, 0.05, 0.1))
        tuning = subprogress(progress, 0.1, 1.0)
        held = None if loaded is None else hold_board(loaded, board)
        runner = TrialRunner(recipe[0], prepared, request.goal, request.max_analyses, tuning, cell=held)
        return search(runner, recipe[1], request)


def level(
    board: BoardSource,
    recipe: RecipeSource = "smt-aqueous",
    goal: Annotated[
        FilmGoal,
        typer.Option(
            "--for",
            help="least-time: the film is kept wherever it is now; even-film: least deviation from the film.",
        ),
    ] = "least-time",
    film_um: Annotated[
        float | None,
        typer.Option(
            "--film-um",
            help="Film, µm of liquid; left out, what all but 5 % of the places get now, or for even-film the mean.",
            min=0.001,
            max=1e6,
            metavar="UM",
        ),
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Program to write.", metavar="OUT.wash")] = None,
    parts: Parts = None,
) -> None:
    """Level the speeds along rasters and flushes: the same film in the least time, or an even film.

    [dim]washboard level smt-demo smt-aqueous -o levelled.wash
    washboard level my-board.tri coat.yaml --for even-film --film-um 40 -o coat.wash[/dim]
    """
    with job_errors():
        from dataclasses import replace

        from commandline.loading import progress_bar, read_and_run
        from reports.files.write_run import check_places, write_run
        from reports.terminal.console import open_console, print_files, print_line
        from reports.terminal.film_card import print_levelled
        from rulesengine.levelling.level_plan import level_plan
        from rulesengine.timing.time_plan import time_plan

        check_places((board, recipe, parts), {"a program": output})
        done = read_and_run(board, recipe, parts)
        with progress_bar() as progress:
            plan, report = level_plan(done.plan, done.board, done.fitted, goal, film_um, progress)
        program = time_plan(plan, done.fitted.limits)
        levelled = replace(done, plan=plan, program=program)
        write_run(levelled, output=output, picture=None, report_file=None, allowed=())
        console = open_console()
        print_levelled(console, report)
        print_files(console, program=output)
        if output is None:
            print_line(console, ("No program was written; -o OUT.wash writes it.", "dim"))


def spacing(
    recipe: RecipeSource,
    nozzle: Annotated[str, typer.Argument(help="Nozzle of the recipe.", metavar="NOZZLE")],
    film_um: Annotated[
        float, typer.Option("--film-um", help="Film to lay, µm of liquid.", min=0.001, max=1e6, metavar="UM")
    ],
    height_mm: Annotated[
        float | None,
        typer.Option(
            "--height-mm",
            help="Orifice above the surface; left out, that of the measured pattern of a radial nozzle.",
            min=0.1,
            max=1000.0,
            metavar="MM",
        ),
    ] = None,
    max_speed_mm_s: Annotated[
        float | None,
        typer.Option(
            "--max-speed-mm-s",
            help="Left out, the maximum of the functions that spray with the nozzle.",
            min=0.01,
            max=10_000.0,
            metavar="MM_S",
        ),
    ] = None,
    picture: Picture = None,
) -> None:
    """Find every spacing of parallel passes at which their film is even, and the speed that lays it.

    [dim]washboard spacing coat.yaml gun --film-um 40 --picture spacing.png
    washboard spacing smt-aqueous ring60 --film-um 500 --height-mm 50[/dim]
    """
    with job_errors():
        from recipes.load import load_recipe
        from reports.files.atomic_write import write_outputs
        from reports.files.write_run import check_places
        from reports.pictures.film_picture import draw_spacings
        from reports.terminal.console import open_console, print_files
        from reports.terminal.film_card import print_spacings
        from rulesengine.levelling.pass_spacing import find_pass_spacings

        check_places((recipe,), {"a picture": picture})
        table = find_pass_spacings(load_recipe(recipe), nozzle, film_um, height_mm, max_speed_mm_s)
        write_outputs({picture: None if picture is None else draw_spacings(table, picture.suffix)})
        console = open_console()
        print_spacings(console, table)
        print_files(console, picture=picture)
