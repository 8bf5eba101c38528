"""Recipes of the library for boards: those of parts follow faces, which a board has none of."""

from recipes.load import read_recipe, recipe_library
from recipes.paths import OverFaces

BOARD_RECIPES = {
    name: file
    for name, file in recipe_library().items()
    if not any(isinstance(template, OverFaces) for template in read_recipe(name).recipe.templates.values())
}
