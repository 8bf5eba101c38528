"""The list of components: which fit a filter, those with findings first."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from boards.board import Component
from reports.tables.table import Column, Table, Text
from specs.finding import Finding, Severity
from webui.cards.boxes import quiet_html
from webui.cards.table import listing_html
from webui.page.session import Session

_WILD = "*?["
_WORD = re.compile(r"[^\s+/,;:()'\"]+")
_COLUMNS = (
    Column("Part", width="18%"),
    Column("Package", width="37%"),
    Column("Class", width="24%"),
    Column("Height", "right", width="21%"),
)


@dataclass(frozen=True, slots=True)
class Row:
    """One component in the list."""

    component: Component
    component_class: str
    """Empty before the first run."""
    worst: Severity | None
    """Of the errors and warnings about it."""


def list_rows(session: Session, wanted: str) -> list[Row]:
    """Components whose name, package or class holds a text or matches a shell pattern; the worst first.

    Components with errors come first, then those with warnings; otherwise they stay in the order of the file.
    """
    run = session.run
    classes = {} if run is None else {each.component: each.component_class for each in run.classified}
    findings = session.board.findings if run is None else run.findings
    said = findings_about([each for each in findings if each.severity != "info"], session.board.components)
    rows = [Row(each, classes.get(each.name, ""), _worst(said.get(each.name, []))) for each in session.board.components]
    kept = [row for row in rows if _fits(row, wanted.strip().casefold())]
    return sorted(kept, key=lambda row: _RANK[row.worst])


def findings_about(findings: Iterable[Finding], components: Iterable[Component]) -> dict[str, list[Finding]]:
    """Findings by the component they are about: its pass made them, or their message names it."""
    names = {component.name for component in components}
    about: dict[str, list[Finding]] = {}
    for finding in findings:
        parts = finding.made_by.split("/")
        words = {word.rstrip(".") for word in _WORD.findall(finding.message)}
        named = {word for word in words if any(sign.isdigit() for sign in word)}  # a part called "side" is no word
        for name in ({*parts[2].split("+")} if len(parts) > 2 else named) & names:
            about.setdefault(name, []).append(finding)
    return about


def rows_html(rows: Sequence[Row], selected: str) -> str:
    """Write the list as a table; a long one says how many more there are."""
    if not rows:
        return quiet_html("No component fits. Clear the filter to see all.")
    cells = [
        (
            Text(row.component.name, tone=row.worst),
            row.component.package,
            row.component_class,
            f"{row.component.height_mm:.2f} mm",
        )
        for row in rows
    ]
    return listing_html(Table(_COLUMNS, tuple(cells)), selected, height="34vh", more="more; filter to see them")


_RANK: dict[Severity | None, int] = {"error": 0, "warning": 1, "info": 2, None: 2}


def _worst(findings: Sequence[Finding]) -> Severity | None:
    return min((finding.severity for finding in findings), key=lambda severity: _RANK[severity], default=None)


def _fits(row: Row, wanted: str) -> bool:
    texts = [text.casefold() for text in (row.component.name, row.component.package, row.component_class)]
    if any(sign in wanted for sign in _WILD):
        return any(fnmatchcase(text, wanted) for text in texts)
    return any(wanted in text for text in texts)
