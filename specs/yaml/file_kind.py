"""Kinds of YAML file that people write: recipe, parameter set, cell, robot."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, Generic, TypeAlias, TypeVar

from specs.errors import ErrorFactory
from specs.spec import Spec

Schema: TypeAlias = dict[str, Any]
Converter: TypeAlias = Callable[[str], str]
"""Rewrites the text of a file, comments kept."""
FORMAT = "format"
"""Key under which a file of any kind states the version of its format; one that does not is of the first."""
S_co = TypeVar("S_co", bound=Spec, covariant=True)


@dataclass(frozen=True, slots=True, eq=False)
class FileKind(Generic[S_co]):
    """A kind of YAML file: its model, its library, and its words in messages."""

    noun: str
    """Such as ``"recipe"``."""
    first_line: str
    """Such as ``"recipe: NAME"``."""
    command: str
    """Its commands, such as ``"washboard recipe"``; with ``list`` it lists the library."""
    error: ErrorFactory
    model: type[S_co]
    library: Callable[[], Mapping[str, Path]]
    """Files that come with Washboard, by name."""
    named: frozenset[str] = frozenset()
    """Top-level mappings of named entries: there ``null`` removes an inherited entry and nothing else."""
    variants: Mapping[str, str] = field(default_factory=dict[str, str])
    """Of such mappings the key that chooses an entry's variant: another variant replaces the inherited entry whole."""
    ordered: frozenset[str] = frozenset()
    """Such mappings whose order counts: one that lists all inherited entries sets their order."""
    format: int = 1
    """Version of its format that this Washboard reads and writes; older ones are converted to it."""
    converters: Mapping[int, Converter] = field(default_factory=dict[int, Converter])
    """By each older version: what makes a text of the next one, and writes that into its key."""

    def schema(self) -> Schema:
        """JSON schema of a complete file, as pydantic makes it, with the key of the format."""
        return _schema(self.model, self.format)


@cache
def _schema(model: type[Spec], version: int) -> Schema:
    schema = model.model_json_schema(by_alias=True)
    stated = {"default": 1, "description": "Version of the file's format; left out: 1.", "enum": [version]}
    schema["properties"][FORMAT] = stated
    return schema
