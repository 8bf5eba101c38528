"""What stops the reading of a cell."""

from specs.errors import LocatedError


class CellError(LocatedError):
    """A cell cannot be used: the message names the file, the line and the YAML path."""
