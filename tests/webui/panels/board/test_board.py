"""A board is chosen, uploaded, given up, coloured: what is refused changes nothing."""

import threading
from types import SimpleNamespace

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session
from viser import UploadedFile
from waiting import WAIT_S

from boards.load import board_library
from boards.part.sources import part_library
from boards.workpiece import load_workpiece
from webui.page.project import open_project
from webui.panels.board import board as board_panel
from webui.panels.board.board import BoardPanel

TINY = board_library()["tiny"].read_bytes()


class Scene:
    """Remembers what a panel asks of it."""

    def __init__(self):
        self.view = SimpleNamespace(components_by="nothing")
        self.legends = {}
        self.looked = []

    def look_at_board(self, side):
        self.looked.append(side)


@pytest.fixture
def opened(tmp_path):
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        panel = BoardPanel(page, Scene())
        page.open()
        yield page, panel
        page.close()


def wait_for_loader(panel):
    thread = panel._job._worker._last
    assert thread is not None
    thread.join(WAIT_S)
    assert not thread.is_alive()


def upload(page, panel, name, content, label="Import CAD"):
    press(page, label, UploadedFile(name, content))
    if panel._job._worker._last is not None:
        wait_for_loader(panel)


def test_samples_and_files_are_offered_and_what_is_shown_is_chosen(opened):
    page, _ = opened
    assert find(page, "Workpiece").options == (*board_library(), *part_library())
    assert find(page, "Workpiece").value == "tiny"


def test_another_board_is_loaded_and_shown(opened):
    page, panel = opened
    press(page, "Workpiece", "two-sided")
    wait_for_loader(panel)
    assert page.session.workpiece_name == "two-sided"
    assert page.session.board.name == "two-sided"
    assert page.session.run is None
    assert "two-sided" in panel._card.content
    assert panel._job._line.content == ""
    assert not panel._job._cancel.visible


def test_an_upload_is_loaded_and_listed(opened):
    page, panel = opened
    upload(page, panel, "mine.tri", TINY)
    assert page.session.workpiece_name == "mine.tri"
    assert find(page, "Workpiece").value == "mine.tri"
    assert page.client.said == []


@pytest.mark.parametrize(
    ("name", "content", "reason"),
    [
        ("broken.step", b"nothing", "is not a STEP file"),
        ("empty.tri", b"", "empty.tri"),
        ("virus.exe", b"MZ", "no reader"),
        ("../../etc/x.tri", TINY, "cannot be kept"),
        ("\ud800.tri", TINY, "cannot be kept"),
    ],
)
def test_a_bad_upload_says_why_and_changes_nothing(opened, name, content, reason):
    page, panel = opened
    before = page.session
    upload(page, panel, name, content)
    assert page.session is before
    assert len(page.client.said) == 1
    assert reason in page.client.said[0]
    assert "defect" not in page.client.said[0]
    assert list(page.project.folder.iterdir()) == []
    assert find(page, "Workpiece").value == "tiny"
    assert panel._job._line.content == ""


def test_a_vanished_or_foreign_board_is_refused(opened):
    page, panel = opened
    press(page, "Workpiece", "../secret.tri")
    wait_for_loader(panel)
    assert "outside the project folder" in page.client.said[0]
    assert page.session.workpiece_name == "tiny"
    assert find(page, "Workpiece").value == "tiny"


def test_heights_of_an_idf_library_are_kept_until_their_board_comes(opened):
    page, _ = opened
    press(page, "Import CAD", UploadedFile("mine.emp", b".HEADER"))
    assert (page.project.folder / "mine.emp").read_bytes() == b".HEADER"
    assert "import that one now" in page.client.said[0]
    assert page.session.workpiece_name == "tiny"


def test_a_parts_table_is_joined_to_the_board_that_is_shown(opened):
    page, panel = opened
    name = page.session.board.components[0].name
    upload(page, panel, "parts.csv", f"Ref,Package\n{name},SOIC-8_odd\n".encode(), "Join parts table")
    assert page.session.workpiece_name == "tiny"
    assert page.session.board.components[0].package == "SOIC-8_odd"
    upload(page, panel, "parts.ods", b"PK", "Join parts table")
    assert "no parts table" in page.client.said[-1]


def test_loading_is_given_up(opened, monkeypatch):
    page, panel = opened
    begun, go_on = threading.Event(), threading.Event()

    def slow(source, table, progress, *, over_faces):
        begun.set()
        assert go_on.wait(WAIT_S)
        return load_workpiece(source, table, progress, over_faces=over_faces)

    monkeypatch.setattr(board_panel, "load_workpiece", slow)
    press(page, "Workpiece", "two-sided")
    assert begun.wait(WAIT_S)
    assert panel._job._cancel.visible
    press(page, "Cancel")
    assert not panel._job._cancel.visible
    assert find(page, "Workpiece").value == "tiny"
    go_on.set()
    wait_for_loader(panel)
    assert page.session.workpiece_name == "tiny"
    assert page.client.said == []


def test_the_board_that_the_page_began_with_can_be_chosen_again(tmp_path):
    from dataclasses import replace

    session = replace(tiny_session(), workpiece_name="/elsewhere/tiny.tri")
    with small_page(session, open_project(tmp_path)) as page:
        panel = BoardPanel(page, Scene())
        page.open()
        press(page, "Workpiece", "two-sided")
        wait_for_loader(panel)
        press(page, "Workpiece", "/elsewhere/tiny.tri")
        wait_for_loader(panel)
        assert page.session.board is session.board
        page.close()


def test_either_side_is_looked_at(opened):
    page, panel = opened
    press(page, "Look at", "Bottom side")
    press(page, "Look at", "Top side")
    assert panel._scene.looked == ["bottom", "top"]
