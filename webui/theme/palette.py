"""The colours of the page: one accent, greys, scales that stay legible on them, and those of verdicts."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

import numpy as np

from cleaning.verdicts.rules import Outcome
from geometry.arrays import Scalars
from specs.finding import Severity
from webui.glb.glb import Colours

Tint: TypeAlias = tuple[int, int, int]
"""Red, green, blue."""
Tints: TypeAlias = dict[str, Tint]
"""A legend: colours by what they mean."""

ACCENT = (12, 92, 146)
"""Buttons, rows that are chosen, progress; red is left to what is wrong."""
CHOSEN_GROUND = (230, 241, 248)
"""Behind rows that are chosen."""
SELECTED = (204, 24, 134)
"""What is selected in the scene: unlike all functions, verdicts and severities."""
INK = (34, 48, 58)
QUIET = (92, 104, 114)
"""Second lines and labels: 5.7 : 1 on white, 5.2 : 1 on the grounds of the status."""
TRANSFER = (170, 178, 184)
BOARD = (128, 150, 132)
FIXTURE = (110, 116, 124)
COMPONENT = (204, 205, 206)
ROBOT = (186, 193, 199)
TOOL = (96, 112, 124)
"""What the flange carries."""
STAND = (206, 209, 211)
"""What stands around a robot."""
COLLIDING = (163, 32, 42)
"""Bodies that touch."""
NAMED = (
    (43, 108, 163), (47, 143, 126), (192, 138, 46), (125, 90, 155),
    (95, 125, 47), (155, 90, 110), (70, 130, 150), (140, 105, 80),
)  # fmt: skip
"""For functions, classes, templates: in their order, over again when there are more."""
_SCALE = np.array([(38, 70, 131), (42, 125, 142), (92, 166, 110), (226, 184, 84)], dtype=np.float64)

VERDICT_COLOURS: dict[Outcome, Tint] = {
    "dirty": (163, 32, 42),
    "marginal": (222, 150, 48),
    "clean, wet": (24, 56, 108),
    "no verdict": (150, 160, 168),
    "clean": (58, 128, 176),
}
"""Worst first; distinct to colour-blind eyes too: dark red, orange, deep blue, grey, blue."""
VERDICT_WORDS: dict[Outcome, str] = {
    "dirty": "Dirty",
    "marginal": "Marginal",
    "clean, wet": "Clean, wet underneath",
    "no verdict": "No verdict",
    "clean": "Clean",
}
SEVERITY_COLOURS: dict[Severity, Tint] = {"error": (163, 32, 42), "warning": (138, 90, 0), "info": QUIET}


def of_names(names: Sequence[str]) -> Tints:
    """Colours of names, by their place."""
    return {name: NAMED[index % len(NAMED)] for index, name in enumerate(dict.fromkeys(names))}


def of_values(values: Scalars, low: float, high: float) -> Colours:
    """(n, 3) colours from dark and cold (low) to light and warm (high); none is like the accent."""
    share = np.clip((values - low) / max(high - low, 1e-9), 0.0, 1.0) * (len(_SCALE) - 1)
    stops = np.arange(len(_SCALE))
    return np.column_stack([np.interp(share, stops, channel) for channel in _SCALE.T]).astype(np.uint8)


def tints_of_values(values: Scalars, low: float, high: float) -> list[Tint]:
    """Colours of ``of_values`` as plain triples."""
    return [(red, green, blue) for red, green, blue in of_values(values, low, high).tolist()]


def tint_values(values: Scalars, marks: Mapping[str, float]) -> tuple[list[Tint], Tints]:
    """Colours of values, and a legend of marked ones, on a scale that spans both."""
    both = np.array([*values, *marks.values()], dtype=np.float64)
    tints = tints_of_values(both, float(both.min(initial=np.inf)), float(both.max(initial=-np.inf)))
    return tints[: len(values)], dict(zip(marks, tints[len(values) :], strict=True))


def to_hex(colour: Iterable[int]) -> str:
    """Write a colour as in ``#0c5c92``."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
