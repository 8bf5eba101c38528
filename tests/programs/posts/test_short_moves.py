"""Programs of whole boards on a gantry: no move is too short to be driven evenly while a jet is on, but at corners."""

from collections import Counter
from dataclasses import replace
from functools import cache

import pytest

from boards.load import board_library, load_board
from programs.posts.dialects import DIALECTS
from programs.timing.forecast import Forecast
from recipes.load import load_recipe
from reports.files.robot_programs import write_tracked
from robotcell.cell.load import LoadedCell, hold_board, read_cell
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.pipeline import run

ON_GANTRIES = [name for name, language in DIALECTS.items() if language.takes_axes]


@cache
def checked(name: str) -> tuple[CellReport, LoadedCell]:
    board = load_board(board_library()[name])
    held = hold_board(read_cell("gantry"), board)
    return track(run(load_recipe("smt-aqueous"), board).program, held.cell, board, terms=terms_of(held)), held


@cache
def predicted(language: str, name: str) -> Forecast:
    forecast = write_tracked(*checked(name), language).forecast
    assert forecast is not None
    return forecast


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tiny", "smt-demo"])
@pytest.mark.parametrize("language", ON_GANTRIES)
def test_no_move_of_a_board_is_short_with_a_jet_on_but_at_a_corner(language: str, name: str) -> None:
    forecast = predicted(language, name)
    assert sum(move.spraying for move in forecast.moves) > 500
    assert [str(move.made_by) for move in forecast.short if not move.at_corner] == []


@pytest.mark.slow
def test_short_moves_in_linuxcnc_are_the_corners_that_the_documents_state() -> None:
    short = predicted("linuxcnc", "smt-demo").short
    assert all(move.at_corner for move in short)
    assert Counter(str(replace(move.made_by, components=())) for move in short) == {
        "sequence[0]/edge": 3,
        "sequence[1]/edge": 2,
        "sequence[0]/around": 1,
        "sequence[1]/edge/transfer": 1,
    }
