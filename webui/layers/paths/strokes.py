"""The strokes of a plan: their data, their colours, and their lines."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Side, Workpiece
from geometry.arrays import Points
from programs.plan import Plan, Transfer
from recipes.recipe import Recipe
from rulesengine.planning.spray_runs import sprayed_in
from specs.source import Source
from webui.glb.glb import flat_triangles_glb, lengths_of, lines_glb, ribbons, unlike_segments
from webui.layers.paths.timeline import Span
from webui.theme.palette import TRANSFER, Tint, Tints, of_names, tint_values

ColourBy: TypeAlias = Literal["function", "template", "speed", "time"]

_MOST_RIBBONS = 20_000
"""More segments are drawn as bare lines: four triangles for each would be more than the board itself has."""


@dataclass(frozen=True, slots=True, eq=False)
class StrokeLine:
    """One stroke: spray passes of one origin with nothing but pauses between them."""

    made_by: Source
    """Recipe path of the stroke, such as ``"sequence[0]/around/U12"``."""
    function: str
    points: Points
    """(n, 3) orifice, n >= 2."""
    speed_mm_s: float
    tilt_deg: float
    """Of the first point, from the board normal."""
    pauses: int
    paused_s: float
    nozzle: str = ""
    side: Side = "top"
    """The sprayed side."""

    @property
    def template(self) -> str:
        """Name of the template, such as ``"around"``."""
        return self.made_by.template

    @property
    def segments(self) -> NDArray[np.float64]:
        """(n - 1, 2, 3)."""
        return np.stack([self.points[:-1], self.points[1:]], axis=1)

    @property
    def length_mm(self) -> float:
        """Length of all laps."""
        return float(lengths_of(self.segments).sum())

    @property
    def laps(self) -> int:
        """Number of times that the same path is repeated."""
        once = float(lengths_of(self.segments[unlike_segments(self.segments)]).sum())
        return max(1, round(self.length_mm / once)) if once > 0 else 1


def stroke_lines(plan: Plan) -> list[StrokeLine]:
    """Strokes of a plan, in order."""
    return [
        StrokeLine(
            made_by=first.made_by,
            function=first.jet.function,
            points=sprayed.points,
            speed_mm_s=float(first.speeds_mm_s.max()),
            tilt_deg=float(np.degrees(np.arccos(min(1.0, abs(float(first.approach[0, 2])))))),
            pauses=len(sprayed.pauses),
            paused_s=sum(pause.duration_s for pause in sprayed.pauses),
            nozzle=first.jet.nozzle,
            side="top" if float(first.approach[0, 2]) < 0 else "bottom",
        )
        for sprayed in sprayed_in(plan)
        for first in sprayed.passes[:1]
    ]


def strokes_glb(lines: Iterable[StrokeLine], tints: list[Tint], width_mm: float = 0.0) -> bytes:
    """Draw strokes, each in its colour.

    Args:
        lines: The strokes.
        tints: A colour for each.
        width_mm: How wide lines are; 0 draws the thinnest, and so do very many lines.
    """
    return _drawn([line.points for line in lines], tints, width_mm)


def transfers_glb(plan: Plan, hidden: frozenset[Source] = frozenset()) -> bytes:
    """Draw the moves with the jet off, but not those to strokes of hidden templates."""
    moves = [item.tcp for item in plan.items if isinstance(item, Transfer) and item.made_by.place not in hidden]
    return _drawn(moves, [TRANSFER] * len(moves), 0.0)


def job_box(workpiece: Workpiece, lines: Iterable[StrokeLine]) -> tuple[Points, Points]:
    """Lowest and highest corner (3,), mm, of a workpiece with what hangs over its edges, and all strokes over it."""
    bodies = [body.patches.reshape(-1, 3) for body in workpiece.bodies if body.role != "fixture"]
    points = np.concatenate([*bodies, *(line.points for line in lines)])
    return points.min(axis=0), points.max(axis=0)


def stroke_spans(lines: list[StrokeLine], spans: list[Span]) -> list[Span | None]:
    """Time span of each stroke: the k-th stroke of an origin has the k-th span of that origin."""
    left: dict[Source, list[Span]] = {}
    for span in reversed(spans):
        left.setdefault(span.made_by, []).append(span)
    return [left[line.made_by].pop() if left.get(line.made_by) else None for line in lines]


def tint_strokes(lines: list[StrokeLine], by: ColourBy, spans: list[Span | None]) -> tuple[list[Tint], Tints]:
    """Colours of strokes, and the legend.

    Args:
        lines: The strokes.
        by: Meaning of the colours.
        spans: Time span of each stroke; used for ``time`` alone.
    """
    match by:
        case "speed":
            speeds = [line.speed_mm_s for line in lines]
            return tint_values(np.array(speeds), {f"{speed:g} mm/s": speed for speed in sorted(set(speeds))})
        case "time":
            begins = [0.0 if span is None else span.begin_s for span in spans]
            last = max(begins, default=0.0)
            marks = {f"{share * last / 60:.1f} min": share * last for share in (0, 0.25, 0.5, 0.75, 1)}
            return tint_values(np.array(begins), marks) if lines else ([], {})
        case "function" | "template":
            names = [line.function if by == "function" else line.template for line in lines]
            legend = of_names(names)
            return [legend[name] for name in names], legend


def tint_functions(recipe: Recipe) -> Tints:
    """Colours of functions, the same as those of their strokes."""
    return of_names([step.function for step in recipe.sequence if step.enabled])


def _drawn(strips: list[Points], tints: list[Tint], width_mm: float) -> bytes:
    segments = np.concatenate([np.empty((0, 2, 3)), *(np.stack([each[:-1], each[1:]], axis=1) for each in strips)])
    counts = [len(each) - 1 for each in strips]
    colours = np.repeat(np.array(tints, dtype=np.uint8).reshape(-1, 3), counts, axis=0)
    shown = unlike_segments(segments)
    segments, colours = segments[shown], colours[shown]
    if width_mm > 0 and len(segments) <= _MOST_RIBBONS:
        return flat_triangles_glb(*ribbons(segments, colours, width_mm))
    return lines_glb(segments.reshape(-1, 3), np.repeat(colours, 2, axis=0))
