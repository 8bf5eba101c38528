"""Reading recipes: from the library by name, from a file, or from text."""

import hashlib
import json
import os
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from pydantic import ValidationError

from recipes.consistency import find_problems
from recipes.document import RECIPE
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.yaml.files import find_file, is_bare, read_text
from specs.yaml.inherit import inherit
from specs.yaml.located import Located, read_yaml
from specs.yaml.problems import raise_problems, translate

_LIBRARY = Path(__file__).parent / "library"


@dataclass(frozen=True, slots=True)
class LoadedRecipe:
    """A recipe and where each of its values was written."""

    recipe: Recipe
    root: Located
    """The resolved tree: a value that was inherited bears the mark of the file it stands in."""


def recipe_library() -> dict[str, Path]:
    """Give the recipes that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


def load_recipe(source: str | Path) -> Recipe:
    """Read a recipe.

    Args:
        source: A library name such as ``smt-aqueous``, or a file.

    Raises:
        RecipeError: it cannot be found or used; the message says where and what to do.
    """
    return read_recipe(source).recipe


def read_recipe(source: str | Path) -> LoadedRecipe:
    """Read a recipe as ``load_recipe`` does and keep where its values stand.

    Raises:
        RecipeError: it cannot be found or used.
    """
    path = find_recipe(source)
    return read_recipe_text(read_text(path, RECIPE), file=path)


def parse_recipe(text: str, *, file: Path | str = "<recipe>") -> Recipe:
    """Read a recipe from its text.

    Args:
        text: YAML.
        file: What to call it in errors; a file that it extends is looked for beside it.

    Raises:
        RecipeError: it cannot be used.
    """
    return read_recipe_text(text, file=file).recipe


def read_recipe_text(text: str, *, file: Path | str = "<recipe>") -> LoadedRecipe:
    """Read a recipe from its text as ``parse_recipe`` does and keep where its values stand.

    Raises:
        RecipeError: it cannot be used.
    """
    root = resolve_text(text, file=file)
    try:
        # JSON is what makes pydantic strict about types (no "60", no true for 1) while lists still become tuples.
        recipe = Recipe.model_validate_json(json.dumps(root.plain()), strict=True)
    except ValidationError as error:
        raise_problems(translate(error, root, RECIPE), root, RECIPE)
        raise AssertionError("a refused recipe has a problem") from error
    raise_problems(find_problems(recipe), root, RECIPE)
    return LoadedRecipe(recipe, root)


def resolve_text(text: str, *, file: Path | str = "<recipe>") -> Located:
    """Merge what a recipe's text says over what it extends; whether that makes a recipe is not looked at.

    Raises:
        RecipeError: it is not YAML, or what it extends cannot be read.
    """
    return inherit(read_yaml(text, file, RECIPE), _read_extended, RECIPE)


def recipe_sha256(recipe: Recipe) -> str:
    """Hash what the recipe says, however it was written: inherited or not, in whatever order where order says nothing.

    The order of classes decides which one takes a component, so it is part of the content.
    """
    content = recipe.model_dump(mode="json", by_alias=True, exclude={"extends"})
    content["classes"] = list(content["classes"].items())
    canonical = json.dumps(content, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(canonical.encode()).hexdigest()


def find_recipe(source: str | Path) -> Path:
    """Find the file of a recipe: a library name first, then a path.

    Raises:
        RecipeError: a bare name that is neither in the library nor a file.
    """
    return find_file(source, recipe_library(), RECIPE)


def _read_extended(name: str, where: Located) -> Located:
    """Read the tree of the recipe that another one extends; a relative path starts at the folder of that other."""
    say = partial(RecipeError, path="extends", file=where.mark.file, line=where.mark.line)
    try:
        path = recipe_library().get(name)
        if path is None and is_bare(name):
            find_recipe(name)
        path = path or Path(os.path.normpath(Path(where.mark.file).parent / name))
        text = read_text(path, RECIPE)
    except RecipeError as error:
        raise say(str(error)) from None
    return read_yaml(text, path, RECIPE)
