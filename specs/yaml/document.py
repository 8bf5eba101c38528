"""What kind of YAML file is read: what to call it in messages, and which keys it knows."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

from specs.errors import JobError

Schema: TypeAlias = dict[str, Any]


class Say(Protocol):
    """Makes the error of one kind of file."""

    def __call__(
        self, message: str, *, path: str = "", file: Path | str | None = None, line: int | None = None
    ) -> JobError:
        """Prefix the message with ``file:line: path:`` as far as they are known."""
        ...


@dataclass(frozen=True, slots=True)
class Document:
    """A kind of YAML file that people write."""

    noun: str
    """Such as ``"recipe"``."""
    begins: str
    """Its first line, such as ``"recipe: NAME"``."""
    listed_by: str
    """The command that lists the library."""
    error: Say
    schema: Callable[[], Schema]
    """Gives the JSON schema of a complete one, as pydantic makes it."""
