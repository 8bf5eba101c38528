"""Plans that tests build by hand or at random."""

from collections.abc import Sequence

import numpy as np

from geometry.arrays import Directions, Points
from programs.plan import Dwell, Jet, Origin, Plan, PlanItem, SprayPass, Transfer
from recipes.recipe import Limits
from specs.source import Source

JET = Jet("clean", "ring60", "saponifier-15", 2.0, True)
ORIGIN = Origin("tiny", "9f2c", "smt-aqueous", "77b0")
LIMITS = Limits(
    acceleration_mm_s2=500, rotation_deg_s=180, rotation_acceleration_deg_s2=720, transfer_speed_mm_s=250, blend_mm=0.5
)
Axes = tuple[Directions, Directions]


def plan_of(*items: PlanItem) -> Plan:
    return Plan(ORIGIN, items, ())


def down(count: int) -> Axes:
    """Approach straight down, reference along +x."""
    return np.tile([0.0, 0.0, -1.0], (count, 1)), np.tile([1.0, 0.0, 0.0], (count, 1))


def leaning(headings: Sequence[float], tilt: float) -> Axes:
    """Approach ``tilt`` off the vertical towards each heading, radians; the reference turns with it."""
    yaw = np.array(headings, dtype=np.float64)
    level = np.stack((np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)), axis=1)
    up = np.array([0.0, 0.0, 1.0])
    return np.sin(tilt) * level - np.cos(tilt) * up, np.cos(tilt) * level + np.sin(tilt) * up


PASS, TRANSFER = Source.parse("s/pass"), Source.parse("s/transfer")


def spray(
    points: Sequence[Sequence[float]] | Points,
    speed: float | Sequence[float] = 60.0,
    axes: Axes | None = None,
    made_by: Source = PASS,
) -> SprayPass:
    tcp = np.array(points, dtype=np.float64)
    approach, reference = down(len(tcp)) if axes is None else axes
    speeds = np.broadcast_to(np.asarray(speed, dtype=np.float64), len(tcp) - 1)
    return SprayPass(tcp, approach, reference, speeds, JET, made_by)


def transfer(points: Sequence[Sequence[float]] | Points, speed: float = 250.0, axes: Axes | None = None) -> Transfer:
    tcp = np.array(points, dtype=np.float64)
    approach, reference = down(len(tcp)) if axes is None else axes
    return Transfer(tcp, approach, reference, speed, TRANSFER)


def pause(duration_s: float, made_by: Source = PASS) -> Dwell:
    return Dwell(duration_s, JET, made_by)


def random_plan(seed: int, count: int) -> Plan:
    """Passes, transfers and pauses of all kinds that meet: rough and fine, curved and straight, turning and not."""
    rng = np.random.default_rng(seed)
    items: list[PlanItem] = []
    here, yaw, tilt = np.array([50.0, 50.0, 50.0]), 0.0, 0.0
    for number in range(count):
        steps = _random_steps(rng)
        tcp = here + np.vstack((np.zeros(3), np.cumsum(steps, axis=0)))
        headings = yaw + np.concatenate(([0.0], np.cumsum(rng.normal(0.0, rng.choice([0.0, 0.2, 1.5]), len(steps)))))
        parts = [
            leaning([heading], lean) for heading, lean in zip(headings, rng.uniform(0.0, 0.5, len(tcp)), strict=True)
        ]
        parts[0] = leaning([yaw], tilt)
        approach, reference = np.vstack([part[0] for part in parts]), np.vstack([part[1] for part in parts])
        speed = float(rng.uniform(5.0, 200.0))
        if rng.random() < 0.6:
            items.append(spray(tcp, speed, (approach, reference), Source.parse(f"s/pass/{number}")))
        else:
            items.append(transfer(tcp, speed, (approach, reference)))
        if rng.random() < 0.3:
            items.append(pause(float(rng.uniform(0.0, 1.0)), Source.parse(f"s/pass/{number}")))
        here, yaw = tcp[-1], float(headings[-1])
        tilt = float(np.arccos(np.clip(-approach[-1, 2], -1.0, 1.0)))
    return plan_of(*items)


def _random_steps(rng: np.random.Generator) -> Points:
    count = int(rng.integers(2, 12))
    match int(rng.integers(0, 4)):
        case 0:
            return rng.normal(0.0, 10.0, (count, 3))
        case 1:
            return rng.choice([0.0, 1.0, -1.0], (count, 3)) * rng.uniform(0.05, 20.0, (count, 1))
        case 2:
            angle = np.linspace(0.0, rng.uniform(1.0, 7.0), 30)
            ring = rng.uniform(0.5, 20.0) * np.stack((np.cos(angle), np.sin(angle), 0.0 * angle), axis=1)
            return np.diff(ring, axis=0)
        case _:
            return rng.normal(0.0, 0.02, (count, 3))


def moved(plan: Plan, yaw: float, shift: Sequence[float]) -> Plan:
    """The same plan with the board turned about z and put elsewhere."""
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0.0], [np.sin(yaw), np.cos(yaw), 0.0], [0.0, 0.0, 1.0]])

    def carried(item: PlanItem) -> PlanItem:
        match item:
            case SprayPass():
                tcp, approach, reference = item.tcp @ turn.T + shift, item.approach @ turn.T, item.reference @ turn.T
                return SprayPass(tcp, approach, reference, item.speeds_mm_s, item.jet, item.made_by)
            case Transfer():
                tcp, approach, reference = item.tcp @ turn.T + shift, item.approach @ turn.T, item.reference @ turn.T
                return Transfer(tcp, approach, reference, item.speed_mm_s, item.made_by)
            case _:
                return item

    return Plan(plan.origin, tuple(carried(item) for item in plan.items), ())
