"""Results that a person should look at."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from specs.json import Json

Severity: TypeAlias = Literal["error", "warning", "info"]

_RANK: dict[Severity, int] = {"error": 0, "warning": 1, "info": 2}


@dataclass(frozen=True, slots=True)
class Finding:
    """What a check saw; never raised.

    It sits below the nouns because a board, a recipe and a program may each have some (``docs/adr/0002``).
    """

    rule: str
    """Name of the check in kebab-case, such as ``"speed-below-asked"``."""
    severity: Severity
    """An ``error`` blocks the export unless the user overrides its rule by name."""
    message: str
    """What was seen, with numbers, and what to do about it."""
    made_by: str = ""
    """Recipe path that asked for it, such as ``"sequence[0]/around/U12"``; empty for the board's own."""
    where: tuple[float, float, float] | None = None
    """Place in the board frame, mm; ``None`` where there is no one place."""


def worst_first(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Errors, then warnings, then notes; within a severity in the order in which they were found."""
    return tuple(sorted(findings, key=lambda finding: _RANK[finding.severity]))


def finding_data(finding: Finding) -> dict[str, Json]:
    """Give a finding as plain data for a report, its place to a tenth of a micrometre."""
    return {
        "rule": finding.rule,
        "severity": finding.severity,
        "message": finding.message,
        "made_by": finding.made_by,
        "where": None if finding.where is None else list[Json](round(value, 4) for value in finding.where),
    }


def blocking(findings: Sequence[Finding], allowed: Sequence[str]) -> list[Finding]:
    """Findings that forbid an export: errors whose rule the user has not allowed by name."""
    return [finding for finding in findings if finding.severity == "error" and finding.rule not in allowed]
