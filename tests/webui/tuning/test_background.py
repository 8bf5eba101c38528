"""Tuning beside a page tells how far it is whenever a recipe is tried, and stops where nobody wants it any more."""

import pytest
from tiny_session import tiny_session
from tuned_recipe import proposal, slower

from cleaning.parameters.load import load_parameters
from webui.page.proposal import Wishes
from webui.threads.worker import CancelledError
from webui.tuning import background as tuning_run


def task_of(session):
    return tuning_run.Task(session.document, session.board, "default", load_parameters(), Wishes(analyses=8).asked())


def test_each_plan_tells_how_many_analyses_were_made(monkeypatch):
    session = tiny_session()
    told = []

    def tune(bench, text, asked):
        assert (bench.most, asked.analyses) == (8, 8)
        assert bench.planned(slower(text)).recipe != session.recipe
        bench.used = 4
        bench.progress("tuning", bench.used / bench.most)
        return proposal(session).tuned

    monkeypatch.setattr(tuning_run, "tune", tune)
    proposed = tuning_run.propose(task_of(session), None, lambda what, done: told.append((what, done)))
    assert proposed.document is session.document
    assert proposed.parameters_name == "default"
    assert proposed.fits(session.document)
    shares = [done for _, done in told]
    assert shares == sorted(shares)
    assert ("tuning, 4 of at most 8 analyses", pytest.approx(0.545)) in told


def test_it_stops_at_the_next_plan(monkeypatch):
    session = tiny_session()
    planned = []

    def tune(bench, text, _asked):
        while True:
            bench.planned(text)
            planned.append(text)

    def progress(what, _done):
        if what.startswith("tuning") and planned:
            raise CancelledError

    monkeypatch.setattr(tuning_run, "tune", tune)
    with pytest.raises(CancelledError):
        tuning_run.propose(task_of(session), None, progress)
    assert len(planned) == 1
