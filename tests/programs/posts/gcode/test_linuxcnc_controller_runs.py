"""What LinuxCNC's real controller does of whole programs is what was planned: path, times, jets."""

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from controller_runs import Run, run_program
from real_linuxcnc import MISSING

from boards.load import load_board
from programs.program import Command, SetNozzle, TimedProgram
from recipes.load import load_recipe
from reports.files.robot_programs import CellExport, export_in_cell
from robotcell.cell.installation import installation_of
from robotcell.cell.load import LoadedCell, hold_board, read_cell
from rulesengine.planning.pipeline import run

pytestmark = [pytest.mark.controller, pytest.mark.timeout(1800), pytest.mark.skipif(bool(MISSING), reason=MISSING)]
STRETCH_S = 120.0
BOARDS = ("tiny", "smt-demo")
"""The first whole, of the other the first two minutes, which end on a lap with C wound up and the tool leaning."""


def beginning_of(program: TimedProgram, seconds: float) -> TimedProgram:
    """Give a program up to the first end of a jet, outside of loops, that comes after so long."""
    depth = 0
    for at, item in enumerate(program.instructions):
        if isinstance(item, Command):
            depth += {"REPEAT": 1, "ENDREPEAT": -1}.get(item.keyword, 0)
        if item.time_s >= seconds and depth == 0 and isinstance(item, SetNozzle) and not item.spraying:
            totals = replace(program.totals, duration_s=item.time_s)
            return replace(program, instructions=program.instructions[: at + 1], totals=totals)
    return program


@cache
def planned(name: str) -> tuple[TimedProgram, LoadedCell, CellExport]:
    """The plan, the gantry with the board in it, and the export."""
    board = load_board(Path(name))
    loaded = read_cell("gantry")
    program = beginning_of(run(load_recipe("smt-aqueous"), board).program, STRETCH_S if name == "smt-demo" else 1e9)
    return program, hold_board(loaded, board), export_in_cell(program, loaded, "linuxcnc", board)


@cache
def driven(name: str, folder: Path) -> Run:
    _, loaded, done = planned(name)
    for file, text in done.exported.files.items():
        (folder / file).write_text(text, "ascii")
    cell = installation_of(loaded)
    return run_program(folder / next(iter(done.exported.files)), done.report.program, loaded.cell.robot, cell, 1200.0)


@pytest.fixture(scope="module", params=BOARDS)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Run]:
    name = str(request.param)
    return name, driven(name, tmp_path_factory.mktemp(name))


def test_it_takes_the_time_of_the_header_and_of_the_plan(case: tuple[str, Run]) -> None:
    name, done = case
    program, _, written = planned(name)
    (text, *_) = written.exported.files.values()
    header = re.search(r"^\(Predicted time ([\d.]+) s", text, re.MULTILINE)
    assert header
    assert done.path_s + done.home_s <= 1.10 * float(header[1])
    assert done.path_s + done.home_s >= 0.95 * float(header[1])
    assert done.path_s <= 1.10 * program.totals.duration_s
    assert done.home_s <= 3.0


def test_the_orifice_keeps_to_its_way_while_it_sprays(case: tuple[str, Run]) -> None:
    _, done = case
    assert done.off_mm <= 0.10
    assert done.left_out_mm <= 0.15  # a cycle's way is up to 0.1 mm


def test_each_jet_begins_and_ends_in_its_place(case: tuple[str, Run]) -> None:
    _, done = case
    assert [(edge.valve, edge.on) for edge in done.edges] == [(edge.valve, edge.on) for edge in done.planned]
    assert max(done.edge_mm) <= 0.40
    assert max(done.edge_s) <= 0.015


def test_no_axis_winds_up(case: tuple[str, Run]) -> None:
    name, done = case
    _, loaded, _ = planned(name)
    turns = np.abs(done.log.joints[:, 4]).max() / 360.0
    assert turns <= loaded.spec.hose_turns + 1e-6
    assert done.log.messages == ()
