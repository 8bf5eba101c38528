"""A recipe to begin with: a copy of another one, with its comments, that works where it is put."""

import os
import re
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE, read_recipe_text, recipe_library
from specs.yaml.edit import edited_text, own_tree, set_value
from specs.yaml.load import find_file, read_text

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_.-]*")


def start_recipe(source: str | Path, file: Path) -> str:
    """Write the text of a new recipe.

    Args:
        source: The recipe to begin with: a library name or a file.
        file: Where the new one will stand; it is named after it.

    Raises:
        RecipeError: the source cannot be used, or the file's name cannot be a recipe's.
    """
    origin = find_file(source, RECIPE)
    return place_recipe(read_text(origin, RECIPE), origin, file)


def place_recipe(text: str, origin: Path, file: Path) -> str:
    """Rewrite a recipe so that it works in another place, and name it after that.

    Args:
        text: The recipe, as it would stand in ``origin``.
        origin: Where what it extends is looked for now.
        file: Where it will stand.

    Raises:
        RecipeError: the text cannot be used, or the file's name cannot be a recipe's.
    """
    name = file.stem
    if _NAME.fullmatch(name) is None:
        message = f"{name!r} cannot name a recipe: begin with a letter; use letters, digits and _ . - only"
        raise RecipeError(message, file=file)
    read_recipe_text(text, file=origin)
    text = re.sub(r"\$schema=\S+", "$schema=recipe.schema.json", text, count=1)
    with edited_text(origin):
        text = set_value(text, ("recipe",), name)
        extends = own_tree(text).find(("extends",))
        if extends is not None and str(extends.value) not in recipe_library():
            base = os.path.normpath(origin.parent / str(extends.value))
            text = set_value(text, ("extends",), os.path.relpath(base, file.parent))
    read_recipe_text(text, file=file)
    return text
