"""How a program is entered at a later part, so that a board that was stopped is finished."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from programs.motion.installation import Channel, Installation
from programs.motion.steps import Line, MotionProgram, Pause, Reach, Step, Switch, UseBoard
from programs.pose import IDENTITY, Pose, compose, rotate
from programs.posts.writing.chapters import Chapter, Part

_AS_HIGH_MM = 0.5
"""Heights that differ by less count as one: then the later place is chosen, from which less is left to drive."""

_LONGEST_WAY = 200
"""Lines that an entry drives at most, so that programs of many parts do not grow with the square of their number."""


def safe_height(motion: MotionProgram, installation: Installation) -> int | None:
    """Find the greatest height of the orifice in a program's lines, whole mm above the base's origin, rounded down.

    The orifice is raised to it before anything else moves; ``None`` where the base leans, or nothing goes in a line.
    """
    place, heights = IDENTITY, list[float]()
    for step in motion.steps if installation.is_upright else ():
        if isinstance(step, UseBoard):
            place = step.T_base_board
        elif isinstance(step, Line):
            heights += [compose(place, pose).position[2] for pose in (step.start, step.target)]
    return math.floor(max(heights)) if heights else None


def find_entries(parts: Sequence[Part], installation: Installation) -> dict[int, tuple[Step, ...]]:
    """Find what has to be done at home before each part but the first, by the part's number.

    The outputs are set as the parts before it leave them. The robot comes by a joint motion to the highest place of the
    planned way since the last joint motion, or of the last lines of it, and drives the rest with all valves shut. One
    that begins with a joint motion which is not planned needs no way; one that is planned has to begin where it does.
    """
    state, found = _State({valve.channel: valve.open_lag_s for valve in installation.valves.values()}), {}
    chapters = [part for part in parts if isinstance(part, Chapter)]
    for at, chapter in enumerate(chapters):
        if chapter.number > 1:
            moves = (step for each in chapters[at:] for step in each.steps if isinstance(step, Line | Reach))
            found[chapter.number] = tuple(state.entry(chapter, next(moves, None)))
        for step in chapter.steps:
            state.keep(step)
    return found


@dataclass(slots=True)
class _State:
    """Outputs and the way so far, while the steps are walked in their order."""

    valves: dict[Channel, float]
    """Lag to open by the channel."""
    outputs: dict[Channel, float] = field(default_factory=dict[Channel, float])
    reach: Reach | None = None
    way: list[Line] = field(default_factory=list[Line])
    """Lines since the last joint motion."""

    def keep(self, step: Step) -> None:
        """Go past a step."""
        if isinstance(step, Switch):
            self.outputs[step.channel] = step.value
        elif isinstance(step, Reach):
            self.reach, self.way = step, []
        elif isinstance(step, Line):
            self.outputs |= {event.channel: event.value for event in step.events}
            self.way.append(step)

    def entry(self, chapter: Chapter, first: Line | Reach | None) -> list[Step]:
        """Give the steps that lead from home to a chapter, of which the first motion, or that after it, is given."""
        maker = chapter.steps[0].made_by
        settings = [
            Switch(channel, value, maker) for channel, value in self.outputs.items() if channel not in self.valves
        ]
        opened = [channel for channel, value in self.outputs.items() if channel in self.valves and value]
        jets = [Switch(channel, self.outputs[channel], maker) for channel in opened]
        lags = [Pause(lag, maker) for lag in [max((self.valves[each] for each in opened), default=0.0)] if lag]
        return [*settings, *self.approach(first), *jets, *lags]

    def approach(self, first: Line | Reach | None) -> list[Step]:
        """Give the way to a motion; none where that may begin anywhere, or nothing moves any more."""
        if self.reach is None or first is None or (isinstance(first, Reach) and not first.way):
            return []
        ends = [self.reach, *(Reach(line.target, line.joints, line.made_by) for line in self.way)]
        heights = [_height(reach.target) for reach in ends]
        nearest = max(len(ends) - 1 - _LONGEST_WAY, 0)
        highest = max(heights[nearest:])
        begin = max(at for at in range(nearest, len(ends)) if heights[at] >= highest - _AS_HIGH_MM)
        return [replace(ends[begin], way=(), start=()), *(replace(line, events=()) for line in self.way[begin:])]


def _height(pose: Pose) -> float:
    """Height above the side of the board that the jet points at, in mm of the board's z."""
    down = rotate(pose.quaternion, (0.0, 0.0, 1.0))[2] <= 0.0
    return pose.position[2] if down else -pose.position[2]
