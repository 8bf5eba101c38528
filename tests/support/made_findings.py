"""Findings of rules that do not exist, or that do, with any severity."""

from specs.finding import Finding, FindingRule, Severity
from specs.finding_rules import FINDING_RULES
from specs.source import Source


def made_finding(
    rule: str,
    severity: Severity,
    message: str = "",
    made_by: Source | str = "",
    where: tuple[float, float, float] | None = None,
) -> Finding:
    """Give a finding of a rule by its id, registered or made up; ``r7-residue`` reports a verdict of R7."""
    verdict = rule.partition("-")[0].upper()
    made_up = FindingRule(
        rule, severity, "", "", verdict=verdict if verdict[:1] == "R" and verdict[1:].isdigit() else ""
    )
    return Finding(FINDING_RULES.get(rule, made_up), message, Source.parse(str(made_by)), where, severity)
