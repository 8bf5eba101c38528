"""Only what changed is sent, and what it replaces stays until a browser has taken it up."""

import time
from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report
from waiting import wait_for

from webui.layers.surface.heat import heat_pieces
from webui.scene import moving as heat_view
from webui.scene.moving import HeatView

FACETS = small_report().facets
CELLS = len(FACETS.cell_areas_mm2)


class Drawing:
    """A scene that only knows what is in it."""

    def __init__(self):
        self.nodes = {}

    def add_glb(self, name, glb, **_):
        assert name not in self.nodes
        self.nodes[name] = glb
        return Handle(self, name)


class Handle:
    def __init__(self, drawing, name):
        self.drawing, self.name = drawing, name

    def remove(self):
        del self.drawing.nodes[self.name]


def colours(shade=0):
    return np.full((CELLS, 3), shade, np.uint8)


def view_of_pieces(monkeypatch, fade_s=0.05):
    monkeypatch.setattr(heat_view, "_FADE_S", fade_s)
    monkeypatch.setattr(heat_view, "heat_pieces", lambda facets: heat_pieces(facets, 100))
    drawing = Drawing()
    return HeatView(drawing), drawing


def test_the_same_colours_send_nothing(monkeypatch):
    view, drawing = view_of_pieces(monkeypatch)
    assert view.show(FACETS, colours()) == sum(map(len, drawing.nodes.values())) > 0
    before = dict(drawing.nodes)
    assert view.show(FACETS, colours()) == 0
    assert drawing.nodes == before


@pytest.mark.slow
def test_one_cell_sends_its_piece_and_the_old_one_goes_later(monkeypatch):
    view, drawing = view_of_pieces(monkeypatch, 0.3)
    view.show(FACETS, colours())
    before = set(drawing.nodes)
    after = colours()
    after[heat_pieces(FACETS, 100)[2].cells[0]] = 200
    sent = view.show(FACETS, after)
    (fresh,) = set(drawing.nodes) - before
    assert before < set(drawing.nodes)  # the old piece is still beneath
    assert sent == len(drawing.nodes[fresh])
    wait_for(lambda: len(drawing.nodes) == len(before))
    assert fresh in drawing.nodes


@pytest.mark.slow
def test_hiding_takes_all_away_at_once_and_for_good(monkeypatch):
    view, drawing = view_of_pieces(monkeypatch, 0.1)
    for shade in range(4):
        view.show(FACETS, colours(60 * shade))
    view.hide()
    assert drawing.nodes == {}
    view.show(FACETS, colours())
    shown = set(drawing.nodes)
    time.sleep(0.3)  # what was to be swept is gone already
    assert set(drawing.nodes) == shown


def test_another_board_replaces_the_first(monkeypatch):
    view, drawing = view_of_pieces(monkeypatch)
    view.show(FACETS, colours())
    first = set(drawing.nodes)
    view.show(replace(FACETS), colours())
    assert not first & set(drawing.nodes)
    assert len(drawing.nodes) == len(first)
