"""The recipe as a kind of YAML file: its noun, its first line, its error and its JSON schema."""

from functools import cache

from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.yaml.document import Document, Schema


@cache
def model_schema() -> Schema:
    """JSON schema of a complete recipe, as pydantic makes it."""
    return Recipe.model_json_schema(by_alias=True)


RECIPE = Document("recipe", "recipe: NAME", "washboard recipe list", RecipeError, model_schema)
