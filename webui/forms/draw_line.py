"""A straight line that is drawn on the board becomes a template of the recipe."""

from dataclasses import dataclass
from itertools import count

from recipes.errors import RecipeError
from recipes.recipe import Recipe
from specs.yaml.edit import Tree, set_value
from webui.page.session import Session


@dataclass(frozen=True, slots=True)
class DrawnLine:
    """What a template of path class straight_line says. Board frame, mm."""

    name: str
    begin: tuple[float, float]
    end: tuple[float, float]
    height_mm: float
    speed_mm_s: float


def add_line(session: Session, line: DrawnLine, step: int) -> Session:
    """Make a line a template, and the last path of a step: one edit.

    Raises:
        RecipeError: the recipe would not be one; the name may be taken or no name.
    """
    if line.name in session.recipe.templates:
        raise RecipeError(f"{line.name!r} is there already; choose another name", path="templates")
    if line.begin == line.end:
        raise RecipeError("the line has no length; click two different points", path=f"templates.{line.name}")
    template: Tree = {
        "path": "straight_line",
        "from": [round(value, 2) for value in line.begin],
        "to": [round(value, 2) for value in line.end],
        "height_mm": line.height_mm,
        "speed_mm_s": line.speed_mm_s,
    }
    sequence: Tree = session.loaded.root.at(("sequence",)).plain()
    sequence[step]["paths"].append(line.name)
    text = set_value(session.document.text, ("templates", line.name), template)
    return session.edited(set_value(text, ("sequence",), sequence))


def free_name(recipe: Recipe) -> str:
    """Propose a name that no template has."""
    return next(name for number in count(1) if (name := f"line{number}") not in recipe.templates)


def step_names(recipe: Recipe) -> tuple[str, ...]:
    """Name the steps to choose from, such as ``1 clean, ring60``."""
    return tuple(f"{place + 1} {step.function}, {step.nozzle}" for place, step in enumerate(recipe.sequence))
