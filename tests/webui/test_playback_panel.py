import threading
import time
from dataclasses import replace

import numpy as np
import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session

from programs.errors import ProgramError
from webui.layers.nozzle import moment
from webui.panels import playback
from webui.panels.playback import PlaybackPanel, instruction_lines, lay_out_run, now_html


def test_instructions_are_those_of_the_program_file():
    program = tiny_session().run.program
    lines = instruction_lines(program)
    assert len(lines) == len(program.instructions)
    for index in np.linspace(0, len(lines) - 1, 50).astype(int):
        assert float(lines[index].split()[0]) == pytest.approx(program.instructions[index].time_s, abs=1e-4)
        assert lines[index].endswith(f"; {program.instructions[index].made_by}")


def test_what_happens_now_is_said_in_words():
    session = tiny_session()
    playable = lay_out_run(session.run, session.loaded)
    now_s = playable.end_s / 2
    shown = moment(playable.timeline, session.recipe, session.board, now_s)
    html = now_html(playable, shown, now_s)
    assert playable.lines[shown.instruction].partition(";")[0].strip() in html
    assert f"jet {'on' if len(shown.rim) else 'off'}" in html
    assert "smt-aqueous.yaml, line" in html


def test_a_program_that_takes_no_time_is_not_played():
    session = tiny_session()
    program = replace(session.run.program, totals=replace(session.run.program.totals, duration_s=0.0))
    with pytest.raises(ProgramError, match="takes no time"):
        lay_out_run(replace(session.run, program=program), session.loaded)


def test_who_presses_play_while_a_new_run_is_laid_out_sees_it_play(monkeypatch):
    session, go_on = tiny_session(), threading.Event()
    with small_page(session) as page:
        panel = PlaybackPanel(page, None)
        panel.show(session, None)
        wait_for(lambda: not find(page, "Time (s)").disabled)
        longest = find(page, "Time (s)").max

        def slow(run, loaded):
            go_on.wait()
            return replace(lay_out_run(run, loaded), end_s=longest + 1.0)

        monkeypatch.setattr(playback, "lay_out_run", slow)
        after = replace(session, run=replace(session.run))
        panel.show(after, session)
        press(page, "Go", "Play")
        go_on.set()
        wait_for(lambda: find(page, "Time (s)").max > longest)
        wait_for(lambda: "Pause" in find(page, "Go").options)
        begun = find(page, "Time (s)").value
        wait_for(lambda: find(page, "Time (s)").value > begun)
        press(page, "Go", "Pause")
        page.close()


def wait_for(condition):
    end = time.monotonic() + 10.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)
