"""How upright the jet is over the F-shaped part, and how clear of everything, by an independent count.

    python benchmarks/part_tilts.py

The part, its table and jaws are six boxes, to which distances are computed here, without the planner's trees and rays.
At each pose along the stripes every direction of a grid of its own (2.5 degrees by 10 degrees of azimuth) is tried:
what is the least tilt at which the lance has its clearance and the orifice sees its target? Then the lance is swept
along the timed program, no point of it moving by more than 1 mm from sample to sample.

As they stand, `gantry` and `ur5e-bench` do not reach all sides of that part. The arms are swept over the hood instead,
in two cells whose board is 50 mm nearer: rows of joints are spaced by the way of the tool and the turn of the joints,
and each row is checked for collisions alone.
"""

import numpy as np
from numpy.typing import NDArray

from boards.part.load import load_part
from programs.playback import build_timeline, play
from recipes.load import load_recipe
from robotcell.cell.load import cell_library, read_cell_text
from robotcell.collision.collision import build_collider, collides
from robotcell.robot.robot import flange_poses
from robotcell.track import terms_of, track
from rulesengine.planning.pipeline import Run, run

Array = NDArray[np.float64]
BOXES = np.array([
    [[0, 0, 0], [45, 50, 200]], [[45, 0, 80], [100, 50, 120]], [[45, 0, 155], [140, 50, 200]],
    [[-150, -150, -80], [250, 200, -60]], [[-7.5, -30, -60], [52.5, 0, 40]], [[-7.5, 50, -60], [52.5, 80, 40]],
], dtype=np.float64)  # fmt: skip
"""Three of the part, the table, two jaws."""
STANDOFF_MM, LENGTH_MM, RADIUS_MM, CLEARANCE_MM = 60.0, 130.0, 8.0, 2.0
STEP_DEG, AZIMUTHS, MOST_DEG, STEP_MM, STEP_RAD = 2.5, 36, 60.0, 1.0, 0.002
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def box_distances(points: Array) -> Array:
    """(n,) from the nearest box; 0 inside."""
    outside = np.maximum(np.maximum(BOXES[:, 0] - points[:, None], points[:, None] - BOXES[:, 1]), 0.0)
    return np.linalg.norm(outside, axis=2)


def lance_distances(orifices: Array, outward: Array) -> Array:
    """(n,) of the lance's axis from the nearest box: along a segment the distance from a box is convex."""
    low, high = np.zeros((len(orifices), len(BOXES))), np.full((len(orifices), len(BOXES)), LENGTH_MM)

    def at(along: Array) -> Array:
        places = orifices[:, None] + along[..., None] * outward[:, None]
        outside = np.maximum(np.maximum(BOXES[:, 0] - places, places - BOXES[:, 1]), 0.0)
        return np.linalg.norm(outside, axis=2)

    for _ in range(24):
        one, two = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
        left = at(one) <= at(two)
        low, high = np.where(left, low, one), np.where(left, two, high)
    return np.minimum(at((low + high) / 2), np.minimum(at(low * 0.0), at(low * 0.0 + LENGTH_MM))).min(axis=1)


def are_hidden(targets: Array, orifices: Array) -> NDArray[np.bool_]:
    """(n,) whether a box stands between, by slabs."""
    ways = orifices - targets
    ways = np.where(np.abs(ways) < 1e-12, 1e-12, ways)[:, None]
    one, two = (BOXES[:, 0] - targets[:, None]) / ways, (BOXES[:, 1] - targets[:, None]) / ways
    enter, leave = np.minimum(one, two).max(axis=2), np.maximum(one, two).min(axis=2)
    return ((np.minimum(leave, 1.0) - np.maximum(enter, 0.0)) > 1e-6).any(axis=1)


def are_free(targets: Array, outward: Array) -> NDArray[np.bool_]:
    orifices = targets + outward * STANDOFF_MM
    free = lance_distances(orifices, outward) >= RADIUS_MM + CLEARANCE_MM - 1e-3
    free[free] = ~are_hidden(targets[free] + outward[free] * 1e-3, orifices[free])
    return free


def least_tilts(targets: Array, normals: Array) -> Array:
    """(n,) degrees; infinite where nothing is free."""
    helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    x = np.cross(normals, helper)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(normals, x)
    least = np.full(len(targets), np.inf)
    for tilt in np.arange(0.0, MOST_DEG + 1e-9, STEP_DEG):
        left = np.flatnonzero(~np.isfinite(least))
        for turn in 2 * np.pi * np.arange(AZIMUTHS if tilt else 1) / AZIMUTHS:
            around = x[left] * np.cos(turn) + y[left] * np.sin(turn)
            outward = normals[left] * np.cos(np.radians(tilt)) + around * np.sin(np.radians(tilt))
            least[left[are_free(targets[left], outward)]] = tilt
    return least


def judge_tilts(run: Run) -> None:
    normals_of = {face.name: np.array(face.normal) for face in run.workpiece.faces}
    pieces = [piece for piece in run.coverings[0].pieces if len(piece.targets) > 1]
    targets = np.concatenate([piece.targets for piece in pieces])
    normals = np.concatenate([np.tile(normals_of[piece.face], (len(piece.targets), 1)) for piece in pieces])
    outward = -np.concatenate([piece.approach for piece in pieces])
    tilts = np.degrees(np.arccos(np.clip((outward * normals).sum(axis=1), -1, 1)))
    least = np.zeros(len(tilts))
    tilted = tilts > 1e-3
    least[tilted] = least_tilts(targets[tilted], normals[tilted])
    needless = tilted & (least == 0)
    needed = tilted & (least > 0)
    over = tilts[needed] - least[needed]
    print(f"{len(tilts)} poses along stripes, {int(tilted.sum())} of them tilted, at most {tilts.max():.1f} degrees")
    print(f"needlessly tilted: {needless.mean():.2%} of all (bar 1 %)")
    print(
        f"above the least where a tilt is needed: {over.mean():.2f} degrees in the mean, {over.max():.2f} at most; "
        f"{(over <= 5.0 + 1e-6).mean():.1%} within 5 degrees (bar all)"
    )


def sweep_lance(run: Run) -> None:
    timeline = build_timeline(run.program)
    count = 2000
    times = np.linspace(0.0, float(timeline.times[-1]), count)
    while True:  # until no end of the lance moves by more than the step
        states = play(timeline, times)
        far = states.tcp - states.approach * LENGTH_MM
        moves = np.maximum(*(np.linalg.norm(np.diff(each, axis=0), axis=1) for each in (states.tcp, far)))
        wide = np.flatnonzero(moves > STEP_MM)
        if not len(wide) or np.diff(times).min() < 1e-6:
            break
        times = np.sort(np.concatenate([times, (times[wide] + times[wide + 1]) / 2]))
    nearest = lance_distances(states.tcp, -states.approach)
    print(
        f"lance swept in {len(times)} samples at most {moves.max():.2f} mm apart: nearest {nearest.min():.2f} mm from "
        f"its axis, its radius is {RADIUS_MM:g} mm; {(nearest < RADIUS_MM).sum()} samples in collision (bar 0)"
    )


def sweep_arm(run: Run, name: str, x_mm: tuple[int, int]) -> None:
    file = cell_library()[name]
    before, after = (f"pose: {{xyz_mm: [{x}, -50," for x in x_mm)
    text = file.read_text("utf-8")
    assert before in text
    loaded = read_cell_text(text.replace(before, after, 1), file=file)
    report = track(run.program, loaded.cell, run.workpiece, terms=terms_of(loaded))
    if not report.possible:
        print(f"{name}: the robot does not reach all of it: {report.findings[0].message}")
        return
    collider, tool = build_collider(report.cell, run.workpiece), report.cell.tools[0]
    tcp = (flange_poses(report.cell.robot, report.joints) @ tool.T_flange_tcp)[:, :3, 3] * 1000
    hits, checked = 0, 0
    for row in range(len(report.joints) - 1):
        one, two = report.joints[row], report.joints[row + 1]
        way, turn = float(np.linalg.norm(tcp[row + 1] - tcp[row])), float(np.abs(two - one).max())
        steps = max(1, int(np.ceil(max(way / STEP_MM, turn / STEP_RAD))))
        share = np.arange(steps)[:, None] / steps
        found = collides(collider, one * (1 - share) + two * share, tool.number)
        hits, checked = hits + int(found.sum()), checked + steps
    print(f"{name}: hood, {checked} rows of joints along the motion, {hits} in collision (bar 0)")


def main() -> None:
    done = run(load_recipe("part-degrease"), load_part("f-bracket"))
    judge_tilts(done)
    sweep_lance(done)
    hood = run(load_recipe("part-slices"), load_part("hood"))
    sweep_arm(hood, "ur5e-bench", (400, 350))
    sweep_arm(hood, "kr6-bench", (470, 420))


if __name__ == "__main__":
    main()
