import base64
import re
from dataclasses import replace

import numpy as np
import pytest
from tiny_session import tiny_session

from programs.errors import ProgramError
from webui.downloads.recording import frame_times, record


@pytest.mark.slow
def test_a_recording_needs_nothing_else_prints_nothing_and_leaves_nothing_running(capsys):
    told: list[float] = []
    html = record(tiny_session().run, 40.0, lambda _what, done: told.append(done))
    data = re.search(r'__VISER_EMBED_DATA__="([A-Za-z0-9+/=]+)"', html)
    assert data is not None
    assert len(base64.b64decode(data[1])) > 10_000
    assert not re.search(r'(?:src|href)="https?://', html)
    assert told == sorted(told)
    assert capsys.readouterr().out == ""


def test_a_recording_names_what_it_shows_and_what_was_not_looked_at():
    run = tiny_session().run
    html = record(replace(run, workpiece=replace(run.workpiece, name="<i>")), 400.0)
    title = html[html.index("<body>") :][:3000]
    assert "&lt;i&gt; \N{MULTIPLICATION SIGN} smt-aqueous" in title
    assert "<i>" not in title
    assert "Cleaning: not analysed" in title
    assert all(step.function in title for step in run.recipe.sequence if step.enabled)
    assert "<title>&lt;i&gt;" in html


def test_a_recording_can_be_given_up():
    class GivenUpError(Exception):
        pass

    def stop(_what, done):
        if done > 0.2:
            raise GivenUpError

    with pytest.raises(GivenUpError):
        record(tiny_session().run, 40.0, stop)


def test_frames_go_from_begin_to_end_and_are_not_too_many():
    times = frame_times(100.0, 10.0)
    assert (times[0], times[-1]) == (0.0, 100.0)
    np.testing.assert_allclose(np.diff(times), 10 / 15, rtol=0.01)
    assert len(frame_times(1e6, 0.1)) == 6001


def test_nothing_to_play_is_refused():
    run = tiny_session().run
    with pytest.raises(ProgramError):
        record(run, 0.0)
    empty = replace(run, program=replace(run.program, totals=replace(run.program.totals, duration_s=0.0)))
    with pytest.raises(ProgramError):
        record(empty)
