"""Two runs on the same board, side by side on the page."""

from collections.abc import Sequence
from html import escape

import numpy as np

from geometry.arrays import Points
from reports.tables.comparison import Row, comparison_tables
from reports.tables.table import lines_of
from rulesengine.planning.pipeline import Run
from webui.layers.paths.strokes import StrokeLine, stroke_lines
from webui.theme.palette import ACCENT, INK, QUIET, to_hex

_SAME_MM = 0.01
"""Paths that are nearer to each other than this all along are the same."""


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


def comparison_html(rows: Sequence[Row], here: str, there: str) -> str:
    """Lay rows out as a table, what differs in ink and with its change, what does not in grey."""
    lines: list[str] = []
    for table in comparison_tables(rows, (here, there), ""):
        lines.append(f'<tr><td colspan="4" style="padding-top:8px;font-weight:600">{escape(table.title)}</td></tr>')
        for row in table.rows:
            (name,), *values, (change,) = (lines_of(cell)[0] for cell in row)
            texts = "".join(
                f'<td style="{_RIGHT}color:{to_hex(QUIET if run.emphasis else INK)}">{escape(run.text)}</td>'
                for (run,) in values
            )
            lines.append(
                f'<tr style="vertical-align:top"><td style="overflow-wrap:anywhere">{escape(name.text)}</td>{texts}'
                f'<td style="{_RIGHT}color:{to_hex(ACCENT)}">{escape(change.text)}</td></tr>'
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


def _way_name(line: StrokeLine) -> str:
    """What makes strokes of two recipes the same stroke: function, template, and what they go around."""
    return "/".join([line.function, *line.made_by.split("/")[1:]])


def _same(one: Points, other: Points) -> bool:
    return one.shape == other.shape and bool(np.abs(one - other).max(initial=0.0) <= _SAME_MM)
