"""Time the search for a robot's motion; compare it with toppra's bound for its path, and with a plan for its cell.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cell_track.py [--checks] [BOARD [RECIPE [CELL ...]]]``

With ``--checks`` only how long the check itself takes, in the cells or in every cell of the library: processor seconds,
of the program's time, and where more than a sixtieth of that is taken the exit code is 1.
"""

import sys
import time
from pathlib import Path

import numpy as np
import toppra
from numpy.typing import NDArray
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraintVarying

from boards.load import load_board
from recipes.load import load_recipe
from robotcell.cell.cell import Cell
from robotcell.cell.load import LoadedCell, cell_library, hold_board, read_cell
from robotcell.motion.retime import rates_of
from robotcell.track import CellReport, terms_of, track
from rulesengine.planning.cell_plan import plan_for_cell
from rulesengine.planning.pipeline import Run, run

toppra.setup_logging("ERROR")
RUNS = 60
"""Runs from rest to rest that are compared: those that take the robot longest."""


MOST_SHARE = 1.0 / 60.0
"""Of a program's time that its check may take."""


def main(words: list[str]) -> None:
    if words[:1] == ["--checks"]:
        sys.exit(print_checks(words[1:]))
    board = load_board(Path(words[0] if words else "smt-demo"))
    planned = run(load_recipe(words[1] if len(words) > 1 else "smt-aqueous"), board)
    for name in words[2:] or ["ur5e-bench", "kr6-bench", "gantry"]:
        loaded = hold_board(read_cell(name), board)
        track(planned.program, loaded.cell, None, terms=terms_of(loaded))  # compiles, and fills the caches
        begin = time.process_time()  # of one thread: the clock, on a machine that does nothing else
        report = track(planned.program, loaded.cell, board, terms=terms_of(loaded))
        took = time.process_time() - begin
        requested = planned.program.totals.duration_s
        print(f"{board.name} in {name}: {took:.1f} s for a program of {requested:.0f} s, 1 / {requested / took:.0f}")
        if not report.possible:
            print("  cannot be done:", report.findings[0].message)
            continue
        ours, bound = compare(report)
        print(f"  the robot takes {report.program.totals.duration_s:.1f} s; its {RUNS} longest runs {ours:.2f} s,")
        print(f"  toppra's bound for their joint paths {bound:.2f} s: {ours / bound:.3f} times as long")
        print_plan_for_cell(planned, loaded)


def print_checks(words: list[str]) -> int:
    """Time the check of a program in each cell; 1 where one takes more than its share."""
    board = load_board(Path(words[0] if words else "smt-demo"))
    program = run(load_recipe(words[1] if len(words) > 1 else "smt-aqueous"), board).program
    requested, failed = program.totals.duration_s, 0
    print(f"{board.name}, a program of {requested:.1f} s\n| cell | s | of the program's time | can be done |")
    first = read_cell("kr6-bench")
    track(program, first.cell, None, terms=terms_of(first))  # compiles, or loads what was compiled
    for name in words[2:] or cell_library():
        loaded = hold_board(read_cell(name), board)
        begin = time.process_time()
        report = track(program, loaded.cell, board, terms=terms_of(loaded))
        took = time.process_time() - begin
        failed |= took > MOST_SHARE * requested
        errors = dict.fromkeys(each.rule.id for each in report.findings if each.severity == "error")
        print(f"| {name} | {took:.1f} | 1 / {requested / took:.0f} | {', '.join(errors) or 'yes'} |", flush=True)
    return failed


def print_plan_for_cell(free: Run, loaded: LoadedCell) -> None:
    """Plan for the cell, check that anew, and print planned time, price and the robot's time."""
    planned = plan_for_cell(free, loaded)
    timing = planned.robot
    if timing is None:
        print("  not planned for:", planned.findings[0].message)
        return
    report = track(planned.program, loaded.cell, planned.board, terms=terms_of(loaded))
    added = report.added.from_home + report.added.tool_changes + report.added.to_home
    whole, price = report.program.totals.duration_s, ", ".join(f"{each:.1f} {kind}" for kind, each in timing.price_s)
    print(f"  planned for it {timing.planned_s:.1f} s: {timing.planned_s - timing.free_s:.1f} s more ({price});")
    ratios = (whole - added) / timing.planned_s, whole / timing.planned_s
    print(f"  it takes {ratios[0]:.3f} times that, {ratios[1]:.3f} with {added:.1f} s for home and changes of the tool")
    rates, joints = rates_of(report.program, report.joints), report.cell.robot.joints
    speed = max(np.abs(rates.speed[:, index]).max() / joint.speed for index, joint in enumerate(joints))
    push = max(np.abs(rates.acceleration[:, index]).max() / joint.acceleration for index, joint in enumerate(joints))
    print(f"  at most {speed:.1%} of a joint's greatest speed, {push:.1%} of its acceleration")


def compare(report: CellReport) -> tuple[float, float]:
    """Seconds of the longest runs, ours and toppra's, for the same joints and no faster than the program anywhere."""
    rates = rates_of(report.program, report.joints)
    rest = np.abs(rates.speed).max(axis=1) < 1e-9
    edges = np.flatnonzero(np.diff(np.concatenate(([True], rest, [True])).astype(int)))
    runs = [(a, b) for a, b in zip(edges[0::2], edges[1::2], strict=True) if b - a > 20]
    runs.sort(key=lambda pair: rates.times[pair[0]] - rates.times[pair[1]])
    clock = report.clock  # of the program; none within joint moves that it does not have
    ours = bound = 0.0
    for a, b in runs[:RUNS]:
        least = bound_of(report.cell, rates.q[a : b + 1], np.diff(clock[a : b + 1]))
        if least is not None:
            ours += float(rates.times[b] - rates.times[a])
            bound += max(least, float(clock[b] - clock[a]))  # the grid's caps reach over a sample; the program's do not
    return ours, bound


def bound_of(cell: Cell, q: NDArray[np.float64], lasting: NDArray[np.float64]) -> float | None:
    """Least time from rest to rest along rows of joints, in no interval faster than the program."""
    steps = np.linalg.norm(np.diff(q, axis=0), axis=1)
    kept = np.concatenate(([True], steps > 1e-7))
    if kept.sum() < 5 or not np.all(lasting > 0.0):
        return None
    s = np.concatenate(([0.0], np.cumsum(steps)))
    fastest = steps / lasting
    path = toppra.SplineInterpolator(s[kept], q[kept])
    speed = np.array([joint.speed for joint in cell.robot.joints])
    push = np.array([joint.acceleration for joint in cell.robot.joints])

    def highest(place: float) -> NDArray[np.float64]:
        """Speeds of the joints at a place of the path, where the program's own pace is the limit too."""
        interval = int(np.clip(np.searchsorted(s, place, side="right") - 1, 0, len(steps) - 1))
        near = fastest[max(interval - 1, 0) : interval + 2].max()
        own = np.abs(path(place, 1)) * near + 1e-9
        limit = np.minimum(speed, own)
        return np.stack((-limit, limit), axis=1)

    grid = np.unique(np.concatenate((s[kept], 0.5 * (s[kept][1:] + s[kept][:-1]))))
    solver = TOPPRA(
        [JointVelocityConstraintVarying(highest), JointAccelerationConstraint(np.stack((-push, push), axis=1))],
        path,
        gridpoints=grid,
        solver_wrapper="seidel",
        parametrizer="ParametrizeConstAccel",
    )
    trajectory = solver.compute_trajectory(0.0, 0.0)
    return None if trajectory is None else float(trajectory.duration)


if __name__ == "__main__":
    main(sys.argv[1:])
