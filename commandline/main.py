"""The command line; each command imports what it needs when it runs, so that help is quick."""

import gc
import io
import logging
import sys
from collections.abc import Callable
from functools import cache
from typing import Annotated, TextIO, cast

import typer
from typer.main import get_command

from commandline.arguments import with_places_checked
from commandline.commands import (
    analyse,
    calibrate,
    check,
    compare,
    demo,
    export,
    level,
    operate,
    plan,
    study,
    ui,
    validate,
)
from commandline.commands import show as program
from commandline.commands import tune as tuning
from commandline.errors import UsageError, job_errors, report_usage
from commandline.nouns import board, cell, controller, parameters, part, recipe
from specs import ending

app = typer.Typer(
    name="washboard",
    help="Program robots that spray-clean printed circuit boards: CAD and a recipe in, a timed nozzle program out.",
    epilog="Start with: washboard demo",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
app.command("plan")(plan.plan)
app.command("show")(program.show)
app.command("classify")(plan.classify)
app.command("check")(check.check)
app.command("export")(export.export)
app.command("operate")(operate.operate)
app.command("analyse")(analyse.analyse)
app.command("bath")(analyse.bath)
app.command("compare")(compare.compare)
app.command("results")(analyse.results)
app.command("tune")(tuning.tune)
app.command("study")(study.study)
app.command("validate")(validate.validate)
app.command("level")(level.level)
app.command("spacing")(level.spacing)
app.command("demo")(demo.demo)
app.add_typer(board.app, name="board")
app.add_typer(part.app, name="part")
app.add_typer(recipe.app, name="recipe")
app.add_typer(cell.app, name="cell")
app.add_typer(controller.app, name="controller")
app.add_typer(parameters.app, name="parameters")
app.add_typer(calibrate.app, name="calibrate")
app.command("ui")(ui.ui)


@app.callback(invoke_without_command=True)
def _options(
    version: Annotated[bool, typer.Option("--version", is_eager=True, help="Print the version and stop.")] = False,
) -> None:
    """Options of the whole command."""
    if version:
        from importlib.metadata import version as version_of

        typer.echo(f"washboard {version_of('washboard')}")
        raise typer.Exit


@cache
def _command() -> Callable[..., int | None]:
    """The whole command with all its options, built once in a process."""
    _report_errors(app)
    return get_command(app)


def _report_errors(group: typer.Typer) -> None:
    """Let every command end as ``job_errors`` states: there, since typer takes an interrupt for its own."""
    for command in group.registered_commands:
        command.callback = command.callback and job_errors()(with_places_checked(command.callback))
    for inner in group.registered_groups:
        if inner.typer_instance is not None:
            _report_errors(inner.typer_instance)


def main() -> None:
    """Run ``washboard``: whatever happens, it ends in an exit code and not in a traceback."""
    ending.begin()
    gc.set_threshold(400_000, 20, 100)  # a plan is many objects and hardly a circle: looking for them takes a twentieth
    for stream in (sys.stdin, sys.stdout):  # a terminal that knows only ASCII gets a mark in place of a letter, and
        if isinstance(stream, io.TextIOWrapper):  # what is typed in another encoding is no reason to stop listening
            stream.reconfigure(errors="replace")
    logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it logs where its cache is if no home can be written
    try:
        with job_errors():
            try:
                code = _command()(standalone_mode=False) or 0  # None unless something raised typer.Exit
            except UsageError as error:
                code = report_usage(error)
            finally:
                stdout = cast("TextIO | None", sys.stdout)
                if stdout is not None:  # a shell may have closed it: washboard >&-
                    stdout.flush()  # here a closed pipe is distinct from a defect; at exit it would not be
            sys.exit(code)
    except typer.Exit as end:
        sys.exit(end.exit_code)
