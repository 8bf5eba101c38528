"""ABB RAPID with RobotWare Paint: guns are opened and shut by brushes, between ``PaintL`` that do not stop."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from programs.errors import ProgramError
from programs.motion.installation import Channel, Installation
from programs.motion.lower import Capability, Lowered
from programs.motion.steps import Line, Step, Switch
from programs.posts.dialect import Dialect, ProgramFiles, Task
from programs.posts.layout import words_of
from programs.posts.reading.execution import Block, Values
from programs.posts.robots.abb.read import DIALECT as RAPID
from programs.posts.robots.abb.read import WORDS, RapidReader
from programs.posts.robots.abb.write import Rapid
from programs.posts.writing.forms import fill


class Paint(Rapid):
    """RAPID whose lines switch nothing: brushes stand between them."""

    verb = "PaintL"
    brush_form = "SetBrush {brush};"

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
        return fill(self.brush_form, brush=self.guns.index(channel) + 1 if value else 0)

    def setup(self) -> Iterator[Task]:
        """State what the integrator has to set up, the brushes too."""
        yield from super().setup()
        brushes = (f"brush {number} opens {gun.name}" for number, gun in enumerate(self.guns, start=1))
        yield Task("brush table of the process controller", ("brush 0 shuts all guns", *brushes))

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

    verbs = "PaintL|MoveL|MoveJ"

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

    def fields(self) -> Mapping[str, str]:
        """Give the pattern of each field of the writer's forms; a gun is set by its brush alone."""
        guns = "|".join(self.guns.values())
        return {**super().fields(), "brush": r"\d+", "name": rf"(?!(?:{guns})\b)\w+" if guns else r"\w+"}

    def blocks(self) -> Iterator[Block]:
        """List the statements of forms."""
        yield [Paint.brush_form], self.brush
        yield from super().blocks()

    def brush(self, values: Values) -> None:
        """Change guns as a brush does: 0 shuts the one that is open, or all if none is known to be."""
        number = values["brush"]
        if number == "0":
            for gun in [self.opened] if self.opened else self.guns.values():
                self.switch(gun, 0.0)
            self.opened = ""
            return
        if self.opened or number not in self.guns:
            raise ProgramError(f"brush {number} is not in the table, or {self.opened} is open.")
        self.opened = self.guns[number]
        self.switch(self.opened, 1.0)


DIALECT = replace(
    RAPID,
    title="ABB RAPID, RobotWare Paint",
    notes="For IRC5P: brush 0 shuts the guns, brush 1 opens the one that the string sBrush1 names, and so on; fill the "
    "brush table so. Where the process controller leads the guns itself, give the cell's valves no lag.",
    capability=Capability(
        controller_class=3,
        timing="boundary",  # assumed: a SetBrush without a plane acts where the next PaintL begins
        cycle_s=0.004,  # assumed, of the process controller
        step_mm_s=0.1,
    ),
    layout=replace(RAPID.layout, words=words_of(Paint, WORDS)),
    write=Paint.write,
    rebuild=PaintReader.rebuild,
)
