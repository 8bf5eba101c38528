"""Errors that stop the reading of a cell."""

from collections.abc import Generator
from contextlib import contextmanager

from specs.errors import LocatedError
from specs.yaml.located import Located, YamlPath, spell_path


class CellError(LocatedError):
    """A cell cannot be used: the message names the file, the line and the YAML path."""


def error_at(root: Located, path: YamlPath, message: str) -> CellError:
    """Give the error of a value in a cell's file."""
    mark = root.at(path).mark
    return CellError(message, path=spell_path(path), file=mark.file, line=mark.line)


@contextmanager
def errors_at(root: Located, path: YamlPath) -> Generator[None]:
    """Turn errors into those of a value in a cell's file."""
    try:
        yield
    except CellError as error:
        raise error_at(root, path, str(error)) from None
