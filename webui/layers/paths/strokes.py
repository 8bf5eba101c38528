"""The strokes of a plan, and the program over time: spans of strokes, functions and the jet, events, their strip."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from html import escape
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from boards.board import Side, Workpiece
from geometry.arrays import Points, Scalars
from programs.plan import Plan, Transfer
from programs.playback import Timeline
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from recipes.recipe import Recipe
from rulesengine.planning.spray_runs import sprayed_in
from specs.source import Source
from webui.glb.glb import flat_triangles_glb, lengths_of, lines_glb, ribbons, unlike_segments
from webui.theme.palette import (
    ACCENT,
    INK,
    PAPER,
    QUIET,
    TRACK,
    TRANSFER,
    Tint,
    Tints,
    css_colour,
    ink_on,
    of_names,
    tint_values,
    to_hex,
)

STRIP_PX = 66
_MARK = "washboard-seek"
SEEK_STYLE = f"""<style>
div:has(> .{_MARK}) + div {{ position: relative; padding-top: 6px; }}
div:has(> .{_MARK}) + div .mantine-Slider-root {{
  position: absolute; left: 12px; right: 12px; top: -{STRIP_PX}px; height: {STRIP_PX}px; padding: 0; z-index: 2;
  overflow: hidden;
}}
div:has(> .{_MARK}) + div :is(.mantine-Slider-trackContainer, .mantine-Slider-track) {{ height: {STRIP_PX}px; }}
div:has(> .{_MARK}) + div .mantine-Slider-trackContainer {{ cursor: pointer; }}
div:has(> .{_MARK}) + div .mantine-Slider-track {{ opacity: 0; }}
div:has(> .{_MARK}) + div .mantine-NumberInput-root {{ width: 100% !important; margin-left: 0 !important; }}
</style><div class="{_MARK}"></div>"""
"""The slider that follows lies invisible over the strip above: clicks and drags on the strip move it."""
_COLUMNS = 600
_SOON_S = 1e-6


@dataclass(frozen=True, slots=True)
class Span:
    """Time span of one stroke."""

    made_by: Source
    begin_s: float
    end_s: float


def spray_spans(program: TimedProgram) -> list[Span]:
    """Time spans of strokes, ascending; pauses belong to the stroke before them."""
    spans: list[Span] = []
    spraying, maker, begin_s, now_s = False, "", 0.0, 0.0
    for item in program.instructions:
        moves = isinstance(item, MoveTo)
        stops = isinstance(item, SetNozzle) and not item.spraying
        if maker and (stops or (moves and item.made_by != maker)):
            spans.append(Span(maker, begin_s, item.time_s if stops else now_s))
            maker = ""
        if moves and spraying and not maker:
            maker, begin_s = item.made_by, now_s
        if isinstance(item, SetNozzle):
            spraying = item.spraying
        now_s = max(now_s, item.time_s + (item.duration_s if isinstance(item, Wait) else 0.0))
    return [*spans, Span(maker, begin_s, now_s)] if maker else spans


def times_by_place(program: TimedProgram) -> dict[Source, float]:
    """Seconds of each step, and of each template in its step, with the moves to them."""
    by_stroke: dict[Source, float] = {}
    now_s = 0.0
    for item in program.instructions:
        end_s = max(now_s, item.time_s + (item.duration_s if isinstance(item, Wait) else 0.0))
        by_stroke[item.made_by] = by_stroke.get(item.made_by, 0.0) + end_s - now_s
        now_s = end_s
    times: dict[Source, float] = {}
    for made_by, time_s in by_stroke.items():  # strokes are far fewer than instructions
        if made_by.step is not None:
            for place in {Source(made_by.step), Source(made_by.step, made_by.template)}:
                times[place] = times.get(place, 0.0) + time_s
    return times


def event_times(program: TimedProgram) -> Scalars:
    """(k,) times of events, s, ascending: switches of the jet, pauses, commands, the end."""
    happens = [item.time_s for item in program.instructions if isinstance(item, SetNozzle | Wait | Command)]
    return np.unique(np.round([*happens, program.totals.duration_s], 4))


def step_event(events: Scalars, now_s: float, steps: int) -> float:
    """Time of the next event (steps = 1) or the one before (-1), s; ``now_s`` where there is none."""
    if steps > 0:
        later = events[events > now_s + _SOON_S]
        return float(later[0]) if len(later) else now_s
    earlier = events[events < now_s - _SOON_S]
    return float(earlier[-1]) if len(earlier) else now_s


def function_bands(timeline: Timeline, end_s: float) -> list[tuple[str, float, float]]:
    """Functions with their begin and end, s."""
    begins = [*np.maximum(timeline.function.times, 0.0).tolist(), end_s]
    names = [timeline.function.names[int(code)] for code in timeline.function.codes]
    return [(name, begin, end) for name, begin, end in zip(names, begins[:-1], begins[1:], strict=True) if end > begin]


def spray_bands(timeline: Timeline, end_s: float) -> list[tuple[float, float]]:
    """Begin and end, s, of the times with the jet on."""
    times = [*timeline.switch_times.tolist(), end_s]
    on = timeline.switched_on[1:].tolist()
    return [
        (begin, end) for spraying, begin, end in zip(on, times[:-1], times[1:], strict=True) if spraying and end > begin
    ]


def top_speeds(timeline: Timeline, end_s: float, columns: int = _COLUMNS) -> Scalars:
    """(columns,) greatest speed in each of so many equal parts of the program, mm/s."""
    edges = np.linspace(0.0, end_s, columns + 1)
    key = np.clip(np.searchsorted(timeline.times, edges), 0, len(timeline.times) - 1)
    first, last = key[:-1], np.maximum(key[1:] + 1, key[:-1] + 1)
    ends = np.column_stack([first, np.minimum(last, len(timeline.speed) - 1)]).ravel()
    return np.asarray(np.maximum.reduceat(timeline.speed, ends)[::2], dtype=np.float64)


def strip_html(timeline: Timeline, end_s: float, tints: Mapping[str, tuple[int, int, int]]) -> str:
    """Strip of functions, jet and speed over time, as wide as its container.

    Args:
        timeline: The program.
        end_s: How long it takes; > 0.
        tints: Colour of each function.
    """
    bands, sprays = "", ""
    for name, begin_s, stop_s in function_bands(timeline, end_s):
        width, tint = _share(stop_s - begin_s, end_s), tints.get(name, QUIET)
        bands += (
            f'<div title="{escape(name)}" style="position:absolute;left:{_share(begin_s, end_s):.3f}%;'
            f"width:{width:.3f}%;top:0;height:18px;line-height:18px;box-sizing:border-box;"
            f"border-right:1px solid {PAPER};background:{to_hex(tint)};color:{ink_on(tint)};overflow:hidden;"
            f'white-space:nowrap;padding-left:{6 if width > 5 else 0}px">{escape(name) if width > 5 else ""}</div>'
        )
    for begin_s, stop_s in spray_bands(timeline, end_s):
        left, width = _share(begin_s, end_s), _share(stop_s - begin_s, end_s)
        sprays += f'<rect x="{left:.3f}" y="0" width="{width:.3f}" height="6"/>'
    speeds = top_speeds(timeline, end_s)
    top = max(float(speeds.max()), 1e-9)
    x = np.linspace(0, 100, len(speeds))
    corners = " ".join(f"{at:.2f},{34 - 26 * speed / top:.1f}" for at, speed in zip(x, speeds, strict=True))
    return (
        f'<div style="position:relative;height:{STRIP_PX}px;margin:0 12px;font-size:11px;color:{css_colour(INK)}">'
        f"{bands}"
        '<svg viewBox="0 0 100 34" preserveAspectRatio="none" '
        'style="position:absolute;left:0;top:22px;width:100%;height:44px;display:block">'
        f'<g fill="{css_colour(INK)}">{sprays}</g>'
        f'<polygon points="0,34 {corners} 100,34" fill="{TRACK}"/></svg>'
        f'<span style="position:absolute;right:2px;top:30px;padding:0 3px;background:{PAPER};'
        f'color:{css_colour(QUIET)}">up to {top:.0f} mm/s</span></div>'
    )


def cursor_html(now_s: float, end_s: float) -> str:
    """Cursor over the strip above, at the time that is shown."""
    left = _share(min(max(now_s, 0.0), end_s), end_s)
    return (
        '<div style="position:relative;height:0;margin:0 12px"><div style="position:absolute;'
        f"left:{left:.3f}%;top:-{STRIP_PX}px;height:{STRIP_PX}px;width:2px;margin-left:-1px;"
        f'background:{css_colour(ACCENT)}"></div></div>'
    )


def clock(seconds: float) -> str:
    """Write a time as in ``1 min 23.4 s``."""
    tenths = round(max(seconds, 0.0) * 10)
    minutes, rest = divmod(tenths, 600)
    return f"{minutes} min {rest / 10:.1f} s" if minutes else f"{rest / 10:.1f} s"


def clock_html(now_s: float, end_s: float) -> str:
    """Time that is shown, of the whole."""
    minutes, seconds = divmod(round(end_s), 60)
    end = f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
    return f"<b>{clock(now_s)}</b> of {escape(end)}"


def _share(seconds: float, end_s: float) -> float:
    return 100 * seconds / end_s if end_s > 0 else 0.0


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
