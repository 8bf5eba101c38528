import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from command import contents, washboard

from recipes.load import load_recipe
from specs.output_file import OutputFile

START = "from commandline.start import main; main()"
OWN = "recipe: own\nextends: smt-aqueous   # ours\nsequence:\n  - {function: clean, nozzle: ring60, paths: [edge]}\n"


@pytest.fixture
def own(tmp_path: Path) -> Path:
    file = tmp_path / "own.yaml"
    file.write_text(OWN, "utf-8")
    return file


@pytest.mark.slow
def test_a_new_recipe_is_written_and_the_old_one_is_left_alone(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    new, report = own.with_name("new.yaml"), own.with_name("new.json")
    write, recipes = OutputFile.write, list[str]()

    def note(file: OutputFile, content: str | bytes, known_as: Path | None = None) -> None:
        recipes.extend([content if isinstance(content, str) else content.decode()] * (file.path == new))
        write(file, content, known_as)

    monkeypatch.setattr(OutputFile, "write", note)
    done = washboard("tune", "tiny", own, "--analyses", "3", "-o", new, "--report", report)
    assert (done.code, done.err) == (1, "")
    assert 1 <= len(recipes) == len(set(recipes))  # what is there already could not be refused by a full disk
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
    assert "The 3 analyses are spent." in done.out
    assert "Pareto front" in done.out
    assert not new.with_name("new.yaml.tuning").exists()
    interrupted = own.with_name("again.yaml")
    words = ["tune", "tiny", str(own), "--analyses", "3", "-o", str(interrupted)]
    process = subprocess.Popen([sys.executable, "-c", START, *words], stderr=subprocess.PIPE, text=True)
    while process.poll() is None and not interrupted.exists():
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    line = process.communicate()[1]
    assert process.returncode == 130
    assert "error: interrupted; written before, and complete: " in line
    assert "; the best of 1 analysis: 1 of 5 clean, " in line
    assert line.endswith("; --resume goes on\n")
    assert line.count("\n") == 1
    assert load_recipe(interrupted).recipe == "again"
    refused = washboard(*words, "--resume", "--for", "clean-and-dry")
    assert (refused.code, "it is of another choice of options" in refused.err) == (2, True)
    refused = washboard(*words)
    assert (refused.code, "--resume to go on" in refused.err) == (2, True)
    folder, picture = own.with_name("front"), own.with_name("front.svg")
    done = washboard(*words, "--resume", "--front", folder, "--picture", picture)
    assert (done.code, done.err) == (1, "")
    assert interrupted.read_text("utf-8") == new.read_text("utf-8").replace("recipe: new", "recipe: again")
    front = sorted(each["front"] for each in told["trials"] if each["front"])
    assert [load_recipe(folder / f"front-{number}.yaml").recipe for number in front] == [f"front-{n}" for n in front]
    assert len(list(folder.iterdir())) == len(front)
    assert picture.read_bytes().startswith(b"<?xml")


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
        (["--worth", "saving=all"], "'all' is no number from 0 on below 100"),
        (["--worth", "saving=100"], "'100' is no number"),
        (["--worth", "gain=1"], "'gain' is no worth"),
        (["--worth", "saving=1", "--worth", "saving=2"], "stands twice"),
        (["--resume"], "--resume goes on with the recipe that -o names"),
        (["-o", "none.yaml", "--resume"], "there is none. Leave out --resume"),
        (["--picture", "front.jpg"], "a picture is written as .png or .svg"),
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


def test_a_board_that_cannot_be_planned_leaves_nothing_to_go_on_with(own: Path) -> None:
    own.with_name("other.csv").write_text("Ref,Height\nQ7,2\n", "utf-8")
    before = contents(own.parent)
    done = washboard("tune", "tiny", own, "--parts", own.with_name("other.csv"), "-o", own.with_name("new.yaml"))
    assert done.code == 2
    assert "1 rows of other.csv are not on the board: Q7. No row has a component" in done.err
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
