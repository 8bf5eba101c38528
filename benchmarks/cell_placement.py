"""The search of placements against a dense search: ratio of the values, how many seeds reach 99 %, evaluations, times.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cell_placement.py [SEEDS] [bodies | map]``

With ``map`` only maps of 40 x 40 places by 12 yaws among bodies are made, and compared with the search. With
``bodies`` only a case whose bodies decide is searched, and the best place of each seed is looked at by points
sampled on the robot and its tool, without the product's collision check.

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

from robotcell.cell.cell import Cell, HasRoom, TableBounds, room_on_table
from robotcell.cell.load import read_cell
from robotcell.collision.collision import Collider, build_collider, collides
from robotcell.placement.configurations import describe_placement
from robotcell.placement.evaluate import Criterion, PlacementGoal, PlacementTask
from robotcell.placement.optimise import find_placements
from robotcell.placement.placement_map import MapGrid, map_placements, reach_bounds, refine_map
from robotcell.placement.reachability import Targets, configurations_at, measure
from robotcell.robot.meshes import placed_triangles
from robotcell.robot.robot import Body, Box, link_poses, pose

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


def blocked_case() -> Case:
    """The flat top in the library's cell of the UR5e, with its tool and table, and a post beside the best place."""
    cell = read_cell("ur5e-bench").cell
    targets = flat_top(6, 4)
    post = Body("post", Box((0.06, 0.06, 0.6)), pose((0.6, 0.15, 0.3), (0, 0, 0)))
    middle = targets.T_board_tcp[:, :3, 3].mean(axis=0)
    place = pose((0.5 - middle[0], -middle[1], 2 * HEIGHT), (0, 0, 0))  # the direction of the dense search: along x
    cell = replace(cell, fixtures=(*cell.fixtures, post), T_cell_board=place)
    return Case("flat top beside a post, UR5e with bodies", cell, targets, "least", 0.0)


def boxed_case() -> Case:
    """The chamfered box beside the same post."""
    flat, targets = blocked_case(), chamfered_box(step=0.02)
    middle = targets.T_board_tcp[:, :3, 3].mean(axis=0)
    place = pose((0.5 - middle[0], -middle[1], 2 * HEIGHT), (0, 0, 0))
    return replace(flat, name="box beside a post", cell=replace(flat.cell, T_cell_board=place), targets=targets)


def map_among_bodies(seeds: int) -> None:
    """Compare the best node of a map, and the best place beside it, with the best of the search."""
    flat, box = blocked_case(), boxed_case()
    cases: tuple[tuple[Case, Criterion], ...] = (
        (flat, "least"), (flat, "mean"), (box, "least"), (box, "p5"), (box, "mean"),
    )  # fmt: skip
    for case, criterion in cases:
        collider = build_collider(case.cell, None)
        goal = PlacementGoal(criterion=criterion, distance=(0.15, 0.95), direction=(-np.pi, np.pi))
        found = [
            find_placements(case.cell, case.targets, replace(goal, seed=seed), collider)[0] for seed in range(seeds)
        ]
        tried = [each.value for each in found]
        begun, used = time.perf_counter(), time.process_time()
        task = PlacementTask(case.cell, case.targets, goal, collider)
        # As the command does: a node lies where a search ended, here the worst of them.
        through = min(found, key=lambda each: each.value).T_cell_board
        mapped = refine_map(task, map_placements(task, MapGrid(reach_bounds(case.cell), through=through)))
        used, took = time.process_time() - used, time.perf_counter() - begun
        assert mapped.refined is not None
        print(
            f"{case.name}, {criterion}: best of {seeds} searches {max(tried):.4f}; best node "
            f"{mapped.score.value / max(tried):.4f} of it, beside it {mapped.refined.value / max(tried):.4f}; "
            f"{used:.1f} s of a core, {took:.1f} s by the clock",
            flush=True,
        )


def clear_value(case: Case, collider: Collider, distance: float, turn: float, above: float) -> float:
    """The least value of the best branch that is better than ``above`` without a collision, or minus infinity."""
    centre = case.targets.T_board_tcp[:, :3, 3].mean(axis=0) * [1, 1, 0]
    place = pose((distance, 0, 2 * HEIGHT), (0, 0, turn))
    place[:3, 3] -= place[:3, :3] @ centre
    found = configurations_at(case.cell, place, case.targets, 1)
    w = measure(case.cell, found.q, case.targets.tool[found.target], "manipulability")
    best = -np.inf
    for branch in range(8):
        mine = found.branch == branch
        better = mine.sum() == len(case.targets.tool) and w[mine].min() > max(best, above)
        if better and not collides(collider, found.q[mine], case.cell.tools[0].number).any():
            best = float(w[mine].min())
    return best


def dense_clear(case: Case, collider: Collider) -> tuple[float, float]:
    """Best least value of a dense search with the bodies, and without them."""
    spacing = 0.02, np.radians(5.0)
    nodes = [(r, a) for r in np.arange(0.2, 0.95, spacing[0]) for a in np.arange(0, 2 * np.pi, spacing[1])]
    centre = case.targets.T_board_tcp[:, :3, 3].mean(axis=0) * [1, 1, 0]
    bounds = list[tuple[float, float, float]]()
    for r, a in nodes:
        place = pose((r, 0, 2 * HEIGHT), (0, 0, a))
        place[:3, 3] -= place[:3, :3] @ centre
        bounds.append((at_place(case, place, 0.0, "least"), r, a))
    found = list[tuple[float, float, float]]()
    for bound, r, a in sorted(bounds, reverse=True):
        if not np.isfinite(bound) or (len(found) >= 8 and bound < 0.8 * max(found)[0]):
            break
        value = clear_value(case, collider, r, a, 0.0)
        if np.isfinite(value):
            found.append((value, r, a))
    best = max(found)[0]
    for _, r, a in sorted(found, reverse=True)[:8]:
        for dr in np.linspace(-1, 1, 9):
            for da in np.linspace(-1, 1, 9):
                best = max(best, clear_value(case, collider, r + dr * spacing[0], a + da * spacing[1], best))
    return best, max(bounds)[0]


def deepest(cell: Cell, joints: np.ndarray) -> float:
    """Least distance, m, of points sampled on moving links and tool from the fixtures, all of which are boxes."""
    random, least = np.random.default_rng(0), np.inf
    for q in joints:
        links = cell.T_cell_base @ link_poses(cell.robot, q[None])[0]
        moving = [(body, links[n]) for n, bodies in enumerate(cell.robot.bodies) for body in bodies if n > 1]
        moving += [(body, links[-1] @ cell.robot.T_link_flange) for body in cell.tools[0].bodies]
        for body, at in moving:
            triangles = placed_triangles(body)
            chosen = triangles[random.integers(0, len(triangles), 400)]
            share = random.dirichlet((1.0, 1.0, 1.0), 400)
            points = np.einsum("ni,nij->nj", share, chosen) @ at[:3, :3].T + at[:3, 3]
            for fixture in cell.fixtures:
                inside = (points - fixture.T_carrier_shape[:3, 3]) @ fixture.T_carrier_shape[:3, :3]
                beyond = np.abs(inside) - 0.5 * np.array(fixture.shape.size)
                away = np.linalg.norm(np.maximum(beyond, 0.0), axis=1) + np.minimum(beyond.max(axis=1), 0.0)
                least = min(least, float(away.min()))
    return least


def search_among_bodies(seeds: int) -> None:
    """The flat top, and the box: that is reached without a collision at 24 of the 2,736 dense places only."""
    for case in (blocked_case(), boxed_case()):
        search_clear(case, seeds)


def search_clear(case: Case, seeds: int) -> None:
    collider = build_collider(case.cell, None)
    best, free = dense_clear(case, collider)
    print(f"{case.name}: dense {best:.4f}, {free:.4f} without the bodies", flush=True)
    ratios, nearest, most = list[float](), np.inf, 0
    for seed in range(seeds):
        goal = PlacementGoal(distance=(0.15, 0.95), seed=seed)
        found = find_placements(case.cell, case.targets, goal, collider)[0]
        there = replace(case.cell, T_cell_board=found.T_cell_board)
        details = describe_placement(there, case.targets, goal, collider)
        nearest = min(nearest, deepest(there, details.joints))
        ratios.append(found.value / best)
        most = max(most, found.tried)
        assert found.value == details.values.min() >= 0.0
    print(
        f"  {sum(ratio >= 0.99 for ratio in ratios)} of {seeds} seeds at least 99 %, the lowest {min(ratios):.4f}, "
        f"at most {most} evaluations; sampled points come within {1e3 * nearest:.1f} mm of a fixture"
    )


def main(words: list[str]) -> None:
    """Print a line for each case."""
    seeds = int(words[0]) if words and words[0].isdigit() else 10
    if "bodies" in words:
        search_among_bodies(seeds)
        return
    if "map" in words:
        map_among_bodies(seeds)
        return
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
