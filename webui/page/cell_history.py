"""Edits of a cell's file from the page, which can be undone: the file has the edit at once."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from reports.files.atomic_write import OutputError, write_text_atomically
from robotcell.cell.cell_edits import CellEdit, apply_edits
from robotcell.cell.load import CELL, LoadedCell, cell_sha256, read_cell_text
from robotcell.errors import CellError
from specs.yaml.load import read_text


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
        write_text_atomically(self.file, self.text_after)

    def take_back(self) -> None:
        """Write the file as it was; a copy is removed.

        Raises:
            CellError: the file was changed elsewhere since.
            OutputError: it cannot be written.
        """
        self._require(self.text_after)
        if self.text_before is not None:
            write_text_atomically(self.file, self.text_before)
            return
        try:
            self.file.unlink()
        except OSError as error:
            raise OutputError(self.file, error.strerror or str(error), "Remove it by hand.") from None

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
