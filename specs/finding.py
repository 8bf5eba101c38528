"""Results that a person should look at."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from specs.errors import printable
from specs.json import Json
from specs.source import NO_SOURCE, Source

Severity: TypeAlias = Literal["error", "warning", "info"]

_RANK: dict[Severity, int] = {"error": 0, "warning": 1, "info": 2}


@dataclass(frozen=True, slots=True)
class FindingRule:
    """What one check looks for. All of them are in ``specs/finding_rules.py``."""

    id: str
    """Name in kebab-case, as reports, lists and ``--allow`` have it."""
    severity: Severity
    """Severity of its findings; an ``error`` blocks the export unless the user overrides the rule by name."""
    meaning: str
    """What a finding of it states, in the words of the page's table."""
    page: str
    """Page of ``docs`` whose table lists it."""
    also: Severity | None = None
    """The other severity, of a rule whose findings differ in weight."""
    verdict: str = ""
    """Rule of the cleaning model, such as ``"R7"``, if a finding reports its verdict."""

    def __str__(self) -> str:
        """Give the id."""
        return self.id


@dataclass(frozen=True, slots=True)
class Finding:
    """What a check saw; never raised.

    It sits below the nouns because a board, a recipe and a program may each have some (``docs/adr/0001``).
    """

    rule: FindingRule
    message: str
    """What was seen, with numbers, and what to do about it."""
    made_by: Source = NO_SOURCE
    """What in the recipe caused it, such as ``"sequence[0]/around/U12"``; empty for the board's own."""
    where: tuple[float, float, float] | None = None
    """Place in the board frame, mm; ``None`` where there is no one place."""
    override: Severity | None = None
    """Severity of this finding where it is not the rule's."""

    def __post_init__(self) -> None:
        """Escape in the message what would break its line: it quotes names of files and of what is in them."""
        object.__setattr__(self, "message", printable(self.message))

    @property
    def severity(self) -> Severity:
        """Severity of this finding: the rule's, unless it is overridden."""
        return self.override or self.rule.severity

    def record(self) -> dict[str, str]:
        """Give what a table of findings shows."""
        return {
            "severity": self.severity, "rule": self.rule.id, "message": self.message, "made by": str(self.made_by)
        }  # fmt: skip


def worst_first(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Errors, then warnings, then notes; within a severity in the order in which they were found."""
    return tuple(sorted(findings, key=lambda finding: _RANK[finding.severity]))


def grouped_findings(findings: Sequence[Finding]) -> list[tuple[Finding, int]]:
    """Give the first of each rule and severity, and how many there are; worst first as given."""
    counts = Counter((finding.severity, finding.rule.id) for finding in findings)
    firsts: dict[tuple[str, str], Finding] = {}
    for finding in findings:
        firsts.setdefault((finding.severity, finding.rule.id), finding)
    return [(finding, counts[key]) for key, finding in firsts.items()]


def finding_data(finding: Finding) -> dict[str, Json]:
    """Give a finding as plain data for a report, its place to a tenth of a micrometre."""
    return {
        "rule": finding.rule.id,
        "severity": finding.severity,
        "message": finding.message,
        "made_by": str(finding.made_by),
        "where": None if finding.where is None else list[Json](round(value, 4) for value in finding.where),
    }


def blocking(findings: Sequence[Finding], allowed: Sequence[str]) -> list[Finding]:
    """Findings that forbid an export: errors whose rule the user has not allowed by name."""
    return [finding for finding in findings if finding.severity == "error" and finding.rule.id not in allowed]
