"""What is wrong in a recipe is said once, with file, line, YAML path and the way out."""

import re
from pathlib import Path

import pytest

from recipes.errors import RecipeError
from recipes.load import load_recipe, parse_recipe, read_recipe, recipe_library, recipe_sha256
from recipes.paths import PATH_CLASSES

DEFAULT = recipe_library()["smt-aqueous"].read_text("utf-8")


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def test_a_recipe_comes_from_the_library_or_from_a_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.yaml"
    file.write_text(DEFAULT, "utf-8")
    assert load_recipe(file) == load_recipe(str(file)) == load_recipe("smt-aqueous") == parse_recipe(DEFAULT)


def test_a_byte_order_mark_and_windows_line_ends_do_no_harm(tmp_path: Path) -> None:
    file = tmp_path / "windows.yaml"
    file.write_bytes(b"\xef\xbb\xbf" + DEFAULT.replace("\n", "\r\n").encode())
    assert load_recipe(file) == load_recipe("smt-aqueous")


@pytest.mark.parametrize(
    ("before", "after", "path", "message"),
    [
        ("    speed_mm_s: 60", "    sped_mm_s: 60", "templates.sweep.sped_mm_s", "did you mean 'speed_mm_s'"),
        ("path: raster", "path: rastr", "templates.sweep.path", "did you mean 'raster'"),
        ("pattern: air_knife", "pattern: knife", "nozzles.knife.pattern", "did you mean 'air_knife'"),
        ("    path: raster\n", "", "templates.sweep.path", "is missing"),
        ("speed_mm_s: 60", "speed_mm_s: '60'", "templates.sweep.speed_mm_s", "must be a number, not '60'"),
        ("speed_mm_s: 60", "speed_mm_s: true", "templates.sweep.speed_mm_s", "must be a number, not true"),
        (
            "speed_mm_s: 60",
            "speed_mm_s: -1",
            "templates.sweep.speed_mm_s",
            "must be at least 0.01 mm/s, not -1: speeds of a robot range from 0.01 to 10,000 mm/s",
        ),
        ("speed_mm_s: 60", "speed_mm_s: 1e-7", "templates.sweep.speed_mm_s", "must be at least 0.01 mm/s, not 1e-07"),
        (
            "height_mm: auto\n",
            "height_mm: 1.0e+300\n",
            "templates.edge.height_mm",
            "must be at most 1,000 mm, not 1e+300",
        ),
        ("height_mm: 50\n", "height_mm: 1e30\n", "nozzles.ring60.wavefront.height_mm", "must be at most 1,000 mm"),
        (
            "speed_mm_s: 40",
            "speed_mm_s: {small: 1e9, default: 40}",
            "templates.around.speed_mm_s.small",
            "at most 10,000",
        ),
        ("direction_deg: longest_edge", "direction_deg: 1e9", "templates.sweep.direction_deg", "at most 360 degrees"),
        ("overlap: 0.3", "overlap: 0.99999", "templates.sweep.overlap", "must be at most 0.99, not 0.99999"),
        ("[0, 24.1, 31.8]", "[0, 24.1, 1e30]", "nozzles.ring60.wavefront.points[0][2]", "at most 20,000 mm"),
        ("clearance_mm: 5 ", "clearance_mm: 0 ", "limits.clearance_mm", "must be at least 0.01 mm, not 0"),
        ("speed_mm_s: 60", "speed_mm_s: .nan", "templates.sweep.speed_mm_s", "a finite number"),
        ("speed_mm_s: 60", "speed_mm_s: 1e999", "templates.sweep.speed_mm_s", "a finite number"),
        ("toward: inside", "toward: insde", "templates.edge.toward", "did you mean 'inside'"),
        ("3, default: 1}", "3, default: 1.5}", "templates.around.passes.default", "whole number, not 1.5"),
        (
            "{bottom_terminated: 3, default: 1}",
            "[2]",
            "templates.around.passes",
            "a whole number or a mapping by class",
        ),
        ("{bottom_terminated: 3, default: 1}", "-1", "templates.around.passes", "must be at least 0"),
        ("longest_edge", "longest", "templates.sweep.direction_deg", "must be a number or longest_edge"),
        ("[0, 24.1, 31.8]", "[0, 24.1]", "nozzles.ring60.wavefront.points[0]", "value number 3"),
        ("[0, 24.1, 31.8]", "[0, 44.1, 31.8]", "nozzles.ring60.wavefront", "inner radius must be smaller"),
        ("solution: di-water", "solution: 12", "functions.rinse.solution", "put it in quotes"),
        ("  rinse:\n", "  1rinse:\n", "functions.1rinse", "begins with a letter"),
        ("paths: [edge, sweep, flush]", "paths: []", "sequence[1].paths", "at least 1"),
        ("{resistivity_mohm_cm: 1.0, max", "{max", "sequence[1].until", "exactly one of resistivity_mohm_cm"),
        ("masks: []", "masks: [{margin_mm: 1}]", "masks[0]", "exactly one of avoid, clean, ignore"),
        ("limits:", "limits: 4\nlimit:", "limits", "must be a mapping, not 4"),
    ],
)
def test_errors_name_line_path_and_the_way_out(before: str, after: str, path: str, message: str) -> None:
    assert before in DEFAULT
    text = DEFAULT.replace(before, after, 1)
    with pytest.raises(RecipeError, match=re.escape(message)) as caught:
        parse_recipe(text, file="mine.yaml")
    assert caught.value.path == path
    assert str(caught.value).startswith(f"mine.yaml:{caught.value.line}: {path}: ")


@pytest.mark.parametrize(("template", "path"), [("edge", "board_perimeter"), ("around", "component_perimeter")])
def test_a_closed_path_has_no_ends_to_overshoot(template: str, path: str) -> None:
    before = f"    path: {path}\n"
    text = DEFAULT.replace(before, f"{before}    overshoot_mm: 3\n")
    with pytest.raises(RecipeError) as caught:
        parse_recipe(text, file="mine.yaml")
    *first, last = sorted(
        spec.model_fields["path"].default for spec in PATH_CLASSES if "overshoot_mm" in spec.model_fields
    )
    assert str(caught.value).startswith(
        f"mine.yaml:{line_of(text, 'overshoot_mm')}: templates.{template}.overshoot_mm: no key of {path}; "
        f"{', '.join(first)} and {last} have it. Known: lead_in_mm, path, height_mm, "
    )


def test_the_line_is_that_of_the_wrong_value() -> None:
    text = DEFAULT.replace("tilt_deg: 20", "tilt_deg: 95")
    with pytest.raises(RecipeError) as caught:
        parse_recipe(text)
    assert caught.value.line == line_of(text, "tilt_deg: 95")


def test_the_first_of_several_errors_comes_first_and_the_others_are_listed() -> None:
    text = DEFAULT.replace("speed_mm_s: 15\n", "speed_mm_s: x\n").replace("pressure_bar: 4.0", "pressure_bar: 0")
    with pytest.raises(RecipeError) as caught:
        parse_recipe(text, file="m")
    first, count, *others = str(caught.value).splitlines()
    assert caught.value.line == line_of(text, "pressure_bar: 0")
    assert "functions.dry.pressure_bar" in first
    assert count == f"and {len(others)} more:"
    assert any("templates.soak.speed_mm_s" in other for other in others)


def test_at_most_ten_others_are_listed() -> None:
    text = DEFAULT + "".join(f"extra{index}: 1\n" for index in range(30))
    with pytest.raises(RecipeError) as caught:
        parse_recipe(text)
    lines = str(caught.value).splitlines()
    assert len(lines) == 13
    assert lines[-1].strip() == "… and 19 more"


def test_a_misspelt_key_is_not_reported_as_missing_too() -> None:
    with pytest.raises(RecipeError) as caught:
        parse_recipe(DEFAULT.replace("classes:", "clases:"))
    assert "did you mean 'classes'" in str(caught.value)
    assert "is missing" not in str(caught.value)


def test_a_missing_key_says_what_it_is_for() -> None:
    with pytest.raises(RecipeError, match=r"is missing\. Length of the slot"):
        parse_recipe(DEFAULT.replace("    width_mm: 80\n", ""))


def test_unknown_names_list_the_library_and_the_nearest() -> None:
    with pytest.raises(RecipeError, match=r"Did you mean 'smt-aqueous'.*dry-only, low-standoff"):
        load_recipe("smt-aqeous")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "latin.yaml").write_bytes("recipe: a\n# grün\n".encode("latin-1"))
    (tmp_path / "big.yaml").write_bytes(b"# " + b"x" * 5_000_001)
    for name, message in (("latin.yaml", "latin.yaml:2: .*UTF-8"), ("big.yaml", "too many"), ("none.yaml", "no such")):
        with pytest.raises(RecipeError, match=message):
            load_recipe(tmp_path / name)
    with pytest.raises(RecipeError, match="not a file"):
        load_recipe(tmp_path)
    with pytest.raises(RecipeError, match="not a file"):
        load_recipe("/dev/zero")
    with pytest.raises(RecipeError, match="cannot be read"):
        load_recipe("a\0b.yaml")


def test_the_hash_is_of_what_the_recipe_says_not_of_how_it_is_written() -> None:
    recipe = load_recipe("smt-aqueous")
    assert recipe_sha256(parse_recipe(DEFAULT.replace("speed_mm_s: 60", "speed_mm_s: 6e1"))) == recipe_sha256(recipe)
    assert recipe_sha256(parse_recipe(DEFAULT.replace("speed_mm_s: 60", "speed_mm_s: 61"))) != recipe_sha256(recipe)
    inherited = parse_recipe("recipe: smt-aqueous\nextends: smt-aqueous\n")
    assert recipe_sha256(inherited) == recipe_sha256(recipe)


def test_a_default_that_is_stated_is_the_same_recipe() -> None:
    stated = DEFAULT.replace("    distance_mm: 0\n", "")
    assert stated != DEFAULT
    assert recipe_sha256(parse_recipe(stated)) == recipe_sha256(parse_recipe(DEFAULT))


def test_the_hash_knows_the_order_of_classes() -> None:
    text = DEFAULT.replace("  small:\n    area_mm2: {max: 20}\n", "")
    other = text.replace("  bottom_terminated:  ", "  small:\n    area_mm2: {max: 20}\n  bottom_terminated:  ")
    assert next(iter(parse_recipe(other).classes)) == "small"
    assert parse_recipe(other).classes == load_recipe("smt-aqueous").classes
    assert recipe_sha256(parse_recipe(other)) != recipe_sha256(load_recipe("smt-aqueous"))


def test_each_value_can_be_traced_to_its_file_and_line() -> None:
    loaded = read_recipe("low-standoff")
    mark = loaded.root.at(("nozzles", "ring60", "half_angle_deg")).mark
    assert Path(mark.file) == recipe_library()["smt-aqueous"]
    assert mark.line == line_of(DEFAULT, "half_angle_deg: 30")
    assert Path(loaded.root.at(("templates", "around", "speed_mm_s")).mark.file).stem == "low-standoff"
