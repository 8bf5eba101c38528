"""Steps of robot programs that tests build by hand, and when their signals leave."""

import numpy as np

from programs.motion.installation import Channel
from programs.motion.samples import SampledLine
from programs.motion.steps import Event, Line, MotionProgram, Pause, Step, Switch
from programs.plan import Origin
from programs.pose import Pose

ORIGIN = Origin("tiny", "9f2c", "smt-aqueous", "77b0")
DOWN = (0.0, 1.0, 0.0, 0.0)


def pose(x: float, y: float = 0.0, z: float = 50.0) -> Pose:
    return Pose((x, y, z), DOWN)


def line(start: Pose, target: Pose, speed: float, *, blend_mm: float = 0.0, events: tuple[Event, ...] = ()) -> Line:
    """A line at an even speed."""
    length = float(np.linalg.norm(np.subtract(target.position, start.position)))
    shares = np.linspace(0.0, 1.0, 5)
    samples = SampledLine(shares * length / speed, shares, np.empty((5, 0)))
    return Line(start, target, speed, 0.0, blend_mm, samples, 0.0, "s/line", events)


def ramp(start: Pose, target: Pose, duration_s: float) -> Line:
    """A line that speeds up evenly to the middle and slows down evenly from there."""
    seconds = np.linspace(0.0, 1.0, 41)
    shares = np.where(seconds < 0.5, 2 * seconds**2, 1 - 2 * (1 - seconds) ** 2)
    length = float(np.linalg.norm(np.subtract(target.position, start.position)))
    samples = SampledLine(seconds * duration_s, shares, np.empty((41, 0)))
    return Line(start, target, 2 * length / duration_s, 0.0, 0.0, samples, 0.0, "s/ramp")


def turn(start: Pose, radians: float, duration_s: float) -> Line:
    """A turn about the board's z on the spot, at an even rate."""
    half = 0.5 * radians
    w, x, y, z = start.quaternion
    c, s = np.cos(half), np.sin(half)
    turned = (float(c * w - s * z), float(c * x - s * y), float(c * y + s * x), float(c * z + s * w))
    shares = np.linspace(0.0, 1.0, 5)
    samples = SampledLine(shares * duration_s, shares, np.empty((5, 0)))
    target = Pose(start.position, turned)
    return Line(start, target, 0.0, radians / duration_s, 0.0, samples, 0.0, "s/turn")


def program(*steps: Step) -> MotionProgram:
    """Steps as a program; each line begins when what is before it is over."""
    return MotionProgram(ORIGIN, sum(map(lasting, steps)), steps, ())


def lasting(step: Step) -> float:
    return step.duration_s if isinstance(step, Line | Pause) else 0.0


def signals(steps: tuple[Step, ...] | list[Step], channel: Channel) -> list[tuple[float, float]]:
    """When each signal of a channel leaves, as the offsets say it on the planned courses, and its value."""
    told: list[tuple[float, float]] = []
    now = 0.0
    for step in steps:
        if isinstance(step, Switch) and step.channel == channel:
            told.append((now, step.value))
        elif isinstance(step, Line):
            told += [(now + leaves(step, event), event.value) for event in step.events if event.channel == channel]
        now += lasting(step)
    return told


def leaves(line: Line, event: Event) -> float:
    """Seconds from the beginning of a line at which the offsets of an event have its signal leave."""
    if line.length_mm > 1e-6:
        share = event.offset_mm / line.length_mm + (1.0 if event.reference == "end" else 0.0)
        assert abs(share - event.share) * line.length_mm < 1e-3
    return line.samples.second_at(event.share) + event.offset_s
