"""A program over time: spans of strokes, functions and the jet, events, and the strip that shows them."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape

import numpy as np

from geometry.arrays import Scalars
from programs.playback import Timeline
from programs.program import Command, MoveTo, SetNozzle, TimedProgram, Wait
from specs.source import Source
from webui.theme.palette import ACCENT, INK, PAPER, QUIET, TRACK, css_colour, ink_on, to_hex

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
