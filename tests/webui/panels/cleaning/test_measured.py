"""Measurements on the page: read, compared with the analysis, kept in the report, gone with the board."""

from contextlib import contextmanager
from dataclasses import replace

import pytest
from cleaning_report import small_report
from small_page import press, small_page
from tiny_session import tiny_session
from viser import UploadedFile

from specs.progress import no_progress
from webui.downloads.downloads import KINDS, make_download
from webui.page.evaluations import Analysed
from webui.page.project import open_project
from webui.page.session import comparison_of
from webui.panels.cleaning.parts import UPLOAD, MeasuredCard, measured_html

TABLE = b"# synthetic\ncomponent,method,value,unit,limit\nU1,ic,3,ug/cm2,2\nC1,ic,9,ug/cm2,2\n"


def analysed_session():
    session = tiny_session()
    return replace(session, analysed=Analysed(session.run.program, "default", small_report()))


@contextmanager
def opened(session, folder):
    with small_page(session, open_project(folder)) as page:
        card = MeasuredCard(page)
        page.open()
        yield page, card
        page.close()


def test_a_table_is_compared_with_the_analysis(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, card):
        assert not card._text.visible
        press(page, UPLOAD, UploadedFile("sir.csv", TABLE))
        assert page.client.said == []
        text = card._text.content
        assert card._text.visible
        assert "1 of 2 measured components predicted as measured (50 %)" in text
        assert "predicted clean, measured not clean" in text
        assert "SYNTHETIC" in text
        assert "sir.csv" in text
        assert list(tmp_path.iterdir()) == [], "it is not kept"


def test_a_table_waits_for_the_analysis_and_goes_with_the_board(tmp_path):
    session = tiny_session()
    with opened(session, tmp_path) as (page, card):
        press(page, UPLOAD, UploadedFile("sir.csv", TABLE))
        assert "as soon as the program is analysed" in card._text.content
        session = page.session
    assert comparison_of(session) is None
    later = replace(session, analysed=analysed_session().analysed)
    later = replace(later, analysed=Analysed(session.run.program, "default", small_report()))
    assert "50 %" in measured_html(later)
    other = later.with_workpiece("other", session.board)
    assert other.measured is None
    assert measured_html(other) == ""


def test_a_bad_table_is_refused_with_its_line(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, card):
        press(page, UPLOAD, UploadedFile("sir.csv", TABLE.replace(b"C1", b"C99")))
        assert len(page.client.said) == 1
        assert "the board has no 'C99'" in page.client.said[0]
        assert not card._text.visible


@pytest.mark.slow
def test_the_downloaded_report_has_the_comparison(tmp_path):
    with opened(analysed_session(), tmp_path) as (page, _):
        press(page, UPLOAD, UploadedFile("sir.csv", TABLE))
        session = page.session
    page_kind, data_kind = list(KINDS)[-2:]
    found, _ = comparison_of(session)
    assert found.table.sha256 in make_download(data_kind, session, (), 10.0, no_progress).content.decode()
    assert "What was measured" in make_download(page_kind, session, (), 10.0, no_progress).content.decode()
