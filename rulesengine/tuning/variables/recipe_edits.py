"""Edits of a recipe as values at paths, written into its text as its owner would, and the difference of two texts."""

import difflib
import re
from collections.abc import Sequence
from pathlib import Path
from typing import TypeAlias

from recipes.errors import RecipeError
from recipes.rewrite import write_values
from specs.yaml.located import Located, YamlPath, spell_path
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
    """Parse paths such as ``templates.around.speed_mm_s`` or ``sequence[0]``, all below which is to stay.

    Raises:
        RecipeError: it is no path, or there is nothing at it.
    """
    found: list[YamlPath] = []
    for word in words:
        path = read_path(word)
        node = root
        for at, key in enumerate(path):
            inner = node.get(key)
            if inner is None:
                why = "it is a single value"
                if isinstance(node.value, dict):
                    why = name_nearest(str(key), list(node.value))
                elif isinstance(node.value, list):
                    why = f"the list has {len(node.value)} items, counted from 0"
                raise RecipeError(f"nothing to keep there: {why}", path=spell_path(path[: at + 1]))
            node = inner
        found.append(path)
    return tuple(found)


def read_path(word: str) -> YamlPath:
    """Parse a path such as ``templates.around.speed_mm_s`` or ``sequence[0]``.

    Raises:
        RecipeError: it is no path.
    """
    parts = list(_PART.finditer(word))
    if not word or "".join(part.group(0) for part in parts) != word:
        raise RecipeError(f"{word!r} is no path; write it as in templates.around.speed_mm_s or sequence[0]")
    return tuple(int(part[2]) if part[2] else part[1] for part in parts)


def is_kept(path: YamlPath, kept: Sequence[YamlPath]) -> bool:
    """Whether writing at a path would change something that is kept."""
    return any(path[: len(each)] == each or each[: len(path)] == path for each in kept)


def recipe_diff(before: str, after: str, name_before: str, name_after: str) -> str:
    """Unified diff of two recipe texts; empty where nothing differs."""
    lines = difflib.unified_diff(
        before.splitlines(keepends=True), after.splitlines(keepends=True), name_before, name_after
    )
    return "".join(line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n" for line in lines)
