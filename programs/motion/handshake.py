"""The signals between a program and the line that brings what is washed, as steps around it."""

from collections.abc import Sequence

from programs.motion.installation import Handshake, Installation
from programs.motion.steps import Await, Step, Switch
from specs.source import NO_SOURCE


def before_waits(line: Handshake | None) -> list[Step]:
    """Give what comes before anything else: all signals off, then the start of a cycle is awaited."""
    if line is None:
        return []
    off = [channel for channel in (line.busy, line.done, line.fault) if channel is not None]
    begin = [Await(line.start, True, NO_SOURCE)] if line.start is not None else []
    return [*(Switch(channel, 0.0, NO_SOURCE) for channel in off), *begin]


def after_waits(line: Handshake | None) -> list[Step]:
    """Give what comes before the first motion."""
    return [Switch(line.busy, 1.0, NO_SOURCE)] if line is not None and line.busy is not None else []


def after_motion(line: Handshake | None) -> list[Step]:
    """Give what comes after the last motion: a controller that starts again washes nothing twice."""
    if line is None:
        return []
    steps: list[Step] = [Switch(line.busy, 0.0, NO_SOURCE)] if line.busy is not None else []
    if line.done is not None:
        steps.append(Switch(line.done, 1.0, NO_SOURCE))
    if line.present is not None:
        steps.append(Await(line.present, not line.state, NO_SOURCE))
        steps += [Switch(line.done, 0.0, NO_SOURCE)] if line.done is not None else []
    return steps


def with_handshake(steps: Sequence[Step], installation: Installation) -> list[Step]:
    """Give the steps of a program with those of its handshake."""
    line = installation.handshake
    return [*before_waits(line), *after_waits(line), *steps, *after_motion(line)]
