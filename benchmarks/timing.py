"""Time a synthetic plan of about 3,000 runs, and compare with toppra called run by run on the same paths and grids.

Run: ``OMP_NUM_THREADS=1 python benchmarks/timing.py``
"""

import time

import numpy as np

from geometry.arrays import Directions, Points
from programs.plan import Command, Dwell, Jet, Origin, Plan, PlanItem, SprayPass, Transfer
from programs.program import MoveTo
from recipes.recipe import Limits
from rulesengine.timing.corner_blending import round_corners
from rulesengine.timing.coupled_limits import solve_runs, spans_of
from rulesengine.timing.time_plan import chain_of, parametrise, time_plan
from specs.source import Source

JET = Jet("clean", "ring60", "saponifier-15", 2.0, True)
UP = 110.0


def tilted(yaw: np.ndarray, tilt: float) -> tuple[Directions, Directions]:
    approach = np.stack(
        (np.sin(tilt) * np.cos(yaw), np.sin(tilt) * np.sin(yaw), np.full_like(yaw, -np.cos(tilt))), axis=1
    )
    reference = np.cross(approach, np.cross(np.array([1.0, 0.0, 0.0]), approach))
    return approach, reference / np.linalg.norm(reference, axis=1, keepdims=True)


def ring(centre: Points, half: tuple[float, float], turns: int) -> tuple[Points, Directions, Directions]:
    """Around a rectangle with rounded corners, the jet leaning inwards; ``turns`` times."""
    angle = np.arange(0, 360 * turns + 1, 10) * np.pi / 180
    quadrant = np.sign(np.stack((np.cos(angle + 1e-9), np.sin(angle + 1e-9)), axis=1))
    flat = quadrant * half + 4.0 * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    approach, reference = tilted(angle + np.pi, np.radians(30))
    return np.column_stack((centre[:2] + flat, np.full(len(angle), 40.0))), approach, reference


def box(centre: Points, half: tuple[float, float]) -> tuple[Points, Directions, Directions]:
    """Around a rectangle with sharp corners, the jet straight down."""
    flat = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * half
    approach, reference = tilted(np.zeros(5), 0.0)
    return np.column_stack((centre[:2] + flat, np.full(5, 40.0))), approach, reference


def synthetic_plan(parts: int) -> Plan:
    """Rings around parts in a grid, boxes around others, lines with a pause, and the transfers between."""
    rng = np.random.default_rng(7)
    items: list[PlanItem] = []
    here: tuple[Points, Directions, Directions] | None = None
    for number in range(parts):
        centre = np.array([number % 40 * 12.0, number // 40 * 12.0, 0.0])
        half = (float(rng.integers(2, 12)) / 2, float(rng.integers(2, 12)) / 2)
        shape = ring(centre, half, 2) if number % 3 == 0 else box(centre, half)
        path = shape if number % 3 < 2 else (shape[0][:2], shape[1][:2], shape[2][:2])
        if here is not None:
            items += between(here, path, number)
        items.append(SprayPass(path[0], path[1], path[2], np.full(len(path[0]) - 1, 40.0), JET, Source(number, "part")))
        items.append(Dwell(0.2, JET, Source(number, "part")))
        here = path
    return Plan(Origin("synthetic", "0", "synthetic", "0"), (Command("FUNCTION", ("clean",), Source(0)), *items), ())


def between(here: tuple[Points, ...], there: tuple[Points, ...], number: int) -> list[Transfer]:
    """Up, across while turning, and down."""
    a, b = here[0][-1], there[0][0]
    tcp = np.array([a, (a[0], a[1], UP), (b[0], b[1], UP), b])
    approach, reference = (np.array([here[k][-1], here[k][-1], there[k][0], there[k][0]]) for k in (1, 2))
    return [Transfer(tcp, approach, reference, 250.0, Source(number, "part", motion="transfer"))]


def main() -> None:
    limits = Limits()
    plan = synthetic_plan(1500)
    time_plan(synthetic_plan(4), limits)  # imports toppra
    begin = time.process_time()
    program = time_plan(plan, limits)
    ours = time.process_time() - begin
    profile = parametrise(round_corners(chain_of(plan), limits), limits)
    moving = profile.pick(np.flatnonzero(np.isfinite(profile.stages.grip)))
    begin = time.process_time()
    for span in spans_of(moving.stages):
        solve_runs(moving.stages, [span], np.radians(limits.rotation_acceleration_deg_s2))
    theirs = time.process_time() - begin
    runs = int(profile.stages.run[-1]) + 1
    moves = sum(isinstance(instruction, MoveTo) for instruction in program.instructions)
    print(f"{runs} runs, {len(profile.begin)} stages, {moves} moves, {program.totals.duration_s:.1f} s of program")
    print("processor time")
    print(f"time_plan          {ours:6.2f} s   (motion {profile.durations().sum():.2f} s)")
    print(f"toppra run by run  {theirs:6.2f} s")
    print(f"ratio              {ours / theirs:6.2f}")


if __name__ == "__main__":
    main()
