"""The header of an exported program, and the page of text beside one whose language has no room for it."""

from collections.abc import Iterable, Iterator

from programs.motion.analog import analog_channels
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, MotionProgram, Reach, Repeat, Switch
from programs.posts.dialect import Dialect
from programs.posts.writing.forms import short
from programs.posts.writing.wording import cut, join_lines, plain
from programs.timing.forecast import Forecast

_MOST_FINDINGS = 12
_WIDTH = 110


def heading(dialect: Dialect, lowered: Lowered, installation: Installation) -> tuple[str, ...]:
    """Give the lines of a program's header without comment marks: printable ASCII, of any length.

    It has no date and no path, so that the same program gives the same bytes.
    """
    motion, error, capability = lowered.motion, lowered.error, dialect.capability
    origin = motion.origin
    found = [f"{finding.severity}: {finding.message}" for finding in motion.findings if finding.severity != "info"]
    lines = (
        f"{dialect.title}, written by Washboard",
        f"Board  {origin.board}  sha256 {origin.board_sha256}",
        f"Recipe {origin.recipe}  sha256 {origin.recipe_sha256}",
        f"Cell   {installation.cell}  robot {installation.robot}",
        *([f"Held   {installation.held}"] if installation.held else []),
        f"Planned time {motion.duration_s:.1f} s, each loop once",
        *_home_lines(motion),
        *_warnings(dialect, motion),
        *_predicted(lowered.forecast),
        f"Worst event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms at planned speeds"
        + (f" ({error.made_by})" if error.made_by else ""),
        f"Controller class {capability.controller_class}; cycle {1e3 * capability.cycle_s:g} ms is in the error",
        *(f"Analog {capability.analog.describe(channel)}" for channel in analog_channels(motion.steps)),
        *found[:_MOST_FINDINGS],
        *([f"and {len(found) - _MOST_FINDINGS} findings more"] if len(found) > _MOST_FINDINGS else []),
    )
    return tuple(plain(line) for line in lines)


def _predicted(forecast: Forecast | None) -> Iterator[str]:
    if forecast is not None:
        yield f"Predicted time {forecast.describe()}"
        yield (
            f"Worst event error {forecast.event_mm:.2f} mm, {1e3 * forecast.event_s:.1f} ms at predicted speeds"
            + (f" ({forecast.event_by})" if forecast.event_by else "")
        )


def _home_lines(motion: MotionProgram) -> list[str]:
    """Give how long the joint motions before the first line and after the last take, where they are known."""
    lines = [at for at, step in enumerate(motion.steps) if isinstance(step, Line)]
    out, back = (
        sum(step.duration_s for step in part if isinstance(step, Reach))
        for part in (motion.steps[: min(lines, default=0)], motion.steps[max(lines, default=0) :])
    )
    return [f"In it {out:.1f} s from home and {back:.1f} s back, at half of the joints' speeds"] if out or back else []


def _warnings(dialect: Dialect, motion: MotionProgram) -> Iterator[str]:
    """Warn of joint motions at the planned speed, in languages that state it."""
    if dialect.maker is not None and any(step.way for step in motion.steps if isinstance(step, Reach)):
        yield "Joint motions take their planned times: first run at reduced speed, in manual mode, valves dry"


def short_heading(lowered: Lowered, installation: Installation, page: str) -> tuple[str, ...]:
    """Give the lines of a header for comments of some 30 characters, the rest being on a page."""
    origin, error, forecast = lowered.motion.origin, lowered.error, lowered.forecast
    predicted = () if forecast is None else (f"Time {forecast.predicted_s:.1f} s, {forecast.ratio:.2f} x plan",)
    return (
        f"Washboard: board {origin.board}",
        f"recipe {origin.recipe}",
        f"cell {installation.cell}",
        *predicted,
        f"Event error {error.distance_mm:.2f} mm, {1e3 * error.time_s:.1f} ms",
        f"Frames: see {page}",
    )


def sheet(dialect: Dialect, lowered: Lowered, installation: Installation, notes: Iterable[str]) -> str:
    """Write the page: the header of every program, the language's own notes, the outputs and inputs in use.

    Args:
        dialect: The language.
        lowered: The program.
        installation: The cell.
        notes: Tables, units and registers of the language.
    """
    lines = [*heading(dialect, lowered, installation), "", *notes, "", *_channel_lines(lowered.motion)]
    return join_lines(cut(line, _WIDTH) for line in lines)


def _channel_lines(motion: MotionProgram) -> Iterator[str]:
    yield from (f"{channel.kind} output {channel.number}  {channel.name}" for channel in _channels(motion))
    inputs: dict[str, None] = {}
    for step in motion.steps:
        if isinstance(step, Repeat) and (sensor := step.sensor) is not None:
            reading = f"{step.key} = {short(sensor.scale, 6)} * reading + {short(sensor.offset, 6)}"
            inputs[f"analog input {sensor.number}  {sensor.name}: {reading}"] = None
    yield from inputs


def channels_of(motion: MotionProgram) -> list[Channel]:
    """Give the outputs that a program sets, by kind and number."""
    return sorted(_channels(motion), key=lambda channel: (channel.kind, channel.number))


def _channels(motion: MotionProgram) -> dict[Channel, None]:
    """Outputs in the order in which they first change."""
    used: dict[Channel, None] = {}
    for step in motion.steps:
        if isinstance(step, Switch):
            used[step.channel] = None
        elif isinstance(step, Line):
            used |= {event.channel: None for event in step.events}
    return used
