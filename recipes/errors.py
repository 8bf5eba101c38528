"""What stops the reading of a recipe."""

from specs.errors import LocatedError


class RecipeError(LocatedError):
    """A recipe cannot be used: the message names the file, the line and the YAML path."""
