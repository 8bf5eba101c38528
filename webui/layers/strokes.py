"""The paths of a plan as coloured lines, with what each of them is."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Points
from programs.plan import Dwell, Plan, SprayPass, Transfer
from webui.layers.glb import Colours, lines_glb
from webui.palette import TRANSFER, of_names, of_values

ColourBy: TypeAlias = Literal["function", "template", "speed"]
Tints: TypeAlias = dict[str, tuple[int, int, int]]


@dataclass(frozen=True, slots=True, eq=False)
class StrokeLine:
    """All that one maker sprays in one go: passes that follow each other with nothing but pauses between them."""

    made_by: str
    """Recipe path of the stroke, such as ``"sequence[0]/around/U12"``."""
    function: str
    points: Points
    """(n, 3) orifice, n >= 2."""
    speed_mm_s: float
    tilt_deg: float
    """Of the first point, from the board normal."""
    pauses: int
    paused_s: float

    @property
    def place(self) -> str:
        """Recipe path of the template in its step, such as ``"sequence[0]/around"``."""
        return "/".join(self.made_by.split("/")[:2])

    @property
    def template(self) -> str:
        """Name of the template, such as ``"around"``."""
        return self.made_by.split("/")[1] if "/" in self.made_by else self.made_by


def stroke_lines(plan: Plan) -> list[StrokeLine]:
    """Collect the sprayed strokes of a plan in order."""
    found: list[StrokeLine] = []
    parts: list[SprayPass] = []
    pauses: list[Dwell] = []
    for item in plan.items:
        if isinstance(item, Dwell) and parts:
            pauses.append(item)
            continue
        if parts and not (isinstance(item, SprayPass) and item.made_by == parts[0].made_by):
            found.append(_line(parts, pauses))
            parts, pauses = [], []
        if isinstance(item, SprayPass):
            parts.append(item)
    return [*found, _line(parts, pauses)] if parts else found


def strokes_glb(lines: Iterable[StrokeLine], tints: list[tuple[int, int, int]]) -> bytes:
    """Draw strokes, each in its colour."""
    return _drawn([line.points for line in lines], tints)


def transfers_glb(plan: Plan) -> bytes:
    """Draw the moves with the jet off."""
    moves = [item.tcp for item in plan.items if isinstance(item, Transfer)]
    return _drawn(moves, [TRANSFER] * len(moves))


def tint_strokes(lines: list[StrokeLine], by: ColourBy) -> tuple[list[tuple[int, int, int]], Tints]:
    """Colour strokes by what they are: a colour for each, and the legend."""
    if by == "speed":
        speeds = np.array([line.speed_mm_s for line in lines])
        if len(speeds) == 0:
            return [], {}
        low, high = float(speeds.min()), float(speeds.max())
        legend = {
            f"{speed:g} mm/s": _triple(of_values(np.array([speed]), low, high))
            for speed in sorted(set(speeds.tolist()))
        }
        return [_triple(of_values(np.array([speed]), low, high)) for speed in speeds], legend
    names = [line.function if by == "function" else line.template for line in lines]
    legend = of_names(names)
    return [legend[name] for name in names], legend


def _line(parts: list[SprayPass], pauses: list[Dwell]) -> StrokeLine:
    first = parts[0]
    return StrokeLine(
        made_by=first.made_by,
        function=first.jet.function,
        points=np.concatenate([first.tcp, *(part.tcp[1:] for part in parts[1:])]),
        speed_mm_s=first.speed_mm_s,
        tilt_deg=float(np.degrees(np.arccos(min(1.0, abs(float(first.approach[0, 2])))))),
        pauses=len(pauses),
        paused_s=sum(pause.duration_s for pause in pauses),
    )


def _drawn(strips: list[Points], tints: list[tuple[int, int, int]]) -> bytes:
    ends = [np.repeat(strip, 2, axis=0)[1:-1] for strip in strips]
    colours = np.repeat(np.array(tints, dtype=np.uint8).reshape(-1, 3), [len(each) for each in ends], axis=0)
    return lines_glb(np.concatenate([np.empty((0, 3)), *ends]), colours)


def _triple(colours: Colours) -> tuple[int, int, int]:
    red, green, blue = (int(channel) for channel in colours[0])
    return red, green, blue
