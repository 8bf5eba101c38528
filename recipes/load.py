"""Reading recipes: from the library by name, from a file, or from text."""

from dataclasses import dataclass
from pathlib import Path

from recipes.consistency import find_problems
from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.json import content_sha256
from specs.source import Source
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, parse_spec, read_text, resolve_text
from specs.yaml.located import Located
from specs.yaml.problems import raise_problems

_LIBRARY = Path(__file__).parent / "library"


def recipe_library() -> dict[str, Path]:
    """Give the recipes that come with Washboard: name to file, in alphabetical order."""
    return {path.stem: path for path in sorted(_LIBRARY.glob("*.yaml"))}


RECIPE = FileKind(
    "recipe",
    "recipe: NAME",
    "washboard recipe",
    RecipeError,
    Recipe,
    recipe_library,
    named=frozenset({"functions", "nozzles", "classes", "templates"}),
    variants={"templates": "path", "nozzles": "pattern"},
    ordered=frozenset({"classes"}),
)


@dataclass(frozen=True, slots=True)
class LoadedRecipe:
    """A recipe and where each of its values was written."""

    recipe: Recipe
    root: Located
    """The resolved tree: a value that was inherited bears the mark of the file it stands in."""


def load_recipe(source: str | Path) -> Recipe:
    """Read a recipe.

    Args:
        source: A library name such as ``smt-aqueous``, or a file.

    Raises:
        RecipeError: it cannot be found or used; the message states where and what to do.
    """
    return read_recipe(source).recipe


def read_recipe(source: str | Path) -> LoadedRecipe:
    """Read a recipe as ``load_recipe`` does and keep where its values stand.

    Raises:
        RecipeError: it cannot be found or used.
    """
    path = find_file(source, RECIPE)
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
    root = resolve_text(text, file, RECIPE)
    recipe = parse_spec(root, RECIPE)
    raise_problems(find_problems(recipe), root, RECIPE)
    return LoadedRecipe(recipe, root)


def locate_error(error: RecipeError, loaded: LoadedRecipe) -> RecipeError:
    """Add file and line to an error that was found after reading, where the value stands in the user's own file."""
    keys = Source(entry=error.path).recipe_path
    node = loaded.root.find(keys)
    installed = loaded.root.mark.file in map(str, recipe_library().values())
    if error.file is not None or not keys or installed:
        return error
    message = str(error).removeprefix(f"{error.path}: ")
    line = node.mark.line if node is not None and node.mark.file == loaded.root.mark.file else None
    return RecipeError(message, path=error.path, file=loaded.root.mark.file, line=line)


def recipe_sha256(recipe: Recipe) -> str:
    """Hash the content of a recipe, however it was written: inherited or not, keys in any order.

    The order of classes decides which one takes a component, so it is part of the content.
    """
    content = recipe.model_dump(mode="json", by_alias=True, exclude={"extends"})
    content["classes"] = list(content["classes"].items())
    return content_sha256(content)
