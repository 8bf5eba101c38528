import io
import zipfile
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from html import unescape
from pathlib import Path
from types import SimpleNamespace

import pytest
from cleaning_report import small_report
from made_findings import made_finding
from small_page import find, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from cleaning.analyse import analyse_on
from cleaning.parameters.load import load_parameters
from programs.errors import ProgramError
from programs.posts.dialects import DIALECTS
from reports.files.robot_programs import export_tracked
from robotcell.cell.load import read_cell
from washboard import driven
from webui.downloads import downloads
from webui.downloads.downloads import (
    KINDS,
    RobotProgram,
    _everything,
    _language_of,
    download_program,
    forbidding,
    judge_program,
    make_download,
    make_program,
)
from webui.page.evaluations import Analysed, AnalysisSettings, analyse_run, check_program
from webui.page.project import open_project
from webui.panels.robot.program import ProgramPanel, written_html

pytestmark = pytest.mark.slow

EVERYTHING = next(iter(KINDS))


def quiet(_what, _done):
    pass


@cache
def ready(maker="universal-robots"):
    """A session whose program was checked in a cell, with a robot that counts as one of that maker."""
    cell = read_cell("ur5e-bench")
    cell = replace(cell, cell=replace(cell.cell, robot=replace(cell.cell.robot, maker=maker)))
    session = replace(tiny_session(), cell=cell, cell_name="ur5e-bench")
    return replace(session, checked=check_program(session.run, cell, quiet))


@cache
def written():
    """The program of ``ready`` in the language of its robot."""
    return make_program(ready(), "ur", quiet)


def still():
    """The check of ``ready`` for a robot that cannot do the program."""
    done = ready().check
    return replace(done, motion=None, report=replace(done.report, joints=done.report.joints[:0]))


def in_language(made, dialect, **changed):
    exported = replace(made.written.exported, **changed)
    return replace(made, written=replace(made.written, dialect=dialect, exported=exported))


def test_a_program_is_written_of_what_was_checked_and_packed_alike_each_time():
    one, same = (make_program(ready("fanuc"), "fanuc", quiet) for _ in range(2))
    assert one.checked is ready("fanuc").check
    packed = download_program(one, ())
    assert packed == download_program(same, ())
    assert packed.name == "tiny-smt-aqueous-fanuc.zip"
    with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
        files = {name: archive.read(name).decode() for name in archive.namelist()}
    assert files == {"TISX45.ls.commissioning.md": one.page(), **one.written.exported.files}


def test_a_program_of_one_file_is_packed_with_its_page() -> None:
    made = written()
    packed = download_program(made, ())
    assert packed.name == "tiny-smt-aqueous-ur.zip"
    with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
        names = archive.namelist()
        assert archive.read("tiny__smt_aqueous.script.commissioning.md").decode() == made.page()
    assert sorted(names) == ["tiny__smt_aqueous.script", "tiny__smt_aqueous.script.commissioning.md"]


def test_a_zip_has_every_file_of_the_job_as_it_is_downloaded_alone(monkeypatch):
    monkeypatch.setattr(downloads, "make_program", lambda *_: written())
    session = replace(ready(), analysed=Analysed(ready().played.program, "default", small_report()))
    told = []
    packed = make_download(EVERYTHING, session, (), 10.0, lambda what, share: told.append((what, share)))
    assert packed.name == "tiny-smt-aqueous.zip"
    with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
        files = {name: archive.read(name) for name in archive.namelist()}
    listed = files.pop("tiny__smt_aqueous.script.commissioning.md").decode()
    assert [name for name in files if f"`{name}`" not in listed] == []
    for words in (
        DIALECTS["ur"].notes,
        "workpiece is held by its front left corner, which is at 400, -50, 150",
        "Predicted clean",
    ):
        assert words in listed
    cell_file = Path(session.cell.root.mark.file)
    assert files.pop(f"cell-{cell_file.name}") == cell_file.read_bytes()
    for kind in ("Program (.wash)", "Report (JSON)", "Recipe (YAML)", "Cleaning report (JSON)"):
        alone = make_download(kind, session, (), 10.0, quiet)
        assert files.pop(alone.name) == alone.content
    robot = written().written.exported.files
    assert {name: files.pop(name).decode() for name in robot} == dict(robot)
    left = {"tiny-smt-aqueous.png", "tiny-smt-aqueous-joints.png", "tiny-smt-aqueous-cleaning.html"}
    assert files.keys() == left
    assert all(content[:4] == b"\x89PNG" for name, content in files.items() if name.endswith(".png"))
    assert [share for _, share in told] == sorted(share for _, share in told)


def test_a_zip_without_cell_and_analysis_has_the_files_of_the_plan(monkeypatch):
    monkeypatch.setattr(downloads, "_content", lambda suffix, *_: suffix.encode())
    files = _everything(tiny_session(), tiny_session().run, (), quiet)
    names = [f"tiny-smt-aqueous{end}" for end in (".wash", ".json", ".png")] + ["smt-aqueous.yaml"]
    assert list(files) == names


def test_what_forbids_the_robots_program_forbids_the_zip(monkeypatch):
    done = ready().check
    wrong = replace(done, report=replace(done.report, findings=(made_finding("collision", "error", "the wall"),)))
    nothing = SimpleNamespace(exported=SimpleNamespace(findings=()))
    monkeypatch.setattr(downloads, "make_program", lambda *_: RobotProgram(wrong, nothing))
    with pytest.raises(ProgramError, match="the wall"):
        make_download(EVERYTHING, replace(ready(), checked=wrong), (), 10.0, quiet)


def test_for_a_robot_without_a_language_of_its_own_one_has_to_be_chosen():
    cell = ready().cell
    other = replace(cell, cell=replace(cell.cell, robot=replace(cell.cell.robot, maker=None)))
    with pytest.raises(ProgramError, match="choose one in the tab Program"):
        _language_of(replace(tiny_session(), cell=other))
    assert _language_of(replace(tiny_session(), cell=other, language="joint-table")) == "joint-table"


def test_a_project_is_packed_in_its_folder():
    content = {"tiny.pjx": "list\n", "start.pgx": "code\n"}
    made = written()
    packed = download_program(in_language(made, "val3", files=content, language=DIALECTS["val3"]), ())
    assert packed.name == "tiny-smt-aqueous-val3.zip"
    with zipfile.ZipFile(io.BytesIO(packed.content)) as archive:
        assert archive.namelist() == ["tiny/tiny.pjx.commissioning.md", *(f"tiny/{name}" for name in content)]


def test_a_program_for_another_makers_robot_is_refused():
    with pytest.raises(ProgramError, match=r"ABB RAPID is for ABB, and robot ur5e .* choose ur"):
        make_program(ready(), "abb", quiet)


def test_a_program_that_was_not_checked_is_checked_first(monkeypatch):
    done, told = ready().check, []
    monkeypatch.setattr(downloads, "check_program", lambda run, cell, progress: replace(done, run=run, cell=cell))
    fresh = replace(ready(), checked=None)
    made = make_program(fresh, "ur", lambda what, share: told.append((what, share)))
    assert made.checked.run is fresh.run
    assert told[-1] == ("writing", 0.8)


def test_without_cell_or_plan_there_is_no_program():
    with pytest.raises(ProgramError, match="no cell"):
        make_program(tiny_session(), "ur", quiet)
    with pytest.raises(ProgramError, match="not planned"):
        make_program(replace(ready(), run=None), "ur", quiet)


def test_errors_forbid_the_download_until_their_rules_are_allowed():
    done = ready().check
    wrong = replace(
        done, report=replace(done.report, findings=(made_finding("collision", "error", "it hits the wall"),))
    )
    made = make_program(replace(ready(), checked=wrong), "ur", quiet)
    assert forbidding(made.findings).keys() == {"collision"}
    with pytest.raises(ProgramError, match="it hits the wall"):
        download_program(made, ())
    assert download_program(made, ("collision",)).name == "tiny-smt-aqueous-ur.zip"


def test_what_a_robot_cannot_do_is_written_as_planned_and_says_so():
    made = make_program(replace(ready(), checked=still()), "ur", quiet)
    assert "tiny__smt_aqueous.script" in made.written.exported.files
    with pytest.raises(ProgramError, match="joint values"):
        make_program(replace(ready(), checked=still()), "joint-table", quiet)


def test_the_page_writes_the_bytes_of_the_command():
    done = export_tracked(ready().check.report, ready().cell, "linuxcnc").exported
    assert dict(make_program(ready(), "linuxcnc", quiet).written.exported.files) == dict(done.files)


def test_the_analysis_of_the_plan_is_not_made_again(monkeypatch):
    calls = []

    def count(*words, **rest):
        calls.append(words[1])
        return analyse_on(*words, **rest)

    monkeypatch.setattr(driven, "analyse_on", count)
    run = ready().run
    analysed = analyse_run(run, AnalysisSettings("default", load_parameters("default"), "sketch"), None, quiet)
    session = replace(ready(), analysed=analysed)
    judged = judge_program(written(), session, analysed.prepared.parameters, quiet)
    assert len(calls) == 1
    assert calls[0] is not run.program
    assert judged.verdict.planned is analysed.report
    driven_now = replace(session, judged=judged)
    assert driven_now.judged_now is judged
    assert any("as driven" in line or "drives it" in line for line in downloads._verdicts(driven_now))
    assert replace(driven_now, parameters_name="other").judged_now is None
    with pytest.raises(ProgramError, match="nothing is driven"):
        judge_program(replace(written(), checked=still()), session, analysed.prepared.parameters, quiet)


def test_the_worst_event_error_is_said_and_findings_are_text():
    made = written()
    html = written_html(made)
    assert f"{made.written.exported.error.distance_mm:.2f} mm" in html
    assert made.written.exported.forecast.describe() in unescape(html)
    odd = in_language(made, "ur", findings=(made_finding("r", "warning", "<script>"),))
    assert "<script>" not in written_html(odd)


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        sent = []
        page.client.send_file_download = lambda name, content, **_: sent.append((name, content))
        scene = SmallScene(page)
        panel = ProgramPanel(page, scene)
        page.open()
        yield page, panel, sent
        page.close()


def test_the_panel_writes_shows_and_gives_away(tmp_path):
    with opened(ready(), tmp_path) as (page, panel, sent):
        assert find(page, "Language").value == "URScript"
        press(page, "Write")
        wait_for(lambda: find(page, "Download").visible)
        assert "Events" in panel._run._line.content
        press(page, "Download")
        packed = download_program(written(), ())
        assert sent == [(packed.name, packed.content)]
        press(page, "Judge as driven")
        wait_for(lambda: page.session.judged_now is not None)
        assert "driven by" in panel._judge._line.content
        press(page, "Language", "Joint look-up table")
        wait_for(lambda: "tiny__smt_aqueous.csv" in find(page, "File").options)
        assert page.session.language == "joint-table"
        page.show(replace(page.session, run=replace(page.session.run)))
        assert not find(page, "Download").visible
        assert not find(page, "Judge as driven").visible
        assert page.session.judged_now is None
        assert "changed" in panel._run._line.content


def test_without_a_cell_the_panel_says_where_to_choose_one(tmp_path):
    with opened(tiny_session(), tmp_path) as (page, panel, _):
        assert not find(page, "Write").visible
        assert "tab Robot" in panel._run._line.content


def test_what_keeps_a_program_from_being_written_is_said_in_the_tab(tmp_path):
    with opened(replace(ready(), checked=still()), tmp_path) as (page, panel, _):
        press(page, "Language", "Joint look-up table")
        press(page, "Write")
        wait_for(lambda: "joint values" in panel._run._line.content)
        assert find(page, "Write").label == "Write"
        assert not find(page, "Download").visible
