"""A part on the page: read, planned, analysed and downloaded as the command line does."""

from dataclasses import replace

import numpy as np
import pytest
from part_session import ascii_stl, part_session
from small_parts import block

from boards.board import Board, Part
from boards.errors import BoardError
from boards.workpiece import is_read_otherwise, load_workpiece
from cleaning.part_faces import judge_faces, times_in_cone
from programs.errors import ProgramError
from recipes.errors import RecipeError
from recipes.load import load_recipe
from reports.files.write_run import json_bytes, program_bytes, write_run
from reports.tables.run_report import part_cleaning_report
from rulesengine.planning.pipeline import run
from rulesengine.surface.part_job import survey_part
from specs.output_file import OutputFile
from specs.progress import no_progress
from washboard.cleaned import judge_part
from webui.cards.findings import place_of, status_cells
from webui.downloads.downloads import KINDS, make_download

EVERYTHING, PROGRAM, _, _, REPORT, _, _, CLEANING_PAGE, CLEANING_DATA = KINDS


@pytest.fixture(scope="module")
def session():
    return part_session()


@pytest.fixture(scope="module")
def analysed(session):
    return replace(session, analysed=judge_part(session.run.program, session.run.workpiece, session.run.recipe))


def cells_of(session):
    return {cell.title: (cell.text, cell.tone, cell.note) for cell in status_cells(session)}


@pytest.mark.slow
def test_a_mesh_is_a_part_for_a_recipe_over_faces_and_a_board_for_others(session, tmp_path):
    mesh = tmp_path / "box.stl"
    mesh.write_bytes(ascii_stl(block((0, 0, 0), (40, 30, 20))))
    part = load_workpiece(mesh, over_faces=True)
    assert isinstance(part, Part)
    assert len(part.faces) == 6
    boards = load_recipe("rinse-only")
    assert is_read_otherwise(mesh, part, over_faces=boards.over_faces)
    assert not is_read_otherwise(mesh, part, over_faces=session.recipe.over_faces)
    assert isinstance(load_workpiece("tiny", over_faces=True), Board)
    mesh.write_bytes(b"solid nothing\nendsolid nothing\n")
    with pytest.raises(BoardError, match="open a recipe for parts first"):
        load_workpiece(mesh, over_faces=boards.over_faces)


def test_a_panel_file_is_a_board(session, tmp_path):
    panel = tmp_path / "two.yaml"
    panel.write_text("panel: {board: tiny, nx: 2, pitch_mm: [60, 60]}\n")
    board = load_workpiece(panel)
    assert isinstance(board, Board)
    assert len(board.instances) == 2


def test_a_recipe_for_boards_does_not_fit_a_part(session):
    with pytest.raises(RecipeError, match="Open a recipe for parts, such as part-degrease"):
        run(load_recipe("rinse-only"), session.workpiece, no_progress)


def test_a_part_has_faces_in_place_of_components(session):
    assert session.board is None
    assert not session.workpiece.components
    assert session.run.coverings
    assert session.planned
    assert cells_of(session)["Sprayed"] == ("6 of 6", "good", "faces")
    bare = replace(session, run=replace(session.run, coverings=()))
    assert cells_of(bare)["Sprayed"] == ("0 of 6", "error", "faces")
    unseen = [each for each in session.run.findings if each.rule.id == "surface-unseen"]
    assert [place_of(each, session.workpiece) for each in unseen] == ["face-6"]


def test_the_verdicts_are_those_of_the_command_line(session, analysed):
    run = session.run
    held, survey = times_in_cone(run.program, run.workpiece, run.recipe), survey_part(run.recipe, run.workpiece)
    expected = judge_faces(run.workpiece, held, survey.visible, survey.hider)
    assert analysed.face_analysis.verdicts == expected
    assert {each.verdict for each in expected} == {"dirty"}
    assert cells_of(analysed)["Cleaning"] == ("6 dirty", "error", "0 clean")
    assert session.face_analysis is None
    slower = replace(analysed, run=replace(run, program=replace(run.program)))
    assert slower.face_analysis is None
    assert cells_of(slower)["Cleaning"] == ("older", "old", "")
    assert analysed.with_workpiece("box", session.workpiece).analysed is None


def test_the_page_gives_the_bytes_that_the_command_line_writes(session, analysed, tmp_path):
    written = {PROGRAM: tmp_path / "a.wash", REPORT: tmp_path / "a.json"}
    write_run(
        session.run,
        output=OutputFile(written[PROGRAM]),
        picture=None,
        report_file=OutputFile(written[REPORT]),
        allowed=(),
    )
    for kind, file in written.items():
        assert make_download(kind, session, (), 10.0, no_progress).content == file.read_bytes(), kind
    assert written[PROGRAM].read_bytes() == program_bytes(session.run)
    with pytest.raises(ProgramError, match="press Analyse"):
        make_download(CLEANING_DATA, session, (), 10.0, no_progress)
    page = make_download(CLEANING_PAGE, analysed, (), 10.0, no_progress).content.decode()
    assert all(each.face in page for each in analysed.face_analysis.verdicts)
    made, verdicts = make_download(CLEANING_DATA, analysed, (), 10.0, no_progress), analysed.face_analysis.verdicts
    report = part_cleaning_report(session.workpiece, session.run.program, verdicts)
    assert made.content == json_bytes(report)
    assert made.name == "thing-boxes-cleaning.json"


def test_what_hides_the_part_is_not_cleaned_with_it(session):
    low, high = session.workpiece.box
    np.testing.assert_allclose([low, high], [[0, 0, 0], [40, 30, 20]])
