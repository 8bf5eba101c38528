import io
import json
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest
from cleaning_report import small_report, soaked_report
from command import contents, washboard
from rich.console import Console

from cleaning.verdicts.results import CleaningReport
from reports.cards.cleaning import worst_card
from reports.tables.cleaning_tables import headline
from reports.terminal.console import print_card


def told(report: CleaningReport) -> str:
    lines = io.StringIO()
    print_card(Console(file=lines, width=10_000), worst_card(report, 12.3))
    return lines.getvalue()


@pytest.mark.slow
def test_the_demonstration_does_all_of_it_and_dirt_is_no_failure(tmp_path: Path) -> None:
    done = washboard("demo", "--into", tmp_path / "out", "--board", "tiny", "--recipe", "rinse-only")
    assert (done.code, done.err) == (0, "")
    written = contents(tmp_path / "out")
    ends = (
        ".wash",
        ".json",
        "__rinse_only.script",
        "__rinse_only.script.commissioning.md",
        "-board.png",
        "-paths.png",
        "-joints.png",
        "-cleaning.html",
        "-cleaning.json",
    )
    assert set(written) == {f"tiny{end}" for end in ends}
    found = json.loads(written["tiny-cleaning.json"])
    assert found["recipe"]["name"] == "rinse-only"
    assert found["verdict"] != "clean"
    assert (found["washboard"], found["effort"]) == (version("washboard"), "fast")
    assert all(name in done.out for name in written)
    assert done.out.index("can be done") < done.out.index("no proof of cleanliness")
    page = written["tiny-cleaning.html"].decode()
    assert page.startswith("<!DOCTYPE html>")
    headlines = [line.partition("clean. ")[2] for line in done.out.splitlines() if "what comes out clean. " in line]
    assert len(headlines) == 1
    assert headlines[0] in page


def test_the_worst_three_are_told_with_their_reasons_and_what_it_is_worth() -> None:
    report = small_report()
    lines = told(report).splitlines()
    assert lines[0].endswith(headline(report))
    assert "uncalibrated" in lines[1]
    assert "1 of 2 that are not clean fail by R7 residue" in lines[2]
    assert lines[3].split(maxsplit=1)[1].strip() == "1 dirty, 1 marginal, 1 no verdict, 2 clean"
    wanting = report.worst_first()[:3]
    assert [line.split()[0] for line in lines[4:7]] == [part.component for part in wanting]
    for line, part in zip(lines[4:7], wanting, strict=True):
        assert f"{part.verdict}: {part.judgements[0].because}" in line
    assert lines[7].split() == ["analysed", "in", "12.3", "s"]
    assert len(lines) == 8


def test_a_part_that_is_clean_and_stays_wet_is_not_called_marginal() -> None:
    report = soaked_report()
    clean = replace(report, parts=tuple(part for part in report.parts if part.component in ("C1", "R2")))
    assert "C1 and 1 more  clean, wet: It stays wet." in told(clean)


def test_of_a_clean_board_no_part_is_named() -> None:
    clean = tuple(part for part in small_report().parts if part.verdict == "clean")
    report = replace(small_report(), verdict="clean", parts=clean)
    lines = told(report).splitlines()
    assert lines[0].endswith(headline(report))
    assert [line.split()[0] for line in lines[2:]] == ["verdicts", "analysed"]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("--cell", "kr6-bench", "--dialect", "ur"), "URScript is for Universal Robots"),
        (("--cell", "gantry"), "give --dialect"),
    ],
)
def test_another_makers_robot_is_refused_before_anything_is_written(
    tmp_path: Path, words: tuple[str, ...], reason: str
) -> None:
    done = washboard("demo", "--into", tmp_path / "out", "--board", "tiny", *words)
    assert done.code == 2
    assert reason in done.err
    assert not (tmp_path / "out").exists()
