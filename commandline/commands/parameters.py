"""``washboard parameters``: look at the parameter sets of the cleaning model, check one, get the schema."""

import typer

from commandline.arguments import ParametersSource
from commandline.errors import job_errors

app = typer.Typer(help="Look at parameter sets of the cleaning model, check one, get the schema.", no_args_is_help=True)


@app.command("list")
def list_parameters() -> None:
    """List the parameter sets that come with Washboard."""
    with job_errors():
        from cleaning.parameters.load import load_parameters, parameter_library
        from commandline.loading import print_library

        print_library({name: load_parameters(name).description for name in parameter_library()})


@app.command()
def show(source: ParametersSource = "default") -> None:
    """Show a set: every value, how it is known and from where, and the file and line it was written on.

    [dim]washboard parameters show water-soluble
    washboard parameters show my-line.yaml[/dim]
    """
    with job_errors():
        from cleaning.parameters.load import read_parameters
        from reports.terminal.console import open_console
        from reports.terminal.spec_card import print_parameters

        print_parameters(open_console(), read_parameters(source))


@app.command()
def schema() -> None:
    """Print the JSON schema; an editor that knows it completes keys and marks mistakes.

    [dim]washboard parameters schema > parameters.schema.json[/dim]
    """
    with job_errors():
        from cleaning.parameters.schema import parameters_schema

        typer.echo(parameters_schema().encode(), nl=False)  # UTF-8 whatever encoding the terminal has


@app.command()
def keys() -> None:
    """Print every key of a parameter set with its default and meaning, as Markdown."""
    with job_errors():
        from cleaning.parameters.schema import parameters_keys

        typer.echo(parameters_keys().encode(), nl=False)
