"""What came of tuning as plain data: what ``--report`` writes."""

from dataclasses import asdict

from rulesengine.tuning.explain import Reason
from rulesengine.tuning.trial.outcome import Outcome
from rulesengine.tuning.trial.result import Figures, Tuned, figures_of
from specs.json import Json

VERSION = 1
"""Of the data: it changes when a key changes its meaning or goes."""


def tuning_report(tuned: Tuned, reasons: tuple[Reason, ...], diff: str) -> dict[str, Json]:
    """Collect what was asked, changed and reached; the same tuning gives the same data."""
    asked, limits = tuned.asked, tuned.asked.limits
    return {
        "washboard_tuning": VERSION,
        "for": asked.goal,
        "clean": tuned.last.clean,
        "within_limits": tuned.within,
        "limits": {"time": limits.seconds, "litres": limits.litres},
        "allowed": [str(kind) for kind in sorted(asked.allowed.kinds)],
        "analyses": {"used": tuned.used, "most": asked.analyses},
        "components": tuned.last.total,
        "left_out": list[Json](sorted(tuned.last.left_out)),
        "before": _figures(figures_of(tuned.first)),
        "after": _figures(figures_of(tuned.last)),
        "changes": [
            {"what": list[Json](each.what), "before": _figures(each.before), "after": _figures(each.after)}
            for each in tuned.changes
        ],
        "wanting": [dict[str, Json](asdict(reason)) for reason in reasons],
        "residues": dict[str, Json](_residues(tuned.last)),
        "diff": diff,
    }


def _figures(figures: Figures) -> dict[str, Json]:
    return {
        "components_held": figures.held,
        "judgements_wanting": figures.wanting,
        "worst_residue": figures.worst_residue,
        "seconds": figures.seconds,
        "litres": figures.litres,
    }


def _residues(outcome: Outcome) -> dict[str, float]:
    return {name: float(f"{share:.6g}") for name, share in outcome.residues.items()}
