"""Times of candidates on a cell's robot, estimated by the recipe that was last planned for it.

A plan for a robot takes as long as two to five checks, and tuning plans many more candidates than it analyses. So each
candidate that is analysed is planned for the robot, and only these are accepted; what the others would take is
estimated: each template of each step takes as much longer than within the recipe's limits as it did last.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

SprayTimes: TypeAlias = Mapping[tuple[str, str], float]
"""Seconds by step and template."""
_LEAST_S = 1e-6


@dataclass(frozen=True, slots=True)
class ProgramTimes:
    """What a program takes."""

    seconds: float
    litres: float
    sprayed: SprayTimes


@dataclass(frozen=True, slots=True)
class RobotRatios:
    """Seconds that a robot takes for a second within the recipe's limits."""

    sprayed: SprayTimes
    """By step and template."""
    all_sprayed: float
    """Of all of them together, for templates that were not sprayed."""
    rest: float
    """With the jet off."""

    def estimate(self, free: ProgramTimes) -> ProgramTimes:
        """Estimate what the robot takes for a program of which the times within the recipe's limits are known."""
        sprayed = {key: self.sprayed.get(key, self.all_sprayed) * seconds for key, seconds in free.sprayed.items()}
        before, after = sum(free.sprayed.values()), sum(sprayed.values())
        seconds = after + self.rest * (free.seconds - before)
        litres = free.litres * after / max(before, _LEAST_S)
        return ProgramTimes(round(seconds, 3), round(litres, 6), sprayed)


def robot_ratios(free: ProgramTimes, robot: ProgramTimes) -> RobotRatios:
    """Compare what one recipe takes within its limits and on a robot."""

    def ratio(longer: float, shorter: float) -> float:
        return longer / shorter if shorter > _LEAST_S else 1.0

    sprayed = {key: ratio(robot.sprayed.get(key, seconds), seconds) for key, seconds in free.sprayed.items()}
    totals = sum(free.sprayed.values()), sum(robot.sprayed.values())
    rest = ratio(robot.seconds - totals[1], free.seconds - totals[0])
    return RobotRatios(sprayed, ratio(totals[1], totals[0]), rest)
