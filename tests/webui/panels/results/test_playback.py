import threading
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session
from waiting import wait_for

from programs.errors import ProgramError
from programs.native import render_line
from webui.layers.paths.nozzle import moment
from webui.panels.results import playback
from webui.panels.results.playback import PlaybackPanel, lay_out_run, now_html, veil_html


def test_what_happens_now_is_said_in_words():
    session = tiny_session()
    playable = lay_out_run(session.run, session.loaded)
    now_s = playable.end_s / 2
    shown = moment(playable.timeline, session.recipe, session.board, now_s)
    html = now_html(playable, shown, now_s)
    assert render_line(session.run.program, shown.instruction).partition(";")[0].strip() in html
    assert f"jet {'on' if len(shown.rim) else 'off'}" in html
    assert "smt-aqueous.yaml, line" in html


def test_a_program_that_takes_no_time_is_not_played():
    session = tiny_session()
    program = replace(session.run.program, totals=replace(session.run.program.totals, duration_s=0.0))
    with pytest.raises(ProgramError, match="takes no time"):
        lay_out_run(replace(session.run, program=program), session.loaded)


@pytest.fixture
def laid_out(monkeypatch):
    """The runs that are laid out, in order."""
    runs = []

    def listen(run, loaded):
        runs.append(run)
        return lay_out_run(run, loaded)

    monkeypatch.setattr(playback, "lay_out_run", listen)
    return runs


@contextmanager
def open_panel(session):
    with small_page(session) as page:
        panel = PlaybackPanel(page, SimpleNamespace(show_moment=lambda _: None))
        page.open()
        yield page, panel
        page.close()


def newer(session):
    return replace(session, run=replace(session.run))


@pytest.mark.slow
def test_of_edits_in_a_row_only_the_last_one_is_laid_out(monkeypatch, laid_out):
    monkeypatch.setattr(playback, "_QUIET_S", 0.3)
    sessions = [tiny_session(), newer(tiny_session()), newer(tiny_session())]
    with open_panel(sessions[0]) as (page, _panel):
        for after in sessions[1:]:
            page.show(after)
        assert laid_out == []
        wait_for(lambda: not find(page, "Time (s)").disabled)
        assert laid_out == [sessions[-1].run]


def test_a_strip_that_is_out_of_date_is_faded_until_it_is_renewed(monkeypatch):
    monkeypatch.setattr(playback, "_QUIET_S", 0.1)
    session = tiny_session()
    with open_panel(session) as (page, panel):
        wait_for(lambda: not find(page, "Time (s)").disabled)
        assert panel._cursor.content != veil_html()
        monkeypatch.setattr(playback, "_QUIET_S", 60.0)
        page.show(newer(session))
        assert panel._cursor.content == veil_html()
        press(page, "Time (s)", 1.0)
        wait_for(lambda: panel._cursor.content != veil_html())


@pytest.fixture
def impatient(monkeypatch):
    """Nothing is laid out before somebody asks for it."""
    monkeypatch.setattr(playback, "_QUIET_S", 60.0)


def test_play_lays_out_at_once_and_plays(impatient):
    with open_panel(tiny_session()) as (page, _):
        press(page, "Go", "Play")
        wait_for(lambda: "Pause" in find(page, "Go").options)
        wait_for(lambda: find(page, "Time (s)").value > 0)
        press(page, "Go", "Pause")
        assert "Play" in find(page, "Go").options


def test_scrubbing_lays_out_and_goes_there(impatient):
    with open_panel(tiny_session()) as (page, panel):
        press(page, "Time (s)", 1.0)
        wait_for(lambda: not find(page, "Time (s)").disabled)
        wait_for(lambda: panel._player.now_s == 1.0)
        wait_for(lambda: "1.0 s" in panel._now.content)


def test_a_step_lays_out_and_goes_to_the_next_event(impatient):
    session = tiny_session()
    events = lay_out_run(session.run, session.loaded).events
    with open_panel(session) as (page, panel):
        press(page, "Go", "Next event")
        wait_for(lambda: panel._player.now_s > 0)
        assert panel._player.now_s == events[events > 0][0]


def test_a_layout_that_comes_too_late_is_not_taken(impatient):
    session = tiny_session()
    with open_panel(session) as (page, panel):
        page.show(newer(session))
        panel._take(lay_out_run(session.run, session.loaded))
        assert find(page, "Time (s)").disabled
        page.show(replace(session, run=None))
        panel._take(lay_out_run(session.run, session.loaded))
        assert find(page, "Time (s)").disabled


def test_who_presses_play_while_a_new_run_is_laid_out_sees_it_play(monkeypatch, impatient):
    session, go_on = tiny_session(), threading.Event()
    with open_panel(session) as (page, _panel):
        press(page, "Go", "Next event")
        wait_for(lambda: not find(page, "Time (s)").disabled)
        longest = find(page, "Time (s)").max

        def slow(run, loaded):
            go_on.wait()
            return replace(lay_out_run(run, loaded), end_s=longest + 1.0)

        monkeypatch.setattr(playback, "lay_out_run", slow)
        page.show(newer(session))
        press(page, "Go", "Play")
        press(page, "Go", "Play")
        go_on.set()
        wait_for(lambda: find(page, "Time (s)").max > longest)
        wait_for(lambda: "Pause" in find(page, "Go").options)
        begun = find(page, "Time (s)").value
        wait_for(lambda: find(page, "Time (s)").value > begun)
        press(page, "Go", "Pause")
