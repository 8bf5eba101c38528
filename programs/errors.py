"""What stops the reading of a program."""

from specs.errors import LocatedError


class ProgramError(LocatedError):
    """A program file cannot be used."""
