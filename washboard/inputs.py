"""Opening what a job is made of: workpieces, recipes, cells, and programs with what they were planned for."""

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Board, Workpiece
from boards.errors import BoardError
from boards.load import PANEL_SUFFIX, SUFFIXES, board_library, load_board
from boards.part.sources import PART_SUFFIXES, part_library
from boards.parts_table.read import Tables, tables_of
from boards.workpiece import load_workpiece
from programs.load import load_program
from programs.program import TimedProgram
from recipes.errors import RecipeError
from recipes.load import RECIPE, LoadedRecipe, load_recipe, read_recipe_text, recipe_library, recipe_sha256
from recipes.recipe import Recipe
from recipes.rewrite import write_values
from specs.confinement import find_beside
from specs.errors import printable
from specs.finding import Finding
from specs.finding_rules import BOARD_DIFFERS, RECIPE_DIFFERS
from specs.output_file import OutputFile
from specs.progress import Progress, no_progress
from specs.source import Source
from specs.yaml.edit import edited_text
from specs.yaml.load import find_file, read_text
from specs.yaml.tree import Tree

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell

_SHOWN = 16
"""Digits of a fingerprint."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class OpenedRecipe:
    """A recipe with its text. An edit gives another one; this one stays as it is."""

    text: str
    """YAML, with its comments."""
    file: Path
    """Where it was read; files that it extends are looked for beside it."""
    loaded: LoadedRecipe

    @property
    def recipe(self) -> Recipe:
        """All its values."""
        return self.loaded.recipe

    def edit(self, path: str | Mapping[str, Tree], value: Tree = None) -> "OpenedRecipe":
        """Give the recipe with other values, checked as its file is.

        Args:
            path: Of one value, such as ``"templates.around.speed_mm_s"``; or several with their values.
            value: The new value of a single path; ``None`` takes out what stands there.

        Raises:
            RecipeError: a value is refused, or cannot be written there; the message has the path.
        """
        values = {path: value} if isinstance(path, str) else path
        text = write_values(self.text, self.file, {Source(entry=key).recipe_path: new for key, new in values.items()})
        with edited_text(self.file):
            return OpenedRecipe(text, self.file, read_recipe_text(text, file=self.file))

    def save(self, file: str | Path) -> Path:
        """Write the text, in a file beside what it extends.

        Raises:
            OutputError: it cannot be written.
        """
        from recipes.start import place_recipe

        OutputFile(Path(file)).write(place_recipe(self.text, self.file, Path(file)))
        return Path(file)

    def __repr__(self) -> str:
        return f"<recipe {self.recipe.recipe}>"

    def html(self) -> str:
        """The text, for a notebook."""
        return f"<pre>{escape(self.text)}</pre>"

    _repr_html_ = html


@dataclass(frozen=True, slots=True, eq=False)
class OpenedProgram:
    """A program that was read, with the workpiece and the recipe that it was planned for."""

    program: TimedProgram
    file: Path
    workpiece: Workpiece
    recipe: Recipe
    differences: tuple[Finding, ...]
    """Between workpiece and recipe and those that the program states."""


def open_board(source: str | Path, parts: Tables = None, progress: Progress = no_progress) -> Board:
    """Open a board or a panel.

    Args:
        source: Name of a sample board, or a file.
        parts: Placement and BOM tables to join to it by designator.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: it cannot be found, read or used.
    """
    return load_board(Path(source), parts, progress)


def open_workpiece(
    source: str | Path,
    recipe: "OpenedRecipe | Recipe | None" = None,
    parts: Tables = None,
    progress: Progress = no_progress,
) -> Workpiece:
    """Open a board, a panel, a part or the points of a scan.

    Args:
        source: Name of a sample, or a file.
        recipe: A mesh is a part where this recipe follows the faces of parts, and a board otherwise.
        parts: Placement and BOM tables to join to a board.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: it cannot be found, read or used.
    """
    known = recipe.recipe if isinstance(recipe, OpenedRecipe) else recipe
    return load_workpiece(source, parts, progress, over_faces=known is not None and known.over_faces)


def open_recipe(source: str | Path) -> OpenedRecipe:
    """Open a recipe of the library by its name, or a file.

    Raises:
        RecipeError: it cannot be found or used.
    """
    file = find_file(source, RECIPE)
    text = read_text(file, RECIPE)
    return OpenedRecipe(text, file, read_recipe_text(text, file=file))


def open_cell(source: "str | Path | LoadedCell") -> "LoadedCell":
    """Open a robot cell of the library by its name, or a file; one that is open stays as it is.

    Raises:
        CellError: it cannot be found or used.
    """
    from robotcell.cell.load import LoadedCell, read_cell  # late: a plan without a cell needs no robot

    return source if isinstance(source, LoadedCell) else read_cell(source)


def open_program(
    file: str | Path,
    workpiece: str | Path | None = None,
    recipe: str | Path | None = None,
    parts: Tables = None,
    progress: Progress = no_progress,
    *,
    again: str = "open_program({file!r}, WORKPIECE)",
) -> OpenedProgram:
    """Open a native program with its workpiece and its recipe.

    Args:
        file: The program.
        workpiece: Name or file; left out, it is looked for among the samples and beside the program.
        recipe: Likewise.
        parts: Tables that are joined to a board.
        progress: Receives the stage and the share done.
        again: How a workpiece is named that was not found.

    Raises:
        JobError: one of them cannot be used or was not found, or the workpiece is another than the program's.
    """
    path = Path(file)
    program = load_program(path)
    planned = find_recipe(program, path) if recipe is None else load_recipe(recipe)
    found = open_workpiece_of(program, path, workpiece, parts, progress)
    if found is None:
        noun = "part" if planned.over_faces else "board"
        name = again.format(file=printable(str(path)))
        message = f"the {noun} {program.origin.board!r} of this program was not found. Name it: {name}."
        raise BoardError(message, file=path)
    require_workpiece(program, path, found)
    return OpenedProgram(program, path, found, planned, tuple(find_differences(program, found, planned)))


def open_workpiece_of(
    program: TimedProgram,
    file: Path,
    named: str | Path | None = None,
    parts: Tables = None,
    progress: Progress = no_progress,
) -> Workpiece | None:
    """Open the workpiece that was named, or look for that of a program.

    A mesh is a part where the program was planned on just that part.

    Args:
        program: States its workpiece.
        file: Where the program was read.
        named: Name or file; left out, what is found among the samples and beside the program, with the fingerprint that
            the program states.
        parts: Tables that are joined to a board, as they were when the program was planned.
        progress: Receives the stage and the share done.

    Returns:
        ``None`` where none was named and none was found.

    Raises:
        BoardError: what was named, or the table, cannot be used.
    """
    if named is None:
        found = find_workpiece(program, file, parts, progress)
        if (tables := tables_of(parts)) and (found is None or found.faces):
            reason = (
                f"{found.name} is a part" if found is not None else f"{program.origin.board} was planned without it"
            )
            raise BoardError(
                f"this table is for a board, and {reason}. Leave it out, or name its board.", file=tables[0]
            )
        return found
    if not tables_of(parts) and str(named).lower().endswith(PART_SUFFIXES):
        from boards.part.load import load_part  # late: boards need none of its libraries

        with suppress(BoardError):  # it may be a board
            part = load_part(named, progress)
            if part.sha256 == program.origin.board_sha256:
                return part
    return load_workpiece(named, parts, progress)


def find_workpiece(
    program: TimedProgram, file: Path, parts: Tables = None, progress: Progress = no_progress
) -> Workpiece | None:
    """Look for the workpiece of a program among the samples and beside it; its fingerprint must be the same.

    Returns:
        ``None`` where there is none of its name, or only with another fingerprint.

    Raises:
        BoardError: the table cannot be used, or the only files of its name cannot be read.
    """
    origin = program.origin
    unread: dict[Path, BoardError] = {}
    for place in _places(origin.board, file, board_library(), (*SUFFIXES, PANEL_SUFFIX)):
        try:
            board = load_board(place, parts, progress)
        except BoardError as error:
            if error.file in tables_of(parts):
                raise
            unread[place] = error  # what cannot be read is not what was planned, but perhaps it was
            continue
        if board.sha256 == origin.board_sha256:
            return board
    for place in _places(origin.board, file, part_library(), PART_SUFFIXES):
        from boards.part.load import load_part

        try:
            part = load_part(place, progress)
        except BoardError as error:
            unread[place] = error
            continue
        if part.sha256 == origin.board_sha256:
            return part
        unread.pop(place, None)
    for error in unread.values():
        reason = str(error).partition("\n")[0].rstrip(".")
        message = (
            f"{origin.board!r}, on which this program was planned, was not found: {reason}. Mend or remove that file"
        )
        raise BoardError(f"{message}, or name another.", file=file)
    return None


def find_recipe(
    program: TimedProgram, file: Path, advice: str = "Name it with --recipe, or plan the board again."
) -> Recipe:
    """Look for the recipe of a program in the library and beside the program; its fingerprint must be the same.

    Args:
        program: States the recipe.
        file: Where the program was read.
        advice: What to do where it is not found.

    Raises:
        RecipeError: it is not there, cannot be used, or has been changed since.
    """
    name, sha256 = program.origin.recipe, program.origin.recipe_sha256
    reason = "it is neither in the library nor beside the program"
    for place in _places(name, file, recipe_library(), (".yaml", ".yml")):
        try:
            recipe = load_recipe(place)
        except RecipeError as error:  # what cannot be used is not the recipe that was planned
            reason = str(error).partition("\n")[0].rstrip(".")
            continue
        if recipe_sha256(recipe) == sha256:
            return recipe
        reason = f"{place} has changed since"
    message = f"the recipe {name!r} of this program (sha256 {sha256[:_SHOWN]}) was not found: {reason}. {advice}"
    raise RecipeError(message, file=file)


def _places(name: str, file: Path, library: Mapping[str, Path], suffixes: tuple[str, ...]) -> list[Path]:
    """Where an input of that name may be: in the library, or beside the program."""
    found = [library[name]] if name in library else []
    for suffix in suffixes:
        with suppress(ValueError):  # a program names what lies in its folder and nothing else
            path = find_beside(f"{name}{suffix}", file)
            found += [path] if path.is_file() else []
    return found


def require_workpiece(program: TimedProgram, file: Path, workpiece: Workpiece, *, exactly: bool = False) -> None:
    """Refuse a workpiece of another name and content than the one that a program, read from a file, was planned on.

    Args:
        program: States its workpiece.
        file: Where the program was read.
        workpiece: The board or part.
        exactly: Refuse other versions of the same one too.

    Raises:
        BoardError: it is another one.
    """
    origin, name = program.origin, workpiece.name
    planned, given = origin.board_sha256[:_SHOWN], workpiece.sha256[:_SHOWN]
    if workpiece.sha256 == origin.board_sha256:
        return
    if name != origin.board:
        raise BoardError(
            f"this program was made for the board {origin.board} (sha256 {planned}), not for {name} "
            f"(sha256 {given}). Give its own board, or plan {name}.",
            file=file,
        )
    if exactly:
        message = f"this program was made for another version of {name} (sha256 {planned}, not {given}). Plan it again."
        raise BoardError(message, file=file)


def find_differences(program: TimedProgram, workpiece: Workpiece, recipe: Recipe | None = None) -> list[Finding]:
    """Compare workpiece and recipe with those that a program was planned with; a finding for each that differs."""
    found: list[Finding] = []
    origin = program.origin
    if workpiece.sha256 != origin.board_sha256:
        message = (
            f"{workpiece.name} (sha256 {workpiece.sha256[:_SHOWN]}) differs from the board of this program, "
            f"{origin.board} (sha256 {origin.board_sha256[:_SHOWN]}), on which its paths were planned. Plan it again."
        )
        found.append(Finding(BOARD_DIFFERS, message))
    if recipe is not None and recipe_sha256(recipe) != origin.recipe_sha256:
        message = (
            f"{recipe.recipe} (sha256 {recipe_sha256(recipe)[:_SHOWN]}) differs from the recipe of this program: its "
            "nozzles and functions are used, its paths are not. Plan it again."
        )
        found.append(Finding(RECIPE_DIFFERS, message))
    return found
