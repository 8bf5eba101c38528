"""A program that was read is shown in place of the job: nothing can be edited, and the job goes on afterwards."""

import pytest
from small_page import find, inputs, press, small_page, windows
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from programs.errors import ProgramError
from programs.export import export
from robotcell.cell.installation import installation_of
from robotcell.cell.load import read_cell
from webui.page.project import open_project
from webui.page.session import READ_ONLY
from webui.panels.recipe.recipe import RecipePanel
from webui.panels.recipe.text import TextPanel
from webui.panels.results.overview import status_html
from webui.panels.robot.program import CLOSE, OPEN, UPLOAD, ProgramPanel


@pytest.fixture
def page(tmp_path):
    session = tiny_session()
    for name, text in export(session.run.program, installation_of(read_cell("ur5e-bench")), "ur").files.items():
        (tmp_path / name).write_text(text)
    broken = (tmp_path / "tiny__smt_aqueous.script").read_text().replace("movel(", "moveq(", 1)
    (tmp_path / "broken.script").write_text(broken)
    with small_page(session, open_project(tmp_path)) as page:
        scene = SmallScene(page)
        RecipePanel(page, scene)
        TextPanel(page, scene)
        ProgramPanel(page, scene)
        page.open()
        yield page
        page.close()


def open_named(page, name):
    press(page, OPEN)
    assert windows(page)
    press(page, "Program", name)
    press(page, "Open", at=-1)


@pytest.mark.slow
def test_a_program_is_shown_read_only_and_closed_again(page):
    job = page.session
    text, section = find(page, "YAML"), find(page, "Section")
    open_named(page, "tiny__smt_aqueous.script")
    wait_for(lambda: page.session.shown is not None)
    shown = page.session
    assert shown.timed.program.totals.duration_s > 0
    assert shown.plan is shown.shown.run.plan
    assert "Read from URScript" in status_html(shown, None, "", 0.0)
    wait_for(lambda: text.disabled)  # its panels follow one after the other
    wait_for(lambda: not section.visible)
    wait_for(lambda: not find(page, OPEN).visible)
    assert not page.attempt(lambda session: session.set_value(("templates", "sweep", "speed_mm_s"), 12))
    assert READ_ONLY in page.client.said[-1]
    assert page.session is shown
    with pytest.raises(ProgramError, match="cannot be edited"):
        _ = shown.planned_run
    press(page, CLOSE)
    assert page.session.run is job.run
    assert page.session.document is job.document
    assert (page.session.board, page.session.cell) == (job.board, job.cell)
    assert not text.disabled
    assert section.visible
    assert page.attempt(lambda session: session.set_value(("templates", "sweep", "speed_mm_s"), 12))


@pytest.mark.slow
def test_the_job_stays_where_reading_fails(page):
    job = page.session
    open_named(page, "broken.script")
    wait_for(lambda: len(page.client.said) > 0)
    assert "broken.script:" in page.client.said[-1]
    assert "moveq" in page.client.said[-1]
    assert (page.session.run, page.session.document) == (job.run, job.document)
    assert page.session.shown is None
    assert find(page, UPLOAD).visible
    assert not any(getattr(handle, "label", "") == CLOSE and handle.visible for handle in inputs(page))
