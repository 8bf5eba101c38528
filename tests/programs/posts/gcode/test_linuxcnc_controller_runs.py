"""What LinuxCNC's real controller does of whole programs is what was planned: path, times, jets, cleanliness."""

import re
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from controller_runs import Run, run_program, tool_points
from each_workpiece import BOARD_RECIPE, write_inputs
from real_linuxcnc import MISSING
from trimesh.convex import convex_hull

import rulesengine.planning.pipeline as planning
from boards.board import Workpiece
from boards.load import load_board
from boards.part.load import load_part
from boards.workpiece import load_workpiece
from cleaning.verdicts.results import outcome
from programs.driven import with_totals
from programs.program import Command, SetNozzle, TimedProgram
from programs.run_log import program_of_log, read_run_log
from programs.summary import jet_seconds
from recipes.load import load_recipe
from recipes.recipe import Recipe
from reports.files.robot_programs import CellExport, export_in_cell
from robotcell.cell.installation import installation_of
from robotcell.cell.load import LoadedCell, hold_board, read_cell
from washboard.cleaned import Cleaned, FaceReport, analyse

pytestmark = [pytest.mark.controller, pytest.mark.timeout(2400), pytest.mark.skipif(bool(MISSING), reason=MISSING)]
STRETCH_S = 120.0
TIMES = "paths: [lines], repeat: 3"
BODIES = {
    "frustum": [(x * s, y * s, z) for s, z in ((30, 0), (15, 15)) for x in (-1, 1) for y in (-1, 1)],
    "roof": [(x * s, y * t, z) for s, t, z in ((30, 20, 0), (15, 2, 12)) for x in (-1, 1) for y in (-1, 1)],
}
PART = """
part: {name}
body: {{file: {name}.stl}}
fixtures:
  table: {{kind: box, size_mm: [300, 300, 20], at: {{xyz_mm: [0, 0, -10]}}}}
"""


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A workpiece in the gantry, with what is planned and exported."""

    plan: planning.Run
    loaded: LoadedCell
    done: CellExport


Job = tuple[Workpiece, Recipe, LoadedCell]


def board_of_library(name: str, _folder: Path) -> Job:
    return load_board(Path(name)), load_recipe("smt-aqueous"), read_cell("gantry")


def panel(recipe: str, folder: Path) -> Job:
    write_inputs(folder)
    return load_workpiece(folder / "two.yaml"), load_recipe(recipe), read_cell("gantry")


def short(name: str, folder: Path) -> Job:
    """One of the small workpieces, with lines only, three times."""
    write_inputs(folder)
    file = folder / "brief.yaml"
    file.write_text(BOARD_RECIPE.replace("paths: [lines]", TIMES))
    return load_workpiece(folder / name), load_recipe(file), read_cell("gantry")


def part(name: str, folder: Path) -> Job:
    """A convex part on a table at 80 mm; the gantry holds no boards."""
    convex_hull(np.array(BODIES[name], float)).export(folder / f"{name}.stl")
    file = folder / f"{name}.yaml"
    file.write_text(PART.format(name=name))
    lines = Path(read_cell("gantry").root.mark.file).read_text("utf-8").splitlines(keepends=True)
    kept = "".join(line for line in lines if not line.strip().startswith("holder:"))
    at_table = "  hold: origin\n  pose: {xyz_mm: [0, 0, 80]}"
    (folder / "cell.yaml").write_text(re.sub(r"  hold: front_left\n  pose: .*", at_table, kept, count=1), "utf-8")
    return load_part(file), load_recipe("part-degrease"), read_cell(folder / "cell.yaml")


WORKPIECES: dict[str, Callable[[Path], Job]] = {
    "tiny": lambda folder: board_of_library("tiny", folder),
    "smt-demo, two minutes": lambda folder: board_of_library("smt-demo", folder),
    "repeat": lambda folder: short("small.tri", folder),
    "panel, repeat": lambda folder: short("two.yaml", folder),
    "frustum": lambda folder: part("frustum", folder),
    "roof": lambda folder: part("roof", folder),
    "smt-demo": lambda folder: board_of_library("smt-demo", folder),
    "two-sided": lambda folder: board_of_library("two-sided", folder),
    "panel": lambda folder: panel("smt-aqueous", folder),
}
WHOLE = ("smt-demo", "two-sided", "panel")
"""Of many minutes each. Two minutes of the first end on a lap with C wound up and the tool leaning."""
BESIDE = {"repeat": 2, "roof": 2}
"""Processes beside them that do nothing but count."""


def beginning_of(program: TimedProgram, seconds: float) -> TimedProgram:
    """Give a program up to the first end of a jet, outside of loops, that comes after so long."""
    depth = 0
    for at, item in enumerate(program.instructions):
        if isinstance(item, Command):
            depth += {"REPEAT": 1, "ENDREPEAT": -1}.get(item.keyword, 0)
        if item.time_s >= seconds and depth == 0 and isinstance(item, SetNozzle) and not item.spraying:
            return with_totals(program, program.instructions[: at + 1])
    return program


@cache
def case_of(name: str, folder: Path) -> Case:
    workpiece, recipe, loaded = WORKPIECES[name](folder)
    plan = planning.run(recipe, workpiece)
    plan = replace(plan, program=beginning_of(plan.program, STRETCH_S if "minutes" in name else np.inf))
    return Case(plan, hold_board(loaded, workpiece), export_in_cell(plan.program, loaded, "linuxcnc", workpiece))


@cache
def driven(name: str, folder: Path) -> Run:
    case = case_of(name, folder)
    for file, text in case.done.exported.files.items():
        (folder / file).write_text(text, "ascii")
    cell, robot = installation_of(case.loaded), case.loaded.cell.robot
    for routine in cell.placements:
        (folder / f"{routine}.ngc").write_text(f"o<{routine}> sub\no<{routine}> endsub\nM2\n", "ascii")
    file = folder / next(iter(case.done.exported.files))
    with ExitStack() as beside:
        for _ in range(BESIDE.get(name, 0)):
            counting = beside.enter_context(subprocess.Popen([sys.executable, "-c", "while True: pass"]))
            beside.callback(counting.kill)
        return run_program(file, case.done.report.program, robot, cell, 2000.0)


@pytest.fixture(
    scope="module", params=[pytest.param(each, marks=[pytest.mark.whole] * (each in WHOLE)) for each in WORKPIECES]
)
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    return str(request.param), tmp_path_factory.mktemp("run")


def test_it_takes_the_time_of_the_header_and_of_the_plan(folder: tuple[str, Path]) -> None:
    case, done = case_of(*folder), driven(*folder)
    (text, *_) = case.done.exported.files.values()
    header = re.search(r"^\(Predicted time ([\d.]+) s", text, re.MULTILINE)
    assert header
    assert 0.95 * float(header[1]) <= done.path_s + done.home_s <= 1.10 * float(header[1])
    tracked_s = case.done.report.program.totals.duration_s
    assert tracked_s >= case.plan.program.totals.duration_s - 0.1  # the robot turns more slowly than the plan
    path_s = tracked_s - case.done.report.added.from_home - case.done.report.added.to_home
    assert 0.98 * path_s <= done.path_s <= 1.05 * path_s
    assert done.home_s <= 3.0


def test_the_orifice_keeps_to_its_way_while_it_sprays(folder: tuple[str, Path]) -> None:
    done = driven(*folder)
    assert done.off_mm <= 0.10
    assert done.left_out_mm <= 0.15  # a cycle's way is up to 0.1 mm


def test_each_jet_begins_and_ends_in_its_place(folder: tuple[str, Path]) -> None:
    done = driven(*folder)
    assert [(edge.valve, edge.on) for edge in done.edges] == [(edge.valve, edge.on) for edge in done.planned]
    assert max(done.edge_mm) <= 0.20
    assert max(done.edge_s) <= 0.020


def test_no_axis_winds_up(folder: tuple[str, Path]) -> None:
    done = driven(*folder)
    turns = np.abs(done.log.joints[:, 4]).max() / 360.0
    assert turns <= case_of(*folder).loaded.spec.hose_turns + 1e-6
    assert done.log.messages == ()


def test_what_gets_clean_is_what_was_predicted_and_jets_take_their_time(folder: tuple[str, Path]) -> None:
    name, place = folder
    case = case_of(*folder)
    file = table_of(driven(*folder), case, place / "run.csv")
    planned = analyse(case.plan)
    foretold = analyse(replace(case.plan, program=case.done.driven), before=planned)
    ran = analyse(case.plan, log=file, before=planned)
    if "minutes" not in name:  # a board that was not finished has parts between two verdicts
        assert outcomes(ran) == outcomes(foretold)
    if name in BODIES:
        assert set(outcomes(ran).values()) == {"clean"}
    log = program_of_log(read_run_log(file), case.done.report.program)
    due, took = (by_path_class(each, case.plan.recipe) for each in (case.done.driven, log))
    # Where the export states that the machine cannot keep times, they are less sure.
    off = 0.05 if any(each.rule.id == "dose-differs" for each in case.done.exported.findings) else 0.03
    for path, seconds in due.items():
        assert took[path] / seconds == pytest.approx(1.0, abs=off), path


def outcomes(done: Cleaned) -> dict[str, str]:
    """What becomes of each component, or of each face that can be seen."""
    report = done.report
    if isinstance(report, FaceReport):
        return {f"{each.face} {each.made_by}": each.verdict for each in report.verdicts if each.visible_share > 0.0}
    return {each.component: outcome(each) for each in (*report.parts, report.bare)}


def by_path_class(program: TimedProgram, recipe: Recipe) -> dict[str, float]:
    """Seconds of the jets by path class."""
    seconds = defaultdict[str, float](float)
    for source, jet_s in jet_seconds(program).items():
        seconds[recipe.templates[source.template].path] += jet_s
    return seconds


def table_of(ran: Run, case: Case, file: Path) -> Path:
    """Write the log of a run as a table that ``analyse --log`` reads."""
    text = next(iter(case.done.exported.files.values())).splitlines()
    seconds, orifice = ran.log.seconds, tool_points(ran.log, text, installation_of(case.loaded))
    on = np.zeros(len(seconds), dtype=np.int8)
    for begin, end in zip(ran.edges[::2], ran.edges[1::2], strict=True):
        on[(seconds >= begin.seconds) & (seconds < end.seconds)] = 1
    rows = np.column_stack((seconds, orifice, on))
    np.savetxt(file, rows, "%.4f", ",", header="time_s,x_mm,y_mm,z_mm,jet")
    return file
