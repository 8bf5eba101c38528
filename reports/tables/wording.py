"""Numbers, times, lists of names, and counts of findings in words."""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from math import isinf
from typing import TYPE_CHECKING

from specs.finding import Finding, Severity

if TYPE_CHECKING:
    from cleaning.verdicts.results import Number

SEVERITY_WORDS: dict[Severity, str] = {"error": "Errors", "warning": "Warnings", "info": "Notes"}
_NAME = r"[^\s+/]*[^\s+/.,:;]"
_GROUP = re.compile(rf"(?P<first>{_NAME}\+{_NAME})(?P<rest>(?:\+{_NAME}){{2,}})")
_LEAST = 1e-3
"""Below it the digits of a number mean nothing."""


def amount(count: int, noun: str, plural: str = "") -> str:
    """Count things: ``no moves``, ``1 move``, ``44,712 moves``."""
    named = noun if count == 1 else plural or f"{noun}s"
    return f"{count:,} {named}" if count else f"no {named}"


def clock(seconds: float) -> str:
    """Seconds as a person reads them: ``42.3 s`` or ``7 min 11 s``."""
    if round(seconds, 1) < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    return f"{whole // 60} min {whole % 60:02d} s"


def shorten(text: str) -> str:
    """Name the first two members of a group and count the others: ``U1+C4+37 more``."""
    return _GROUP.sub(lambda found: f"{found['first']}+{found['rest'].count('+')} more", text)


def name_some(names: Sequence[str], most: int) -> str:
    """List names; those beyond a number are counted."""
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def short_number(value: float) -> str:
    """Three digits of a number; ``under 0.001`` for next to nothing."""
    if 0 < value < _LEAST:
        return f"under {_LEAST:g}"
    if isinf(value):
        return "∞"
    return f"{value:,.0f}" if 1000 <= abs(value) < 1e9 else f"{value:.3g}"


def number_text(number: "Number", highest: "Number | None" = None) -> str:
    """A number with its unit and its limit, or the range from it to the highest."""
    last = highest or number
    limit = "" if number.limit is None or last.limit is None else f" (limit {_range(number.limit, last.limit)})"
    return f"{number.name} {_range(number.value, last.value)} {number.unit}".rstrip() + limit


def _range(low: float, high: float) -> str:
    first, last = short_number(low), short_number(high)
    return first if first == last else f"{first} to {last}"


def tally(findings: Iterable[Finding]) -> str:
    """Number of findings by severity, such as ``2 warnings, 15 notes``."""
    counts = Counter(finding.severity for finding in findings)
    nouns = {severity: word.lower().removesuffix("s") for severity, word in SEVERITY_WORDS.items()}
    return ", ".join(amount(counts[each], noun) for each, noun in nouns.items() if counts[each]) or "no findings"
