"""Boards that nobody would make on purpose, as bodies that are understood as if read from a file."""

from brief_recipe import BRIEF
from shapely import Point, Polygon, affinity, box, union_all

from boards.board import Body
from boards.formats.prism import prism
from boards.understand import understand
from recipes.load import load_recipe

BOARD = box(0, 0, 100, 60)


def at(x, y, width, depth):
    return box(x, y, x + width, y + depth)


def body(name, role, outline, low, high, **stated):
    patches, normals, surfaces = prism(outline, low, high)
    return Body(name, role, patches, normals, surfaces, **stated)


def board_with(*parts, outline=BOARD, fixtures=(), thickness=1.6):
    """A board whose bodies are understood as if read from a file.

    ``parts`` are (name, polygon, height) or (name, polygon, height, side); ``fixtures`` (polygon, from, to).
    """
    bodies = [body("pcb", "board", outline, -thickness, 0.0)]
    for name, polygon, height, *side in parts:
        low = -thickness - height if side == ["bottom"] else 0.0
        stated = {"package": "C_0805", "pins": 2, "side": side[0] if side else "top"}
        bodies.append(body(name, "component", polygon, low, low + height, **stated))
    bodies += [body(f"FX{i}", "fixture", polygon, low, high) for i, (polygon, low, high) in enumerate(fixtures)]
    return understand(bodies, "hostile")


def recipe_with(limits=None, every=None, base=""):
    """A library recipe, else the default one in brief, with other limits, and other values in every template."""
    recipe = load_recipe(base) if base else BRIEF
    templates = {name: spec.model_copy(update=every or {}) for name, spec in recipe.templates.items()}
    return recipe.model_copy(update={"templates": templates, "limits": recipe.limits.model_copy(update=limits or {})})


def grid_of_parts(count, pitch=(2.4, 2.0), size=(1.6, 0.8), height=0.6):
    return [(f"R{i}", at(3 + pitch[0] * (i % 24), 3 + pitch[1] * (i // 24), *size), height) for i in range(count)]


BOARDS = {
    "mixed": lambda: board_with(
        ("U1", at(10, 10, 20, 15), 3),
        ("C1", at(33, 12, 2, 1), 1),
        ("C2", at(33, 15, 2, 1), 1),
        ("J1", affinity.rotate(at(60, 20, 8, 25), 20), 45),
        ("U2", at(70, 5, 5, 5), 2, "bottom"),
        ("J2", at(20, 40, 30, 14), 12),
        outline=Polygon([(0, 0), (100, 0), (100, 40), (80, 60), (0, 60)], [at(45, 5, 10, 6).exterior.coords[::-1]]),
        fixtures=[(at(-10, 20, 9, 20), -10, 25)],
    ),
    "towers": lambda: board_with(
        ("J1", at(20, 20, 15, 15), 80),
        ("U1", at(37, 22, 8, 8), 2),
        ("J2", at(60, 10, 10, 30), 120),
        ("C1", at(72, 20, 2, 1), 1),
    ),
    "clamped all around": lambda: board_with(
        ("U1", at(40, 20, 20, 20), 2),
        fixtures=[
            (at(-12, -12, 10, 84), -10, 70),
            (at(102, -12, 10, 84), -10, 70),
            (at(-2, 62, 104, 10), -10, 70),
            (at(-2, -12, 104, 10), -10, 70),
        ],
    ),
    "under overhanging clamps": lambda: board_with(
        ("U1", at(40, 20, 20, 20), 2),
        ("C1", at(3, 10, 2, 1), 1),
        fixtures=[(at(-20, 5, 30, 20), 12, 20), (at(90, -10, 20, 80), 3, 6)],
    ),
    "big hole": lambda: board_with(
        ("U1", at(2, 2, 10, 10), 2), outline=Polygon(BOARD.exterior, [at(15, 15, 70, 30).exterior.coords[::-1]])
    ),
    "two necks": lambda: board_with(
        ("U1", at(2, 2, 10, 10), 2),
        ("U2", at(100, 10, 10, 10), 3),
        outline=union_all(
            [at(0, 0, 30, 40), at(29, 18, 30, 3), at(58, 0, 30, 40), at(87, 19, 12, 2), at(98, 0, 30, 40)]
        ),
    ),
    "beyond the edge": lambda: board_with(
        ("J1", at(-15, 10, 25, 20), 12), ("J2", at(95, 40, 25, 30), 45), ("J3", at(150, 0, 5, 5), 9)
    ),
    "one in another": lambda: board_with(
        ("U1", at(20, 20, 30, 20), 2),
        ("U2", at(40, 30, 20, 20), 5),
        ("U3", at(25, 22, 5, 5), 8),
        ("SH1", at(15, 15, 60, 40), 1),
    ),
    "one speck": lambda: board_with(("R1", at(50, 30, 0.4, 0.2), 0.1)),
    "nothing": board_with,
    "bottom only": lambda: board_with(
        ("U1", at(20, 20, 10, 10), 3, "bottom"), ("U2", at(60, 20, 10, 10), 30, "bottom")
    ),
    "very small": lambda: board_with(("R1", at(2, 2, 1, 0.5), 0.4), outline=at(0, 0, 8, 5), thickness=0.8),
    "thin ring": lambda: board_with(
        ("R1", at(46, 1, 1, 2), 0.5), outline=Point(50, 50).buffer(50).difference(Point(50, 50).buffer(46))
    ),
    "tight grid": lambda: board_with(*grid_of_parts(240), outline=at(0, 0, 65, 30)),
    "two metres away": lambda: board_with(
        ("U1", at(2020, -3010, 10, 10), 3), ("J2", at(2060, -3020, 10, 10), 60), outline=at(2000, -3040, 100, 60)
    ),
    "rising and turned": lambda: board_with(
        *[
            (f"U{i}", affinity.rotate(at(10 + 16 * (i % 5), 8 + 17 * (i // 5), 8, 8), 7 * i), 2 + 7 * i)
            for i in range(15)
        ]
    ),
}
