"""Gerber job files: functions, thickness and size of a set of layers that states none, and what contradicts them."""

import json
from pathlib import Path
from shutil import make_archive
from typing import Any

import pytest
from orders import PLACES, RIGHT, centroid, gerbers, middles, rules, table

from boards.board import Board
from boards.load import load_board

FUNCTIONS = {"one.art": "Copper,L1,Top", "two.art": "Copper,L2,Bot", "three.art": "Profile,NP"}


def job(
    functions: dict[str, str] = FUNCTIONS, thickness: Any = 0.8, size: tuple[float, float] = (40.0, 30.0)
) -> dict[str, Any]:
    return {
        "Header": {"GenerationSoftware": {"Vendor": "own"}},
        "GeneralSpecs": {"Size": {"X": size[0], "Y": size[1]}, "LayerNumber": 2, "BoardThickness": thickness},
        "FilesAttributes": [{"Path": name, "FileFunction": each} for name, each in functions.items()],
    }


def order(folder: Path, *stated: object) -> Path:
    """Layers whose names and contents say nothing, a table, and job files."""
    layers = gerbers(folder)
    for name, other in (("b.gtl", "one.art"), ("b.gbl", "two.art"), ("b.gko", "three.art")):
        text = (layers / name).read_text().replace("%TF.FileFunction,Profile,NP*%\n", "")
        (layers / name).unlink()
        (layers / other).write_text(text)
    table(layers, "cpl.csv", centroid())
    for number, each in enumerate(stated):
        (layers / f"card{number}.gbrjob").write_text(each if isinstance(each, str) else json.dumps(each))
    return layers


def thickness(board: Board) -> float:
    return board.top_z_mm - board.bottom_z_mm


def against(board: Board) -> dict[tuple[str, str], tuple[str, str]]:
    return {(each.component, each.about): (each.taken, each.other) for each in board.contradictions}


@pytest.mark.parametrize("packed", [False, True])
def test_functions_thickness_and_size_come_from_the_job_file(tmp_path: Path, packed: bool) -> None:
    path = order(tmp_path, job())
    if packed:
        path = Path(make_archive(str(tmp_path / "packed"), "zip", path))
    board = load_board(path)
    assert middles(board) == RIGHT
    assert {body.name: len(body.pads) for body in board.bodies if body.pads} == {
        name: 8 if name == "U1" else 2 for name in PLACES
    }
    assert thickness(board) == pytest.approx(0.8)
    states = {each.name: (each.kind, each.states) for each in board.sources}
    assert states["card0.gbrjob"] == ("job file", "size 40.0 x 30.0 mm, 0.8 mm thick, 3 files")
    assert states["one.art"][1] == "copper, top"
    assert not {"parts-contradict", "layers-missing"} & rules(board)


def test_a_mask_that_only_the_job_file_calls_so_sorts_out_vias(tmp_path: Path) -> None:
    layers = order(tmp_path, job({**FUNCTIONS, "four.art": "SolderMask,Top"}))
    text = (layers / "one.art").read_text()
    (layers / "four.art").write_text(text)
    (layers / "one.art").write_text(text.replace("M02*", "D10*\nX11500000Y20000000D03*\nX9000000Y21000000D03*\nM02*"))
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert {body.name: len(body.pads) for body in board.bodies}["R1"] == 2
    assert not any("belong to no row" in each.message for each in board.findings)


def test_what_the_layers_contradict_is_a_finding_of_each_kind(tmp_path: Path) -> None:
    layers = order(tmp_path, job(size=(90.0, 30.0)), job(thickness=2.4))
    (layers / "two.art").write_text("%TF.FileFunction,Copper,L2,Bot*%\n" + (layers / "two.art").read_text())
    (layers / "card0.gbrjob").write_text(json.dumps(job({**FUNCTIONS, "two.art": "Soldermask,Top"}, size=(90.0, 30.0))))
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert thickness(board) == pytest.approx(0.8)
    assert against(board) == {
        ("two.art", "function"): ("Copper,L2,Bot", "Soldermask,Top"),
        ("board", "size"): ("40.0 x 30.0 mm", "90.0 x 30.0 mm"),
        ("board", "thickness"): ("0.8 mm", "2.4 mm"),
    }
    assert sum(each.rule.id == "parts-contradict" for each in board.findings) == 3


def test_a_thickness_that_no_board_has_is_not_taken(tmp_path: Path) -> None:
    board = load_board(order(tmp_path, job(thickness=0.02)))
    assert thickness(board) == pytest.approx(1.6)
    assert against(board) == {("board", "thickness"): ("1.6 mm", "0.02 mm")}


def test_the_stack_states_the_thickness_where_nothing_else_does(tmp_path: Path) -> None:
    stated = {**job(thickness=None), "MaterialStackup": [{"Thickness": mm} for mm in (0.035, 0.93, 0.035)] + [{}]}
    assert thickness(load_board(order(tmp_path, stated))) == pytest.approx(1.0)


def test_files_that_are_listed_and_not_there_are_one_finding(tmp_path: Path) -> None:
    listed = {**FUNCTIONS, "Bare.art": "Copper,L4,Bot", "mask.art": "SolderMask,Top", "print.art": "Legend,Top"}
    board = load_board(order(tmp_path, job(listed)))
    (found,) = (each.message for each in board.findings if each.rule.id == "layers-missing")
    assert found == "2 files that the job file lists are not there: Bare.art, mask.art."


@pytest.mark.parametrize("text", ["{", "[]", "null", '{"GeneralSpecs": 3, "FilesAttributes": {"Path": 1}}',
                                  '{"FilesAttributes": [3, {}, {"Path": ["x"]}], "MaterialStackup": [1]}'])  # fmt: skip
def test_a_damaged_job_file_states_nothing(tmp_path: Path, text: str) -> None:
    layers = gerbers(tmp_path)
    table(layers, "cpl.csv", centroid())
    (layers / "b.gbrjob").write_text(text)
    board = load_board(layers)
    assert middles(board) == RIGHT
    assert thickness(board) == pytest.approx(1.6)
