"""Commanded speeds at which a controller, by its model, takes the planned time on each line."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt

from programs.timing.drive import Drive, drive
from programs.timing.ways import Machine, Way, commanded

_ROUNDS = 12
"""Lines share the speeds at which they meet: each round solves every line between those of the round before."""
_CLOSE = 2e-3
"""Share of the planned time within which a line is left as it is."""
_MOST_BIAS = 0.02
"""Share of its time by which a line may make up for others of its stroke that cannot take theirs."""
_REACHED = 0.999
"""Share of its commanded speed below which a line does not reach it."""
_SHORTEST_SHARE = 0.5
"""Of its time, to which a line is shortened in one round at most."""
_LEAST_FACTOR, MOST_FACTOR = 0.02, 2.0
"""Of the speed that the plan reaches on a line: slower or faster than so many times none is commanded."""


@dataclass(frozen=True, slots=True)
class PlannedLine:
    """A line of the plan: some ways one after the other, as the text divides it, that have one commanded speed."""

    first: int
    after: int
    """Number of its first way, and of the one after its last."""
    pieces: tuple[tuple[int, float, float], ...]
    """What counts of it: number of a way, and the shares of that between which it does."""
    due_s: float
    """Planned time of those."""
    stroke: int
    """Lines of one stroke have one number."""
    most: float = MOST_FACTOR
    """Greatest factor of the speed."""


def fit_factors(machine: Machine, ways: Sequence[Way], lines: Sequence[PlannedLine]) -> list[float]:
    """Find the factors of the commanded speeds with which each line takes its planned time.

    Between the speeds at its ends a line that goes at p in its middle takes a time that falls as p rises, so that one p
    takes the planned time; it is the smaller root of a quadratic equation.

    Args:
        machine: The controller's model, and the limits of the joints.
        ways: As they follow each other from rest to rest, at the speeds that are commanded so far.
        lines: Of the plan, in order; together they are all ways.

    Returns:
        For each line; 1 where it keeps its speed. A line that cannot take its time takes the nearest.
    """
    factors, bias = [1.0] * len(lines), defaultdict[int, float](float)
    whole = defaultdict[int, float](float)
    for line in lines:
        whole[line.stroke] += line.due_s
    limits = machine.limits(ways)
    stated = [commanded(way, limit.ramp)[0] for way, limit in zip(ways, limits, strict=True)]
    line_of = [at for at, line in enumerate(lines) for _ in range(line.first, line.after)]
    for _ in range(_ROUNDS):
        speeds = [factors[at] * speed for at, speed in zip(line_of, stated, strict=True)]
        driven = drive(machine.lanes_at(ways, limits, speeds), machine.controller.look_ahead)
        missing = defaultdict[int, float](float)
        is_settled = True
        for at, line in enumerate(lines):
            parts = driven[line.first : line.after]
            takes_s = sum(time_between(driven[way], begin, end) for way, begin, end in line.pieces)
            due_s = line.due_s * (1.0 + bias[line.stroke])
            missing[line.stroke] += line.due_s - takes_s
            if due_s <= 0.0 or abs(takes_s - due_s) <= _CLOSE * due_s:
                continue
            better = _next_factor(parts, factors[at], due_s - takes_s, ways[line.first : line.after])
            new = min(max(better, _LEAST_FACTOR), line.most)
            is_settled &= abs(new - factors[at]) <= _CLOSE * factors[at]
            factors[at] = new
        if is_settled:
            off = {stroke: lacks_s / max(whole[stroke], 1e-9) for stroke, lacks_s in missing.items()}
            if all(bias[stroke] or abs(share) <= _CLOSE for stroke, share in off.items()):
                break
            bias |= {
                stroke: min(max(share, -_MOST_BIAS), _MOST_BIAS) for stroke, share in off.items() if not bias[stroke]
            }
    return factors


def _next_factor(parts: Sequence[Drive], factor: float, lacks_s: float, ways: Sequence[Way]) -> float:
    """Give the factor with which a line would take so much longer, between the speeds that it has at its ends now."""
    way, fastest = max(zip(ways, parts, strict=True), key=lambda each: each[1].peak)
    top, commanded = fastest.peak, factor * way.speed
    if way.whole_s is not None or not 0.0 < commanded < inf or (lacks_s < 0.0 and top < _REACHED * commanded):
        return factor  # its speed is not what its time depends on
    takes_s, length = sum(each.moving_s for each in parts), sum(each.lane.length for each in parts)
    begin, end = parts[0].begin, parts[-1].end
    ramp = min((each.lane.ramp for each in parts), key=lambda each: each.acceleration)
    changes = 0.5 * (2.0 * top**2 - begin**2 - end**2) / ramp.acceleration
    whole_s = (2.0 * top - begin - end) / ramp.acceleration + max(length - changes, 0.0) / top
    linear = ramp.acceleration * (whole_s + lacks_s) + begin + end
    constant = ramp.acceleration * length + 0.5 * (begin**2 + end**2)
    under_root = linear**2 - 4.0 * constant
    shortest = sqrt(constant)  # the peak of two ramps without a plateau
    speed = 2.0 * constant / (linear + sqrt(under_root)) if under_root >= 0.0 and linear > 0.0 else shortest
    if speed < max(begin, end):  # both ends change with it
        speed = top * takes_s / max(takes_s + lacks_s, _SHORTEST_SHARE * takes_s)
    return speed / way.speed


def time_between(drive: Drive, begin: float, end: float) -> float:
    """Seconds from one share of a line to another as it is driven, the pause at its end included."""
    return drive.second_at(end) - drive.second_at(begin) + (drive.lane.rest_s if end >= 1.0 else 0.0)
