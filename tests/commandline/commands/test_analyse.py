import hashlib
import json
import re
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest
from cleaning_report import small_report, soaked_report
from command import contents, washboard

from boards.load import load_board
from washboard import cleaned


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("planned") / "tiny.wash"
    assert washboard("plan", "tiny", "rinse-only", "-o", path).code == 0
    return path


def report_instead(monkeypatch: pytest.MonkeyPatch, **changed: object) -> None:
    """Let every analysis find the small report: its command is what is tried here."""
    monkeypatch.setattr(cleaned, "analyse_on", lambda *_, **_named: replace(small_report(), **changed))


@pytest.mark.slow
def test_a_program_is_analysed_with_the_board_and_recipe_that_are_found_and_twice_the_same(
    program: Path, tmp_path: Path
) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        files = ("--html", tmp_path / name / "t.html", "--json", tmp_path / name / "t.json")
        done = washboard("analyse", program, *files, "--verify", "U1")
        assert (done.code, done.err) == (1, "")
        assert "Predicted: " in done.out
        assert "no proof of cleanliness" in done.out
        assert "exact, mm" in done.out
    assert contents(tmp_path / "one") == contents(tmp_path / "two")
    told = json.loads((tmp_path / "one" / "t.json").read_text("utf-8"))
    assert [each["component"] for each in told["components"]] == ["C1", "J1", "R1", "R2", "U1"]
    assert told["recipe"]["name"] == "rinse-only"
    assert told["stages"][0]["sprayed_mm3"] > told["stages"][0]["landed_mm3"] >= 0
    assert (tmp_path / "one" / "t.html").read_text("utf-8").startswith("<!DOCTYPE html>")


def test_a_clean_board_ends_with_zero(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    parts = tuple(part for part in small_report().parts if part.verdict == "clean")
    report_instead(monkeypatch, verdict="clean", parts=parts)
    done = washboard("analyse", program)
    assert done.code == 0, done.err
    assert "all of 2 components clean" in done.out
    assert "2 clean" in done.out


@pytest.mark.slow
@pytest.mark.parametrize("verdict", ["dirty", "marginal", "no verdict"])
def test_anything_else_ends_with_one(program: Path, monkeypatch: pytest.MonkeyPatch, verdict: str) -> None:
    report_instead(monkeypatch, verdict=verdict)
    assert washboard("analyse", program).code == 1


@pytest.mark.slow
def test_the_worst_come_first_with_what_to_do(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report_instead(monkeypatch)
    told = washboard("analyse", program).out
    assert told.index("U1 ") < told.index("R1 ") < told.index("J1 ")
    assert "Wash it longer: time limits it most." in told
    assert "1 dirty, 1 marginal, 1 no verdict, 2 clean" in told
    assert "values of default: " in told
    assert "takes       1 min 32 s, 2.60 l" in told
    report_instead(monkeypatch, litres=())
    assert "takes       1 min 32 s, no liquid" in washboard("analyse", program).out


def test_what_is_clean_and_stays_wet_is_not_called_marginal(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report_instead(monkeypatch, parts=soaked_report().parts)
    rows = {line.split()[0].rstrip(","): line for line in washboard("analyse", program).out.splitlines() if line}
    assert re.search(r"C1, R2 +clean, wet +B +R12 ", rows["C1"])
    assert re.search(r"R1 +marginal +B +R10 ", rows["R1"])
    assert re.search(r"J1 +no verdict +A +R14 ", rows["J1"])


@pytest.mark.slow
def test_every_report_says_by_which_version_and_how_thoroughly_it_was_made(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report_instead(monkeypatch)
    page, data = tmp_path / "t.html", tmp_path / "t.json"
    out = washboard("analyse", program, "--html", page, "--json", data, "--effort", "full").out
    assert f"analysed    by Washboard {version('washboard')}, effort full" in out.splitlines()
    assert f"Analysed by Washboard {version('washboard')}, effort full." in page.read_text("utf-8")
    told = json.loads(data.read_text("utf-8"))
    assert [*told][:3] == ["washboard_cleaning_report", "washboard", "effort"]
    assert (told["washboard"], told["effort"]) == (version("washboard"), "full")


def test_facts_have_no_blanks_at_their_ends(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report_instead(monkeypatch, parts=soaked_report().parts)
    lines = washboard("analyse", program).out.splitlines()
    facts = [line for line in lines if re.match(r"(components|wet|takes|assumed|noted|analysed)  ", line)]
    assert len(facts) >= 6
    assert [line for line in facts if line != line.rstrip()] == []
    assert {re.match(r"\w+ +", line).end() for line in facts} == {12}, "they stand in one column"


@pytest.mark.parametrize("option", ["--html", "--json"])
def test_no_file_is_called_like_a_pipe(program: Path, option: str) -> None:
    commands = (("analyse", program), ("compare", "tiny", "rinse-only", "dry-only"))
    for done in (washboard(*words, option, "-") for words in commands):
        assert (done.code, done.out) == (2, "")
        assert "-: cannot be written: stdout has the summary. Name a file." in done.err


@pytest.mark.slow
def test_what_was_entered_stands_in_the_report(program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    report_instead(monkeypatch)
    entered = (
        "--serial",
        "SN 42",
        "--detergent",
        "Lot 7",
        "--bath-c",
        "61",
        "--conductivity",
        "0.8",
        "--date",
        "Monday",
    )
    washboard("analyse", program, "--html", tmp_path / "t.html", *entered)
    page = (tmp_path / "t.html").read_text("utf-8")
    assert all(f"<b>{word}</b>" in page for word in entered[1::2])


def test_what_is_not_at_hand_is_said_with_what_to_do(program: Path, tmp_path: Path) -> None:
    text = program.read_text("utf-8")
    stray = tmp_path / "stray.wash"
    stray.write_text(text.replace("RECIPE rinse-only", "RECIPE lost"), "utf-8")
    refused = washboard("analyse", stray)
    assert refused.code == 2
    assert "the recipe 'lost'" in refused.err
    assert "--recipe" in refused.err
    stray.write_text(text.replace("BOARD tiny", "BOARD lost"), "utf-8")
    refused = washboard("analyse", stray)
    assert refused.code == 2
    assert "the board 'lost'" in refused.err


def test_a_recipe_that_is_not_quite_the_one_is_used_with_a_warning(
    program: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report_instead(monkeypatch)
    done = washboard("analyse", program, "tiny", "--recipe", "smt-aqueous")
    assert done.code == 1
    assert re.search(r"warning: smt-aqueous \(sha256 [0-9a-f]{16}\) differs from the recipe", done.err)
    assert "noted       smt-aqueous" in done.out, "a report that is kept says it too"


def test_another_version_of_the_board_is_analysed_with_a_warning_and_the_report_is_of_it(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report_instead(monkeypatch)
    text = program.read_text("utf-8")
    older = tmp_path / "older.wash"
    sha = load_board(Path("tiny")).sha256
    older.write_text(text.replace(sha, "0" * 64), "utf-8")
    data = tmp_path / "t.json"
    done = washboard("analyse", older, "tiny", "--json", data)
    assert done.code == 1
    assert "differs from the board of this program, tiny (sha256 0000000000000000)" in done.err
    told = json.loads(data.read_text("utf-8"))
    assert told["board"] == {"name": "tiny", "sha256": sha}
    assert told["findings"][0]["rule"] == "board-differs"
    assert told["traceability"]["program_sha256"] == hashlib.sha256(older.read_bytes()).hexdigest()


def test_a_program_of_another_board_is_refused(program: Path) -> None:
    done = washboard("analyse", program, "two-sided")
    assert done.code == 2
    assert done.err.count("\n") == 1
    assert "made for the board tiny (sha256 " in done.err
    assert "not for two-sided" in done.err


@pytest.mark.slow
def test_a_parts_table_is_joined_to_the_board_that_is_found(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report_instead(monkeypatch)
    table = tmp_path / "bom.csv"
    table.write_text("reference,package\nU1,QFN-32\n", "utf-8")
    planned = tmp_path / "tiny.wash"
    assert washboard("plan", "tiny", "rinse-only", "--parts", table, "-o", planned).code == 0
    done = washboard("analyse", planned, "--parts", table)
    assert (done.code, done.err) == (1, "")
    assert "nix.csv" in washboard("analyse", planned, "--parts", tmp_path / "nix.csv").err


@pytest.mark.parametrize(("option", "name"), [("--html", "a.tri"), ("--json", "a.wash"), ("--html", "a.json")])
def test_a_file_that_is_named_like_another_thing_is_not_written(program: Path, option: str, name: str) -> None:
    done = washboard("analyse", program, option, program.parent / name)
    assert done.code == 2
    assert "its name is that of" in done.err


def test_mistakes_are_refused_before_the_long_work(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("the analysis began")

    monkeypatch.setattr(cleaned, "analyse_on", never)
    twice = washboard("analyse", program, "--html", tmp_path / "t", "--json", tmp_path / "t")
    assert (twice.code, "written twice" in twice.err) == (2, True)
    unknown = washboard("analyse", program, "--verify", "U1,U9")
    assert unknown.code == 2
    assert "no component 'U9'. Did you mean U1?" in unknown.err
    lost = washboard("analyse", program, "--parameters", "defualt")
    assert (lost.code, "Did you mean 'default'?" in lost.err) == (2, True)


@pytest.mark.slow
def test_what_was_worked_out_exactly_is_in_the_page_and_in_the_data(program: Path, tmp_path: Path) -> None:
    page, data = tmp_path / "t.html", tmp_path / "t.json"
    washboard("analyse", program, "--html", page, "--json", data, "--verify", "U1,R1")
    verified = json.loads(data.read_text("utf-8"))["verified"]
    assert [each["component"] for each in verified] == ["U1", "R1"]
    assert all(each["exact_mm"] > 0 and each["cells"] > 0 for each in verified)
    assert "Worked out exactly" in page.read_text("utf-8")


def test_components_of_which_the_same_is_said_stand_in_one_line(program: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    r1 = next(part for part in small_report().parts if part.component == "R1")
    alike = tuple(replace(r1, component=f"R{number}") for number in range(1, 16))
    report_instead(monkeypatch, parts=alike, verdict="marginal")
    lines = [
        line
        for line in washboard("analyse", program).out.splitlines()
        if "R10 incomplete rinse" in line and "fail by" not in line
    ]
    assert len(lines) == 1
    assert lines[0].startswith(", ".join(f"R{number}" for number in range(1, 13)) + " and 3 more")


@pytest.mark.slow
def test_two_recipes_are_compared(tmp_path: Path) -> None:
    files = ("--html", tmp_path / "both.html", "--json", tmp_path / "both.json")
    done = washboard("compare", "tiny", "rinse-only", "dry-only", *files)
    assert done.code == 0, done.err
    assert "no proof of cleanliness" in done.out
    assert "Total time" in done.out
    assert "Strokes" in done.out
    assert "Worst residue under a part" in done.out
    told = json.loads((tmp_path / "both.json").read_text("utf-8"))
    assert [each["recipe"]["name"] for each in told["reports"]] == ["rinse-only", "dry-only"]
    assert len(told["components"]) == 5
    assert "rinse-only and dry-only" in (tmp_path / "both.html").read_text("utf-8")


@pytest.mark.slow
def test_programs_are_compared_as_the_recipes_that_they_were_made_with(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report_instead(monkeypatch)
    by_recipe = washboard("compare", "tiny", "rinse-only", "dry-only").out.splitlines()
    dried = tmp_path / "dried.wash"
    assert washboard("plan", "tiny", "dry-only", "-o", dried).code == 0
    done = washboard("compare", "tiny", program, dried)
    assert (done.code, done.err) == (0, "")
    assert "tiny.wash and dried.wash" in done.out
    told = [line.split() for line in done.out.splitlines()]
    for name in ("Total time", "Travel", "Moves"):
        assert next(line for line in by_recipe if name in line).split() in told, "it is the same program"
    assert "Strokes" not in done.out


@pytest.mark.slow
def test_what_has_one_name_is_told_apart_by_its_file(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    report_instead(monkeypatch)
    (tmp_path / "mine.yaml").write_text("recipe: rinse-only\nextends: rinse-only\n", "utf-8")
    done = washboard("compare", "tiny", "rinse-only", tmp_path / "mine.yaml")
    assert f"rinse-only and {tmp_path / 'mine.yaml'}" in done.out


@pytest.mark.slow
def test_a_program_that_cannot_be_compared_is_refused_with_what_to_do(program: Path, tmp_path: Path) -> None:
    other = washboard("compare", "two-sided", program, "rinse-only")
    assert (other.code, "not for two-sided" in other.err) == (2, True)
    older = tmp_path / "older.wash"
    text = program.read_text("utf-8")
    older.write_text(text.replace(load_board(Path("tiny")).sha256, "0" * 64), "utf-8")
    changed = washboard("compare", "tiny", "rinse-only", older)
    assert (changed.code, "another version of tiny (sha256 0000" in changed.err) == (2, True)
    older.write_text(text.replace("RECIPE rinse-only", "RECIPE lost"), "utf-8")
    lost = washboard("compare", "tiny", "rinse-only", older)
    assert (lost.code, "Put it beside the program" in lost.err) == (2, True)


@pytest.mark.slow
def test_how_sure_that_is_is_printed_and_written(tmp_path: Path) -> None:
    program = tmp_path / "washed.wash"
    assert washboard("plan", "tiny", "-o", program).code == 0
    page, data = tmp_path / "a.html", tmp_path / "a.json"
    done = washboard("analyse", program, "--capability", "--html", page, "--json", data)
    found = json.loads(data.read_text("utf-8"))["capability"]
    assert f"in {100 * found['together']:.0f} of 100 sets of values" in done.out
    assert "How sure that is" in page.read_text("utf-8")
    shares = {each["component"]: each["clean_share"] for each in found["components"]}
    assert set(shares) == {"U1", "C1", "R1", "R2", "J1", "board"}
    plain = washboard("analyse", program, "--json", data)
    assert json.loads(data.read_text("utf-8"))["capability"] is None
    assert "sets of values" not in plain.out
