"""How many rows of joints a second are checked for collisions, against pinocchio called bare in a tight loop.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cell_collision.py [--robot ur5e] [--rows 4000] [BOARD]``

Both get the same: robot, tool, board, fixtures, pairs and margins, and they must agree on every row.
``random`` rows are anywhere between the limits of the joints; ``at work`` the nozzle hangs 30 to 80 mm above the board,
tilted up to 30 degrees, as in a program. Ways go from a row at work some way off, measured at the end of the arm.
"""

import argparse
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio
from numpy.typing import NDArray

from boards.board import Board
from boards.load import load_board
from robotcell.cell.cell import Cell, Tool
from robotcell.cell.robot_library import load_robot
from robotcell.collision.body_pairs import Scene
from robotcell.collision.clearance import clearance
from robotcell.collision.collision import Collider, build_collider, collides, collides_between, first_pairs
from robotcell.robot.robot import Body, Box, Capsule, Joints, Poses, Robot, flange_poses, jacobians

ROUNDS = 3
TOOL = 1


def at(x: float, y: float, z: float) -> Poses:
    pose = np.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def wash_cell(robot: Robot) -> Cell:
    """A table under the robot, a wall behind it, a post and a clamp near the board; a nozzle with holder and hose."""
    tool = Tool(
        number=TOOL,
        name="ring",
        T_flange_tcp=at(0, 0, 0.15),
        bodies=(
            Body("holder", Box((0.06, 0.06, 0.08)), at(0, 0, 0.04)),
            Body("nozzle", Capsule(0.008, 0.05), at(0, 0, 0.117)),
            Body("hose", Capsule(0.012, 0.15), at(0.05, 0, 0.05)),
        ),
    )
    fixtures = (
        Body("table", Box((1.6, 1.6, 0.05)), at(0.3, 0, -0.03)),
        Body("wall", Box((0.02, 1.6, 1.0)), at(-0.6, 0, 0.5)),
        Body("post", Capsule(0.03, 0.6), at(0.3, 0.6, 0.3)),
        Body("clamp", Box((0.02, 0.02, 0.02)), at(0.35, 0.08, 0.1)),
    )
    home = np.array([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]) if robot.dof == 6 else np.zeros(robot.dof)
    return Cell("bench", robot, np.eye(4), at(0.4, -0.05, 0.1), home, (tool,), fixtures, 0.01)


def rows_at_work(cell: Cell, board: Board, count: int) -> Joints:
    """Bring the nozzle over the board from home by damped least squares; rows that do not arrive are left out."""
    rng = np.random.default_rng(2)
    west, south, east, north = np.array(board.outline.bounds) / 1000
    place = np.column_stack(
        [rng.uniform(west, east, count), rng.uniform(south, north, count), rng.uniform(0.03, 0.08, count)]
    )
    place += cell.T_cell_board[:3, 3] + [0, 0, board.top_z_mm / 1000]
    tilt = rng.uniform(0, np.radians(30), count)
    around = rng.uniform(-np.pi, np.pi, count)
    aim = np.column_stack([np.sin(tilt) * np.cos(around), np.sin(tilt) * np.sin(around), -np.cos(tilt)])
    q, tcp = np.tile(cell.home, (count, 1)), cell.tools[0].T_flange_tcp
    for _ in range(60):
        now = flange_poses(cell.robot, q) @ tcp
        error = np.concatenate([place - now[:, :3, 3], np.cross(now[:, :3, 2], aim)], axis=1)
        matrix = jacobians(cell.robot, q, tcp)
        damped = matrix @ matrix.swapaxes(1, 2) + 1e-4 * np.eye(6)
        q = q + (matrix.swapaxes(1, 2) @ np.linalg.solve(damped, error[..., None]))[..., 0]
    now = flange_poses(cell.robot, q) @ tcp
    return q[(np.linalg.norm(now[:, :3, 3] - place, axis=1) < 1e-3) & ((now[:, :3, 2] * aim).sum(axis=1) > 0.999)]


def bare(scene: Scene) -> Callable[[Joints], NDArray[np.bool_]]:
    """Give pinocchio the scene; one call a row, which stops at the first pair."""
    model = pinocchio.Model()
    ids = [0]
    for joint in scene.robot.joints:
        kind = (
            pinocchio.JointModelRevoluteUnaligned
            if joint.kind == "revolute"
            else pinocchio.JointModelPrismaticUnaligned
        )
        placement = pinocchio.SE3(joint.T_parent_joint if len(ids) > 1 else scene.T_cell_base @ joint.T_parent_joint)
        ids.append(model.addJoint(ids[-1], kind(joint.axis), placement, joint.name))
    shapes = pinocchio.GeometryModel()
    for index, solid in enumerate(scene.solids):
        pose = solid.T_link_solid if solid.stands or solid.link else scene.T_cell_base @ solid.T_link_solid
        parent = ids[solid.link]
        shapes.addGeometryObject(pinocchio.GeometryObject(f"{index}", parent, 0, pinocchio.SE3(pose), solid.geometry))
    for one, other in zip(scene.first.tolist(), scene.second.tolist(), strict=True):
        shapes.addCollisionPair(pinocchio.CollisionPair(one, other))
    data, found = model.createData(), shapes.createData()
    for request, margin in zip(found.collisionRequests, scene.margins, strict=True):
        request.security_margin = float(margin)

    def check(q: Joints) -> NDArray[np.bool_]:
        return np.array([pinocchio.computeCollisions(model, data, shapes, found, row, True) for row in q])

    return check


def rate(count: int, work: Callable[[], object]) -> float:
    """Per second, the best of some rounds."""
    best = np.inf
    for _ in range(ROUNDS):
        begin = time.perf_counter()
        work()
        best = min(best, time.perf_counter() - begin)
    return count / best


def compare(name: str, collider: Collider, q: Joints) -> None:
    check = bare(collider.scenes[TOOL])
    ours, theirs = collides(collider, q, TOOL), check(q)
    fast, loop = rate(len(q), lambda: collides(collider, q, TOOL)), rate(len(q), lambda: check(q))
    print(
        f"{name:10s} {len(q):6d} rows, {ours.mean():4.0%} collide, {np.count_nonzero(ours != theirs)} differ: "
        f"{fast:8,.0f}/s, bare {loop:8,.0f}/s, ratio {fast / loop:.2f}"
    )


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("board", nargs="?", type=Path, default=Path("smt-demo"))
    parser.add_argument("--robot", default="ur5e")
    parser.add_argument("--rows", type=int, default=4000)
    arguments = parser.parse_args(words)
    board, robot = load_board(arguments.board), load_robot(arguments.robot)
    cell = wash_cell(robot)
    begin = time.perf_counter()
    collider = build_collider(cell, board)
    triangles = sum(len(body.patches) for body in board.bodies)
    pairs = len(collider.scenes[TOOL].first)
    took = time.perf_counter() - begin
    print(f"{robot.name}, {board.name}: {triangles:,} triangles, {pairs} pairs, built in {took:.2f} s")
    rng = np.random.default_rng(1)
    limits = np.array([[max(joint.lowest, -np.pi), min(joint.highest, np.pi)] for joint in robot.joints])
    compare("random", collider, rng.uniform(limits[:, 0], limits[:, 1], (arguments.rows, robot.dof)))
    q = rows_at_work(cell, board, arguments.rows)
    compare("at work", collider, q)
    free = q[~collides(collider, q, TOOL)]
    few = free[:500]
    print(f"first pairs, at work: {rate(len(q), lambda: first_pairs(collider, q, TOOL)):,.0f} rows/s")
    print(f"clearance, at work: {rate(len(few), lambda: clearance(collider, few, TOOL)):,.0f} rows/s")
    for step in (0.002, 0.01, 0.05):
        turn = rng.normal(size=few.shape)
        far = few + turn / np.abs(turn).sum(axis=1)[:, None] * step / 0.8
        found = collides_between(collider, few, far, TOOL)
        speed = rate(len(few), lambda far=far: collides_between(collider, few, far, TOOL))
        print(f"ways of about {step * 1000:.0f} mm: {speed:,.0f}/s, {found.mean():.0%} collide")


if __name__ == "__main__":
    main(sys.argv[1:])
