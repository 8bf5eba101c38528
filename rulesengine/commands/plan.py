"""``washboard classify``, ``plan`` and ``show``."""

from pathlib import Path
from typing import Annotated

import typer

from rulesengine.errors import job_errors

Board = Annotated[str, typer.Argument(help="Board file (.tri, STEP, GLB, IDF, KiCad …) or the name of a sample.")]
Recipe = Annotated[str, typer.Argument(help="Recipe file, or the name of a library recipe.")]
Parts = Annotated[
    Path | None, typer.Option("--parts", help="Placement or BOM table (CSV) to join to the board.", metavar="CSV")
]


def classify(board: Board, recipe: Recipe = "smt-aqueous", parts: Parts = None) -> None:
    """Show which class takes each component, and the rule that put it there.

    [dim]washboard classify smt-demo smt-aqueous[/dim]
    """
    with job_errors():
        from rich.console import Console
        from rich.markup import escape
        from rich.table import Table

        from recipes.load import load_recipe
        from rulesengine import classify as rules
        from rulesengine.commands.loading import read_board
        from rulesengine.summary import print_findings

        loaded_recipe = load_recipe(recipe)
        loaded = read_board(board, parts)
        classified, findings = rules.classify(loaded_recipe, loaded)
        _, mask_findings = rules.service(loaded_recipe, loaded)
        table = Table("component", "package", "class", "because", box=None, pad_edge=False, header_style="dim")
        for each, component in zip(classified, loaded.components, strict=True):
            row = (each.component, component.package, each.component_class, each.because)
            table.add_row(*(escape(cell) for cell in row))
        console = Console()
        console.print(table)
        print_findings(console, (*findings, *mask_findings))


def plan(
    board: Board,
    recipe: Recipe = "smt-aqueous",
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Program to write.", metavar="OUT.wash")] = None,
    picture: Annotated[
        Path | None, typer.Option("--picture", help="Picture of the paths to write.", metavar="PNG|SVG")
    ] = None,
    report: Annotated[Path | None, typer.Option("--report", help="Report to write.", metavar="JSON")] = None,
    parts: Parts = None,
    allow: Annotated[
        list[str] | None, typer.Option("--allow", help="Write the program in spite of errors of this rule.")
    ] = None,
) -> None:
    """Plan a board: read it, follow the recipe, write the timed program and say what came out.

    [dim]washboard plan smt-demo smt-aqueous -o demo.wash --picture demo.png
    washboard plan board.step my-recipe.yaml --parts placement.csv -o board.wash --report board.json[/dim]
    """
    with job_errors():
        from rich.console import Console

        from rulesengine.commands.loading import read_and_run
        from rulesengine.commands.writing import write_run
        from rulesengine.summary import print_run

        done = read_and_run(board, recipe, parts)
        console = Console()
        print_run(console, done)
        write_run(done, output=output, picture=picture, report_file=report, allowed=allow or [])
        for name, path in (("Program", output), ("Picture", picture), ("Report", report)):
            if path is not None:
                console.print(f"{name}: {path}", highlight=False, soft_wrap=True)


def show(
    program: Annotated[Path, typer.Argument(help="Native program (.wash).")],
) -> None:
    """Read a program back and say what it does.

    [dim]washboard show board.wash[/dim]
    """
    with job_errors():
        from rich.console import Console

        from programs.load import load_program
        from rulesengine.summary import print_program

        print_program(Console(), load_program(program))
