"""Bounds on the work of a recipe: refused from its strokes, before anything is ordered, timed or written."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from programs.plan import Jet
from recipes.errors import RecipeError
from rulesengine.strokes.stroke import Stroke
from specs.source import Source
from specs.yaml.located import spell_path

MOST_LINES = 10_000
"""Parallel lines of one template."""
MOST_STROKES = 50_000
MOST_POINTS = 2_000_000
"""Of all strokes, laps and repeats counted."""
MOST_S = 86_400.0
MOST_LITRES = 1000.0
_RATHER = (
    "raise its speed_mm_s, or lower what multiplies it: repeats, passes and delays of the template, repeat of its step"
)


@dataclass(frozen=True, slots=True)
class Work:
    """What one template takes in its step."""

    made_by: Source
    strokes: int
    points: int
    seconds: float
    """Of spraying, at the programmed speed throughout: no motion takes less."""
    litres: float


def measure(strokes: Iterable[Stroke], jet: Jet, made_by: Source, repeats: int) -> Work:
    """Count points and add up the least time of strokes; the same stroke may be there many times."""
    count = points = 0
    seconds = 0.0
    # Repeats share their strokes; each is measured once.
    for stroke, times in Counter(strokes).items():
        count += times
        points += times * stroke.laps * len(stroke.tcp)
        seconds += times * stroke.laps * (stroke.lap_mm / stroke.speed_mm_s + float(stroke.delays.sum()))
    litres = seconds / 60.0 * jet.flow_lpm if jet.liquid else 0.0
    return Work(made_by, repeats * count, repeats * points, repeats * seconds, repeats * litres)


def require_bounds(work: Iterable[Work]) -> None:
    """Make sure that a machine can do a plan in a day, and that it can be planned.

    Raises:
        RecipeError: it takes more than a day or 1,000 litres, or too many strokes or points; the message names the
            template that takes the most.
    """
    parts = list(work)
    bounds = (
        ("strokes", MOST_STROKES, 1.0, "{:,.0f} strokes"),
        ("points", MOST_POINTS, 1.0, "{:,.0f} points"),
        ("seconds", MOST_S, 3600.0, "{:,.1f} h of spraying"),
        ("litres", MOST_LITRES, 1.0, "{:,.0f} l"),
    )
    for name, most, unit, words in bounds:
        amounts = [float(getattr(part, name)) for part in parts]
        if (total := sum(amounts)) > most:
            largest = int(np.argmax(amounts))
            source = parts[largest].made_by
            message = (
                f"the plan would take {words.format(total / unit)}; a plan has at most {words.format(most / unit)}. "
                f"{source} alone takes {words.format(amounts[largest] / unit)}: {_RATHER}"
            )
            raise RecipeError(message, path=spell_path(source.recipe_path))


def require_lines(width_mm: float, pitch_mm: float, made_by: Source) -> None:
    """Make sure that lines do not lie endlessly close together.

    Raises:
        RecipeError: more than 10,000 lines would lie across the width.
    """
    if width_mm > MOST_LINES * pitch_mm:
        message = (
            f"lines {pitch_mm:.2g} mm apart across {width_mm:,.0f} mm are more than {MOST_LINES:,}. Raise pitch_mm; or "
            "where it is auto, raise height_mm, lower overlap or check the nozzle's angles and wave front"
        )
        raise RecipeError(message, path=spell_path(made_by.recipe_path))


def require_totals(duration_s: float, litres: float) -> None:
    """Make sure that a timed program stays within the bounds too: corners and limits of the motion take time.

    Raises:
        RecipeError: it takes more than a day or 1,000 litres.
    """
    if duration_s > MOST_S or litres > MOST_LITRES:
        message = (
            f"the program would take {duration_s / 3600.0:,.1f} h and {litres:,.0f} l; a plan has at most "
            f"{MOST_S / 3600.0:g} h and {MOST_LITRES:,.0f} l. Raise speeds, or the accelerations under limits; lower "
            "repeats, passes and delays"
        )
        raise RecipeError(message, path="sequence")
