"""A program of joint motions alone: from home to a place, on to another, and back."""

from dataclasses import replace

import numpy as np
from installations import for_language, small_cell
from robot_steps import DOWN, program

from programs.motion.installation import Installation
from programs.motion.steps import Moment, MotionProgram, Reach, UseBoard, UseTool
from programs.pose import Pose
from programs.posts.writing.joint_moves import machine_of
from programs.timing.controller import Controller
from specs.source import NO_SOURCE

HOME = (0.0,) * 6
FAR, NEAR = (1.2, -0.4, 0.8, 0.0, 0.6, 2.0), (0.3, -0.4, -0.7, 0.1, 0.6, 1.0)
CONTROLLER = Controller("zone")


def cell_of(language: str = "abb") -> Installation:
    """Joints of 180 degrees/s and 720 degrees/s2, the last one twice as fast."""
    cell = for_language(small_cell(), language)
    joints = [replace(joint, speed=np.pi, acceleration=4 * np.pi) for joint in cell.joints]
    joints[5] = replace(joints[5], speed=2 * np.pi)
    return replace(cell, joints=tuple(joints), home=HOME)


def reach(start: tuple[float, ...], joints: tuple[float, ...], seconds: float) -> Reach:
    place = Pose((100.0 * joints[0], 0.0, 50.0), DOWN)
    return Reach(place, joints, NO_SOURCE, (Moment(seconds, place, joints),), start)


def begun() -> Reach:
    return Reach(Pose((0.0, 0.0, 50.0), DOWN), HOME, NO_SOURCE)


def journey(language: str) -> tuple[MotionProgram, Installation]:
    """From home to a place and on to another, with time planned as for half of the joints' speeds."""
    cell = cell_of(language)
    machine = machine_of(cell, CONTROLLER)
    way = [(HOME, FAR), (FAR, NEAR), (NEAR, HOME)]
    times = [machine.joint_time(np.degrees(np.subtract(end, start)), 0.5) for start, end in way]
    moves = [reach(start, end, seconds) for (start, end), seconds in zip(way, times, strict=True)]
    frames = (UseBoard("", cell.T_base_board, NO_SOURCE), UseTool(1, "ring60", NO_SOURCE), begun())
    return replace(program(*frames, *moves), duration_s=sum(times)), cell
