"""Arguments and options that several commands share, and what the shell completes for them."""

from collections.abc import Callable
from contextlib import nullcontext
from functools import wraps
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Literal, TypeAlias, cast, get_args, get_type_hints

import typer

import boards
import cleaning
import recipes
import robotcell
from specs.confinement import record_reads, resolve
from specs.input_file import InputFile
from specs.output_file import OutputFile, OutputFolder, OutputPlace


def input_name(value: str) -> str:
    """Read what a command reads: a file, or a name of a library.

    Raises:
        JobError: it is a pipe, a device, a socket, or a link that leads nowhere.
    """
    InputFile(Path(value)).check_kind()
    return value


def input_path(value: str) -> Path:
    """Read the path of what a command reads; errors are those of ``input_name``."""
    return Path(input_name(value))


def output_file(kind: str = "", *beside: str, in_place: bool = False) -> Callable[[str], OutputFile]:
    """Give the parser of a file that a command writes, with its kind and the endings of those that grow beside it."""

    def place(value: str) -> OutputFile:
        return OutputFile(Path(value), kind, beside, in_place)

    return place


def output_folder(only: str = "") -> Callable[[str], OutputFolder]:
    """Give the parser of a folder that a command writes into, with the pattern of its files if it replaces a set."""

    def place(value: str) -> OutputFolder:
        return OutputFolder(Path(value), only)

    return place


def with_places_checked(command: Callable[..., object]) -> Callable[..., object]:
    """Check the places of a command's outputs before it begins: writable, none of its inputs, no two of them one."""

    @wraps(command)
    def checked(**given: object) -> object:
        values = [each for value in given.values() for each in _listed(value)]
        places = [each for each in values if isinstance(each, OutputPlace)]
        own = check(given, places) if places else []
        written = [file.path for each in places if isinstance(each, OutputFile) for file in each.all_written]
        with record_reads(*own, written=written) if places else nullcontext():  # outputs are none of what inputs name
            return command(**given)

    def check(given: dict[str, object], places: list[OutputPlace]) -> list[Path]:
        """Give the outputs that may be read: of a run that goes on, and the file that is edited in its place."""
        from reports.files.write_run import check_places

        read = [
            (cast("str | Path | None", each), metavar)
            for name, metavar in inputs_of(command).items()
            for each in _listed(given[name])
        ]
        cell = next((each for each, metavar in read if metavar == "CELL"), None)
        check_places([each for each, _ in read], places, edited=cell)
        files = [each for each in places if isinstance(each, OutputFile)]
        edited = cell is not None and resolve(Path(cell))
        resumed = given.get("output") if given.get("resume") else None
        return [each.path for each in files if each is resumed or (each.in_place and resolve(each.path) == edited)]

    return checked


def _listed(value: object) -> list[object]:
    """What an option holds that may be given again."""
    return cast("list[object]", value) if isinstance(value, list) else [value]


def inputs_of(command: Callable[..., object]) -> dict[str, str]:
    """Give the names of a command's parameters that are read, by their parsers; with what stands for each."""
    hints = get_type_hints(command, include_extras=True)
    given = [(name, each) for name, hint in hints.items() for each in get_args(hint)[1:] if hasattr(each, "parser")]
    return {name: str(each.metavar) for name, each in given if each.parser in (input_name, input_path)}


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
complete_reference = _completer(cleaning, "library", "validation", suffix="")
_LIBRARIES = {
    "BOARD": complete_board, "[BOARD]": complete_board, "PART": complete_part, "RECIPE": complete_recipe,
    "RECIPE|PROGRAM.wash": complete_recipe, "CELL": complete_cell, "PARAMETERS": complete_parameters,
    "REFERENCE": complete_reference, "PROGRAM|PART": None,
}  # fmt: skip
"""Of what may be the name of one of a library, by what stands for it in the help: what completes it"""
_KINDS = {"PNG|SVG": "a picture", "OUT.wash": "a program", "JSON": "a report", "HTML": "a page",
          "OUT.yaml": "a YAML file", "NEW.yaml": "a YAML file", "PAGE.md": "a page"}  # fmt: skip
"""Of files that are written"""


def input_option(flags: str, metavar: str, about: str) -> Any:
    """Give an option that names what a command reads: a file, or one of a library where there is one."""
    return typer.Option(*flags.split(), help=about, metavar=metavar, **_read(metavar))


def input_argument(metavar: str, about: str) -> Any:
    """Give an argument that names what a command reads."""
    return typer.Argument(help=about, metavar=metavar, **_read(metavar))


def _read(metavar: str) -> dict[str, Any]:
    parser = input_name if metavar in _LIBRARIES else input_path
    return {"autocompletion": _LIBRARIES.get(metavar), "parser": parser}


def output_option(flags: str, metavar: str, about: str, *beside: str, in_place: bool = False) -> Any:
    """Give an option that names a file to write, with the endings of those that grow beside it."""
    parser = output_file(_KINDS.get(metavar, ""), *beside, in_place=in_place)
    return typer.Option(*flags.split(), help=about, metavar=metavar, parser=parser)


BoardSource = Annotated[
    str,
    input_argument(
        "BOARD",
        "Board file (.tri, STEP, GLB, STL, OBJ, PLY, IDF, KiCad, Eagle, IPC-2581, ODB++, Gerber) "
        "or the name of a sample board.",
    ),
]
RecipeSource = Annotated[str, input_argument("RECIPE", "Recipe file, or the name of a library recipe.")]
CellSource = Annotated[str, input_argument("CELL", "Cell file, or the name of a library cell.")]
CellOption = Annotated[
    str | None,
    input_option(
        "--cell", "CELL", "Cell whose robot carries the program out: its limits hold besides those of the recipe."
    ),
]
CellName = Annotated[str | None, input_option("--cell", "CELL", "Cell file, or the name of a library cell.")]
Allow = Annotated[
    list[str] | None,
    typer.Option("--allow", help="Go on in spite of errors of this rule; may be repeated.", metavar="RULE"),
]
ParametersSource = Annotated[
    str, input_argument("PARAMETERS", "File of a parameter set, or the name of one of the library.")
]
ParametersOption = Annotated[
    str, input_option("--parameters", "PARAMETERS", "Parameter set of the cleaning model: a name or a file.")
]
ProgramSource = Annotated[Path, input_argument("PROGRAM.wash", "Native program.")]
ProgramBoard = Annotated[
    str | None,
    input_option(
        "--board",
        "BOARD",
        "Board of the program, for collisions; left out, it is looked for among the samples and beside the program.",
    ),
]
ProgramRecipe: TypeAlias = Annotated[
    str | None,
    input_option(
        "--recipe", "RECIPE", "Recipe of the program; left out, it is looked for in the library and beside the program."
    ),
]
VerdictOption = Annotated[
    bool,
    typer.Option(
        "--verdict",
        help="Judge too what comes out clean, as planned and as the controller drives it by its model: an analysis, "
        "which needs board and recipe.",
    ),
]
Effort: TypeAlias = Literal["fast", "full"]
EffortOption = Annotated[
    Effort, typer.Option("--effort", help="fast: 64 rays a sample; full: 256 rays, and samples twice as dense.")
]
Parts = Annotated[
    list[Path] | None,
    input_option("--parts", "CSV", "Placement or BOM table, or netlist, to join to the board; may be given again."),
]
Picture = Annotated[OutputFile | None, output_option("--picture", "PNG|SVG", "Picture to write.")]
ProgramOutput = Annotated[OutputFile | None, output_option("--output -o", "OUT.wash", "Program to write.")]
DataOutput = Annotated[OutputFile | None, output_option("--json", "JSON", "The same as data.")]

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
    if (
        not found
        or len(found) > _MOST_NUMBERS
        or not all(word.isdecimal() and len(word) < 10 and int(word) for word in found)
    ):
        raise JobError(f"--boards {words}: give 1 to {_MOST_NUMBERS} whole numbers from 1 on, such as 1,100,400.")
    return sorted({int(word) for word in found})


NoToken = Annotated[
    bool,
    typer.Option(
        "--no-token", help="Serve the page without a token: every user of this machine can then use it as you can."
    ),
]


def complete_dialect(incomplete: str) -> list[str]:
    """Names of the dialects."""
    from programs.posts.dialects import DIALECTS

    return [name for name in DIALECTS if name.startswith(incomplete)]


DialectOption = Annotated[
    str | None,
    typer.Option(
        "--dialect",
        help="Language of the controller; left out, that of the robot's maker. `washboard export --list` names them.",
        autocompletion=complete_dialect,
    ),
]
