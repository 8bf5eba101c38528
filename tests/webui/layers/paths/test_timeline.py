import re
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_programs import hand_program
from tiny_session import tiny_session

from programs.playback import build_timeline
from webui.layers.paths.strokes import (
    Span,
    clock,
    clock_html,
    cursor_html,
    event_times,
    function_bands,
    spray_bands,
    spray_spans,
    step_event,
    strip_html,
    top_speeds,
)


def test_a_stroke_is_sprayed_from_jet_on_to_jet_off_with_its_pauses():
    assert spray_spans(hand_program()) == [Span("sequence[0]/edge", 1.0, 3.2)]


def test_all_spans_of_a_run_are_its_spray_time():
    run = tiny_session().run
    spans = spray_spans(run.program)
    assert sum(span.end_s - span.begin_s for span in spans) == pytest.approx(run.program.totals.spray_s, abs=0.01)
    assert all(a.end_s <= b.begin_s + 1e-9 for a, b in pairwise(spans))


def test_events_are_switches_pauses_and_commands():
    assert event_times(hand_program()).tolist() == [0.0, 1.0, 2.0, 3.2, 4.2]


@given(st.floats(0, 5))
@settings(max_examples=30)
def test_steps_lead_to_the_nearest_event_on_either_side(now_s):
    events = event_times(hand_program())
    later, earlier = step_event(events, now_s, 1), step_event(events, now_s, -1)
    assert earlier <= now_s <= later
    assert not np.any((events > now_s + 1e-6) & (events < later))
    assert not np.any((events < now_s - 1e-6) & (events > earlier))


def test_at_the_ends_a_step_stays():
    events = event_times(hand_program())
    assert step_event(events, 4.2, 1) == 4.2
    assert step_event(events, 0.0, -1) == 0.0


def test_bands_say_when_function_and_jet_hold():
    timeline = build_timeline(hand_program())
    assert [band for band in function_bands(timeline, 4.2) if band[0]] == [("clean", 0.0, 4.2)]
    assert spray_bands(timeline, 4.2) == [(1.0, 3.2)]


def test_the_speed_curve_keeps_every_peak():
    timeline = build_timeline(hand_program())
    few, many = top_speeds(timeline, 4.2, 3), top_speeds(timeline, 4.2, 500)
    assert few.max() == many.max() == pytest.approx(timeline.speed.max())
    assert top_speeds(timeline, 4.2, 42)[21] == 0.0  # from 2.1 to 2.2 it waits


def test_the_strip_shows_the_functions_and_escapes_their_names():
    session = tiny_session()
    html = strip_html(build_timeline(session.run.program), session.run.program.totals.duration_s, {"clean": (1, 2, 3)})
    assert html.count("#010203") == 1
    assert ">clean<" in html
    widths = [float(width) for width in re.findall(r"%;width:([\d.]+)%", html)]
    assert sum(widths) == pytest.approx(100, abs=0.1)


def test_the_cursor_stays_on_the_strip():
    assert "left:50.000%" in cursor_html(5.0, 10.0)
    assert "left:100.000%" in cursor_html(50.0, 10.0)
    assert "left:0.000%" in cursor_html(1.0, 0.0)


def test_times_are_written_as_people_say_them():
    assert clock(83.4) == "1 min 23.4 s"
    assert clock(59.97) == "1 min 0.0 s"
    assert clock(3.21) == "3.2 s"
    assert clock_html(83.4, 647.2) == "<b>1 min 23.4 s</b> of 10 min 47 s"
