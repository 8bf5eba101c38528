"""Edits of a recipe as values at paths, written into its text as its owner would."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from recipes.errors import RecipeError
from recipes.rewrite import write_values
from specs.yaml.located import Key, Located, YamlPath, spell_path
from specs.yaml.schema import name_nearest
from specs.yaml.tree import Tree

Edits: TypeAlias = tuple[tuple[YamlPath, Tree], ...]
"""Values by the paths where they are to stand, in the order of writing."""
_PART = re.compile(r"(?:^|\.)([^.\[\]]+)|\[(\d+)\]")


def apply_edits(text: str, file: Path, edits: Edits) -> str:
    """Write values into a recipe one after the other; a list that is only inherited is copied into the text first.

    Raises:
        RecipeError: a value cannot be written there.
    """
    for path, value in edits:
        text = write_values(text, file, {path: value})
    return text


def read_kept(words: Sequence[str], root: Located) -> tuple[YamlPath, ...]:
    """Read paths such as ``templates.around.speed_mm_s`` or ``sequence[0]``, all below which is to stay.

    Raises:
        RecipeError: it is no path, or there is nothing at it.
    """
    return tuple(_read_path(word, root) for word in words)


def _read_path(word: str, root: Located) -> YamlPath:
    parts = list(_PART.finditer(word))
    if not word or "".join(part.group(0) for part in parts) != word:
        raise RecipeError(f"{word!r} is no path; write it as in templates.around.speed_mm_s or sequence[0]")
    path: YamlPath = tuple(int(part[2]) if part[2] else part[1] for part in parts)
    node = root
    for at, key in enumerate(path):
        inner = node.get(key)
        if inner is None:
            raise RecipeError(f"nothing to keep there: {_missing(key, node)}", path=spell_path(path[: at + 1]))
        node = inner
    return path


def _missing(key: Key, node: Located) -> str:
    if isinstance(node.value, dict):
        return name_nearest(str(key), list(node.value))
    if isinstance(node.value, list):
        return f"the list has {len(node.value)} items, counted from 0"
    return "it is a single value"


def is_kept(path: YamlPath, kept: Sequence[YamlPath]) -> bool:
    """Say whether writing at a path would change something that is kept."""
    return any(path[: len(each)] == each or each[: len(path)] == path for each in kept)
