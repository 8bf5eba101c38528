"""Two runs on the same board, side by side."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from html import escape

import numpy as np

from geometry.arrays import Points
from rulesengine.pipeline import Run
from rulesengine.summary import clock
from webui.finding_list import SEVERITY_WORDS
from webui.layers.strokes import StrokeLine, stroke_lines
from webui.palette import ACCENT, INK, QUIET, to_hex

_SAME_MM = 0.01
"""Paths that are nearer to each other than this all along are the same."""


@dataclass(frozen=True, slots=True)
class Row:
    """One quantity of both runs, as it is written."""

    group: str
    name: str
    here: str
    there: str
    change: str = ""
    """Of the second against the first, such as ``"+12 %"``; empty where both are the same."""

    @property
    def differs(self) -> bool:
        """Say whether the runs differ in it."""
        return self.here != self.there


def compare(here: Run, there: Run) -> list[Row]:
    """Compare totals, litres by function, strokes by template, and findings by severity."""
    return [*_totals(here, there), *_litres(here, there), *_templates(here, there), *_findings(here, there)]


def unlike_strokes(here: Run, there: Run) -> list[StrokeLine]:
    """Strokes of the second run that the first does not have: another way, or none of that name."""
    ways: dict[str, list[Points]] = {}
    for line in stroke_lines(here.plan):
        ways.setdefault(_way_name(line), []).append(line.points)
    return [
        line
        for line in stroke_lines(there.plan)
        if not any(_same(line.points, way) for way in ways.get(_way_name(line), []))
    ]


def comparison_html(rows: Iterable[Row], here: str, there: str) -> str:
    """Lay rows out as a table, what differs in ink and with its change, what does not in grey."""
    lines: list[str] = []
    group = ""
    for row in rows:
        if row.group != group:
            group = row.group
            lines.append(f'<tr><td colspan="4" style="padding-top:8px;font-weight:600">{escape(group)}</td></tr>')
        ink = to_hex(INK) if row.differs else to_hex(QUIET)
        values = "".join(f'<td style="{_RIGHT}color:{ink}">{escape(text)}</td>' for text in (row.here, row.there))
        name = f'<td style="overflow-wrap:anywhere">{escape(row.name)}</td>'
        lines.append(
            f'<tr style="vertical-align:top">{name}{values}'
            f'<td style="{_RIGHT}color:{to_hex(ACCENT)}">{escape(row.change)}</td></tr>'
        )
    heads = "".join(
        f'<th style="{_RIGHT}font-weight:600;{_CUT}" title="{escape(text)}">{escape(text)}</th>'
        for text in (here, there)
    )
    return (
        f'<table style="margin:4px 12px;width:calc(100% - 24px);border-collapse:collapse;table-layout:fixed;'
        f'font-size:12px;line-height:1.6;color:{to_hex(INK)};font-variant-numeric:tabular-nums">'
        '<colgroup><col style="width:30%"><col style="width:27%"><col style="width:27%"><col style="width:16%">'
        f"</colgroup><tr><th></th>{heads}<th></th></tr>{''.join(lines)}</table>"
    )


_RIGHT = "text-align:right;white-space:nowrap;"
_CUT = "overflow:hidden;text-overflow:ellipsis;"


def _totals(here: Run, there: Run) -> list[Row]:
    one, other = here.program.totals, there.program.totals
    group = "Program"
    return [
        Row(
            group, "Total time", clock(one.duration_s), clock(other.duration_s), _part(one.duration_s, other.duration_s)
        ),
        Row(group, "Spraying", clock(one.spray_s), clock(other.spray_s), _part(one.spray_s, other.spray_s)),
        Row(group, "Travel", _metres(one.travel_mm), _metres(other.travel_mm), _part(one.travel_mm, other.travel_mm)),
        Row(group, "Moves", f"{one.moves:,}", f"{other.moves:,}", _part(one.moves, other.moves)),
    ]


def _litres(here: Run, there: Run) -> list[Row]:
    one, other = dict(here.program.totals.liquid_l), dict(there.program.totals.liquid_l)
    return [
        Row(
            "Liquid",
            name,
            _litre(one.get(name)),
            _litre(other.get(name)),
            _part(one.get(name), other.get(name)),
        )
        for name in dict.fromkeys([*one, *other])
    ]


def _templates(here: Run, there: Run) -> list[Row]:
    one, other = _strokes_by_template(here), _strokes_by_template(there)
    return [
        Row("Strokes", name, *_stroke_values(one.get(name), other.get(name))) for name in dict.fromkeys([*one, *other])
    ]


def _stroke_values(one: "_Strokes | None", other: "_Strokes | None") -> tuple[str, str, str]:
    change = _part(one.way_mm, other.way_mm) if one is not None and other is not None else ""
    return str(one or "none"), str(other or "none"), change


@dataclass(slots=True)
class _Strokes:
    """What one template sprays in one step."""

    count: int = 0
    way_mm: float = 0.0

    def __str__(self) -> str:
        return f"{self.count}, {_metres(self.way_mm)}"


def _strokes_by_template(run: Run) -> dict[str, _Strokes]:
    found: dict[str, _Strokes] = {}
    for line in stroke_lines(run.plan):
        strokes = found.setdefault(_place_name(run, line.place), _Strokes())
        strokes.count += 1
        strokes.way_mm += float(np.linalg.norm(np.diff(line.points, axis=0), axis=1).sum())
    return found


def _place_name(run: Run, place: str) -> str:
    """Name a template in its step as the paths panel does: its function and itself."""
    step, _, template = place.partition("/")
    number = int(step.removeprefix("sequence[").removesuffix("]"))
    return f"{run.recipe.sequence[number].function} {template}"


def _findings(here: Run, there: Run) -> list[Row]:
    one, other = (Counter(finding.severity for finding in run.findings) for run in (here, there))
    return [
        Row("Findings", word, str(one[severity]), str(other[severity])) for severity, word in SEVERITY_WORDS.items()
    ]


def _way_name(line: StrokeLine) -> str:
    """What makes strokes of two recipes the same stroke: function, template, and what they go around."""
    return "/".join([line.function, *line.made_by.split("/")[1:]])


def _same(one: Points, other: Points) -> bool:
    return one.shape == other.shape and bool(np.abs(one - other).max(initial=0.0) <= _SAME_MM)


def _part(one: float | None, other: float | None) -> str:
    """Write a change in percent; nothing where there is none, or nothing to take it of."""
    if one is None or other is None or one == 0:
        return ""
    change = 100 * (other - one) / one
    return "" if abs(change) < 0.05 else f"{change:+.0f} %" if abs(change) >= 10 else f"{change:+.1f} %"


def _litre(value: float | None) -> str:
    return "none" if value is None else f"{value:.2f} l"


def _metres(travel_mm: float) -> str:
    return f"{travel_mm / 1000:.2f} m"
