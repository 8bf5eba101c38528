"""Cleanliness and drying apart: whether a component comes out clean, and whether it stays wet underneath."""

from collections.abc import Iterable

from cleaning.verdicts.results import CleaningReport, Judgement, Part
from cleaning.verdicts.rules import OUTCOMES, VERDICTS, WET_GAP, Outcome, Verdict


def cleanliness(part: Part) -> Verdict:
    """Give the verdict on a component by all rules but drying."""
    return _worst(each.verdict for each in part.judgements if each.rule != WET_GAP)


def stays_wet(part: Part) -> bool:
    """Whether drying leaves water under a component."""
    return any(each.rule == WET_GAP and each.verdict != "clean" for each in part.judgements)


def outcome(part: Part) -> Outcome:
    """Give the verdict on a component by all rules but drying; ``clean, wet`` where only water is left."""
    clean = cleanliness(part)
    return "clean, wet" if clean == "clean" and stays_wet(part) else clean


def deciding_judgement(part: Part) -> Judgement:
    """Give the judgement that decides what becomes of a component: that it stays wet counts where nothing else does."""
    wet = outcome(part) == "clean, wet"
    return next((each for each in part.judgements if (each.rule == WET_GAP) == wet), part.judgements[0])


def report_cleanliness(report: CleaningReport) -> Verdict:
    """Give the verdict on a board and its process by all rules but drying."""
    return _worst([*map(cleanliness, (report.bare, *report.parts)), *(each.verdict for each in report.process)])


def report_outcome(report: CleaningReport) -> Outcome:
    """Give the verdict on a board and its process by all rules but drying; ``clean, wet`` where only water is left."""
    clean = report_cleanliness(report)
    return "clean, wet" if clean == "clean" and any(map(stays_wet, report.parts)) else clean


def count_cleanliness(parts: Iterable[Part]) -> dict[Verdict, int]:
    """Count components by their cleanliness, the worst first; a verdict that none has is left out."""
    found = [cleanliness(part) for part in parts]
    return {verdict: found.count(verdict) for verdict in VERDICTS if verdict in found}


def parts_by_instance(report: CleaningReport) -> dict[str, list[Part]]:
    """Components of each board of a panel, by the board's number; empty for a single board."""
    parts = {part.component: part for part in report.parts}
    return {
        instance.name: [
            parts[name] for component in instance.board.components if (name := instance.rename(component.name)) in parts
        ]
        for instance in report.board.instances
    }


def rank_parts(report: CleaningReport) -> list[Part]:
    """Give the components by what becomes of them, the worst first; then by residue, then in the board's order."""
    return sorted(report.parts, key=lambda part: (OUTCOMES.index(outcome(part)), -(part.residue or 0.0)))


def unclean_parts(report: CleaningReport) -> list[Part]:
    """Give the components that lack something, the worst first."""
    return [part for part in rank_parts(report) if part.verdict not in ("clean", "avoided")]


def _worst(verdicts: Iterable[Verdict]) -> Verdict:
    found = list(verdicts)
    return min(found, key=VERDICTS.index) if found else "clean"
