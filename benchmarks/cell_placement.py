"""The search of placements against a dense search: ratio of the values, how many seeds reach 99 %, evaluations, times.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cell_placement.py [SEEDS]``

Eight cases: the flat top and the chamfered box of the Maribor paper, and six of other robots, shapes, tools and bounds.
The dense search looks at distances and turns on a grid, then on a finer one around its eight best, with the criterion
worked out here. A case that no place of the dense search can do is compared by its least value.
"""

import sys
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from placed_parts import HEIGHT, LENGTH, WIDTH, chamfered_box, dome, flat_top, lance_cell

from robotcell.cell.cell import Cell
from robotcell.placement.criteria import Criterion, PlacementGoal
from robotcell.placement.optimise import find_placements
from robotcell.placement.reachability import Targets, configurations_at, measure
from robotcell.placement.room import HasRoom, TableBounds, room_on_table
from robotcell.robot.poses import pose

_BOX = np.array([[x, y, z] for x in (0, LENGTH) for y in (0, WIDTH) for z in (-HEIGHT, 0)])


@dataclass(frozen=True)
class Case:
    """A part, a robot, and what is maximised."""

    name: str
    cell: Cell
    targets: Targets
    criterion: Criterion
    floor: float
    room: HasRoom | None = None


def cases() -> list[Case]:
    """The two of the paper, and six more."""
    table = room_on_table(TableBounds((-0.35, 0.35), (-0.85, 0.0)), _BOX)
    beside = room_on_table(TableBounds((0.3, 0.75), (-0.1, 0.5)), _BOX)
    return [
        Case("flat top, 150 mm", lance_cell(0.15), flat_top(), "mean", 0.028),
        Case("box, 150 mm", lance_cell(0.15), chamfered_box(), "mean", 0.028),
        Case("box, the table of the paper, p5", lance_cell(0.15), chamfered_box(step=0.02), "p5", 0.028, table),
        Case("box, a table at the side, least", lance_cell(0.05), chamfered_box(step=0.02), "least", 0.0, beside),
        Case("dome to 60 degrees, UR5e", lance_cell(0.1, "ur5e"), dome(0.12, 80, np.radians(60)), "least", 0.0),
        Case("flat top, KR 6", lance_cell(0.15, "kr6-r900"), flat_top(), "mean", 0.01),
        Case("box, IRB 1200", lance_cell(0.12, "irb1200-7"), chamfered_box(step=0.02), "p5", 0.0),
        Case("dome to 30 degrees, GP8", lance_cell(0.2, "gp8"), dome(0.2, 60, np.radians(30)), "mean", 0.005),
        Case("box, 250 mm: infeasible", lance_cell(0.25), chamfered_box(step=0.02), "mean", 0.028),
    ]


def criterion_of(values: np.ndarray, criterion: Criterion) -> float:
    """Worth of (k,) values."""
    rank = max(int(np.ceil(0.05 * len(values) - 1e-9)) - 1, 0)
    return {"mean": values.mean(), "least": values.min(), "p5": np.sort(values)[rank]}[criterion]


def at_place(case: Case, place: np.ndarray, floor: float, criterion: Criterion) -> float:
    """Value of the best branch there; minus infinity where none does."""
    found = configurations_at(case.cell, place, case.targets, 1)
    w = measure(case.cell, found.q, case.targets.tool[found.target], "manipulability")
    best = -np.inf
    for branch in range(8):
        mine = w[found.branch == branch]
        if len(mine) == len(case.targets.tool) and mine.min() >= floor:
            best = max(best, criterion_of(mine, criterion))
    return float(best)


def dense(case: Case, floor: float, criterion: Criterion) -> tuple[float, int]:
    """Best value, and how many places were looked at."""
    around = np.radians(np.arange(0, 360, 10.0)) if case.room is not None else np.zeros(1)
    centre = case.targets.T_board_tcp[:, :3, 3].mean(axis=0) * [1, 1, 0]
    looked = 0

    def value(distance: float, turn: float) -> float:
        nonlocal looked
        best = -np.inf
        for angle in around:
            place = pose((distance * np.cos(angle), distance * np.sin(angle), HEIGHT), (0, 0, turn + angle))
            place[:3, 3] -= place[:3, :3] @ centre
            if case.room is None or case.room(place):
                looked += 1
                best = max(best, at_place(case, place, floor, criterion))
                if case.name.startswith("box, the"):
                    break  # nothing but the table breaks the symmetry of a UR5
        return best

    spacing = 0.02, np.radians(5.0)
    grid = [(value(r, a), r, a) for r in np.arange(0.2, 0.95, spacing[0]) for a in np.arange(0, 2 * np.pi, spacing[1])]
    best, top = max(grid)[0], sorted(grid, reverse=True)[:8]
    for _, r, a in top:
        for dr in np.linspace(-1, 1, 9):
            for da in np.linspace(-1, 1, 9):
                best = max(best, value(r + dr * spacing[0], a + da * spacing[1]))
    return best, looked


def main(words: list[str]) -> None:
    """Print a line for each case."""
    seeds = int(words[0]) if words else 10
    for case in cases():
        best, looked = dense(case, case.floor, case.criterion)
        feasible = np.isfinite(best)
        if not feasible:
            best, looked = dense(case, 0.0, "least")
        around = (-np.pi, np.pi) if case.room is not None else (0.0, 0.0)
        goal = PlacementGoal(criterion=case.criterion, floor=case.floor, distance=(0.15, 0.95), direction=around)
        begun, ratios, most = time.process_time(), list[float](), 0
        for seed in range(seeds):
            found = find_placements(case.cell, case.targets, replace(goal, seed=seed), has_room=case.room)[0]
            reached = found.value if feasible else found.least if found.value < 0.0 else np.nan
            ratios.append(reached / best)
            most = max(most, found.tried)
        took = (time.process_time() - begun) / seeds
        print(
            f"{case.name}: dense {best:.4f} of {looked} places{'' if feasible else ', least, infeasible'}; "
            f"{sum(ratio >= 0.99 for ratio in ratios)} of {seeds} seeds at least 99 %, "
            f"the lowest {min(ratios):.4f}, at most {most} evaluations, {took:.2f} s",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:])
