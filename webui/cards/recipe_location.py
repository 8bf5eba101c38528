"""The recipe entry that caused a stroke or a finding, and its place in the file."""

import re
from pathlib import Path

from recipes.load import LoadedRecipe
from recipes.recipe import Recipe
from specs.yaml.located import YamlPath

_STEP = re.compile(r"sequence\[(\d+)\]")


def yaml_path(recipe: Recipe, made_by: str) -> YamlPath:
    """Path of the entry to edit: the template of a stroke, else its step; empty for neither.

    Args:
        recipe: The recipe with the templates.
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
    """File and line of that entry, such as ``smt-aqueous.yaml, line 104``; empty where no entry caused it."""
    path = yaml_path(loaded.recipe, made_by)
    if not path or loaded.root.get(path[0]) is None:
        return ""
    mark = loaded.root.at(path).mark
    return f"{Path(mark.file).name}, line {mark.line}"


def components_of(made_by: str) -> list[str]:
    """Components of a stroke, such as those of ``"sequence[0]/around/U12+U13"``."""
    parts = made_by.split("/")
    return parts[2].split("+") if len(parts) > 2 else []
