"""What a person states once of an order: titles and units of its tables, its board, heights that no file states."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from boards.errors import BoardError
from boards.formats.names import stem_of
from specs.confinement import refusal
from specs.spec import Bounds, Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.load import parse_spec, read_text, resolve_text

Column: TypeAlias = (
    Literal["ref", "package", "value", "part", "x", "y", "rotation", "side", "pins", "standoff", "height"]
    | Literal["fitted", "omitted", "quantity", "remark"]
)
COLUMNS_FILE = "columns.yaml"

Height = Annotated[float, Bounds(0.05, 300.0, "mm", "heights of components")]


class OrderColumns(Spec):
    """A columns file; what is left out is found by content."""

    columns: dict[Column, str | list[str]] = Field(
        default={},
        description="Titles of columns as the tables have them, by what is in them; several for several tables.",
    )
    unit: Literal["mm", "mil", "inch", "um"] | None = Field(
        default=None, description="Of places where neither title, cell nor a line above states it."
    )
    board: str | None = Field(default=None, description="The file of the order that is the board, where several are.")
    panel: Literal["apart", "whole"] | None = Field(
        default=None, description="Whether a file with several boards is taken apart; left out, as it shows."
    )
    tables: list[str] | None = Field(
        default=None, description="The tables that are joined; left out, all that are there."
    )
    heights_mm: dict[str, Height] = Field(
        default={}, description="Heights above the board, by reference designator or by package."
    )


COLUMNS = FileKind(
    "columns file", "columns: {ref: TITLE}", "washboard board", BoardError, OrderColumns, dict[str, Path]
)


@dataclass(frozen=True, slots=True)
class Stated:
    """A columns file that was read, or none."""

    file: Path | None = None
    model: OrderColumns = field(default_factory=OrderColumns)

    @property
    def titles(self) -> Mapping[Column, tuple[str, ...]]:
        """Titles by column, each of them once."""
        columns = self.model.columns
        return {key: (title,) if isinstance(title, str) else tuple(title) for key, title in columns.items()}


NOTHING_STATED = Stated()


def find_columns(order: Path) -> Stated:
    """Read the columns file of a folder, or that beside a file or an archive: ``NAME.columns.yaml`` comes first.

    Raises:
        BoardError: It cannot be read, or a value does not fit; line and YAML path are named.
    """
    names = (COLUMNS_FILE,) if order.is_dir() else (f"{stem_of(order)}.{COLUMNS_FILE}", COLUMNS_FILE)
    folder = order if order.is_dir() else order.parent
    file = next((each for name in names if (each := folder / name).is_file() and not refusal(each)), None)
    return NOTHING_STATED if file is None else Stated(file, read_columns(file))


def read_columns(file: Path) -> OrderColumns:
    """Read a columns file.

    Raises:
        BoardError: It cannot be read, or a value does not fit.
    """
    return parse_columns(read_text(file, COLUMNS), file)


def parse_columns(text: str, file: Path) -> OrderColumns:
    """Read the text of a columns file.

    Raises:
        BoardError: A value does not fit.
    """
    return parse_spec(resolve_text(text, file, COLUMNS), COLUMNS)
