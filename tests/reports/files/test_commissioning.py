"""The page beside a robot's program: its order, its facts, the same bytes each time."""

import re
from dataclasses import replace
from functools import cache

import pytest
from installations import ARM_LANGUAGES, MACHINE_LANGUAGES, full_cell
from robot_programs import PROGRAMS, joints_of, machine_joints_of

from programs.export import Variant, export
from programs.posts.dialects import DIALECTS
from programs.program import TimedProgram
from reports.files.commissioning import commissioning_page, page_name
from reports.files.robot_programs import CellExport
from robotcell.cell.load import read_cell
from robotcell.track import CellReport
from specs.finding import Finding
from specs.finding_rules import DOSE_DIFFERS
from specs.source import NO_SOURCE

NAMED = pytest.mark.parametrize("name", list(DIALECTS))
TITLES = ("Load", "Left to do by hand", "Compare with the real cell", "Signals", "What the program does", "Start")


@cache
def done(name: str, made: str = "two_tools", first_run: bool = False) -> CellExport:
    cell, program = full_cell(name), PROGRAMS[made]()
    joints = joints_of(program) if name in ARM_LANGUAGES else machine_joints_of(program, cell)
    place = read_cell("gantry" if name in MACHINE_LANGUAGES else "ur5e-bench").cell
    return CellExport(
        CellReport(place, program, program, ()), export(program, cell, name, joints, Variant(first_run=first_run))
    )


@NAMED
def test_a_page_states_what_to_do_in_this_order(name: str) -> None:
    page, exported = done(name).page, done(name).exported
    headings = re.findall(r"(?m)^## (\d)\. (.*)$", page)
    assert headings == [(str(at), title) for at, title in enumerate((*TITLES, "What is known of it"), start=1)]
    for file in exported.files:
        assert f"`{file}`" in page
    for task in exported.handover.tasks:
        assert task.text[1:].replace("<", "\\<") in page
        assert all(line in page for line in task.lines)
    for each in exported.handover.signals:
        assert re.search(rf"(?m)^\| (input |output) \| {each.name} ", page)
    if shared := exported.handover.shared:
        assert f"- Shared with other programs of this cell: {shared}. All else has names of its own.\n" in page
    assert "\n\n\n" not in page
    assert page.endswith("\n")
    assert page == commissioning_page(done(name).report, exported, done(name).findings)


@NAMED
def test_the_lines_to_be_entered_are_code(name: str) -> None:
    page = done(name).page
    code = {line[7:] for line in page.splitlines() if line.startswith(7 * " ")}
    assert code == {line for task in done(name).exported.handover.tasks for line in task.lines}


@NAMED
def test_odd_names_stay_within_their_lines(name: str) -> None:
    page = done(name, "odd_names").page
    assert all(line.isprintable() for line in page.splitlines())
    assert len([line for line in page.splitlines() if line.startswith("# ")]) == 1


@pytest.mark.parametrize("name", ["kuka", "linuxcnc"])
def test_the_page_of_a_first_run_says_how_to_go_on(name: str) -> None:
    first, own = done(name, first_run=True), done(name)
    assert "Then load the program exported without --first-run" in first.page
    assert "`--first-run`" in own.page
    assert page_name(first.exported.files) != page_name(own.exported.files)


def test_what_is_not_to_be_read_as_markdown_or_html_is_not() -> None:
    exported = done("kuka").exported
    odd = replace(exported.handover.signals[0], name="a|b", use="<script>")
    signals = (odd, *exported.handover.signals[1:])
    page = commissioning_page(
        done("kuka").report, replace(exported, handover=replace(exported.handover, signals=signals)), ()
    )
    assert "a\\|b" in page
    assert "\\<script>" in page
    assert "- No errors, no warnings." in page


def test_findings_stand_once_a_rule_with_their_number_and_verdicts_come_first() -> None:
    found = [Finding(DOSE_DIFFERS, f"{at} strokes differ.", NO_SOURCE) for at in range(3)]
    page = commissioning_page(done("kuka").report, done("kuka").exported, found, verdicts=("Predicted clean: all",))
    end = page.partition("## 7. ")[2]
    assert "- Predicted clean: all.\n- warning `dose-differs`, and 2 more: 0 strokes differ.\n" in end


def test_what_is_packed_with_it_is_listed() -> None:
    page = commissioning_page(done("ur").report, done("ur").exported, (), beside={"tiny.wash": "The timed program."})
    assert "- Beside it `tiny.wash`: the timed program.\n" in page


def test_a_program_that_fits_no_robot_has_a_page_too() -> None:
    nothing: TimedProgram = PROGRAMS["three_speeds"]()
    report = CellReport(read_cell("ur5e-bench").cell, nothing, nothing, ())
    assert "## 7." in CellExport(report, export(nothing, full_cell("ur"), "ur")).page
