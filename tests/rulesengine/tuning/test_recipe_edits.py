import pytest

from recipes.errors import RecipeError
from recipes.load import RECIPE, parse_recipe, read_recipe_text, recipe_library
from rulesengine.tuning.variables import apply_edits, is_kept, read_kept, recipe_diff
from specs.yaml.load import read_text, resolve_text

SMT = recipe_library()["smt-aqueous"]
OWN = "recipe: mine\nextends: smt-aqueous\n"


def test_lines_that_are_not_concerned_stay():
    text = read_text(SMT, RECIPE)
    after = apply_edits(text, SMT, ((("templates", "sweep", "speed_mm_s"), 30),))
    changed = [pair for pair in zip(text.splitlines(), after.splitlines(), strict=True) if pair[0] != pair[1]]
    assert changed == [("    speed_mm_s: 60", "    speed_mm_s: 30")]


def test_what_is_only_inherited_is_written_into_the_text(tmp_path):
    file = tmp_path / "mine.yaml"
    edits = ((("templates", "around", "passes", "small"), 6), (("sequence", 1, "paths"), ["sweep"]))
    recipe = parse_recipe(apply_edits(OWN, file, edits), file=file)
    base = parse_recipe(read_text(SMT, RECIPE), file=SMT)
    assert recipe.templates["around"].passes == {"bottom_terminated": 3, "default": 1, "small": 6}
    assert recipe.sequence[1].paths == ["sweep"]
    assert recipe.sequence[0] == base.sequence[0]


def test_paths_that_are_kept_are_read():
    root = read_recipe_text(read_text(SMT, RECIPE), file=SMT).root
    assert read_kept(["templates.around.speed_mm_s", "sequence[0]"], root) == (
        ("templates", "around", "speed_mm_s"),
        ("sequence", 0),
    )


@pytest.mark.parametrize(
    ("word", "told"),
    [
        ("templates.arround", "did you mean 'around'"),
        ("sequence[7]", "the list has 6 items"),
        ("templates.around.speed_mm_s.x", "it is a single value"),
        ("", "is no path"),
        ("templates..around", "is no path"),
        ("sequence[x]", "is no path"),
    ],
)
def test_a_path_that_leads_nowhere_is_refused(word, told):
    root = resolve_text(read_text(SMT, RECIPE), SMT, RECIPE)
    with pytest.raises(RecipeError, match=told.replace("[", r"\[")):
        read_kept([word], root)


def test_keeping_a_part_keeps_all_within_and_all_that_holds_it():
    kept = (("templates", "around"),)
    assert is_kept(("templates", "around", "speed_mm_s"), kept)
    assert is_kept(("templates",), kept)
    assert not is_kept(("templates", "sweep", "speed_mm_s"), kept)


def test_a_difference_is_written_as_usual():
    assert recipe_diff("a: 1\nb: 2\n", "a: 1\nb: 3\n", "old", "new") == (
        "--- old\n+++ new\n@@ -1,2 +1,2 @@\n a: 1\n-b: 2\n+b: 3\n"
    )
    assert recipe_diff("a: 1\n", "a: 1\n", "old", "new") == ""
