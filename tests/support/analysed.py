"""Small boards through the whole chain: planned with a recipe of few paths, and analysed."""

from dataclasses import replace
from functools import cache

from hostile import at, body

from boards.understand import understand
from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from cleaning.prepared_board import prepare
from recipes.load import parse_recipe
from rulesengine.planning.pipeline import run

PARAMETERS = load_parameters()
WASH = "{function: clean, nozzle: ring60, paths: [around]}"
RINSE = "{function: rinse, nozzle: ring60, paths: [around]}"
DRY = "{function: dry, nozzle: knife, paths: [flush]}"
PACKAGES = {
    "U1": ("QFN-16-1EP_3x3mm_P0.5mm", at(18, 17, 3, 3), 0.9, 17),
    "C1": ("C_0805_2012Metric", at(28, 19, 2, 1.25), 0.8, 2),
    "J1": ("PinHeader_1x04_P2.54mm_Vertical", at(36, 14, 2.5, 10), 8.0, 4),
    "C2": ("C_1206_3216Metric", at(10, 19, 3.2, 1.6), 1.0, 2),
}
THICKNESS = 1.6


_LISTED = ("bodies", "components")
"""What tests take by its number: in the order in which they name it, not in that of names."""


def bodies_of(*names, bottom=(), more=()):
    """A slab of 48 by 36 mm with these parts of ``PACKAGES``; those of ``bottom`` lie beneath it."""
    bodies = [body("pcb", "board", at(0, 0, 48, 36), -THICKNESS, 0.0)]
    for name in names:
        package, outline, height, pins = PACKAGES[name]
        side = "bottom" if name in bottom else "top"
        low = -THICKNESS - height if side == "bottom" else 0.0
        bodies.append(body(name, "component", outline, low, low + height, package=package, pins=pins, side=side))
    return (*bodies, *more)


def board_of(*names, **how):
    bodies = bodies_of(*names, **how)
    board, given = understand(bodies, "small"), [body.name for body in bodies]
    kept = {key: tuple(sorted(getattr(board, key), key=lambda each: given.index(each.name))) for key in _LISTED}
    return replace(board, **kept)


def recipe_of(*steps, change=""):
    """``smt-aqueous`` with these steps; ``change`` is more YAML."""
    sequence = "".join(f"\n  - {step}" for step in steps)
    return parse_recipe(f"recipe: few\nextends: smt-aqueous\nsequence:{sequence}\n{change}")


@cache
def prepared_of(names=("U1", "C1", "J1"), bottom=()):
    """A board made ready, once."""
    return prepare(board_of(*names, bottom=bottom), PARAMETERS, lambda *_: None)


def report_of(recipe, prepared=None, effort="sketch"):
    """Plan a recipe on a board that was made ready, and analyse it."""
    prepared = prepared or prepared_of()
    return analyse_on(prepared, run(recipe, prepared.board).program, recipe, effort)


@cache
def usual():
    """Washed, rinsed and dried on the top."""
    return report_of(recipe_of(WASH, RINSE, DRY))


def parts_of(report):
    return {part.component: part for part in report.parts}


def rules_of(part):
    return {(each.rule.id, each.name) for each in part.judgements}


def with_parameters(prepared, **blocks):
    """A subject whose parameters are changed, block by block."""
    known = prepared.parameters
    changed = {name: getattr(known, name).model_copy(update=values) for name, values in blocks.items()}
    return replace(prepared, parameters=known.model_copy(update=changed))
