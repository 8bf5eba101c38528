"""How a program is entered at a later part, so that a board that was stopped is finished."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from programs.motion.installation import Channel, Installation
from programs.motion.steps import Line, Pause, Reach, Step, Switch
from programs.pose import Pose, rotate
from programs.posts.writing.chapters import Chapter, Part

_AS_HIGH_MM = 0.5
"""Heights that differ by less count as one: then the later place is chosen, from which less is left to drive."""


def find_entries(parts: Sequence[Part], installation: Installation) -> dict[int, tuple[Step, ...]]:
    """Find what has to be done at home before each part but the first, by the part's number.

    The outputs are set as the parts before it leave them. The robot comes by a joint motion to the highest place of the
    planned way that led to the part since the last joint motion, and drives the rest of that way with all valves shut.
    A part that begins with a joint motion of its own needs no way.
    """
    state, found = _State({valve.channel: valve.open_lag_s for valve in installation.valves.values()}), {}
    for part in parts:
        if isinstance(part, Chapter):
            if part.number > 1:
                found[part.number] = tuple(state.entry(part))
            for step in part.steps:
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

    def entry(self, chapter: Chapter) -> list[Step]:
        """Give the steps that lead to a chapter from home."""
        maker = chapter.steps[0].made_by
        settings = [
            Switch(channel, value, maker) for channel, value in self.outputs.items() if channel not in self.valves
        ]
        opened = [channel for channel, value in self.outputs.items() if channel in self.valves and value]
        jets = [Switch(channel, self.outputs[channel], maker) for channel in opened]
        lags = [Pause(lag, maker) for lag in [max((self.valves[each] for each in opened), default=0.0)] if lag]
        return [*settings, *self.approach(chapter), *jets, *lags]

    def approach(self, chapter: Chapter) -> list[Step]:
        """Give the motion; none where the chapter begins with a joint motion. After one without motion comes a line."""
        first = next((step for step in chapter.steps if isinstance(step, Line | Reach)), None)
        if self.reach is None or isinstance(first, Reach):
            return []
        heights = [_height(self.reach.target), *(_height(line.target) for line in self.way)]
        highest = max(heights)
        begin = max(at for at, height in enumerate(heights) if height >= highest - _AS_HIGH_MM)
        reach = self.reach
        if begin:
            line = self.way[begin - 1]
            reach = Reach(line.target, line.joints, line.made_by)
        rest = [replace(line, events=()) for line in self.way[begin:]]
        return [replace(reach, way=()), *rest]


def _height(pose: Pose) -> float:
    """Height above the side of the board that the jet points at, in mm of the board's z."""
    down = rotate(pose.quaternion, (0.0, 0.0, 1.0))[2] <= 0.0
    return pose.position[2] if down else -pose.position[2]
