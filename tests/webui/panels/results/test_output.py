import re
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest
from cleaning_report import small_report
from made_findings import made_finding

from programs.errors import ProgramError
from reports.files.write_run import cleaning_bytes, write_run
from reports.html.cleaning_page import Traceability, cleaning_page
from reports.tables.cleaning_tables import this_producer
from rulesengine.planning.pipeline import run
from specs.output_file import OutputFile
from specs.progress import no_progress
from webui.downloads.downloads import KINDS, forbidding, make_download
from webui.page.evaluations import Analysed
from webui.page.session import Session
from webui.server.server import open_session

EVERYTHING, PROGRAM, PNG, SVG, REPORT, _, RECIPE, CLEANING_PAGE, CLEANING_DATA = KINDS
ERROR = made_finding("not-served", "error", "U1 must be cleaned.", "masks")


@pytest.fixture(scope="module")
def session() -> Session:
    begun = open_session("smt-demo", "rinse-only")
    return replace(begun, run=run(begun.recipe, begun.board))


def broken(session: Session) -> Session:
    assert session.run is not None
    return replace(session, run=replace(session.run, findings=(ERROR, *session.run.findings)))


@pytest.mark.slow
def test_the_page_gives_the_bytes_that_the_command_line_writes(session: Session, tmp_path: Path) -> None:
    assert session.run is not None
    places = {PROGRAM: tmp_path / "a.wash", PNG: tmp_path / "a.png", REPORT: tmp_path / "a.json"}
    write_run(
        session.run,
        output=OutputFile(places[PROGRAM]),
        picture=OutputFile(places[PNG]),
        report_file=OutputFile(places[REPORT]),
        allowed=(),
    )
    for kind, place in places.items():
        assert make_download(kind, session, (), 10.0, no_progress).content == place.read_bytes(), kind


@pytest.mark.slow
def test_the_cleaning_report_is_the_one_that_the_command_line_writes(session: Session) -> None:
    assert session.run is not None
    with pytest.raises(ProgramError, match="tab Cleaning"):
        make_download(CLEANING_DATA, session, (), 10.0, no_progress)
    analysed = replace(session, analysed=Analysed(session.run.program, "default", small_report()))
    program = sha256(make_download(PROGRAM, session, (), 10.0, no_progress).content).hexdigest()
    producer, trace = this_producer("fast"), Traceability(program_sha256=program)
    data, page = (make_download(kind, analysed, (), 10.0, no_progress) for kind in (CLEANING_DATA, CLEANING_PAGE))
    assert data.content == cleaning_bytes(small_report(), producer, trace)
    assert data.name == "smt-demo-rinse-only-cleaning.json"
    assert page.content == cleaning_page(small_report(), trace, producer=producer).encode()
    assert page.content.startswith(b"<!DOCTYPE html>")
    assert page.name == "smt-demo-rinse-only-cleaning.html"


@pytest.mark.slow
def test_a_drawing_is_one(session: Session) -> None:
    assert b"<svg" in make_download(SVG, session, (), 10.0, no_progress).content


def test_the_recipe_is_the_text_as_it_is_edited(session: Session) -> None:
    name = session.recipe.sequence[0].paths[0]
    edited = session.set_value(("templates", name, "speed_mm_s"), 31)
    download = make_download(RECIPE, edited, (), 10.0, no_progress)
    assert download.content.decode() == edited.document.text != session.document.text
    assert download.name == "rinse-only.yaml"


def test_errors_forbid_the_program_until_their_rule_is_allowed(session: Session) -> None:
    wrong = broken(session)
    with pytest.raises(ProgramError, match=r"not-served.*U1 must be cleaned"):
        make_download(PROGRAM, wrong, (), 10.0, no_progress)
    with pytest.raises(ProgramError, match="not-served"):
        make_download(PROGRAM, wrong, ("another-rule",), 10.0, no_progress)
    allowed = make_download(PROGRAM, wrong, ("not-served",), 10.0, no_progress)
    assert allowed.content == make_download(PROGRAM, session, (), 10.0, no_progress).content
    assert make_download(REPORT, wrong, (), 10.0, no_progress).content


def test_what_forbids_a_program_is_counted(session: Session) -> None:
    assert forbidding(()) == {}
    assert forbidding(session.run.findings) == {}
    assert forbidding(broken(session).run.findings) == {"not-served": 1}


@pytest.mark.parametrize("kind", [PROGRAM, PNG, REPORT])
def test_a_program_of_an_older_recipe_is_not_given_away(session: Session, kind: str) -> None:
    name = session.recipe.sequence[0].paths[0]
    with pytest.raises(ProgramError, match="not planned yet"):
        make_download(kind, session.set_value(("templates", name, "speed_mm_s"), 31), (), 10.0, no_progress)


@pytest.mark.parametrize("odd", ["../../etc/passwd", "a b/c", "\N{SNOWMAN}\n", "..", "x" * 500, 'a"b'])
def test_names_of_files_are_plain(session: Session, odd: str) -> None:
    assert session.run is not None
    board = replace(session.board, name=odd)
    run_on = replace(session.run, workpiece=board)
    name = make_download(REPORT, replace(session, workpiece=board, run=run_on), (), 10.0, no_progress).name
    assert re.fullmatch(r"[\w][\w.+-]*\.json", name)
    assert len(name) < 200
