"""Colours and words of verdicts, worst first."""

from cleaning.results import Verdict

VERDICT_COLOURS: dict[Verdict, tuple[int, int, int]] = {
    "dirty": (163, 32, 42),
    "marginal": (222, 150, 48),
    "no verdict": (150, 160, 168),
    "clean": (58, 128, 176),
}
"""Told apart by all eyes: dark red, orange, grey, blue."""
VERDICT_WORDS: dict[Verdict, str] = {
    "dirty": "Dirty",
    "marginal": "Marginal",
    "no verdict": "No verdict",
    "clean": "Clean",
}
