"""How a program is entered at a later part, so that a board that was stopped is finished."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from programs.motion.installation import Channel, Installation
from programs.motion.steps import IsClear, Line, MotionProgram, Mount, Pause, Reach, Step, Switch, UseBoard, UseTool
from programs.pose import IDENTITY, Pose, rotate
from programs.posts.writing.chapters import Chapter, Part

_AS_HIGH_MM = 0.5
"""Heights that differ by less count as one: then the later place is chosen, from which less is left to drive."""

_LONGEST_WAY = 200
"""Lines that an entry drives at most, so that programs of many parts do not grow with the square of their number."""


_MOST_PLACES = 12
"""At which it is tried to enter, more or less."""
_PART_RAD = math.radians(3.0)
"""Turn of B or C within which the motion of axes from home is checked as if the joints went evenly with them."""


def safe_height(motion: MotionProgram, installation: Installation) -> int | None:
    """Find the greatest height of the orifice in a program's lines, whole mm above the base's origin, rounded down.

    The orifice is raised to it before anything else moves; ``None`` where the base leans, or nothing goes in a line.
    """
    place, last, highest = IDENTITY, None, -math.inf
    for step in motion.steps if installation.is_upright else ():
        if isinstance(step, UseBoard):
            place, last = step.T_base_board, None
        elif isinstance(step, Line):
            for pose in (step.target,) if step.start is last else (step.start, step.target):
                highest = max(highest, place.position[2] + rotate(place.quaternion, pose.position)[2])
            last = step.target
    return math.floor(highest) if math.isfinite(highest) else None


@dataclass(frozen=True, slots=True)
class Entry:
    """What a program does first if it starts at a later part."""

    steps: tuple[Step, ...]
    is_clear: bool | None = None
    """Whether the joint motion from home collides with nothing; ``None`` where there is none, or it was not checked."""


def find_entries(
    parts: Sequence[Part], installation: Installation, is_clear: IsClear | None = None
) -> dict[int, Entry]:
    """Find what has to be done at home before each part but the first, by the part's number.

    The outputs are set as the parts before it leave them. The robot comes by a joint motion to the highest place of the
    planned way since the last joint motion, or of the last lines of it, and drives the rest with all valves shut. Where
    the joint motion there from home collides another place of them is taken. A part that begins with a joint motion
    whose beginning does not matter needs no way.

    Args:
        parts: Of the program, in the controller's terms.
        installation: The cell.
        is_clear: Check of joint motions from home; ``None`` where there is none.
    """
    lags = {valve.channel: valve.open_lag_s for valve in installation.valves.values()}
    state, found = _State(lags, installation, is_clear), dict[int, Entry]()
    chapters = [part for part in parts if isinstance(part, Chapter)]
    for at, chapter in enumerate(chapters):
        if chapter.number > 1:
            moves = (step for each in chapters[at:] for step in each.steps if isinstance(step, Line | Reach))
            found[chapter.number] = state.entry(chapter, next(moves, None))
        for step in chapter.steps:
            state.keep(step)
    return found


@dataclass(slots=True)
class _State:
    """Outputs and the way so far, while the steps are walked in their order."""

    valves: dict[Channel, float]
    """Lag to open by the channel."""
    installation: Installation
    is_clear: IsClear | None
    tool: int = 0
    placement: str = ""
    outputs: dict[Channel, float] = field(default_factory=dict[Channel, float])
    mount: Mount | None = None
    """Of the tool that is mounted, where a program changes tools."""
    reach: Reach | None = None
    way: list[Line] = field(default_factory=list[Line])
    """Lines since the last joint motion."""

    def keep(self, step: Step) -> None:
        """Go past a step."""
        if isinstance(step, Switch):
            self.outputs[step.channel] = step.value
        elif isinstance(step, UseTool):
            self.tool = step.number
        elif isinstance(step, Mount):
            self.mount = step
        elif isinstance(step, UseBoard):
            self.placement = step.placement
        elif isinstance(step, Reach):
            self.reach, self.way = step, []
        elif isinstance(step, Line):
            self.outputs |= {event.channel: event.value for event in step.events}
            self.way.append(step)

    def entry(self, chapter: Chapter, first: Line | Reach | None) -> Entry:
        """Give the steps that lead from home to a chapter, of which the first motion, or that after it, is given."""
        maker = chapter.steps[0].made_by
        settings = [
            Switch(channel, value, maker) for channel, value in self.outputs.items() if channel not in self.valves
        ]
        opened = [channel for channel, value in self.outputs.items() if channel in self.valves and value]
        jets = [Switch(channel, self.outputs[channel], maker) for channel in opened]
        lags = [Pause(lag, maker) for lag in [max((self.valves[each] for each in opened), default=0.0)] if lag]
        way, is_clear = self.approach(first)
        acts = (step for step in chapter.steps if isinstance(step, Mount | Line | Reach))
        mounts = [self.mount] if self.mount and (way or not isinstance(next(acts, None), Mount)) else []
        return Entry((*mounts, *settings, *way, *jets, *lags), is_clear)

    def approach(self, first: Line | Reach | None) -> tuple[list[Step], bool | None]:
        """Give the way to a motion; none where that may begin anywhere, or nothing moves any more."""
        if self.reach is None or first is None or (isinstance(first, Reach) and not (first.way or first.start)):
            return [], None
        passed = max(len(self.way) - _LONGEST_WAY, 0)
        lines = self.way[max(passed - 1, 0) :]
        ends = [Reach(line.target, line.joints, line.made_by) for line in lines]
        ends = ends if passed else [self.reach, *ends]
        places = _by_height(ends)
        begin, clear = places[0], None
        if self.is_clear is not None and self.installation.home and self.reach.joints:
            clear_at = next((at for at in places if self.is_free(ends[at])), None)
            begin, clear = (begin, False) if clear_at is None else (clear_at, True)
        way = [replace(line, events=()) for line in self.way[passed + begin :]]
        return [replace(ends[begin], way=(), start=()), *way], clear

    def is_free(self, reach: Reach) -> bool:
        """Whether the joint motion from home to a place collides with nothing."""
        assert self.is_clear is not None
        home, machine = self.installation.home, self.installation.tool_point
        rows: tuple[tuple[float, ...], ...] = (home, reach.joints)
        if machine is not None:  # axes go straight, the joints of the carriage do not
            begin = machine.axes(np.array([home]))
            way = np.array([reach.joints]) - begin
            parts = math.ceil(float(np.abs(way[0, 3:]).max()) / _PART_RAD)
            joints = machine.joints(begin + np.linspace(0.0, 1.0, max(parts, 1) + 1)[:, None] * way)
            rows = tuple(tuple(row) for row in joints.tolist())
        return self.is_clear(rows, self.tool, self.placement)


def _by_height(ends: Sequence[Reach]) -> list[int]:
    """Give places to enter at: the highest first, the later ones of those that are as high first."""
    heights = [_height(reach.target) for reach in ends]
    highest = max(heights)
    first = max(at for at in range(len(ends)) if heights[at] >= highest - _AS_HIGH_MM)
    others = sorted((at for at in range(len(ends)) if at != first), key=lambda at: (-heights[at], -at))
    return [first, *others[:: max(len(others) // _MOST_PLACES, 1)]]


def _height(pose: Pose) -> float:
    """Height above the side of the board that the jet points at, in mm of the board's z."""
    down = rotate(pose.quaternion, (0.0, 0.0, 1.0))[2] <= 0.0
    return pose.position[2] if down else -pose.position[2]
