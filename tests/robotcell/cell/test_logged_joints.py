"""Logs of joints: counted as controllers do, of several tools and places of the board, read as what the orifice did."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from robot_programs import PROGRAMS

from programs.errors import ProgramError
from programs.playback import playback
from programs.posts.writing.axes import as_controller_counts, own_axes
from programs.program import Command, MoveTo, SetNozzle, TimedProgram
from programs.run_log import place_joints, program_of_log, read_run_log
from robotcell.cell.installation import exported_joints, installation_of, places_of_tool
from robotcell.cell.load import LoadedCell, read_cell
from specs.source import NO_SOURCE

ROWS = 40
"""Of each of the program's strokes, 0.1 s apart."""
STROKES = [(1, ""), (2, ""), (1, ""), (1, "flip_to_bottom"), (2, "flip_to_bottom")]
"""Tool and place of the board; a jet in the middle of each."""


def swept(loaded: LoadedCell) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Joints (n, dof) of the strokes, rad and m, about the cell's home."""
    share = np.linspace(0.0, 1.0, ROWS * len(STROKES))[:, None]
    return loaded.cell.home + share * np.linspace(0.2, 0.5, len(loaded.cell.home))


def what_ran(loaded: LoadedCell) -> TimedProgram:
    """The program that has the poses of these joints."""
    installation, places = installation_of(loaded), places_of_tool(loaded.cell)
    joints = exported_joints(loaded.cell.robot, swept(loaded))
    items: list[Command | MoveTo | SetNozzle] = []
    for number, (tool, placement) in enumerate(STROKES):
        lies = installation.placements[placement] if placement else installation.T_base_board
        rows = slice(number * ROWS, (number + 1) * ROWS)
        tcp, turns = places(joints[rows], installation.tools[tool].T_flange_tcp, lies)
        begin_s = 0.1 * number * ROWS
        if placement:
            items.append(Command(begin_s, "CALL", (placement,), NO_SOURCE))
        items.append(Command(begin_s, "CALL", ("blow",), NO_SOURCE))  # a routine that leaves the board where it is
        items.append(Command(begin_s, "NOZZLE", ("ring60", "ring", str(tool)), NO_SOURCE))
        items += [
            MoveTo(begin_s + 0.1 * at, (x, y, z), (a, b, c, d), 10.0, NO_SOURCE)
            for at, ((x, y, z), (a, b, c, d)) in enumerate(zip(tcp.tolist(), turns.tolist(), strict=True))
        ]
        items += [SetNozzle(begin_s + 1.0, True, NO_SOURCE), SetNozzle(begin_s + 3.0, False, NO_SOURCE)]
    return replace(PROGRAMS["three_speeds"](), instructions=tuple(sorted(items, key=lambda item: item.time_s)))


def written(loaded: LoadedCell, file: Path) -> Path:
    """The log of these joints as the cell's controller counts them."""
    installation = installation_of(loaded)
    units = [f"j{at}_{'deg' if each.kind == 'revolute' else 'mm'}" for at, each in enumerate(installation.joints, 1)]
    lines = [",".join(("time_s", "jet", *units))]
    for at, row in enumerate(exported_joints(loaded.cell.robot, swept(loaded)).tolist()):
        if installation.tool_point is not None:
            axes = own_axes(installation.tool_point, tuple(row))
            counted = (*axes[:3], *np.degrees(axes[3:]).tolist())
        else:
            counted = as_controller_counts(tuple(row), installation)
        on = 10 <= at % ROWS < 30
        lines.append(",".join((f"{0.1 * at:.4f}", f"{on:d}", *(f"{each:.9f}" for each in counted))))
    file.write_text("\n".join((*lines, "")))
    return file


@pytest.mark.parametrize("cell", ["gantry", "lrmate-bench", "kr6-bench"])
def test_a_log_of_joints_is_what_the_orifice_did(tmp_path: Path, cell: str) -> None:
    """On a machine whose controller counts its turning axes, on an arm with coupled joints, and on a plain one."""
    loaded = read_cell(cell)
    program = what_ran(loaded)
    log = place_joints(
        read_run_log(written(loaded, tmp_path / "run.csv")),
        program,
        installation_of(loaded),
        places_of_tool(loaded.cell),
    )
    found = program_of_log(log, program)
    for number in range(len(STROKES)):  # between the strokes the tool is another at once
        times = 0.1 * number * ROWS + np.linspace(1.0, 3.0, 15)
        ran, due = playback(found, times), playback(program, times)
        np.testing.assert_allclose(ran.tcp, due.tcp, atol=1e-3)
        np.testing.assert_allclose(np.abs(np.sum(ran.quaternion * due.quaternion, axis=1)), 1.0, atol=1e-9)
        assert ran.spraying[1:-1].all()


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        (("j4_deg", "j4_mm"), r"run\.csv:1: the joints are not those of robot .* which are j1_mm, .* j5_deg\."),
        (("j5_deg", "other"), "the joints are not those of robot"),
        (("j1_mm", "j9_mm"), "no column x_mm; .* or j1_deg"),
        (("j1_mm", f"j{5000 * '1'}_mm"), "no column x_mm; .* or j1_deg"),
        (("jet", "valve"), "no column jet"),
    ],
)
def test_joints_of_another_robot_are_refused(tmp_path: Path, changed: tuple[str, str], reason: str) -> None:
    loaded = read_cell("gantry")
    file = written(loaded, tmp_path / "run.csv")
    file.write_text(file.read_text().replace(*changed))
    with pytest.raises(ProgramError, match=reason):
        place_joints(read_run_log(file), what_ran(loaded), installation_of(loaded), places_of_tool(loaded.cell))


def test_a_log_beside_a_program_without_a_jet_is_refused(tmp_path: Path) -> None:
    loaded = read_cell("gantry")
    log, program = read_run_log(written(loaded, tmp_path / "run.csv")), what_ran(loaded)
    dry = replace(program, instructions=tuple(each for each in program.instructions if not isinstance(each, SetNozzle)))
    with pytest.raises(ProgramError, match=r"run\.csv: a jet is on in the log, and the program has none"):
        place_joints(log, dry, installation_of(loaded), places_of_tool(loaded.cell))


def test_joints_in_another_cell_are_those_of_another_program(tmp_path: Path) -> None:
    loaded, other = read_cell("kr6-bench"), read_cell("irb1200-bench")
    log = read_run_log(written(loaded, tmp_path / "run.csv"))
    placed = place_joints(log, what_ran(loaded), installation_of(other), places_of_tool(other.cell))
    with pytest.raises(ProgramError, match="of another program"):
        program_of_log(placed, what_ran(loaded))
