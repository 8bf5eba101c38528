"""Colours and words of outcomes and severities, worst first."""

from cleaning.verdicts.cleanliness import Outcome
from specs.finding import Severity
from webui.theme.palette import QUIET, to_hex

VERDICT_COLOURS: dict[Outcome, tuple[int, int, int]] = {
    "dirty": (163, 32, 42),
    "marginal": (222, 150, 48),
    "clean, wet": (24, 56, 108),
    "no verdict": (150, 160, 168),
    "clean": (58, 128, 176),
}
"""Told apart by all eyes: dark red, orange, deep blue, grey, blue."""
VERDICT_WORDS: dict[Outcome, str] = {
    "dirty": "Dirty",
    "marginal": "Marginal",
    "clean, wet": "Clean, wet underneath",
    "no verdict": "No verdict",
    "clean": "Clean",
}
SEVERITY_COLOURS: dict[Severity, str] = {"error": "#a3202a", "warning": "#8a5a00", "info": to_hex(QUIET)}
