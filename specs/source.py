"""Where in the recipe something comes from: the one place that reads and writes such paths."""

import re
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, Self, TypeAlias, cast

Motion: TypeAlias = Literal["", "transfer", "park", "turn"]

_STEP = re.compile(r"sequence\[(\d+)\]")
_KEYS = re.compile(r"([^./\[\]]+)|\[(\d+)\]")
_MOTIONS = ("transfer", "park", "turn")


@dataclass(frozen=True, slots=True)
class Source:
    """What in the recipe caused a pass, an instruction or a finding; ``made_by`` everywhere.

    Its text is a recipe path such as ``"sequence[0]/around/U12+U13"``, ``"sequence[0]/park"`` or ``"classes/small"``;
    ``parse`` and ``str`` are inverse. The empty source stands for what no recipe caused; it is false.
    """

    step: int | None = None
    """Index into the sequence."""
    template: str = ""
    """Name of the template that the step follows; empty for the step itself."""
    components: tuple[str, ...] = ()
    """Names of the components that are followed together, or of the one at whose edge the nozzle pauses."""
    motion: Motion = ""
    """Motion with the jet off on the way to it: a transfer, to the parked pose, around the edge to the other side."""
    entry: str = ""
    """Path of what is no step: an entry of the recipe or of a cell, such as ``"masks"`` or ``"classes/small"``."""

    @classmethod
    @lru_cache(maxsize=4096)
    def parse(cls, text: str) -> Self:
        """Read the text of a source; what names no step, or is not written as here, is an entry."""
        first, *rest = text.split("/")
        step = _STEP.fullmatch(first)
        if step is None:
            return cls(entry=text)
        motion = rest.pop() if rest and rest[-1] in _MOTIONS else ""
        template = rest[0] if rest else ""
        components = tuple("/".join(rest[1:]).split("+")) if len(rest) > 1 else ()
        found = cls(int(step[1]), template, components, cast(Motion, motion))
        return found if str(found) == text else cls(entry=text)

    def __str__(self) -> str:
        """Give its text."""
        begin = self.entry if self.step is None else f"sequence[{self.step}]"
        return "/".join(filter(None, [begin, self.template, "+".join(self.components), self.motion]))

    def __bool__(self) -> bool:
        """Whether it is not the empty one."""
        return self.step is not None or bool(self.entry)

    @property
    def place(self) -> Self:
        """Its template in its step, whatever the component and motion; without a template, itself."""
        return replace(self, components=(), motion="") if self.template else self

    def belongs_to(self, whole: Self) -> bool:
        """Whether another source is it, its template in its step, or its step."""
        return whole in (self, self.place) or (self.step is not None and whole == Source(self.step))

    @property
    def recipe_path(self) -> tuple[str | int, ...]:
        """Keys of the entry to edit: the template, else the step, else those of its own path."""
        if self.template:
            return ("templates", self.template)
        if self.step is not None:
            return ("sequence", self.step)
        return tuple(int(index) if index else key for key, index in _KEYS.findall(self.entry))


NO_SOURCE = Source()
"""Of what no recipe caused."""
