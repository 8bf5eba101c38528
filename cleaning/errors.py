"""What stops an analysis."""

from specs.errors import LocatedError


class CleaningError(LocatedError):
    """Parameters or measurements cannot be used: the message names the file, the line and the path."""
