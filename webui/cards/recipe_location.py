"""From the recipe path that something was made by to the place where the recipe says so."""

import re
from pathlib import Path

from recipes.load import LoadedRecipe
from recipes.recipe import Recipe
from specs.yaml.located import YamlPath

_STEP = re.compile(r"sequence\[(\d+)\]")


def yaml_path(recipe: Recipe, made_by: str) -> YamlPath:
    """Find what to edit to change what a maker does: the template of a stroke, else its step; empty for neither.

    Args:
        recipe: Knows the templates.
        made_by: Such as ``"sequence[0]/around/U12"`` or ``"classes/small"``.
    """
    first, *rest = made_by.split("/")
    step = _STEP.fullmatch(first)
    if step is None:
        return tuple(part for part in (first, *rest[:1]) if part)
    if rest and rest[0] in recipe.templates:
        return ("templates", rest[0])
    return ("sequence", int(step[1]))


def recipe_line(loaded: LoadedRecipe, made_by: str) -> str:
    """Say where that is written, such as ``smt-aqueous.yaml, line 104``; nothing for what no recipe asked for."""
    path = yaml_path(loaded.recipe, made_by)
    if not path or loaded.root.get(path[0]) is None:
        return ""
    mark = loaded.root.at(path).mark
    return f"{Path(mark.file).name}, line {mark.line}"
