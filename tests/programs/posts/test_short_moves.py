"""Programs of whole boards on a gantry: no move is too short to be driven evenly while a jet is on, but at corners."""

from functools import cache

import pytest

from boards.load import board_library, load_board
from programs.posts.dialects import DIALECTS
from recipes.load import load_recipe
from reports.files.export_robot import write_tracked
from robotcell.cell.hold import hold_board
from robotcell.cell.load import LoadedCell, read_cell
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.pipeline import run

ON_GANTRIES = [name for name, language in DIALECTS.items() if language.takes_axes]


@cache
def checked(name: str) -> tuple[CellReport, LoadedCell]:
    board = load_board(board_library()[name])
    held = hold_board(read_cell("gantry"), board)
    return track(run(load_recipe("smt-aqueous"), board).program, held.cell, board, terms=terms_of(held)), held


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tiny", "smt-demo"])
@pytest.mark.parametrize("language", ON_GANTRIES)
def test_no_move_of_a_board_is_short_with_a_jet_on_but_at_a_corner(language: str, name: str) -> None:
    exported = write_tracked(*checked(name), language)
    assert exported.forecast is not None
    assert sum(move.spraying for move in exported.forecast.moves) > 500
    assert [str(move.made_by) for move in exported.forecast.short if not move.at_corner] == []
