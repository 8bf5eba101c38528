"""``washboard recipe``: begin a recipe, check it, look at it."""

from pathlib import Path
from typing import Annotated

import typer

from commandline.arguments import RecipeSource, output_option
from specs.output_file import OutputFile

app = typer.Typer(help="Begin a recipe, check it, look at it.", no_args_is_help=True)


@app.command("list")
def list_recipes() -> None:
    """List the recipes that come with Washboard."""
    from commandline.loading import print_library
    from recipes.load import load_recipe, recipe_library

    print_library({name: load_recipe(name).description for name in recipe_library()})


@app.command()
def new(
    source: RecipeSource = "smt-aqueous",
    output: Annotated[
        OutputFile | None, output_option("--output -o", "OUT.yaml", "File to write; the recipe is named after it.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite the file if it exists.")] = False,
) -> None:
    """Write a commented recipe to begin with: a copy of one from the library, or of a file.

    [dim]washboard recipe new -o my-board.yaml
    washboard recipe new low-standoff -o my-board.yaml[/dim]
    """
    from recipes.start import start_recipe
    from reports.files.write_run import check_places
    from specs.errors import printable
    from specs.output_file import OutputError

    file = output or OutputFile(Path(f"{Path(source).stem}.yaml"))
    if file.path.exists() and not force:
        raise OutputError(file.path, "it exists", "Name another file, or overwrite it with --force.")
    check_places([source], [file])
    file.write(start_recipe(source, file.path))
    shown = printable(str(file.path))
    typer.echo(f"{shown}: edit it, then run `washboard recipe check {shown}`")


@app.command()
def check(source: RecipeSource) -> None:
    """Check a recipe: the first mistake with its file, line and YAML path; then what is probably a mistake.

    [dim]washboard recipe check my-board.yaml[/dim]
    """
    from recipes.check import check_recipe
    from recipes.load import load_recipe
    from reports.tables.wording import amount

    recipe = load_recipe(source)
    findings = check_recipe(recipe)
    for finding in findings:
        typer.echo(f"{finding.severity}: {finding.made_by}: {finding.message} [{finding.rule.id}]")
    counts = [
        amount(sum(step.enabled for step in recipe.sequence), "step"),
        amount(len(recipe.templates), "template"),
        amount(len(recipe.classes), "class", "classes"),
        amount(len(findings), "finding"),
    ]
    typer.echo(f"{recipe.recipe}: can be used; {', '.join(counts)}")


@app.command()
def show(source: RecipeSource = "smt-aqueous") -> None:
    """Show a recipe with every value resolved, and the file and line each part was written on.

    [dim]washboard recipe show low-standoff[/dim]
    """
    from recipes.load import read_recipe
    from reports.cards.specs import recipe_card
    from reports.terminal.console import open_console, print_card

    print_card(open_console(), recipe_card(read_recipe(source)))


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard recipe schema > recipe.schema.json[/dim]
    """
    from recipes.schema import recipe_schema

    typer.echo(recipe_schema().encode(), nl=False)  # UTF-8 whatever encoding the terminal has


@app.command()
def keys() -> None:
    """Print every key of a recipe with its default and meaning, as Markdown."""
    from recipes.schema import recipe_keys

    typer.echo(recipe_keys().encode(), nl=False)
