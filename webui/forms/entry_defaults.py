"""What a new entry of a recipe begins with: values that are used in the library, where it has any."""

from functools import cache
from typing import cast, get_args

from boards.board import Board
from recipes.load import read_recipe, recipe_library
from recipes.nozzles import Nozzle
from recipes.paths import PathSpec
from recipes.recipe import Recipe
from specs.spec import Spec
from specs.yaml.tree import Tree

_KIND = {"templates": "path", "nozzles": "pattern"}
_WITHOUT_MODEL: dict[str, dict[str, Tree]] = {
    "straight_line": {"path": "straight_line", "height_mm": 50, "speed_mm_s": 40},
    "full_cone": {"pattern": "full_cone", "half_angle_deg": 30, "flow_lpm": 2, "at_bar": 3},
    "flat_fan": {"pattern": "flat_fan", "half_angle_deg": 40, "flow_lpm": 2, "at_bar": 3},
}
"""Kinds that no recipe of the library has."""


def kinds_of(section: str) -> tuple[str, ...]:
    """List what kinds of entries a section can have, such as the path classes of templates; most have one."""
    match section:
        case "templates":
            return tuple(_tag(each, "path") for each in get_args(get_args(PathSpec)[0]))
        case "nozzles":
            return tuple(_tag(each, "pattern") for each in get_args(get_args(Nozzle)[0]))
        case "masks":
            return ("avoid", "clean", "ignore")
        case _:
            return ()


def start_entry(recipe: Recipe, board: Board, section: str, kind: str, name: str) -> Tree:
    """Give the values of a new entry.

    Args:
        recipe: It is made for this one.
        board: A straight line runs across the middle of it; a mask is about its first component.
        section: Key of the section, such as ``"templates"``.
        kind: One of ``kinds_of`` the section.
        name: Of the new entry; a class takes packages of that name.
    """
    match section:
        case "templates" | "nozzles":
            value = dict(_models(section).get(kind) or _WITHOUT_MODEL[kind])
            return {**value, **_across(board)} if kind == "straight_line" else value
        case "functions":
            return dict(_models(section)["clean"])
        case "classes":
            return {"package": [f"*{name.upper()}*"]}
        case "masks":
            first = board.components[0].name if board.components else "J*"
            return {kind: [first]}
        case _:
            return {
                "function": _first(recipe.functions),
                "nozzle": _first(recipe.nozzles),
                "paths": [_first(recipe.templates)],
            }


@cache
def _models(section: str) -> dict[str, dict[str, Tree]]:
    """First entry of each kind in the library; by name where a section has one kind."""
    found: dict[str, dict[str, Tree]] = {}
    names = sorted(recipe_library(), key=lambda name: (name != "smt-aqueous", name))
    for name in names:
        for entry, value in cast("dict[str, dict[str, Tree]]", read_recipe(name).root.plain()[section]).items():
            plain = {key: _without_classes(inner) for key, inner in value.items()}
            plain.pop("wavefront", None)  # measured with one nozzle, and true for no other
            found.setdefault(str(plain[_KIND[section]]) if section in _KIND else entry, plain)
    return found


def _without_classes(value: Tree) -> Tree:
    """Classes differ from recipe to recipe: what all others get is what a new template begins with."""
    return cast("dict[str, Tree]", value)["default"] if isinstance(value, dict) and "default" in value else value


def _across(board: Board) -> dict[str, Tree]:
    low_x, low_y, high_x, high_y = (float(bound) for bound in board.outline.bounds)
    middle = round((low_y + high_y) / 2, 2)
    return {"from": [round(low_x, 2), middle], "to": [round(high_x, 2), middle]}


def _first(entries: dict[str, Tree]) -> str:
    return next(iter(entries))


def _tag(spec: type[Spec], key: str) -> str:
    return str(spec.model_fields[key].default)
