"""A recipe that is being edited: its text, its file, its undo history."""

from dataclasses import dataclass, replace
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE, LoadedRecipe, read_recipe_text, recipe_library
from recipes.start import place_recipe
from reports.files.atomic_write import write_text_atomically
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
        write_text_atomically(self.file, self.text)
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
        write_text_atomically(file, text)
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
