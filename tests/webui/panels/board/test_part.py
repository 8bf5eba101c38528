"""A part in the panels: opened, imported, its faces chosen and judged; what is for boards alone is not shown."""

from contextlib import contextmanager
from dataclasses import replace

import pytest
from part_session import ascii_stl, part_session
from small_page import find, press, small_page
from small_parts import block
from small_scene import SmallScene
from tiny_session import tiny_session
from viser import UploadedFile
from waiting import wait_for

from webui.cards.workpiece_card import face_html
from webui.layers.paths.strokes import stroke_lines
from webui.page.project import open_project
from webui.page.session import Selection
from webui.panels.board.board import BoardPanel, ComponentsPanel
from webui.panels.board.paths import PathsPanel, card_html
from webui.panels.cleaning.analysis import CleaningPanel

BOX = ascii_stl(block((0, 0, 0), (40, 30, 20)))


@contextmanager
def opened(session, folder, *kinds):
    with small_page(session, open_project(folder)) as page:
        scene = SmallScene(page)
        scene.legends = {}
        for kind in kinds:
            kind(page, scene)
        page.open()
        yield page, scene
        page.close()


@pytest.fixture(scope="module")
def session():
    return part_session()


def wait_for_name(page, name):
    wait_for(lambda: page.session.workpiece_name == name)


def test_a_mesh_is_imported_as_a_part_and_a_bad_one_leaves_all_as_it_was(session, tmp_path):
    with opened(session, tmp_path, BoardPanel) as (page, _):
        press(page, "Import CAD", UploadedFile("mine.stl", BOX))
        wait_for_name(page, "mine.stl")
        assert len(page.session.workpiece.faces) == 6
        before = page.session
        press(page, "Import CAD", UploadedFile("bad.stl", b"solid bad\nfacet"))
        wait_for(lambda: page.client.said)
        assert page.session is before
        assert len(page.client.said) == 1
        assert "\n" not in page.client.said[0]
        assert [file.name for file in tmp_path.iterdir()] == ["mine.stl"]


def test_another_recipe_reads_the_mesh_as_what_it_is_for(session, tmp_path):
    with opened(session, tmp_path, BoardPanel) as (page, _):
        press(page, "Import CAD", UploadedFile("mine.stl", BOX))
        wait_for_name(page, "mine.stl")
        part = page.session.workpiece
        boards = tiny_session().document
        page.attempt(lambda now: now.with_document(boards))
        wait_for(lambda: page.client.said)  # a box is no board
        assert "open a recipe for parts first" in page.client.said[0]
        assert page.session.workpiece is part


def test_what_is_for_boards_alone_is_not_shown(session, tmp_path):
    kinds = (BoardPanel, CleaningPanel, PathsPanel)
    with opened(session, tmp_path, *kinds) as (page, _):
        assert [find(page, label).visible for label in ("Parameters", "Effort", "How sure")] == [False] * 3
        assert not find(page, "Tune\N{HORIZONTAL ELLIPSIS}").visible
        assert find(page, "Stripes").visible
        assert find(page, "Lance").visible
        page.attempt(lambda now: now.with_workpiece("tiny", tiny_session().workpiece))
        assert [find(page, label).visible for label in ("Parameters", "Effort", "How sure")] == [True] * 3
        assert find(page, "Tune\N{HORIZONTAL ELLIPSIS}").visible
        assert not find(page, "Stripes").visible


def test_a_face_is_chosen_looked_at_and_described(session, tmp_path):
    with opened(session, tmp_path, ComponentsPanel) as (page, scene):
        assert find(page, "Go to").options[1:] == tuple(face.name for face in session.workpiece.faces)
        press(page, "Go to", "face-4")
        assert page.session.selection.component == "face-4"
        assert scene.looked == ["face-4"]
        assert "1.00, 0.00, 0.00" in face_html(page.session, "face-4")
        press(page, "Filter", "6")
        assert find(page, "Go to").options[1:] == ("face-6",)


def test_the_card_of_a_stroke_has_the_stripes_of_its_face(session, tmp_path):
    lines = stroke_lines(session.run.plan)
    line = next(each for each in lines if each.made_by.components == ("face-1",))
    own = [piece for piece in session.run.coverings[0].pieces if piece.face == "face-1"]
    html = card_html(replace(session, selection=Selection(made_by=line.made_by)), lines)
    assert f"{len(own)} on 1 face<" in html
    assert "Height" not in html


def test_analyse_shows_the_verdict_of_each_face_and_its_colours(session, tmp_path):
    with opened(session, tmp_path, CleaningPanel) as (page, scene):
        press(page, "Analyse")
        wait_for(lambda: page.session.face_analysis is not None)
        wait_for(lambda: scene.layers.get("/cleanness"))
        verdicts = page.session.face_analysis.verdicts
        assert set(find(page, "Face").options[1:]) == {each.face for each in verdicts}
        press(page, "Step", "Worst")
        worst = min(verdicts, key=lambda each: each.held_share)
        assert page.session.selection.component == worst.face
        press(page, "Clean and not clean", False)
        assert scene.layers["/cleanness"] == b""
