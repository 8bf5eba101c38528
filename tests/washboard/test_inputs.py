from dataclasses import replace

import pytest
from small_boards import board_of
from small_programs import hand_program

from recipes.errors import RecipeError
from recipes.load import RECIPE, load_recipe, recipe_library, recipe_sha256
from specs.yaml.load import read_text
from washboard.inputs import find_differences, find_recipe


def planned_with(recipe):
    program = hand_program()
    return replace(program, origin=replace(program.origin, recipe=recipe.recipe, recipe_sha256=recipe_sha256(recipe)))


def write_own(folder, text="description: ours\n"):
    file = folder / "mine.yaml"
    file.write_text(f"recipe: mine\nextends: smt-aqueous\n{text}", "utf-8")
    return file


def test_a_recipe_of_the_library_is_found(tmp_path):
    recipe = load_recipe("smt-aqueous")
    assert find_recipe(planned_with(recipe), tmp_path / "a.wash") == recipe


def test_a_recipe_beside_the_program_is_found(tmp_path):
    recipe = load_recipe(write_own(tmp_path))
    assert find_recipe(planned_with(recipe), tmp_path / "a.wash") == recipe


def test_a_copy_beside_the_program_counts_where_the_library_has_changed(tmp_path):
    text = read_text(recipe_library()["smt-aqueous"], RECIPE).replace("pressure_bar: 3.5", "pressure_bar: 3.25")
    (tmp_path / "smt-aqueous.yaml").write_text(text, "utf-8")
    recipe = load_recipe(tmp_path / "smt-aqueous.yaml")
    assert find_recipe(planned_with(recipe), tmp_path / "a.wash") == recipe


def test_a_recipe_that_was_changed_since_is_refused(tmp_path):
    program = planned_with(load_recipe(write_own(tmp_path)))
    changed = write_own(tmp_path, "functions: {clean: {pressure_bar: 3.0}}\n")
    with pytest.raises(RecipeError, match=r"mine\.yaml has changed since.*--recipe"):
        find_recipe(program, tmp_path / "a.wash")
    board = replace(board_of(), sha256=program.origin.board_sha256)
    assert [each.rule.id for each in find_differences(program, board, load_recipe(changed))] == ["recipe-differs"]
    assert [each.rule.id for each in find_differences(program, board_of())] == ["board-differs"]


def test_a_recipe_that_is_nowhere_is_refused_with_what_to_do(tmp_path):
    program = planned_with(load_recipe(write_own(tmp_path)))
    (tmp_path / "mine.yaml").unlink()
    with pytest.raises(RecipeError, match=r"a\.wash: the recipe 'mine' .* neither in the library nor beside"):
        find_recipe(program, tmp_path / "a.wash")


def test_a_recipe_that_cannot_be_read_is_named_with_the_reason(tmp_path):
    program = planned_with(load_recipe(write_own(tmp_path)))
    (tmp_path / "mine.yaml").write_bytes(b"\xff\xfe")
    with pytest.raises(RecipeError, match=r"was not found: .*mine\.yaml:1: is not UTF-8 text; .*\. Name it with"):
        find_recipe(program, tmp_path / "a.wash")


def test_a_broken_recipe_beside_the_program_is_not_it(tmp_path):
    program = planned_with(load_recipe(write_own(tmp_path)))
    (tmp_path / "mine.yaml").write_text("recipe: [", "utf-8")
    with pytest.raises(RecipeError, match="was not found"):
        find_recipe(program, tmp_path / "a.wash")


@pytest.mark.parametrize("name", ["../mine", "{around}/mine", "way/mine", "link"])
def test_a_program_names_no_recipe_outside_its_folder(tmp_path, name):
    recipe = load_recipe(write_own(tmp_path))
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "way").symlink_to(tmp_path)
    (folder / "link.yaml").symlink_to(tmp_path / "mine.yaml")
    program = planned_with(recipe)
    program = replace(program, origin=replace(program.origin, recipe=name.format(around=tmp_path)))
    with pytest.raises(RecipeError, match="neither in the library nor beside"):
        find_recipe(program, folder / "a.wash")
