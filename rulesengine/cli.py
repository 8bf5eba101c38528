"""The command line; each command imports what it needs when it runs, so that help is quick."""

from typing import Annotated

import typer

from rulesengine.commands import board, demo, plan, recipe

app = typer.Typer(
    name="washboard",
    help="Program robots that spray-clean printed circuit boards: CAD and a recipe in, a timed nozzle program out.",
    epilog="Start with: washboard demo",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)
app.add_typer(board.app, name="board")
app.add_typer(recipe.app, name="recipe")
app.command("classify")(plan.classify)
app.command("plan")(plan.plan)
app.command("show")(plan.show)
app.command("demo")(demo.demo)


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        typer.echo(f"washboard {version('washboard')}")
        raise typer.Exit


@app.callback()
def _options(
    _: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and stop.")
    ] = False,
) -> None:
    """Options of the whole command."""


def main() -> None:
    """Run ``washboard``."""
    app()
