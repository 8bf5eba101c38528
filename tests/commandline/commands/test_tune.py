import json
from pathlib import Path

import pytest
from command import contents, washboard

from recipes.load import load_recipe

OWN = "recipe: own\nextends: smt-aqueous   # ours\nsequence:\n  - {function: clean, nozzle: ring60, paths: [edge]}\n"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    file = tmp_path / "own.yaml"
    file.write_text(OWN, "utf-8")
    return file


@pytest.mark.slow
def test_a_new_recipe_is_written_and_the_old_one_is_left_alone(own: Path) -> None:
    new, report = own.with_name("new.yaml"), own.with_name("new.json")
    done = washboard("tune", "tiny", own, "--analyses", "3", "-o", new, "--report", report)
    assert (done.code, done.err) == (1, "")
    assert own.read_text("utf-8") == OWN
    assert load_recipe(new).recipe == "new"
    assert "extends: smt-aqueous   # ours" in new.read_text("utf-8")
    told = json.loads(report.read_text("utf-8"))
    assert told["analyses"] == {"used": 3, "most": 3}
    assert told["after"]["open_requirements"] <= told["before"]["open_requirements"]
    assert {each["component"] for each in told["unmet"]} >= {"U1"}
    assert "-recipe: own\n+recipe: new\n" in told["diff"]
    assert "Not clean: " in done.out
    assert "3 of at most 3" in done.out
    assert "+recipe: new" in done.out
    assert "a higher --analyses" in done.out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--limit", "time=soon"], "'soon' is no positive number"),
        (["--limit", "minutes=3"], "'minutes' is no limit"),
        (["--allow", "speed"], "did you mean 'speeds'"),
        (["--keep", "templates.arround"], "did you mean 'around'"),
        (["--keep", "nothing at all"], "nothing to keep there"),
        (["--parameters", "defualt"], "defualt"),
        (["--analyses", "1"], "--analyses"),
        (["--cell", "kr6-bnech"], "kr6-bench"),
        (["--for", "shiny"], "shiny"),
    ],
)
def test_words_that_mean_nothing_are_refused(own: Path, words: list[str], told: str) -> None:
    before = contents(own.parent)
    done = washboard("tune", "tiny", own, *words)
    assert done.code == 2
    assert told in done.err
    assert done.err.startswith("error: ")
    assert "Traceback" not in done.err
    assert contents(own.parent) == before


def test_the_recipe_itself_is_never_written(own: Path) -> None:
    done = washboard("tune", "tiny", own, "-o", own)
    assert done.code == 2
    assert "it is read by this command" in done.err
    assert own.read_text("utf-8") == OWN


def test_no_recipe_that_is_there_is_written_over(own: Path) -> None:
    other = own.with_name("other.yaml")
    other.write_text("recipe: other\n", "utf-8")
    done = washboard("tune", "tiny", own, "-o", other)
    assert done.code == 2
    assert "it is there already" in done.err
    assert other.read_text("utf-8") == "recipe: other\n"


def test_a_name_that_cannot_be_a_recipes_is_refused_at_once(own: Path) -> None:
    done = washboard("tune", "tiny", own, "-o", own.with_name("7 up.yaml"))
    assert done.code == 2
    assert "cannot name a recipe" in done.err
