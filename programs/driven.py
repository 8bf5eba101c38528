"""A program as a controller drives it: the same paths and commands at other times."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import dist
from operator import attrgetter
from typing import Literal

import numpy as np

from geometry.arrays import Scalars
from programs.playback import playback
from programs.program import Instruction, MoveTo, SetNozzle, TimedProgram, Totals, Wait
from programs.soundness import TICK_S
from programs.summary import by_function
from specs.source import NO_SOURCE

_DIGITS = 7
"""Decimals of a second to which times are the same."""


def drive_program(
    program: TimedProgram, clock: Sequence[tuple[float, float]], jets: Sequence[tuple[float, bool]]
) -> TimedProgram:
    """Give a program at other times.

    Args:
        program: As planned, or as a robot carries it out.
        clock: Its times, and when they come; neither decreases. Where one time comes at several the pose is held.
        jets: When jets begin and end, in the new times.
    """
    planned, driven = np.array(clock).T
    moved = list(_at_other_times(program, np.round(planned, _DIGITS), driven))
    switches = [item for item in program.instructions if isinstance(item, SetNozzle)]
    begins = [item for item in switches if item.spraying]
    made_by = begins[0].made_by if begins else NO_SOURCE
    for seconds, on in jets:
        if on and begins:  # one of the program may be missing, where the valve cannot shut between two
            planned_s = float(np.interp(seconds, driven, planned))
            made_by = min(begins, key=lambda item: abs(item.time_s - planned_s)).made_by
        moved.append(SetNozzle(seconds, on, made_by))
    moved.sort(key=attrgetter("time_s"))  # what is switched comes after all else that happens then
    return with_totals(program, moved)


def with_totals(program: TimedProgram, instructions: Sequence[Instruction]) -> TimedProgram:
    """Give a program with other instructions, in order: with the speeds and totals that follow from them.

    Liquids are as many times more as the jet of their function is on for longer.
    """
    done: list[Instruction] = []
    before: MoveTo | None = None
    way_mm = 0.0
    for item in instructions:
        each = item
        if isinstance(item, MoveTo):
            way = dist(before.position, item.position) if before is not None else 0.0
            lasts_s = item.time_s - before.time_s if before is not None else 0.0
            each = replace(item, speed_mm_s=way / lasts_s if lasts_s > TICK_S else 0.0)
            before, way_mm = each, way_mm + way
        done.append(each)
    driven = replace(program, instructions=tuple(done))
    sprayed, planned = (_sprayed(each) for each in (driven, program))
    liquids = tuple(
        (name, litres * sprayed[name] / planned[name] if planned[name] > 0.0 else litres)
        for name, litres in program.totals.liquid_l
    )
    moves = sum(isinstance(item, MoveTo) for item in done)
    return replace(driven, totals=Totals(done[-1].time_s, sum(sprayed.values()), way_mm, moves, liquids))


def _sprayed(program: TimedProgram) -> dict[str, float]:
    """Seconds with the jet on, by function."""
    seconds = defaultdict[str, float](float)
    for each in by_function(program):
        seconds[each.function] += each.spray_s
    return seconds


def _at_other_times(program: TimedProgram, planned: Scalars, driven: Scalars) -> Iterator[Instruction]:
    """Give moves and commands at their new times, with a pose at each time of the clock where they move meanwhile."""
    waits = [round(item.time_s, _DIGITS) for item in program.instructions if isinstance(item, Wait)]
    inner = np.unique([*planned.tolist(), *waits])
    states = playback(program, inner)
    poses = list(zip(inner.tolist(), states.tcp.tolist(), states.quaternion.tolist(), strict=True))
    rows = {seconds: number for number, (seconds, _, _) in enumerate(poses)}
    begin, end = partial(when, planned, driven, "left"), partial(when, planned, driven, "right")
    done = 0
    now, free_s = 0.0, 0.0
    last: MoveTo | None = None
    for item in program.instructions:
        time_s = round(item.time_s, _DIGITS)
        while done < len(poses) and poses[done][0] < time_s:
            knot, (x, y, z), (a, b, c, d) = poses[done]
            done += 1
            if last is None or knot < free_s:
                continue
            if knot > now:
                last = MoveTo(begin(knot), (x, y, z), (a, b, c, d), 0.0, item.made_by)
                yield last
            if end(knot) - begin(knot) > TICK_S:  # the robot stands
                last = replace(last, time_s=end(knot))
                yield last
        now = time_s
        if isinstance(item, SetNozzle):
            continue
        if isinstance(item, MoveTo):
            last = replace(item, time_s=begin(time_s))
            yield last
        elif isinstance(item, Wait) and last is not None:  # a jet may begin or end meanwhile: a pose that is held
            free_s = round(item.time_s + item.duration_s, _DIGITS)
            _, (x, y, z), (a, b, c, d) = poses[rows[time_s]]
            held = MoveTo(begin(time_s), (x, y, z), (a, b, c, d), 0.0, item.made_by)
            last = replace(held, time_s=begin(free_s))
            yield from (held, last)
        else:
            yield replace(item, time_s=begin(time_s))


def when(planned: Scalars, driven: Scalars, side: Literal["left", "right"], seconds: float) -> float:
    """Give when a time of a clock comes: first (``left``), or last where it comes several times (``right``)."""
    at = int(np.searchsorted(planned, seconds, side=side))
    same = at if side == "left" else at - 1
    if 0 <= same < len(planned) and planned[same] == seconds:
        return float(driven[same])
    if not 0 < at < len(planned):
        end = 0 if at == 0 else -1
        return max(float(driven[end] + seconds - planned[end]), 0.0)
    share = (seconds - planned[at - 1]) / (planned[at] - planned[at - 1])
    return float(driven[at - 1] + share * (driven[at] - driven[at - 1]))
