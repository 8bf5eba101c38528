from dataclasses import replace

import numpy as np
from made_findings import made_finding
from shown_cell import shown_cell
from tiny_session import tiny_session

from robotcell.diagnosis.plausibility import Frame, check_cell, frame_card
from robotcell.robot.robot import pose
from webui.cards.findings import mistakes_html
from webui.panels.robot.robot import frames_html


def test_places_and_directions_are_told_in_millimetres():
    cell, board = shown_cell(), tiny_session().board
    html = frames_html(frame_card(cell, board))
    assert mistakes_html([each for each in check_cell(cell, board) if each.severity != "info"]) == ""
    assert "450.0" in html  # where the board's own frame is
    assert "Tool 1 lance at home" in html
    assert html.count("corner") == 4


def test_a_board_upside_down_and_a_tool_that_sprays_the_flange_are_said():
    cell = shown_cell()
    turned = replace(cell.tools[0], T_flange_tcp=cell.tools[0].T_flange_tcp @ pose((0, 0, 0), (np.pi, 0, 0)))
    wrong = replace(cell, T_cell_board=cell.T_cell_board @ pose((0, 0, 0), (np.pi, 0, 0)), tools=(turned,))
    html = mistakes_html(check_cell(wrong, None))
    assert "board-upside-down" in html
    assert "tcp-turned" in html


def test_what_a_file_says_is_only_text_and_zero_has_no_sign():
    html = frames_html([Frame("<i>", (-0.01, 1.0, -2.0), "<u>")]) + mistakes_html(
        [made_finding("rule", "error", "<b>", "<s>")]
    )
    assert not any(tag in html for tag in ("<i>", "<u>", "<b>", "<s>"))
    assert ">0.0<" in html
    assert ">\N{MINUS SIGN}2.0<" in html
