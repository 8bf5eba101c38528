"""Arguments and options that several commands share, and what the shell completes for them."""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Annotated, Literal, TypeAlias

import typer

import boards
import cleaning
import recipes
import robotcell


def _completer(package: ModuleType, *folders: str, suffix: str = ".yaml") -> Callable[[str], list[str]]:
    """Complete names of a library; the shell itself offers files. They are listed without loading what reads them."""

    def complete(incomplete: str) -> list[str]:
        library = Path(package.__path__[0]).joinpath(*folders)
        names = sorted(file.name.split(".")[0] for file in library.iterdir() if suffix in file.suffixes)
        return [name for name in names if name.startswith(incomplete)]

    return complete


complete_board = _completer(boards, "library", suffix=".tri")
complete_part = _completer(boards, "part", "library")
complete_recipe = _completer(recipes, "library")
complete_cell = _completer(robotcell, "library", "cells")
complete_parameters = _completer(cleaning, "library")

BoardSource = Annotated[
    str,
    typer.Argument(
        help="Board file (.tri, STEP, GLB, STL, OBJ, PLY, IDF, KiCad, Eagle, IPC-2581, ODB++, Gerber) "
        "or the name of a sample board.",
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
CellOption = Annotated[
    str | None,
    typer.Option(
        "--cell",
        help="Cell whose robot carries the program out: its limits hold besides those of the recipe.",
        metavar="CELL",
        autocompletion=complete_cell,
    ),
]
CellName = Annotated[
    str | None,
    typer.Option(
        "--cell", help="Cell file, or the name of a library cell.", metavar="CELL", autocompletion=complete_cell
    ),
]
Allow = Annotated[
    list[str] | None,
    typer.Option("--allow", help="Go on in spite of errors of this rule; may be repeated.", metavar="RULE"),
]
ParametersSource = Annotated[
    str,
    typer.Argument(
        help="File of a parameter set, or the name of one of the library.",
        metavar="PARAMETERS",
        autocompletion=complete_parameters,
    ),
]
ParametersOption = Annotated[
    str,
    typer.Option(
        "--parameters",
        help="Parameter set of the cleaning model: a name or a file.",
        metavar="PARAMETERS",
        autocompletion=complete_parameters,
    ),
]
ProgramSource = Annotated[Path, typer.Argument(help="Native program.", metavar="PROGRAM.wash")]
ProgramBoard = Annotated[
    str | None,
    typer.Option(
        "--board",
        help="Board of the program, for collisions; left out, it is looked for among the samples and beside the "
        "program.",
        metavar="BOARD",
        autocompletion=complete_board,
    ),
]
Effort: TypeAlias = Literal["fast", "full"]
EffortOption = Annotated[
    Effort, typer.Option("--effort", help="fast: 64 rays a sample; full: 256 rays, and samples twice as dense.")
]
Parts = Annotated[
    Path | None, typer.Option("--parts", help="Placement or BOM table (CSV) to join to the board.", metavar="CSV")
]
Picture = Annotated[Path | None, typer.Option("--picture", help="Picture to write.", metavar="PNG|SVG")]

_MOST_NUMBERS = 12
_MOST_FLUX_ML = 1000.0


def flux_in_mg(words: str, stated_mg: float | None) -> float | None:
    """Read what flux a board brings: as stated, or the solids of a liquid flux.

    Raises:
        JobError: the flux is unknown, its volume is no number, or both are given.
    """
    from cleaning.parameters.chemistries import fluxes
    from specs.errors import JobError
    from specs.yaml.schema import name_nearest

    if not words:
        return stated_mg
    name, _, volume = words.partition(":")
    if stated_mg is not None:
        raise JobError("give --flux or --flux-mg, not both: each states what a board brings.")
    if name not in fluxes():
        raise JobError(f"--flux {words}: unknown flux {name!r}; {name_nearest(name, list(fluxes()))}")
    try:
        millilitres = float(volume)
    except ValueError:
        millilitres = -1.0
    if not 0.0 <= millilitres <= _MOST_FLUX_ML:
        raise JobError(f"--flux {words}: give millilitres from 0 to {_MOST_FLUX_ML:g} after the name, as in {name}:3.")
    return 1e3 * fluxes()[name].solids_g(millilitres)


def board_numbers(words: str) -> list[int]:
    """Read the numbers of boards.

    Raises:
        JobError: one is no whole number from 1 on, or there are too many.
    """
    from specs.errors import JobError

    found = [word.strip() for word in words.split(",") if word.strip()]
    if not found or len(found) > _MOST_NUMBERS or not all(word.isdecimal() and 0 < int(word) < 10**9 for word in found):
        raise JobError(f"--boards {words}: give 1 to {_MOST_NUMBERS} whole numbers from 1 on, such as 1,100,400.")
    return sorted({int(word) for word in found})
