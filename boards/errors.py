"""What stops the reading of a board."""

from specs.errors import LocatedError


class BoardError(LocatedError):
    """A board file, or the board in it, cannot be used."""
