"""What stops a study."""

from specs.errors import LocatedError


class StudyError(LocatedError):
    """A study cannot be used or go on: the message names the file, the line and the YAML path, as far as known."""
