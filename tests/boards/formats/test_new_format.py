"""A format that is enrolled in the table and checks nothing itself: what no board can have is refused, and at once."""

import math
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from shapely import Polygon, box

import boards.formats.table
from boards.board import NOMINAL_HEIGHT, Body, Pad, Surface
from boards.errors import BoardError
from boards.formats.layout import EdgeDrawing, LayoutNotes, LayoutPart, LayoutWords, build_bodies, read_outline
from boards.formats.loops import arc, arc_between, box_around, chain, enclosed, outline_of, slot
from boards.formats.prism import prism
from boards.formats.table import FORMATS, Format
from boards.load import load_board
from boards.packages.heights import HeightEvidence

EDGE = box(0, 0, 60, 40)
HOSTILE = (math.nan, math.inf, -math.inf, 1e308, 1e20)
WORDS = LayoutWords("Made up", "edge", "drawing", str)
PART = LayoutPart("U1", box(1, 1, 4, 4), "top", HeightEvidence("SOIC-8", "U1", (), "", False, 3.0))


def enrol(monkeypatch: pytest.MonkeyPatch, read: Callable[[Path], object]) -> None:
    module = ModuleType("boards.formats.made_up")
    vars(module)["read_made_up"] = read
    monkeypatch.setitem(sys.modules, module.__name__, module)
    form = Format("made up", (".made",), "formats.made_up:read_made_up")
    monkeypatch.setattr(boards.formats.table, "FORMATS", (*FORMATS, form))


def ring(bad: float) -> np.ndarray:
    return np.array([(0.0, 0.0), (60.0, 0.0), (bad, 30.0), (0.0, 40.0)])


def bodies(outline: Polygon, high_mm: float = 1.6) -> tuple[tuple[Body, ...], tuple[()]]:
    return (Body("board", "board", *prism(EDGE, 0.0, 1.6)), Body("U1", "component", *prism(outline, 1.6, high_mm))), ()


def loose(bad: float) -> tuple[tuple[Body, ...], tuple[()]]:
    """Patches that went through nothing of ours."""
    patches = np.full((1, 3, 3), bad)
    return (*bodies(box(1, 1, 4, 4), 3.0)[0], Body("U2", "component", patches, patches[:, 0], (Surface("s", 1),))), ()


def star(count: int) -> Polygon:
    turn, radius = np.linspace(0, 2 * np.pi, count, endpoint=False), 15 + (np.arange(count) % 2)
    return Polygon(np.column_stack([30 + radius * np.cos(turn), 20 + radius * np.sin(turn)]))


def drawn(bad: float) -> Polygon:
    with np.errstate(invalid="ignore"):
        return Polygon(ring(bad))


MADE: dict[str, Callable[[float], object]] = {
    "prism": lambda bad: bodies(drawn(bad)),
    "height": lambda bad: bodies(box(1, 1, 4, 4), bad),
    "chain": lambda bad: chain([ring(bad)]),
    "loop": lambda bad: outline_of([ring(bad)], [], file=Path("b"), spot=str),
    "drill": lambda bad: outline_of([ring(9.0)], [ring(bad)], file=Path("b"), spot=str),
    "enclosed": lambda bad: enclosed([ring(bad)]),
    "box": lambda bad: bodies(box_around([ring(bad)]) or drawn(bad)),
    "arc": lambda bad: arc(np.array([0.0, bad]), np.zeros(2), 3.0),
    "sweep": lambda bad: arc(np.array([0.0, 1.0]), np.zeros(2), bad),
    "chord": lambda bad: chain([arc_between(np.zeros(2), np.array([bad, 1.0]), 1.0)]),
    "slot": lambda bad: chain([slot(np.zeros(2), np.array([1.0, 0.0]), abs(bad), 1.0)]),
    "round slot": lambda bad: chain([slot(np.zeros(2), np.array([1.0, 0.0]), 0.0, abs(bad))]),
    "layout": lambda bad: read_outline(EdgeDrawing([ring(bad)]), Path("b"), WORDS, LayoutNotes()),
    "thickness": lambda bad: build_bodies(EDGE, bad, [PART], WORDS, LayoutNotes()),
    "patches": loose,
}


@pytest.mark.parametrize("bad", HOSTILE)
@pytest.mark.parametrize("made", MADE)
def test_what_no_board_has_is_refused_at_once(
    made: str, bad: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    enrol(monkeypatch, lambda _: MADE[made](bad))
    (tmp_path / "b.made").touch()
    begin = time.process_time()
    with pytest.raises(BoardError, match=r"10 m|no drawing|no number"):
        load_board(tmp_path / "b.made")
    assert time.process_time() - begin < 1.0


@pytest.mark.parametrize("outline", [star(100_000), star(30_001), star(10_001)], ids=["huge", "drawn", "thinned"])
def test_outlines_that_take_too_long_to_triangulate_are_refused(outline: Polygon) -> None:
    with pytest.raises(BoardError, match=r"one line of an outline has [\d,]+ corners"):
        prism(outline, 0.0, 1.0)


def test_a_new_format_is_read_once_it_is_in_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    enrol(monkeypatch, lambda _: bodies(box(1, 1, 4, 4), 3.0))
    (tmp_path / "b.made").touch()
    board = load_board(tmp_path / "b.made")
    assert [(each.name, each.height_mm) for each in board.components] == [("U1", pytest.approx(1.4))]


def soldered(name: str, at: tuple[float, float], pads_at: tuple[float, float], low_mm: float = 1.6) -> Body:
    x, y = at
    pads = (Pad(*pads_at, 1.0, 1.0, 0.0, False),)
    made = Body(name, "component", *prism(box(x, y, x + 2, y + 2), low_mm, low_mm + 1.0), pads=pads, side="top")
    return replace(made, extra=((NOMINAL_HEIGHT, "assumed"),))


@pytest.mark.parametrize("table", ["", "Ref,Side,Rotation,PosX,PosY\nU1,bottom,0,11,11\nQ7,top,0,1,1\n"])
def test_a_reader_that_judges_nothing_is_judged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, table: str) -> None:
    """Places against the outline, bodies against pads, heights that nothing states, tables against the board."""
    parts = (
        soldered("U1", (10, 10), (11, 11)),
        soldered("U2", (90, 10), (91, 11)),
        soldered("U3", (20, 20), (40, 30)),
        soldered("U4", (30, 10), (31, 11), 20.0),
    )
    enrol(monkeypatch, lambda _: ((Body("board", "board", *prism(EDGE, 0.0, 1.6)), *parts), ()))
    (tmp_path / "b.made").touch()
    (tmp_path / "t.csv").write_text(table or "Ref,Value\nU1,1k\n")
    found = {each.rule.id: each.message for each in load_board(tmp_path / "b.made", tmp_path / "t.csv").findings}
    expected = {
        "component-outside": "U2",
        "component-off-pads": "U3",
        "component-floating": "U4",
        "assumed-height": "U1",
    }
    expected |= {"parts-contradict": "U1 side top", "parts-not-on-board": "Q7"} if table else {}
    assert {rule for rule, words in expected.items() if words in found.get(rule, "")} == {*expected}
