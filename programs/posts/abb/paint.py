"""ABB RAPID with RobotWare Paint: guns are opened and shut by brushes, between ``PaintL`` that do not stop."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps_of_robot import Line, Step, Switch
from programs.posts.abb.write import LONGEST_LINE as LONGEST_LINE
from programs.posts.abb.write import Words, render_with, set_output

TITLE = "ABB RAPID, RobotWare Paint"
NOTES = (
    "For IRC5P: brush 0 shuts the guns, brush 1 opens the one that the string sBrush1 names, and so on; fill the brush "
    "table so. Where the process controller leads the guns itself, give the cell's valves no lag."
)
CAPABILITY = Capability(
    controller_class=3,
    says="boundary",  # assumed: a SetBrush without a plane acts where the next PaintL begins
    cycle_s=0.004,  # assumed, of the process controller
    step_mm_s=0.1,
)


def render(lowered: Lowered, installation: Installation) -> dict[str, str]:
    """Write a program: one module, or a module for each part and a ``.pgf`` that lists them.

    Raises:
        ProgramError: two guns are to be open at a time.
    """
    between = list(_between_lines(lowered.motion.steps))
    valves = {valve.channel for valve in installation.valves.values()}
    switched = (step.channel for step in between if isinstance(step, Switch))
    guns = list(dict.fromkeys(channel for channel in switched if channel in valves))
    steps = tuple(_one_gun_at_a_time(between, guns))
    brushes = _Brushes(guns)
    names = tuple(f'CONST string sBrush{number}:="{gun.name}";' for number, gun in enumerate(guns, start=1))
    words = Words(TITLE, CAPABILITY, "PaintL", brushes.set, names)
    return render_with(replace(lowered, motion=replace(lowered.motion, steps=steps)), installation, words)


@dataclass(slots=True)
class _Brushes:
    """The guns by number."""

    guns: list[Channel]

    def set(self, channel: Channel, value: float) -> str:
        """Change a gun by its brush, and any other output by itself."""
        if channel not in self.guns:
            return set_output(channel, value)
        return f"SetBrush {self.guns.index(channel) + 1 if value else 0};"


def _between_lines(steps: Sequence[Step]) -> Iterator[Step]:
    """Put outputs at a line's beginning before it, and those at its end after it."""
    for step in steps:
        if not isinstance(step, Line):
            yield step
            continue
        changes = [(event.share, Switch(event.channel, event.value, event.made_by)) for event in step.events]
        yield from (change for share, change in changes if share < 0.5)
        yield replace(step, events=())
        yield from (change for share, change in changes if share > 0.5)


def _one_gun_at_a_time(steps: Sequence[Step], guns: list[Channel]) -> Iterator[Step]:
    """Leave out what shuts guns that are shut, after the first of them, which shuts all."""
    opened: Channel | None = None
    shut_all = False
    for step in steps:
        if not (isinstance(step, Switch) and step.channel in guns):
            yield step
            continue
        if opened not in (None, step.channel):
            raise ProgramError(
                f"{step.made_by}: a brush opens one gun, and {opened.name if opened else ''} is open. "
                "Let one jet end before the next begins."
            )
        opened = step.channel if step.value else None
        if step.value or not shut_all:
            yield step
        shut_all = not step.value
