"""``washboard parameters``: look at the parameter sets of the cleaning model, check one, get the schema."""

import typer

from commandline.arguments import ParametersSource

app = typer.Typer(help="Look at parameter sets of the cleaning model, check one, get the schema.", no_args_is_help=True)


@app.command("list")
def list_parameters() -> None:
    """List the parameter sets that come with Washboard, the solutions that recipes may name, and fluxes."""
    from cleaning.parameters.chemistries import chemistries, fluxes
    from cleaning.parameters.load import load_parameters, parameter_library
    from commandline.loading import print_library

    sets = {name: load_parameters(name).description for name in parameter_library()}
    solutions = {name: each.description for name, each in chemistries().items()}
    liquid = {name: f"{each.solids_pct:g} % solids. {each.description}" for name, each in fluxes().items()}
    width = max(map(len, (*sets, *solutions, *liquid)))
    typer.echo("parameter sets, one for each flux or published coupons (--parameters NAME, or extends: NAME)")
    print_library(sets, "  ", width)
    typer.echo("solutions (solution: NAME in a recipe; a set that has the name under liquids has precedence)")
    print_library(solutions, "  ", width)
    typer.echo("liquid fluxes (bath --flux NAME:MILLILITRES)")
    print_library(liquid, "  ", width)


@app.command()
def show(source: ParametersSource = "default") -> None:
    """Show a set, a solution or a flux: every value, how it is known and from where, and where it was written.

    [dim]washboard parameters show water-soluble
    washboard parameters show amine-alkoxypropanol
    washboard parameters show my-line.yaml[/dim]
    """
    from cleaning.parameters.chemistries import chemistries, fluxes
    from cleaning.parameters.load import read_parameters
    from reports.cards.specs import chemistry_card, parameters_card
    from reports.terminal.console import open_console, print_card

    library = {**chemistries(), **fluxes()}
    if source in library:
        print_card(open_console(), chemistry_card(source, library[source]))
    else:
        print_card(open_console(), parameters_card(read_parameters(source)))


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard parameters schema > parameters.schema.json[/dim]
    """
    from cleaning.parameters.load import parameters_schema

    typer.echo(parameters_schema().encode(), nl=False)  # UTF-8 whatever encoding the terminal has


@app.command()
def keys() -> None:
    """Print every key of a parameter set with its default and meaning, as Markdown."""
    from cleaning.parameters.load import parameters_keys

    typer.echo(parameters_keys().encode(), nl=False)
