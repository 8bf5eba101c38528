"""The classical mistakes of a cell are found by name: units, a tool or a board the wrong way round, out of reach."""

from functools import cache

import numpy as np
import pytest
from small_cells import CELL

from boards.board import Board
from boards.load import board_library, load_board
from robotcell.cell.load import cell_library, read_cell, read_cell_text
from robotcell.diagnosis.plausibility import check_cell, describe_direction, frame_card, longest_reach
from robotcell.robot.robot import flange_poses

TCP = "tcp: {xyz_mm: [0, 0, 180]}"


@cache
def demo() -> Board:
    return load_board(board_library()["smt-demo"])


def rules(text: str, board: Board | None = None) -> dict[str, str]:
    return {finding.rule.id: finding.message for finding in check_cell(read_cell_text(text).cell, board)}


@pytest.mark.slow
@pytest.mark.parametrize("name", cell_library())
def test_library_cells_have_no_findings(name: str) -> None:
    assert check_cell(read_cell(name).cell, demo()) == ()


def test_a_tool_in_metres() -> None:
    found = rules(CELL.replace(TCP, "tcp: {xyz_mm: [0, 0, 0.18]}"))
    assert "0.18 mm from the flange; xyz_mm is in mm" in found["tcp-units"]


def test_a_tcp_that_is_turned_by_half_a_turn() -> None:
    for turned in ("[180, 0, 0]", "[0, 180, 0]", "[180, 0, 90]"):
        found = rules(CELL.replace(TCP, f"tcp: {{xyz_mm: [0, 0, 180], rpy_deg: {turned}}}"))
        assert "points back at the flange" in found["tcp-turned"]
    assert not rules(CELL.replace(TCP, "tcp: {xyz_mm: [0, 0, 180], rpy_deg: [0, 0, 180]}"))
    assert not rules(CELL.replace(TCP, "tcp: {xyz_mm: [0, 0, 180], rpy_deg: [90, 0, 0]}"))  # a lance with a bend


def test_a_jet_that_hits_its_own_lance() -> None:
    assert "hits its own lance" in rules(CELL.replace(TCP, "tcp: {xyz_mm: [0, 0, 80]}"))["jet-hits-tool"]


def test_a_board_that_lies_upside_down() -> None:
    text = CELL.replace("[400, -50, 150]}", "[400, 50, 150], rpy_deg: [180, 0, 0]}")
    assert "top faces down" in rules(text)["board-upside-down"]
    assert not rules(CELL.replace("[400, -50, 150]}", "[400, 50, 150], rpy_deg: [40, 0, 0]}"))


def test_a_board_out_of_reach_and_one_in_tenths_of_millimetres() -> None:
    assert "mm from the first joint" in rules(CELL.replace("[400, -50, 150]", "[1400, -50, 150]"))["board-out-of-reach"]
    found = rules(CELL.replace("[400, -50, 150]", "[40000, -5000, 15000]"))
    assert "xyz_mm is in mm" in found["board-out-of-reach"]


@pytest.mark.slow
def test_fixtures_in_metres_and_fixtures_in_the_board() -> None:
    assert "mm large" in rules(CELL.replace("[900, 900, 40]", "[0.9, 0.9, 0.04]"))["fixture-units"]
    text = CELL.replace("xyz_mm: [300, 0, -20]", "xyz_mm: [300, 0, 140]")
    assert "table reaches into the box around smt-demo" in rules(text, demo())["fixture-in-board"]


@pytest.mark.slow
def test_a_board_that_no_fixture_holds() -> None:
    low = CELL.replace("[400, -50, 150]", "[400, -50, 29]")
    assert not rules(low, demo())
    found = rules(CELL.replace("[400, -50, 150]", "[400, -50, 45]"), demo())
    assert "no fixture stands within 30 mm under smt-demo" in found["board-not-held"]
    assert "board-not-held" not in rules(CELL)  # the board is not known


@pytest.mark.slow
@pytest.mark.parametrize("name", cell_library())
def test_no_orifice_comes_farther_than_the_longest_reach(name: str) -> None:
    cell = read_cell(name).cell
    lowest, highest = (np.array([getattr(joint, end) for joint in cell.robot.joints]) for end in ("lowest", "highest"))
    bounds = np.maximum(lowest, -2 * np.pi), np.minimum(highest, 2 * np.pi)  # one axis turns without end
    q = np.random.default_rng(4).uniform(*bounds, (500, cell.robot.dof))
    tips = flange_poses(cell.robot, q) @ cell.tools[0].T_flange_tcp
    far = np.linalg.norm(tips[:, :3, 3] - cell.robot.joints[0].T_parent_joint[:3, 3], axis=1)
    assert far.max() <= longest_reach(cell)


def test_the_frame_card_says_where_things_are_and_look() -> None:
    frames = {frame.what: frame for frame in frame_card(read_cell_text(CELL).cell, demo())}
    assert frames["robot base"].looks == "z up, x along -x"
    assert frames["board's own frame"].place_mm == (400, -50, 150)
    assert frames["board's own frame"].looks == "top up, x along +x"
    assert frames["board's back right corner"].place_mm == (500, 30, 150)
    home, flange = frames["tool 1 cone at home"], frames["flange at home"]
    assert flange.place_mm[2] - home.place_mm[2] == pytest.approx(180, abs=0.1)
    assert home.looks.startswith("jet down")


def test_directions_in_words() -> None:
    assert describe_direction(np.array([0.0, 0.0, -1.0])) == "down"
    assert describe_direction(np.array([np.cos(0.2), np.sin(0.2), 0.0])) == "+x, 11.5 degrees off"


def test_a_word_that_sets_a_channel_beyond_its_full_scale() -> None:
    def found(value: float) -> list[tuple[str, str, str]]:
        loaded = read_cell_text(CELL.replace("{goSolution: 2}", f"{{goSolution: 2, aoPressure: {value:g}}}"))
        findings = check_cell(loaded.cell, None, loaded.spec.io)
        return [(finding.rule.id, finding.message, str(finding.made_by)) for finding in findings]

    assert found(10.0) == []
    ((rule, message, made_by),) = found(12.0)
    assert rule == "analog-out-of-range"
    assert message == "di-water sets aoPressure (analog output 1) to 12 V; its full scale is 10 V"
    assert made_by == "io.solutions.di-water.aoPressure"
