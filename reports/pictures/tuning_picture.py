"""Picture of a tuning: all recipes that were analysed by time, liquid and cleanliness, with the Pareto front."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from reports.pictures.sheet import (
    ACCENT,
    FAINT,
    FUNCTION_COLOURS,
    INK,
    QUIET,
    Picture,
    add_panels,
    sheet,
    to_bytes,
    write_foot,
    write_title,
)
from reports.tables.wording import clock
from rulesengine.tuning.front import pareto_front

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from matplotlib.axes import Axes

    from rulesengine.tuning.trial.request import Trial, TuningResult

_WIDTH_MM, _HEIGHT_MM, _BOTTOM_MM = 260.0, 118.0, 24.0
_MINUTE_S = 60.0
_FRONT = FUNCTION_COLOURS[0]
_ROOM = 0.06


def draw_tuning(tuned: TuningResult, suffix: str, chosen: str = "") -> bytes:
    """Draw what was analysed: clean components, liquid and margin over the time of the program.

    The same result gives the same bytes.

    Args:
        tuned: The result.
        suffix: ``.png`` or ``.svg``.
        chosen: Text of the recipe that is marked; empty for the result's own.
    """
    front = pareto_front(tuned.trials)
    mark = next((each for each in tuned.trials if each.text == (chosen or tuned.last.text)), None)
    total = tuned.last.total
    with sheet(_HEIGHT_MM, _WIDTH_MM) as figure:
        panels = add_panels(figure, 3, 3, bottom_mm=_BOTTOM_MM, spaces=(0.2, 0.2))
        drawn = _Drawn(tuned.trials, {id(each): number for number, each in enumerate(front, 1)}, mark, tuned.trials[0])
        _draw(panels[0], drawn, lambda trial: float(trial.figures.clean_components))
        panels[0].set_title("clean components of all recipes", fontsize=9, loc="left")
        panels[0].set_ylim(-_ROOM * total, (1 + _ROOM) * total)
        panels[0].axhline(total, color=FAINT, linewidth=0.6, zorder=0)
        cleanest = max((each.figures.clean_components for each in tuned.trials), default=0)
        near = replace(drawn, trials=[each for each in tuned.trials if each.figures.clean_components == cleanest])
        _draw(panels[1], near, lambda trial: trial.figures.litres)
        panels[1].set_title(f"liquid, l, of those with {cleanest} clean components", fontsize=9, loc="left")
        met = [each for each in near.trials if each.margin]
        _draw(panels[2], replace(near, trials=met or near.trials), lambda trial: trial.margin)
        panels[2].set_title("least margin of those, where all is met", fontsize=9, loc="left")
        write_title(figure, f"{len(tuned.trials)} recipes, {len(front)} on the Pareto front", _subtitle(mark, total))
        write_foot(
            figure,
            "numbers: Pareto front, no other recipe is as good in time, liquid and cleanliness; red: chosen"
            "\nring: as it was; margin: least amount or time over what a clean verdict needs, 0: not met; predictions",
        )
        return to_bytes(figure, suffix)


@dataclass(frozen=True, slots=True)
class _Drawn:
    """Recipes that a panel shows."""

    trials: Sequence[Trial]
    numbers: Mapping[int, int]
    """Of those on the front, by identity."""
    mark: Trial | None
    first: Trial


def picture_of_tuning(tuned: TuningResult, chosen: str = "") -> Picture:
    """Draw a tuning for a page."""
    return Picture(".svg", draw_tuning(tuned, ".svg", chosen), "Recipes by time, liquid and clean components")


def _subtitle(mark: Trial | None, total: int) -> str:
    if mark is None:
        return "predicted by the cleaning model"
    figures, margin = mark.figures, f", margin {mark.margin:.2f}" if mark.margin else ""
    clean = f"{figures.clean_components} of {total} clean"
    return f"chosen: {clean}{margin}, {clock(figures.seconds)}, {figures.litres:.1f} l"


def _draw(axes: Axes, drawn: _Drawn, value: Callable[[Trial], float]) -> None:
    for each in drawn.trials:
        place = each.figures.seconds / _MINUTE_S, value(each)
        number = drawn.numbers.get(id(each))
        colour, size = (FAINT, 4) if number is None else (_FRONT, 5)
        axes.plot(*place, "o", color=colour, markersize=size, zorder=1 if number is None else 2)
        if number is not None:
            axes.annotate(str(number), place, (3, 3), textcoords="offset points", fontsize=7, color=INK, zorder=4)
        if each is drawn.first:
            axes.plot(*place, "o", markersize=9, markerfacecolor="none", color=QUIET, zorder=3)
        if each is drawn.mark:
            axes.plot(*place, "o", color=ACCENT, markersize=7, zorder=3)
    axes.set_xlabel("program, min")
    axes.grid(visible=True, color=FAINT, linewidth=0.3, alpha=0.6)
    axes.tick_params(length=2)
    axes.margins(_ROOM)
