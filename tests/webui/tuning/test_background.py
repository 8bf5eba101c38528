"""Tuning in the background reports its progress at every trial, and stops where it is cancelled."""

from dataclasses import replace

import pytest
from tiny_session import tiny_session
from tuned_recipe import proposal, slower

from cleaning.parameters.load import load_parameters
from robotcell.cell.load import hold_board, read_cell
from rulesengine.tuning.trial.request import RobotTuning
from webui.page.evaluations import TuningSettings
from webui.threads.threads import CancelledError
from webui.tuning import background as tuning_run


def task_of(session):
    return tuning_run.Task(
        session.document, session.board, "default", load_parameters(), TuningSettings(analyses=8).request()
    )


@pytest.mark.slow
def test_each_plan_reports_the_number_of_analyses(monkeypatch):
    session = tiny_session()
    reported = []

    def tune(runner, text, request, _observe):
        assert (runner.max_analyses, request.max_analyses) == (8, 8)
        assert runner.planned(slower(text)).recipe != session.recipe
        runner.used = 4
        runner.planned(text)
        return proposal(session).tuned

    monkeypatch.setattr(tuning_run, "tune", tune)
    proposed = tuning_run.propose(task_of(session), None, lambda what, done: reported.append((what, done)))
    assert proposed.document is session.document
    assert proposed.parameters_name == "default"
    assert proposed.fits(session.document)
    shares = [done for _, done in reported]
    assert shares == sorted(shares)
    assert ("tuning, 4 of at most 8 analyses", pytest.approx(0.545)) in reported


def test_a_cell_is_whose_robot_is_tuned_for(monkeypatch):
    session = tiny_session()
    cell = hold_board(read_cell("kr6-bench"), session.board)
    found = []

    def tune(runner, _text, _request, _observe):
        found.append((runner.cell, runner.robot))
        return proposal(session).tuned

    monkeypatch.setattr(tuning_run, "tune", tune)
    tuning_run.propose(replace(task_of(session), cell=cell), None, lambda *_: None)
    assert found == [(cell, RobotTuning("kr6-bench", "kr6-r900", 0))]


def test_it_stops_at_the_next_plan(monkeypatch):
    session = tiny_session()
    planned = []

    def tune(runner, text, _request, _observe):
        while True:
            runner.planned(text)
            planned.append(text)

    def progress(what, _done):
        if what.startswith("tuning") and planned:
            raise CancelledError

    monkeypatch.setattr(tuning_run, "tune", tune)
    with pytest.raises(CancelledError):
        tuning_run.propose(task_of(session), None, progress)
    assert len(planned) == 1


def test_trials_are_kept_in_the_project_until_tuning_is_done(monkeypatch, tmp_path):
    session = tiny_session()
    found, best = [], []

    def tune(runner, text, _request, observe):
        found.append(runner._store.find(text))
        observe(proposal(session).tuned)
        if len(found) == 1:
            runner._store.add(text, b"record")
            raise CancelledError
        return proposal(session).tuned

    monkeypatch.setattr(tuning_run, "tune", tune)
    task = replace(task_of(session), project=tmp_path.resolve(), take_best=best.append)
    with pytest.raises(CancelledError):
        tuning_run.propose(task, None, lambda *_: None)
    assert best[0].interrupted
    other = replace(task, request=TuningSettings(analyses=9).request())
    tuning_run.propose(other, None, lambda *_: None)
    tuning_run.propose(task, None, lambda *_: None)
    assert found == [None, None, b"record"]
    assert list((tmp_path / ".washboard" / "tuning").iterdir()) == []


def test_tuning_works_where_trials_cannot_be_kept(monkeypatch, tmp_path):
    session = tiny_session()
    (tmp_path / ".washboard").write_text("in the way")
    monkeypatch.setattr(tuning_run, "tune", lambda *_: proposal(session).tuned)
    task = replace(task_of(session), project=tmp_path.resolve())
    assert tuning_run.propose(task, None, lambda *_: None).text == slower(session.document.text)
