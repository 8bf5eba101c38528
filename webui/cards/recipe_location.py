"""Place in the recipe's file of the entry that caused a stroke or a finding."""

from pathlib import Path

from recipes.load import LoadedRecipe
from specs.source import Source


def recipe_line(loaded: LoadedRecipe, made_by: Source) -> str:
    """File and line of the entry of a source, such as ``smt-aqueous.yaml, line 104``; empty where there is none."""
    node = loaded.root
    for key in made_by.recipe_path:
        inner = node.get(key)
        if inner is None:
            break
        node = inner
    return "" if node is loaded.root else f"{Path(node.mark.file).name}, line {node.mark.line}"
