"""From a board file to a timed program: stages, ratio to toppra alone, growth with the board, memory.

Run: ``OMP_NUM_THREADS=1 python benchmarks/plan.py BOARD.tri [RECIPE]``

The reference is toppra, called once for each run (a stretch from rest to rest) of the same plan, on the same grid
points and with the same limits. All times are processor seconds of one thread, which is what a clock shows on a machine
that does nothing else.
"""

import math
import resource
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from shapely import box

from boards.board import Board, Body
from boards.formats.prism import prism
from boards.formats.tri.tri import read_tri, write_tri
from boards.understand import understand
from geometry.coverage.route import forget_routes
from programs import native
from recipes.load import load_recipe
from recipes.recipe import Recipe
from rulesengine.planning.pipeline import make_plan
from rulesengine.timing.corner_blending import round_corners
from rulesengine.timing.coupled_limits import solve_runs, spans_of
from rulesengine.timing.time_plan import chain_of, parametrise, time_plan

GAP_MM = 5.0


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    begin = time.process_time()
    result = work()
    return time.process_time() - begin, result


def panel(bodies: tuple[Body, ...], across: int, up: int) -> tuple[Body, ...]:
    """Copies of a board's components on one slab; GAP_MM apart."""
    board = next(body for body in bodies if body.role == "board")
    low, high = board.patches.reshape(-1, 3).min(axis=0), board.patches.reshape(-1, 3).max(axis=0)
    size = high - low + GAP_MM
    outline = box(low[0], low[1], low[0] + across * size[0] - GAP_MM, low[1] + up * size[1] - GAP_MM)
    patches, normals, surfaces = prism(outline, float(low[2]), float(high[2]))
    copies = [replace(board, patches=patches, normals=normals, surfaces=surfaces)]
    for number in range(across * up):
        step = np.array([number % across * size[0], number // across * size[1], 0.0])
        copies += [
            replace(body, name=f"{body.name}_{number}", patches=body.patches + step)
            for body in bodies
            if body.role != "board"
        ]
    return tuple(copies)


def plan_anew(bodies: tuple[Body, ...], recipe: Recipe, moved_mm: float) -> float:
    """Seconds from a loaded board to its program; moved each time, so that nothing is known from an earlier run."""
    step = np.array([moved_mm, 0.0, 0.0])
    board = understand(tuple(replace(body, patches=body.patches + step) for body in bodies), "moved")
    forget_routes()
    return timed(lambda: time_plan(make_plan(recipe, board), recipe.limits))[0]


def toppra_alone(board: Board, recipe: Recipe) -> tuple[float, int]:
    """Seconds that toppra needs for every run that moves, called run by run, and how many there are."""
    path = round_corners(chain_of(make_plan(recipe, board)), recipe.limits)
    stages = parametrise(path, recipe.limits).stages
    spans = spans_of(stages)
    sharp = np.radians(recipe.limits.rotation_acceleration_deg_s2)
    seconds, _ = timed(lambda: [solve_runs(stages, [span], sharp) for span in spans])
    return seconds, len(spans)


def stage_times(path: Path, recipe: Recipe) -> Board:
    read_s, (bodies, findings) = timed(lambda: read_tri(path))
    understand_s, board = timed(lambda: understand(bodies, path.stem, findings))
    plan_s, plan = timed(lambda: make_plan(recipe, board))
    timing_s, program = timed(lambda: time_plan(plan, recipe.limits))
    render_s, text = timed(lambda: native.render(program))
    total = read_s + understand_s + plan_s + timing_s + render_s
    print(f"{path.name}: {len(bodies)} objects, {sum(len(body.patches) for body in bodies)} patches")
    print(
        f"  read {read_s:.2f} s, understand {understand_s:.2f} s, plan {plan_s:.2f} s, time {timing_s:.2f} s, "
        f"write {render_s:.2f} s; in all {total:.2f} s for {len(text) / 1e6:.1f} MB, {program.totals.moves} moves"
    )
    return board


def main() -> None:
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    source, recipe = Path(sys.argv[1]), load_recipe(sys.argv[2] if len(sys.argv) > 2 else "smt-aqueous")
    warm = understand(*_tiny())
    time_plan(make_plan(recipe, warm), recipe.limits)
    board = stage_times(source, recipe)

    bodies, _ = read_tri(source)
    # In turns, and the least of each: what else the machine does comes and goes.
    pairs = [(plan_anew(bodies, recipe, number), *toppra_alone(board, recipe)) for number in (1.0, 2.0, 3.0, 4.0, 5.0)]
    ours, theirs, runs = (min(each) for each in zip(*pairs, strict=True))
    print(
        f"loaded board to timed program {ours:.2f} s; toppra alone on its {runs} runs {theirs:.2f} s; "
        f"ratio {ours / theirs:.2f} (goal 1.2)"
    )

    base: tuple[float, int] | None = None
    for across, up in ((1, 1), (2, 2), (4, 4)):
        copies = panel(bodies, across, up)
        understand_s, big = timed(lambda copies=copies: understand(copies, "panel"))
        forget_routes()
        plan_s, plan = timed(lambda big=big: make_plan(recipe, big))
        timing_s, _ = timed(lambda plan=plan: time_plan(plan, recipe.limits))
        seconds, count = understand_s + plan_s + timing_s, len(copies)
        base = base or (seconds, count)
        allowed = base[0] * count * math.log(count) / (base[1] * math.log(base[1]))
        print(
            f"panel of {across * up}: {count} objects, understand {understand_s:.2f} s, plan {plan_s:.2f} s, "
            f"time {timing_s:.2f} s; {seconds / allowed:.2f} of n log n"
        )
    print(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


def _tiny() -> tuple[tuple[Body, ...], str]:
    """A small board that warms the compiled code up."""
    patches, normals, surfaces = prism(box(0, 0, 40, 30), -1.6, 0.0)
    slab = Body("board", "board", patches, normals, surfaces)
    parts: list[Body] = []
    for number in range(12):
        x, y = 3.0 + 6 * (number % 6), 5.0 + 12 * (number // 6)
        patches, normals, surfaces = prism(box(x, y, x + 2, y + 1), 0.0, 1.0)
        parts.append(Body(f"C{number}", "component", patches, normals, surfaces, side="top", pins=2))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tiny.tri"
        path.write_text(write_tri((slab, *parts)))
        return read_tri(path)[0], "tiny"


if __name__ == "__main__":
    main()
