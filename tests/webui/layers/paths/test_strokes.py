import json
import struct

import numpy as np
import pytest
from small_plans import pause, plan_of, spray, transfer

from specs.source import Source
from webui.glb.glb import bars, ribbons, unlike_segments
from webui.layers.paths.strokes import Span, stroke_lines, stroke_spans, strokes_glb, tint_strokes, transfers_glb

AROUND, EDGE = Source(0, "around", ("U1",)), Source(0, "edge")
RING = [[0, 0, 40], [20, 0, 40], [20, 10, 40], [0, 10, 40], [0, 0, 40]]


def accessors(glb):
    length = struct.unpack("<I", glb[12:16])[0]
    return json.loads(glb[20 : 20 + length])["accessors"]


def two_strokes():
    return plan_of(
        spray(RING, made_by=AROUND),
        pause(0.5, AROUND),
        spray(RING, made_by=AROUND),
        transfer([[0, 0, 40], [0, 0, 60]]),
        spray([[0, 0, 60], [30, 0, 60]], speed=80, made_by=EDGE),
    )


def test_passes_with_pauses_between_are_one_stroke_and_a_transfer_ends_it():
    around, edge = stroke_lines(two_strokes())
    assert (around.made_by, around.pauses, around.paused_s) == (AROUND, 1, 0.5)
    assert (around.made_by.place, around.template, around.side) == (Source(0, "around"), "around", "top")
    assert edge.template == "edge"


def test_a_ring_gone_twice_is_as_long_as_two_laps():
    around, edge = stroke_lines(two_strokes())
    assert around.length_mm == pytest.approx(120)
    assert (around.laps, edge.laps) == (2, 1)


def test_what_covers_itself_is_drawn_once():
    once = strokes_glb(stroke_lines(plan_of(spray(RING, made_by=AROUND))), [(1, 2, 3)])
    twice = strokes_glb(stroke_lines(two_strokes())[:1], [(1, 2, 3)])
    assert accessors(twice)[0]["count"] == accessors(once)[0]["count"] == 8


def test_a_segment_back_over_another_is_like_it_and_a_point_is_no_segment():
    a, b = [0.0, 0.0, 1.0], [5.0, 0.0, 1.0]
    segments = np.array([[a, a], [a, b], [b, a], [b, [5.0, 2.0, 1.0]]])
    assert unlike_segments(segments).tolist() == [1, 3]


@pytest.mark.parametrize("direction", [[3.0, 4.0, 0.0], [0.0, 0.0, 5.0], [1.0, -2.0, 3.0]])
def test_a_ribbon_is_as_wide_as_asked_and_bars_enclose_it(direction):
    segment = np.array([[[1.0, 2.0, 3.0], np.array([1.0, 2.0, 3.0]) + direction]])
    unit = np.array(direction) / np.linalg.norm(direction)

    def farthest(corners):
        away = corners - segment[0, 0]
        return np.linalg.norm(away - np.outer(away @ unit, unit), axis=1).max()

    colour = np.array([[9, 9, 9]], dtype=np.uint8)
    strips, bar = ribbons(segment, colour, 0.6), bars(segment, colour, 0.6)
    assert farthest(strips[0]) == pytest.approx(0.3)
    assert farthest(bar[0]) == pytest.approx(0.3 * np.sqrt(2))
    assert len(strips[0]) == len(strips[1]) == 12
    assert len(bar[0]) == len(bar[1]) == 24


def test_very_many_segments_are_bare_lines():
    zigzag = np.column_stack([np.arange(30_001), np.arange(30_001) % 2, np.full(30_001, 50.0)])
    lines = stroke_lines(plan_of(spray(zigzag)))
    assert accessors(strokes_glb(lines, [(0, 0, 0)], 0.5))[0]["count"] == 2 * 30_000
    assert accessors(strokes_glb(stroke_lines(plan_of(spray(zigzag[:3]))), [(0, 0, 0)], 0.5))[0]["count"] == 2 * 12


def test_nothing_is_drawn_of_nothing():
    assert strokes_glb([], []) == b""
    assert transfers_glb(plan_of(transfer([[0, 0, 9], [1, 0, 9]])), frozenset({Source.parse("s/transfer")})) == b""


def test_colours_tell_apart_what_they_are_asked_to():
    lines = stroke_lines(two_strokes())
    spans = [Span(AROUND, 10.0, 20.0), Span(EDGE, 70.0, 80.0)]
    by_function, legend = tint_strokes(lines, "function", [None, None])
    assert by_function[0] == by_function[1] == legend["clean"]
    by_template, legend = tint_strokes(lines, "template", [None, None])
    assert by_template == [legend["around"], legend["edge"]]
    assert len(set(by_template)) == 2
    by_speed, legend = tint_strokes(lines, "speed", [None, None])
    assert by_speed == [legend["60 mm/s"], legend["80 mm/s"]]
    by_time, legend = tint_strokes(lines, "time", spans)
    assert by_time[1] == legend["1.2 min"]
    assert by_time[0] != by_time[1]


def test_a_template_done_twice_is_sprayed_at_two_times():
    lines = stroke_lines(
        plan_of(spray(RING, made_by=EDGE), transfer([[0, 0, 40], [0, 0, 40]]), spray(RING, made_by=EDGE))
    )
    spans = [Span(EDGE, 1.0, 2.0), Span(EDGE, 5.0, 6.0)]
    assert stroke_spans(lines, spans) == spans
    assert stroke_spans(lines, spans[:1]) == [spans[0], None]
