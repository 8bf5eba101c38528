"""Outlines as other tools draw them: the edge is the closed loop that holds what is soldered."""

from pathlib import Path

import numpy as np
import pytest

from boards.board import Board
from boards.errors import BoardError
from boards.load import load_board

Lines = list[tuple[float, float, float, float]]
RECTANGLE: Lines = [(0, 0, 40, 0), (40, 0, 40, 30), (40, 30, 0, 30), (0, 30, 0, 0)]
FRAME: Lines = [(-20, -20, 90, -20), (90, -20, 90, 60), (90, 60, -20, 60), (-20, 60, -20, -20)]


def rules(board: Board) -> set[str]:
    return {finding.rule.id for finding in board.findings}


def eagle(file: Path, edge: Lines, *, width: float = 0.2) -> Path:
    """A board of Eagle 9 with four chips of two pads."""
    wires = "".join(f'<wire x1="{a}" y1="{b}" x2="{c}" y2="{d}" width="{width}" layer="20"/>' for a, b, c, d in edge)
    places = [(10, 10), (20, 10), (10, 20), (20, 20)]
    parts = "".join(
        f'<element name="R{n}" library="l" package="R0603" value="1k" x="{x}" y="{y}"/>'
        for n, (x, y) in enumerate(places, start=1)
    )
    pads = "".join(f'<smd name="{n}" x="{x}" y="0" dx="0.9" dy="0.95" layer="1"/>' for n, x in ((1, -0.8), (2, 0.8)))
    file.write_text(
        f'<?xml version="1.0"?><eagle version="9.6.2"><drawing><board><plain>{wires}</plain><libraries>'
        f'<library name="l"><packages><package name="R0603">{pads}</package></packages></library></libraries>'
        f"<elements>{parts}</elements></board></drawing></eagle>",
        "utf-8",
    )
    return file


def gerber(lines: Lines, pads: list[tuple[float, float]], *, pen_in: float = 0.01) -> str:
    """A layer in inches, leading zeros left out, as PADS and Eagle write them; sizes are given in mm."""

    def number(mm: float) -> str:
        return f"{round(mm / 25.4 * 1e4)}"

    drawn = [f"X{number(a)}Y{number(b)}D02*\nX{number(c)}Y{number(d)}D01*" for a, b, c, d in lines]
    flashed = [f"X{number(x)}Y{number(y)}D03*" for x, y in pads]
    head = f"%FSLAX24Y24*%\n%MOIN*%\n%ADD10C,{pen_in}*%\n%ADD11R,0.04X0.04*%\nG01*"
    return "\n".join([head, "D10*", *drawn, "D11*", *flashed, "M02*\n"])


PADS = [(x, y) for x in (5.0, 15.0, 35.0) for y in (5.0, 25.0)]


def order(folder: Path, layers: dict[str, str]) -> Path:
    folder.mkdir()
    (folder / "board.gtl").write_text(gerber([], PADS), "utf-8")
    for name, text in layers.items():
        (folder / name).write_text(text, "utf-8")
    return folder


def test_a_gap_that_the_pen_covers_is_closed_and_named(tmp_path: Path) -> None:
    open_edge: Lines = [(0, 0, 39.9, 0), *RECTANGLE[1:]]
    board = load_board(eagle(tmp_path / "b.brd", open_edge, width=0.2))
    assert board.outline.area == pytest.approx(1200.0, abs=3.0)
    assert "edge-gap" in rules(board)
    with pytest.raises(BoardError, match="is open between"):  # the pen is finer than the gap
        load_board(eagle(tmp_path / "c.brd", open_edge, width=0.05))


def test_a_gap_of_a_mil_is_closed_whatever_the_pen(tmp_path: Path) -> None:
    text = gerber([(0, 0, 40 - 0.0254, 0), *RECTANGLE[1:]], [], pen_in=0.0005)
    board = load_board(order(tmp_path / "o", {"board.gko": text}))
    assert board.outline.area == pytest.approx(1200.0, abs=1.0)
    assert "edge-gap" in rules(board)


def test_lines_beside_a_closed_edge_are_left_out_and_named(tmp_path: Path) -> None:
    dimensions: Lines = [(0, -5, 40, -5), (-5, 0, -5, 30)]
    board = load_board(eagle(tmp_path / "b.brd", [*RECTANGLE, *dimensions]))
    assert board.outline.area == pytest.approx(1200.0, abs=0.1)
    assert "open-edge" in rules(board)
    hole: Lines = [(9, 4, 11, 4), (11, 4, 11, 6), (11, 6, 9, 6), (9, 6, 9, 4)]
    with pytest.raises(BoardError, match="is open between"):  # the closed loop is a cut-out, not the edge
        load_board(eagle(tmp_path / "c.brd", [*RECTANGLE[:3], *hole]))


def test_a_frame_around_the_drawing_is_no_board(tmp_path: Path) -> None:
    board = load_board(eagle(tmp_path / "b.brd", [*FRAME, *RECTANGLE]))
    assert board.outline.area == pytest.approx(1200.0, abs=0.1)
    with_slot = [*RECTANGLE, (30, 5, 35, 5), (35, 5, 35, 10), (35, 10, 30, 10), (30, 10, 30, 5)]
    board = load_board(eagle(tmp_path / "c.brd", [*FRAME, *with_slot]))
    assert board.outline.area == pytest.approx(1175.0, abs=0.1)


@pytest.mark.parametrize("name", ["b.gdo", "b.dim", "b.oln", "b.OLN", "contour.gbr", "b.gm", "b.Outline", "b_contour"])
def test_names_of_edges_by_other_tools(tmp_path: Path, name: str) -> None:
    board = load_board(order(tmp_path / "o", {name: gerber(RECTANGLE, [])}))
    assert board.outline.area == pytest.approx(1200.0, abs=0.5)


def test_the_edge_is_the_loop_that_holds_the_copper_whatever_its_name(tmp_path: Path) -> None:
    legend: Lines = [(60, 0, 80, 0), (80, 0, 80, 20), (80, 20, 60, 20), (60, 20, 60, 0)]
    sheet, edge = gerber([*FRAME], []), gerber(RECTANGLE, [])
    layers = {"board.gm1": gerber(legend, []), "board.gm2": sheet, "board.gko": edge}
    assert load_board(order(tmp_path / "a", layers)).outline.area == pytest.approx(1200.0, abs=0.5)
    # Nothing is called like an edge: a layer without a known name holds it.
    layers = {"board.g99x": gerber(legend, []), "mech13.pho": edge}
    assert load_board(order(tmp_path / "b", layers)).outline.area == pytest.approx(1200.0, abs=0.5)


def test_without_an_edge_the_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BoardError, match="closed line around all copper"):
        load_board(order(tmp_path / "o", {"board.gto": gerber([(1, 1, 2, 2)], [])}))
    with pytest.raises(BoardError, match="is open between"):
        load_board(order(tmp_path / "p", {"board.gko": gerber(RECTANGLE[:3], [])}))


def test_the_same_board_in_another_place_has_the_same_outline(tmp_path: Path) -> None:
    moved = [(a + 100.0, b - 50.0, c + 100.0, d - 50.0) for a, b, c, d in [*RECTANGLE, (0, 40, 40, 40)]]
    with pytest.raises(BoardError, match="is open between"):  # what is soldered lies elsewhere: not the board's edge
        load_board(eagle(tmp_path / "b.brd", moved))
    board = load_board(eagle(tmp_path / "c.brd", [*RECTANGLE, (0.0, 40.0, 40.0, 40.0)]))
    np.testing.assert_allclose(board.outline.bounds, (0.0, 0.0, 40.0, 30.0), atol=1e-6)


def test_a_further_layer_that_is_named_like_an_edge_and_draws_within_it_is_named(tmp_path: Path) -> None:
    slot: Lines = [(20, 10, 24, 10), (24, 10, 24, 14), (24, 14, 20, 14), (20, 14, 20, 10)]
    layers = {"board.gko": gerber(RECTANGLE, []), "board.gm2": gerber(slot, [])}
    board = load_board(order(tmp_path / "a", layers))
    assert board.outline.area == pytest.approx(1200.0, abs=0.5)
    (text,) = [each.message for each in board.findings if each.rule.id == "edge-layers"]
    assert "board.gm2" in text
    assert "Draw cut-outs on the layer of the edge" in text
    same = {"board.gko": gerber(RECTANGLE, []), "board.gm1": gerber([*RECTANGLE, (0, -9, 40, -9)], [])}
    assert "edge-layers" not in rules(load_board(order(tmp_path / "b", same)))
