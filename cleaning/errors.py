"""What stops an analysis."""

from geometry.errors import LocatedError


class CleaningError(LocatedError):
    """Parameters or measurements cannot be used: the message names the file, the line and the path."""
