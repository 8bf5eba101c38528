"""Arguments and options that several commands share, and what the shell completes for them."""

from pathlib import Path
from typing import Annotated

import typer

import boards
import cleaning
import recipes
import robotcell


def complete_board(incomplete: str) -> list[str]:
    """Names of the sample boards; the shell itself offers files. Listed without loading what reads boards."""
    library = Path(boards.__path__[0]) / "library"
    names = sorted(file.name.split(".")[0] for file in library.iterdir() if ".tri" in file.suffixes)
    return [name for name in names if name.startswith(incomplete)]


def complete_recipe(incomplete: str) -> list[str]:
    """Names of the library's recipes; the shell itself offers files."""
    library = Path(recipes.__path__[0]) / "library"
    return sorted(file.stem for file in library.glob("*.yaml") if file.stem.startswith(incomplete))


def complete_cell(incomplete: str) -> list[str]:
    """Names of the library's cells; the shell itself offers files."""
    library = Path(robotcell.__path__[0]) / "library" / "cells"
    return sorted(file.stem for file in library.glob("*.yaml") if file.stem.startswith(incomplete))


def complete_parameters(incomplete: str) -> list[str]:
    """Names of the library's parameter sets; the shell itself offers files."""
    library = Path(cleaning.__path__[0]) / "library"
    return sorted(file.stem for file in library.glob("*.yaml") if file.stem.startswith(incomplete))


BoardSource = Annotated[
    str,
    typer.Argument(
        help="Board file (.tri, STEP, GLB, STL, OBJ, PLY, IDF, KiCad) or the name of a sample board.",
        metavar="BOARD",
        autocompletion=complete_board,
    ),
]
RecipeSource = Annotated[
    str,
    typer.Argument(
        help="Recipe file, or the name of a library recipe.", metavar="RECIPE", autocompletion=complete_recipe
    ),
]
CellSource = Annotated[
    str,
    typer.Argument(help="Cell file, or the name of a library cell.", metavar="CELL", autocompletion=complete_cell),
]
ParametersSource = Annotated[
    str,
    typer.Argument(
        help="File of a parameter set, or the name of one of the library.",
        metavar="PARAMETERS",
        autocompletion=complete_parameters,
    ),
]
MadeFor = Annotated[
    str | None,
    typer.Option(
        "--board",
        help="Board the program was made for, to look for collisions; found by itself among the samples and beside the "
        "program.",
        metavar="BOARD",
        autocompletion=complete_board,
    ),
]
Parts = Annotated[
    Path | None, typer.Option("--parts", help="Placement or BOM table (CSV) to join to the board.", metavar="CSV")
]
Picture = Annotated[Path | None, typer.Option("--picture", help="Picture to write.", metavar="PNG|SVG")]
