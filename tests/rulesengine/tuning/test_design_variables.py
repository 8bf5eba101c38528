"""Design variables of what a recipe leaves to the board: the height on this board, the least time of a step."""

from pathlib import Path

from shapely import box
from small_boards import board_of, part

from recipes.load import parse_recipe
from rulesengine.planning.fit_recipe import fit_recipe
from rulesengine.tuning.variables import apply_edits, design_variables

TEXT = """recipe: fitted
extends: smt-aqueous
templates:
  wide: {path: raster, height_mm: auto, speed_mm_s: 50}
  spare: {path: raster, height_mm: auto, speed_mm_s: 50}
sequence:
  - {function: clean, nozzle: ring60, paths: [wide], least_time_s: 240}
  - {function: clean, nozzle: ring60, paths: [spare], side: bottom, only_with_parts: true, repeat: 2}
"""


def variables():
    board = board_of(part("C1", 20, 20, 2, 1), outline=box(0, 0, 100, 30))
    fitted = fit_recipe(parse_recipe(TEXT), board)
    return {each.path: each for each in design_variables(fitted, frozenset({"small"}), {})}


def test_an_automatic_height_begins_where_the_board_has_it():
    height = variables()["templates", "wide", "height_mm"]
    assert height.value == 20.0
    assert parse_recipe(apply_edits(TEXT, Path("a.yaml"), height.edit(25.0))).templates["wide"].height_mm == 25.0


def test_a_least_time_takes_the_place_of_repeats():
    found = variables()
    assert ("sequence", 0, "repeat") not in found
    least = found["sequence", 0, "least_time_s"]
    assert (least.value, least.kind, least.steps) == (240.0, "wash_time", ("sequence[0]",))
    assert least.by_repeats
    assert [least.rounded(value) for value in (201.0, 2.0, 4000.0)] == [200.0, 5.0, 1800.0]
    changed = parse_recipe(apply_edits(TEXT, Path("a.yaml"), least.edit(200.0)))
    assert changed.sequence[0].least_time_s == 200.0


def test_what_is_left_out_on_this_board_is_no_variable():
    found = variables()
    assert not [path for path in found if "spare" in path or path[:2] == ("sequence", 1)]
