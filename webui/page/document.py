"""What is being edited, with its file and its history: the text of a recipe, and a cell."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE, LoadedRecipe, read_recipe_text, recipe_library
from recipes.start import place_recipe
from robotcell.cell.cell_edits import CellEdit, apply_edits
from robotcell.cell.load import CELL, LoadedCell, cell_sha256, read_cell_text
from robotcell.errors import CellError
from specs.output_file import OutputFile
from specs.yaml.load import find_file, read_text

_MOST_UNDO = 200


@dataclass(frozen=True, slots=True)
class Document:
    """Text of a recipe with its undo and redo history."""

    file: Path
    """File that it is read from and saved to, unless it belongs to the library."""
    text: str
    saved: str
    """Text of the file when it was opened or saved last."""
    past: tuple[str, ...] = ()
    future: tuple[str, ...] = ()

    @property
    def belongs_to_library(self) -> bool:
        """Whether it needs a file of its own before it can be saved."""
        return self.file in recipe_library().values()

    @property
    def dirty(self) -> bool:
        """Whether there is something to save."""
        return self.text != self.saved

    def read(self) -> LoadedRecipe:
        """Read the text.

        Raises:
            RecipeError: it cannot be used.
        """
        return read_recipe_text(self.text, file=self.file)

    def edited(self, text: str) -> "Document":
        """Document with another text, which is not checked; the same text changes nothing."""
        if text == self.text:
            return self
        return replace(self, text=text, past=(*self.past, self.text)[-_MOST_UNDO:], future=())

    def undone(self) -> "Document":
        """Go back one edit, if there is one."""
        if not self.past:
            return self
        return replace(self, text=self.past[-1], past=self.past[:-1], future=(self.text, *self.future))

    def redone(self) -> "Document":
        """Go forward one edit that was undone, if there is one."""
        if not self.future:
            return self
        return replace(self, text=self.future[0], past=(*self.past, self.text), future=self.future[1:])

    def on_disk(self) -> str | None:
        """Present text of the file; ``None`` where it cannot be read."""
        try:
            return read_text(self.file, RECIPE)
        except RecipeError:
            return None

    def changed_on_disk(self) -> bool:
        """Whether the file was changed elsewhere since it was opened or saved here."""
        return self.on_disk() != self.saved

    def reload(self) -> "Document":
        """Load the file again; it can be undone.

        Raises:
            RecipeError: it cannot be read.
        """
        text = read_text(self.file, RECIPE)
        return replace(self.edited(text), saved=text)

    def save(self) -> "Document":
        """Write the file, whatever stands there.

        Raises:
            RecipeError: it belongs to the library.
            OutputError: it cannot be written.
        """
        if self.belongs_to_library:
            raise RecipeError(f"{self.file.stem} belongs to the library; save it under a name of your own")
        OutputFile(self.file).write(self.text)
        return replace(self, saved=self.text)

    def save_as(self, file: Path) -> "Document":
        """Write a new file, named after it inside too.

        Raises:
            RecipeError: the file exists, or its name cannot name a recipe.
            OutputError: it cannot be written.
        """
        if file.exists():
            raise RecipeError("is there already; choose another name", file=file)
        text = place_recipe(self.text, self.file, file)
        OutputFile(file).write(text)
        return replace(self, file=file, text=text, saved=text, past=(*self.past, self.text)[-_MOST_UNDO:], future=())


def open_document(source: str | Path) -> Document:
    """Open a recipe of the library or of a file.

    Raises:
        RecipeError: it cannot be read.
    """
    file = find_file(source, RECIPE)
    text = read_text(file, RECIPE)
    read_recipe_text(text, file=file)
    return Document(file=file, text=text, saved=text)


@dataclass(frozen=True, slots=True, eq=False)
class NamedCell:
    """A cell, and its name in the project's list."""

    name: str
    loaded: LoadedCell


@dataclass(frozen=True, slots=True, eq=False)
class CellChange:
    """An edit of a cell, in its file or in a copy of it in the project folder."""

    before: NamedCell
    after: NamedCell
    file: Path
    """The file that has the edit."""
    text_before: str | None
    """Its text without the edit; ``None`` where it is a copy."""
    text_after: str
    recipe_past: tuple[str, ...]
    """Undo history of the recipe when the edit was made: both are undone in the order in which they were made."""

    def write(self) -> None:
        """Write the edit.

        Raises:
            CellError: the file was changed elsewhere since.
            OutputError: it cannot be written.
        """
        self._require(self.text_before)
        OutputFile(self.file).write(self.text_after)

    def take_back(self) -> None:
        """Write the file as it was; a copy is removed.

        Raises:
            CellError: the file was changed elsewhere since.
            OutputError: it cannot be written.
        """
        self._require(self.text_after)
        if self.text_before is not None:
            OutputFile(self.file).write(self.text_before)
        else:
            OutputFile(self.file).remove()

    def _require(self, text: str | None) -> None:
        if (read_text(self.file, CELL) if self.file.exists() else None) != text:
            raise CellError("was changed elsewhere since; choose the cell again, then check it", file=self.file)


def plan_change(
    cell: NamedCell, edits: Iterable[CellEdit], named: tuple[str, Path], past: tuple[str, ...]
) -> CellChange:
    """Make the edit of a cell; nothing is written.

    Args:
        cell: The cell as it is.
        edits: The edits, not empty.
        named: Name in the project's list, and the file, that the edited cell gets: its own, or those of a copy.
        past: Undo history of the recipe.

    Raises:
        CellError: the file was changed since it was read, or it is no cell with the edits, or the copy would not find
            the files that it names.
    """
    name, file = named
    own = Path(cell.loaded.root.mark.file)
    text = read_text(own, CELL)
    if cell_sha256(read_cell_text(text, file=own)) != cell_sha256(cell.loaded):
        raise CellError("was changed since it was read; choose the cell again, then check it", file=own)
    edited = apply_edits(text, edits, own)
    in_place = file.resolve() == own.resolve()
    after = NamedCell(name, read_cell_text(edited, file=file))
    return CellChange(cell, after, file, text if in_place else None, edited, past)
