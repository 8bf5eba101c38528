"""The recipe that a program was made with, if it is at hand."""

from pathlib import Path

from programs.program import TimedProgram
from recipes.errors import RecipeError
from recipes.load import load_recipe, recipe_library, recipe_sha256
from recipes.recipe import Recipe

_SUFFIXES = (".yaml", ".yml")
_SHOWN = 16


def find_recipe_of(
    program: TimedProgram, file: Path, advice: str = "Name it with --recipe, or plan the board again."
) -> Recipe:
    """Look for the recipe in the library and beside the program; it must say the very same, by its fingerprint.

    Args:
        program: Names the recipe.
        file: Where the program was read.
        advice: What to do where it is not at hand.

    Raises:
        RecipeError: it is not there, cannot be used, or has been changed since.
    """
    named, wanted = program.origin.recipe, program.origin.recipe_sha256
    places = [recipe_library()[named]] if named in recipe_library() else []
    places += [path for path in (file.parent / f"{named}{suffix}" for suffix in _SUFFIXES) if path.is_file()]
    for place in places:
        try:
            recipe = load_recipe(place)
        except RecipeError:
            continue  # what cannot be used is not the recipe that was planned
        if recipe_sha256(recipe) == wanted:
            return recipe
    changed = f"{places[-1]} says something else now" if places else "it is neither in the library nor beside it"
    message = (
        f"the recipe {named!r} that this program was made with (sha256 {wanted[:_SHOWN]}) is not at hand: {changed}. "
        f"{advice}"
    )
    raise RecipeError(message, file=file)


def is_made_with(program: TimedProgram, recipe: Recipe) -> bool:
    """Say whether a program was made with just this recipe."""
    return recipe_sha256(recipe) == program.origin.recipe_sha256
