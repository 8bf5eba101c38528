"""The combinations of a study on the page: sorted, as a table, and as a picture."""

import math
from collections.abc import Callable, Mapping, Sequence
from html import escape

from reports.tables.table import Column, Table, Text
from reports.tables.wording import amount, clock
from studies.results.card import label_of
from studies.results.read_tables import Combination, StudyTables
from webui.theme.html import listing_html, quiet_html
from webui.theme.palette import ACCENT, INK, LINE_COLOUR, QUIET, SELECTED, css_colour, to_hex

_FRONT = "\N{BLACK CIRCLE}"
_LEGEND = (
    f"Coloured, and {_FRONT} in the list: on the Pareto front, no other one is as good in time, liquid and clean "
    "components. Larger: more of them are clean."
)
_MINUTE_S = 60.0
_MOST_DOTS, _MOST_NUMBERS = 1500, 15
"""Of the picture: dots beside those on the front, and numbers on it; more are one blot."""
_LEAST_DOT, _MOST_DOT = 2.5, 6.0
_WIDE, _HIGH = 276.0, 190.0
_LEFT, _BOTTOM, _AROUND = 34.0, 30.0, 12.0
"""Sizes of the picture and of its margins, px."""
_TICKS = 4
_STEPS = (1.0, 2.0, 5.0, 10.0)
_COLUMNS = (
    Column("no.", width="12%"),
    Column("values", width="34%"),
    Column("min", "right", width="17%", is_name=True),
    Column("l", "right", width="18%", is_name=True),
    Column("clean", "right", width="19%"),
)

ORDERS: Mapping[str, Callable[[Combination], float]] = {
    "Number": lambda each: each.number,
    "Time": lambda each: each.seconds,
    "Liquid": lambda each: each.litres,
    "Clean": lambda each: -each.clean,
    "All clean": lambda each: -each.all_clean / max(1, each.samples),
}
"""What combinations can be sorted by; of equal ones the lower number comes first."""


def choose_combinations(tables: StudyTables, board: str, order: str, *, front: bool) -> list[Combination]:
    """Combinations for a board, sorted; those with an error come last.

    Args:
        tables: Of the study.
        board: Its name in the study.
        order: One of ``ORDERS``.
        front: Whether to give those of the Pareto front alone.
    """
    chosen = [each for each in tables.combinations if each.board == board and (each.pareto or not front)]
    return sorted(chosen, key=lambda each: (bool(each.error), ORDERS[order](each), each.number))


def combinations_html(tables: StudyTables, shown: Sequence[Combination], selected: str) -> str:
    """Combinations as a table, the selected one marked."""
    if not shown:
        return quiet_html("No combination.")
    rows = [
        (
            str(each.number),
            (f"{_FRONT} " if each.pareto else "") + label_of(tables, each),
            *(
                (Text("error", tone="error"), "", "")
                if each.error
                else (f"{each.seconds / _MINUTE_S:.2f}", f"{each.litres:.2f}", str(each.clean))
            ),
        )
        for each in shown
    ]
    return listing_html(Table(_COLUMNS, tuple(rows)), selected, height="26vh", more="more")


def pareto_svg(shown: Sequence[Combination], selected: str) -> str:
    """Liquid over time of the combinations for a board, larger dots for more clean components, the front coloured."""
    good = [each for each in shown if not each.error]
    if not good:
        return ""
    across = _Axis.of([each.seconds / _MINUTE_S for each in good], _LEFT, _WIDE - _AROUND)
    up = _Axis.of([each.litres for each in good], _HIGH - _BOTTOM, _AROUND)
    others = [each for each in good if not each.pareto][:_MOST_DOTS]
    front = [each for each in good if each.pareto]
    drawn = [*others, *front]
    dots = "".join(_dot(each, across, up, css_colour(ACCENT) if each.pareto else css_colour(QUIET)) for each in drawn)
    numbers = "".join(
        f'<text x="{across.at(each.seconds / _MINUTE_S):.1f}" y="{up.at(each.litres) - 9:.1f}" text-anchor="middle" '
        f'fill="{css_colour(INK)}">{each.number}</text>'
        for each in front[:_MOST_NUMBERS]
    )
    marked = "".join(_ring(each, across, up) for each in drawn if str(each.number) == selected)
    return (
        f'<div style="margin:4px 12px"><svg viewBox="0 0 {_WIDE:g} {_HIGH:g}" role="img" font-size="10" '
        f'aria-label="Liquid over time of {amount(len(good), "combination")}, {len(front)} on the Pareto front" '
        f'style="display:block;width:100%;font-variant-numeric:tabular-nums">{_grid(across, up)}{dots}{marked}{numbers}'
        "</svg></div>" + quiet_html(_LEGEND)
    )


class _Axis:
    """A range of values laid out along a side of the picture, with round values marked."""

    def __init__(self, low: float, high: float, begin: float, end: float) -> None:
        self._low, self._high, self._begin, self._end = low, high, begin, end

    @classmethod
    def of(cls, values: Sequence[float], begin: float, end: float) -> "_Axis":
        """Span values and a little more."""
        low, high = min(values), max(values)
        more = 0.06 * (high - low) or max(0.05 * abs(high), 0.01)
        return cls(low - more, high + more, begin, end)

    def at(self, value: float) -> float:
        return self._begin + (value - self._low) / (self._high - self._low) * (self._end - self._begin)

    def ticks(self) -> list[float]:
        rough = (self._high - self._low) / _TICKS
        scale = 10.0 ** math.floor(math.log10(rough))
        step = next(each * scale for each in _STEPS if each * scale >= rough * (1.0 - 1e-9))
        first = math.ceil(self._low / step)
        return [step * each for each in range(first, math.floor(self._high / step) + 1)]


def _grid(across: _Axis, up: _Axis) -> str:
    quiet, floor, right = css_colour(QUIET), _HIGH - _BOTTOM, _WIDE - _AROUND
    lines = "".join(f"M{across.at(each):.1f} {_AROUND}V{floor}" for each in across.ticks())
    lines += "".join(f"M{_LEFT} {up.at(each):.1f}H{right}" for each in up.ticks())
    texts = "".join(
        f'<text x="{across.at(each):.1f}" y="{floor + 12}" text-anchor="middle">{each:g}</text>'
        for each in across.ticks()
    )
    texts += "".join(
        f'<text x="{_LEFT - 4}" y="{up.at(each) + 3.5:.1f}" text-anchor="end">{each:g}</text>' for each in up.ticks()
    )
    texts += (
        f'<text x="{right}" y="{_HIGH - 4}" text-anchor="end">program, min</text><text x="2" y="9">liquid, l</text>'
    )
    return f'<path d="{lines}" stroke="{LINE_COLOUR}" stroke-width="0.5"/><g fill="{quiet}">{texts}</g>'


def _dot(each: Combination, across: _Axis, up: _Axis, colour: str) -> str:
    title = f"{each.number}: {clock(each.seconds)}, {each.litres:.2f} l, {each.clean} of {each.components} clean"
    opacity = 1 if each.pareto else 0.45
    return (
        f'<circle cx="{across.at(each.seconds / _MINUTE_S):.1f}" cy="{up.at(each.litres):.1f}" r="{_radius(each):.1f}" '
        f'fill="{colour}" fill-opacity="{opacity}"><title>{escape(title)}</title></circle>'
    )


def _ring(each: Combination, across: _Axis, up: _Axis) -> str:
    return (
        f'<circle cx="{across.at(each.seconds / _MINUTE_S):.1f}" cy="{up.at(each.litres):.1f}" '
        f'r="{_radius(each) + 2.5:.1f}" fill="none" stroke="{to_hex(SELECTED)}" stroke-width="2"/>'
    )


def _radius(each: Combination) -> float:
    return _LEAST_DOT + (_MOST_DOT - _LEAST_DOT) * each.clean / max(1, each.components)
