"""ABB RAPID with RobotWare Paint: guns are opened and shut by brushes, between ``PaintL`` that do not stop."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Lowered
from programs.motion.steps import Line, Step, Switch
from programs.posts.abb.read import RapidReader
from programs.posts.abb.write import Rapid
from programs.posts.dialect import Dialect, ProgramFiles
from programs.posts.reading.execution import Action


class Paint(Rapid):
    """RAPID whose lines switch nothing: brushes stand between them."""

    move = "PaintL"

    def __init__(self, dialect: Dialect, lowered: Lowered, installation: Installation) -> None:
        between = list(_between_lines(lowered.motion.steps))
        valves = {valve.channel for valve in installation.valves.values()}
        switched = (step.channel for step in between if isinstance(step, Switch))
        self.guns = list(dict.fromkeys(channel for channel in switched if channel in valves))
        steps = tuple(_one_gun_at_a_time(between, self.guns))
        super().__init__(dialect, replace(lowered, motion=replace(lowered.motion, steps=steps)), installation)

    def output(self, channel: Channel, value: float) -> str:
        """Change a gun by its brush, and any other output by itself."""
        if channel not in self.guns:
            return super().output(channel, value)
        return f"SetBrush {self.guns.index(channel) + 1 if value else 0};"

    def declarations(self) -> Iterator[str]:
        """Declare the guns of the brushes too."""
        yield from super().declarations()
        yield from (f'CONST string sBrush{number}:="{gun.name}";' for number, gun in enumerate(self.guns, start=1))


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


class PaintReader(RapidReader):
    """A controller with its process controller: which gun is open."""

    moves = "PaintL|MoveL|MoveJ"

    def __init__(self) -> None:
        super().__init__()
        self.guns: dict[str, str] = {}
        """Output by the number of its brush."""
        self.opened = ""

    def load(self, files: ProgramFiles) -> str:
        """Find the guns too."""
        names = r'CONST string sBrush(\d+):="(\w+)";'
        listed = [found for text in files.values() for found in re.findall(names, text)]
        self.guns = dict(listed)
        if [number for number, _ in listed] != [str(number) for number in range(1, 1 + len(set(self.guns.values())))]:
            raise ProgramError("the brushes are not numbered from 1, or two have one gun.", file=next(iter(files)))
        return super().load({file: re.sub(names, "", text) for file, text in files.items()})

    def grammar(self) -> dict[str, Action]:
        """Read brushes too; a gun that is set past its brush is unknown."""
        guns = "|".join(self.guns.values())
        return {r"SetBrush (\d+);": self.brush, rf"SetDO (?:{guns}),.*": self.refuse, **super().grammar()}

    def brush(self, match: re.Match[str]) -> None:
        """Change guns as a brush does: 0 shuts the one that is open, or all if none is known to be."""
        if match[1] == "0":
            for gun in [self.opened] if self.opened else self.guns.values():
                self.switch(gun, 0.0)
            self.opened = ""
            return
        if self.opened or match[1] not in self.guns:
            raise ProgramError(f"brush {match[1]} is not in the table, or {self.opened} is open.")
        self.opened = self.guns[match[1]]
        self.switch(self.opened, 1.0)
