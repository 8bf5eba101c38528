"""The colours of the page: one accent, greys, scales that stay legible on them, and those of verdicts.

A colour of text or of a ground has one shade on light and one on dark; HTML names it by ``css_colour``, and the page's
style sheet gives the name its value (``colour_variables``).
"""

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
    "avoided": (214, 204, 182),
}
"""Worst first; distinct to colour-blind eyes too: dark red, orange, deep blue, grey, blue, sand."""
SEVERITY_COLOURS: dict[Severity, Tint] = {"error": (163, 32, 42), "warning": (138, 90, 0), "info": QUIET}


_SHADES: dict[Tint, tuple[str, Tint, Tint]] = {
    INK: ("ink", INK, (222, 229, 234)),
    QUIET: ("quiet", QUIET, (163, 174, 183)),
    ACCENT: ("accent", ACCENT, (118, 188, 238)),
    CHOSEN_GROUND: ("chosen", CHOSEN_GROUND, (26, 56, 78)),
    SEVERITY_COLOURS["error"]: ("error", SEVERITY_COLOURS["error"], (255, 146, 146)),
    SEVERITY_COLOURS["warning"]: ("warning", SEVERITY_COLOURS["warning"], (240, 190, 90)),
    VERDICT_COLOURS["marginal"]: ("marginal", SEVERITY_COLOURS["warning"], (240, 190, 90)),
    VERDICT_COLOURS["clean, wet"]: ("wet", VERDICT_COLOURS["clean, wet"], (160, 190, 250)),
    VERDICT_COLOURS["no verdict"]: ("unjudged", QUIET, (163, 174, 183)),
    VERDICT_COLOURS["clean"]: ("clean", (34, 100, 146), (126, 190, 232)),
}
"""Name, shade on light and shade on dark, of colours that text has."""
_GROUNDS: dict[str, tuple[Tint, Tint]] = {
    "paper": ((255, 255, 255), (36, 36, 36)),
    "ground": ((244, 246, 247), (46, 50, 54)),
    "error-ground": ((251, 238, 238), (74, 34, 36)),
    "added": ((232, 243, 234), (28, 62, 38)),
    "added-ink": ((31, 107, 52), (150, 220, 165)),
    "removed": ((251, 235, 234), (74, 34, 36)),
    "removed-ink": ((154, 42, 32), (255, 160, 150)),
    "line": ((213, 219, 223), (72, 78, 84)),
    "track": ((219, 225, 229), (72, 80, 88)),
}
PAPER, GROUND, ERROR_GROUND, ADDED, ADDED_INK, REMOVED, REMOVED_INK, LINE_COLOUR, TRACK = (
    f"var(--wb-{name},#{bytes(light).hex()})" for name, (light, _) in _GROUNDS.items()
)
"""CSS of grounds, lines, and of lines of a text that were added or removed."""


def css_colour(tint: Tint) -> str:
    """CSS of a colour of text: its shade on light or dark where it has them, else the colour itself.

    A page without the style sheet, such as a recording, gets the shade on light.
    """
    name, light, _ = _SHADES.get(tint, ("", tint, tint))
    return f"var(--wb-{name},{to_hex(light)})" if name else to_hex(tint)


def colour_variables(*, dark: bool) -> str:
    """CSS declarations of all named colours, on light or on dark."""
    named = {name: (light, on_dark) for name, light, on_dark in _SHADES.values()} | _GROUNDS
    return "".join(f"--wb-{name}:{to_hex(shades[dark])};" for name, shades in named.items())


def shades_of_text(*, dark: bool) -> dict[str, Tint]:
    """Shades of text by their names, on light or on dark."""
    return {name: (on_dark if dark else light) for name, light, on_dark in _SHADES.values() if name != "chosen"}


def grounds_of_text(*, dark: bool) -> dict[str, Tint]:
    """Grounds on which text stands, on light or on dark."""
    return {name: _GROUNDS[name][dark] for name in ("paper", "ground")}


def contrast(one: Tint, other: Tint) -> float:
    """Contrast ratio of two colours, 1 to 21: WCAG 2.2, "contrast ratio" with "relative luminance"."""
    low, high = sorted((_luminance(one), _luminance(other)))
    return (high + 0.05) / (low + 0.05)


def ink_on(ground: Tint) -> str:
    """CSS of black or white, whichever is read better on a ground: one of them has a contrast of 4.5 or more."""
    return "#fff" if contrast((255, 255, 255), ground) >= 4.5 else "#000"


def _luminance(colour: Tint) -> float:
    shares = np.array(colour) / 255.0
    linear = np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


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
