"""The default recipe for tests that need its paths but not its minutes: the top alone, without a least time."""

from recipes.load import load_recipe
from recipes.recipe import Recipe


def brief_recipe() -> Recipe:
    """The default recipe, each path of its top side once."""
    recipe = load_recipe("smt-aqueous")
    changes = {"least_time_s": None, "only_with_parts": False}
    top = [step.model_copy(update=changes) for step in recipe.sequence if step.side == "top"]
    return recipe.model_copy(update={"sequence": top})


BRIEF = brief_recipe()
