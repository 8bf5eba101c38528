"""``import washboard``: quick, opens, edits, plans, analyses, checks and exports as the commands do."""

import json
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest
from command import washboard

import washboard as wb
from specs.rows import Rows

BRIEF = """recipe: brief
extends: rinse-only
# a comment that stays
templates: {sweep: {speed_mm_s: 50}}
"""


@cache
def planned() -> wb.Planned:
    return wb.plan("tiny", "rinse-only")


def test_importing_it_loads_none_of_the_packages_that_do_the_work() -> None:
    code = "import sys, washboard; print(sorted({'numpy', 'pydantic', 'boards.board', 'webui'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_name_is_there_and_others_are_refused_with_the_list() -> None:
    assert all(getattr(wb, name) is not None for name in wb.__all__)
    assert dir(wb) == wb.__all__
    with pytest.raises(AttributeError, match="open_workpiece"):
        _ = wb.open  # type: ignore[attr-defined]


def test_an_edit_gives_another_recipe_checked_as_its_file_is(tmp_path: Path) -> None:
    (tmp_path / "brief.yaml").write_text(BRIEF, "utf-8")
    opened = wb.open_recipe(tmp_path / "brief.yaml")
    edited = opened.edit("templates.sweep.speed_mm_s", 30)
    assert (opened.recipe.templates["sweep"].speed_mm_s, edited.recipe.templates["sweep"].speed_mm_s) == (50, 30)
    assert "# a comment that stays" in edited.text
    both = opened.edit({"templates.sweep.speed_mm_s": 35, "limits.blend_mm": 0.2})
    assert (both.recipe.templates["sweep"].speed_mm_s, both.recipe.limits.blend_mm) == (35, 0.2)
    with pytest.raises(
        wb.JobError, match=r"templates\.sweep\.speed_mm_s: must be at least 0\.01 mm/s, not -5"
    ) as refused:
        opened.edit("templates.sweep.speed_mm_s", -5)
    assert str(refused.value).startswith(f"{tmp_path / 'brief.yaml'} as edited: templates")
    (tmp_path / "wrong.yaml").write_text(BRIEF.replace("50", "-5"), "utf-8")
    checked = washboard("recipe", "check", tmp_path / "wrong.yaml")
    assert str(refused.value).split("templates", 1)[1] in checked.err
    copy = edited.save(tmp_path / "copy.yaml")
    assert wb.open_recipe(copy).recipe.templates["sweep"].speed_mm_s == 30


def test_a_plan_is_that_of_the_command(tmp_path: Path) -> None:
    assert washboard("plan", "tiny", "rinse-only", "-o", tmp_path / "c.wash", "--report", tmp_path / "c.json").code == 0
    planned().save(tmp_path / "f.wash", report=tmp_path / "f.json")
    assert (tmp_path / "f.wash").read_bytes() == (tmp_path / "c.wash").read_bytes()
    assert (tmp_path / "f.json").read_bytes() == (tmp_path / "c.json").read_bytes()
    assert planned().duration_s == json.loads((tmp_path / "c.json").read_text())["totals"]["duration_s"]


@pytest.mark.slow
def test_an_analysis_is_that_of_the_command(tmp_path: Path) -> None:
    program, page, data = tmp_path / "p.wash", tmp_path / "a.html", tmp_path / "a.json"
    planned().save(program)
    washboard("analyse", program, "--html", page, "--json", data)
    clean = wb.analyse(wb.open_program(program))
    assert clean.data() == data.read_bytes()
    assert clean.html() == page.read_text("utf-8")
    assert [each.component for each in clean.verdicts] == [each.name for each in clean.board_report.board.components]
    assert clean.component("U1").component == "U1"
    with pytest.raises(wb.JobError, match="no component or face 'U99'"):
        clean.component("U99")


@pytest.mark.slow
def test_a_check_and_an_export_are_those_of_the_commands(tmp_path: Path) -> None:
    planned().save(tmp_path / "p.wash")
    robot = wb.check(planned(), "ur5e-bench")
    assert robot.possible
    written, page = robot.export(tmp_path / "mine", "ur")
    washboard("export", tmp_path / "p.wash", "--cell", "ur5e-bench", "-o", tmp_path / "theirs")
    for each in (written, page):
        assert each.read_bytes() == (tmp_path / "theirs" / each.name).read_bytes()
    assert robot.picture().startswith(b"\x89PNG")


def test_what_cannot_be_done_is_refused_in_one_sentence() -> None:
    part = wb.open_workpiece("f-bracket")
    with pytest.raises(wb.JobError, match="tuning is for boards, and f-bracket is a part"):
        wb.tune(replace(planned(), run=replace(planned().run, workpiece=part)))
    with pytest.raises(wb.JobError, match=r"f-bracket is a part\. Open a recipe for parts, such as part-degrease"):
        wb.plan(part, "rinse-only")
    with pytest.raises(wb.JobError, match=r"tiny is a board\. Open a recipe for boards, such as smt-aqueous"):
        wb.plan("tiny", "part-degrease")


def test_results_show_themselves_in_a_notebook() -> None:
    plan = planned()
    assert "tiny with rinse-only: 8.3 s" in plan._repr_html_()
    assert plan._repr_png_().startswith(b"\x89PNG")
    assert plan.workpiece.components._repr_html_().count("<tr>") == 1 + len(plan.workpiece.components)
    assert "rinse-only" in plan.opened._repr_html_()
    assert repr(plan) == "<plan of rinse-only on tiny, 8.3 s>"
    assert repr(plan.workpiece.components) == "<5 rows of Component>"


def test_rows_are_escaped_and_may_be_empty() -> None:
    hostile = replace(planned().workpiece.components[0], name="<script>")
    assert "&lt;script&gt;" in Rows([hostile]).html()
    assert Rows().records() == []
    assert Rows().html().count("<tr>") == 1
