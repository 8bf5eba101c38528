"""A page of text beside a program whose language has no room for what the integrator has to know."""

from collections.abc import Sequence

from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import Line, MotionProgram, Repeat, Switch
from programs.posts.writing.heading import heading
from programs.posts.writing.wording import cut, short

_WIDTH = 110


def sheet(
    lowered: Lowered, installation: Installation, capability: Capability, title: str, words: Sequence[str]
) -> str:
    """Write the page: the header of every program, what the language needs, the channels in use.

    Args:
        lowered: The program.
        installation: The cell.
        capability: Of the language.
        title: Of the language.
        words: What the language needs: its tables, units and registers.
    """
    lines = [*heading(lowered, installation, capability, title), "", *words, "", *channel_lines(lowered.motion)]
    return "".join(f"{cut(line, _WIDTH)}\n" for line in lines)


def short_heading(lowered: Lowered, installation: Installation, page: str) -> tuple[str, ...]:
    """Give the lines of a header for comments of some 30 characters, the rest being on a page."""
    origin, error = lowered.motion.origin, lowered.error
    return (
        f"Washboard: board {origin.board}",
        f"recipe {origin.recipe}",
        f"cell {installation.cell}",
        f"Event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms",
        f"Frames: see {page}",
    )


def channel_lines(motion: MotionProgram) -> tuple[str, ...]:
    """Say which outputs and inputs a program uses."""
    outputs: dict[Channel, None] = {}
    inputs: dict[str, None] = {}
    for step in motion.steps:
        match step:
            case Switch():
                outputs[step.channel] = None
            case Line():
                outputs |= {event.channel: None for event in step.events}
            case Repeat() if step.sensor is not None:
                sensor = step.sensor
                reading = f"{step.key} = {short(sensor.scale, 6)} * reading + {short(sensor.offset, 6)}"
                inputs[f"analog input {sensor.number}  {sensor.name}: {reading}"] = None
            case _:
                pass
    return (*(f"{channel.kind} output {channel.number}  {channel.name}" for channel in outputs), *inputs)
