"""Configurations per second against EAIK called bare, and what EAIK and ssik lose at singular poses.

Run: ``OMP_NUM_THREADS=1 python benchmarks/cell_ik.py [--poses 10000] [--rounds 5] [--counted 200]``

EAIK gets its list of poses ready made and its joints are not even read. Processor time, one thread each; the best of
the rounds counts, theirs and ours taken in turns. Then how many different, true configurations
each finds of poses that come of random joints, some of them at zero, and of how many poses it finds none.
"""

import argparse
import sys
import time
from collections.abc import Callable

import numpy as np
import ssik
from eaik.IK_Homogeneous import HomogeneousRobot

from robotcell.cell.robot_library import load_robot
from robotcell.kinematics.chain import chain_of
from robotcell.kinematics.inverse import solve
from robotcell.robot.robot import Poses, Robot, flange_poses

ARMS = ("ur5", "ur5e", "kr6-r900", "cairo")
SINGULAR = {"any": {}, "joint 5 at 0": {4: 0.0}, "joint 3 at 0": {2: 0.0}, "joints 3 and 5 at 0": {2: 0.0, 4: 0.0}}


def bare_eaik(robot: Robot) -> HomogeneousRobot:
    frames = chain_of(robot).steps.copy()
    for index in range(1, len(frames)):
        frames[index] = frames[index - 1] @ frames[index]
    return HomogeneousRobot(frames)


def seconds(work: Callable[[], object]) -> float:
    begin = time.process_time()
    work()
    return time.process_time() - begin


def random_poses(robot: Robot, count: int, fixed: dict[int, float]) -> Poses:
    q = np.random.default_rng(1).uniform(-np.pi, np.pi, (count, 6))
    for joint, value in fixed.items():
        q[:, joint] = value
    return flange_poses(robot, q)


def true_ones(robot: Robot, pose: Poses, rows: list[np.ndarray]) -> int:
    """How many different rows bring the flange to a pose."""
    kept: list[np.ndarray] = []
    for row in rows:
        if np.abs(flange_poses(robot, row[None])[0] - pose).max() < 1e-6 and not any(
            np.abs((row - other + np.pi) % (2 * np.pi) - np.pi).max() < 1e-5 for other in kept
        ):
            kept.append(row)
    return len(kept)


def compare_speed(name: str, robot: Robot, count: int, rounds: int) -> None:
    poses = random_poses(robot, count, {})
    listed, bare = list(poses), bare_eaik(robot)
    solve(robot, poses[:1])
    theirs, mine = [], []
    for _ in range(rounds):
        theirs.append(seconds(lambda: bare.IK_batched(listed, 1)))
        mine.append(seconds(lambda: solve(robot, poses)))
    fast, ours = count / min(theirs), count / min(mine)
    print(f"| {name} | {fast:,.0f} | {ours:,.0f} | {ours / fast:.2f} |")


def compare_counts(name: str, robot: Robot, count: int) -> None:
    bare, sure = bare_eaik(robot), ssik.Manipulator.from_transforms(chain_of(robot).steps)
    for configuration, fixed in SINGULAR.items():
        poses = random_poses(robot, count, fixed)
        found = bare.IK_batched(list(poses), 1)
        eaik = [true_ones(robot, pose, list(one.Q)) for pose, one in zip(poses, found, strict=True)]
        other = [
            true_ones(robot, pose, [one.q for one in sure.solve(pose, respect_limits=False, enumerate_windings=False)])
            for pose in poses
        ]
        ours = solve(robot, poses).count
        shares = " | ".join(f"{np.mean(one):.2f} | {np.mean(np.equal(one, 0)):.0%}" for one in (eaik, other, ours))
        print(f"| {name} | {configuration} | {shares} |")


def main(words: list[str]) -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--counted", type=int, default=200)
    options = parser.parse_args(words)
    robots = {name: load_robot(name) for name in ARMS}
    print("| arm | EAIK bare, poses/s | Washboard, poses/s | ratio |\n| --- | --: | --: | --: |")
    for name, robot in robots.items():
        compare_speed(name, robot, options.poses, options.rounds)
    if not options.counted:
        return
    print("\n| arm | poses | EAIK mean | none | ssik mean | none | Washboard mean | none |")
    print("| --- | --- | --: | --: | --: | --: | --: | --: |")
    for name, robot in robots.items():
        compare_counts(name, robot, options.counted)


if __name__ == "__main__":
    main(sys.argv[1:])
