"""Edits of a recipe's text that take account of what the recipe inherits.

What is only inherited does not stand in the text: a list is copied there before an item of it changes, and what is
removed is written as ``null``.
"""

from collections.abc import Mapping
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE
from specs.yaml.edit import insert_value, move_value, own_tree, remove_value, rename_key, set_value
from specs.yaml.load import resolve_text
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree

_LISTS = ("masks", "sequence")
_DEEPEST = 32
"""Keys of a path: no recipe has values farther down."""


def write_values(text: str, file: Path, values: Mapping[YamlPath, Tree]) -> str:
    """Write values at their paths; ``None`` takes out what stands there.

    Raises:
        RecipeError: a value cannot be written there, or a path has no key or more than any recipe.
    """
    for path, value in values.items():
        if not 0 < len(path) <= _DEEPEST:
            message = f"a path has 1 to {_DEEPEST} keys, as in templates.around.speed_mm_s; this one has {len(path):,}"
            raise RecipeError(message, file=file)
        text = remove(text, file, path) if value is None else set_value(_with_list(text, file, path), path, value)
    return text


def insert(text: str, file: Path, path: YamlPath, value: Tree) -> str:
    """Insert an item into a list, before the index the path ends with.

    Raises:
        RecipeError: there is no such list.
    """
    return insert_value(_with_list(text, file, path), path, value)


def remove(text: str, file: Path, path: YamlPath) -> str:
    """Take out a list item or a key, wherever it comes from; what is not there needs nothing.

    Raises:
        RecipeError: the text cannot be changed there.
    """
    text = _with_list(text, file, path)
    if own_tree(text).find(path) is not None:
        text = remove_value(text, path)
    if isinstance(path[-1], int):
        return text
    inherited = resolve_text(text, file, RECIPE).find(path)
    return text if inherited is None or inherited.value is None else set_value(text, path, None)


def move(text: str, file: Path, path: YamlPath, to: int) -> str:
    """Move a list item or a named entry to another place among its neighbours, counted without it.

    The order of inherited names holds as soon as all of them stand in the text, so they are written there.

    Raises:
        RecipeError: the text cannot be changed there.
    """
    text = _with_list(text, file, path)
    names = resolve_text(text, file, RECIPE).find(path[:-1])
    if names is not None and isinstance(names.value, dict):
        own = own_tree(text).find(path[:-1])
        stated = list(own.value) if own is not None and isinstance(own.value, dict) else []
        if [name for name in stated if name in names.value] != list(names.value):
            for place, name in enumerate(names.value):
                if name not in stated:
                    text = set_value(text, (*path[:-1], name), {})  # {} keeps what the entry inherits
                text = move_value(text, (*path[:-1], name), place)
    return move_value(text, path, to)


def rename(text: str, file: Path, path: YamlPath, name: str) -> str:
    """Give a named entry another name where it stands.

    Raises:
        RecipeError: it is inherited, or the name is taken.
    """
    renamed = rename_key(text, path, name) if own_tree(text).find(path) is not None else text
    if resolve_text(renamed, file, RECIPE).find(path) is not None:
        raise RecipeError("is inherited and keeps its name here; duplicate it instead", path=spell_path(path))
    return renamed


def _with_list(text: str, file: Path, path: YamlPath) -> str:
    """Write a list that is only inherited into the text, so that its items can be changed."""
    top = path[:1]
    if len(path) < 2 or path[0] not in _LISTS or own_tree(text).find(top) is not None:
        return text
    inherited = resolve_text(text, file, RECIPE).find(top)
    return set_value(text, top, [] if inherited is None else inherited.plain())
