"""What the page says of components, as HTML: the list, the card of one, the card of the board."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from html import escape

from boards.board import Board, Component
from geometry.finding import Finding
from rulesengine.classify import Classified
from rulesengine.report import board_facts
from rulesengine.served import served_by
from webui.session import Session

_MOST_ROWS = 150
_WORST = {"error": 0, "warning": 1, "info": 2}
_WILD = "*?["
_CELL = "padding:2px 8px 2px 0;vertical-align:top"
_QUIET = "color:#7b8790"


@dataclass(frozen=True, slots=True)
class Row:
    """One component in the list."""

    component: Component
    component_class: str
    findings: int
    """Warnings and errors that name it."""


def list_rows(session: Session, wanted: str) -> list[Row]:
    """Components whose name, package or class holds a text or matches a shell pattern; those with findings first."""
    run = session.run
    classes = {} if run is None else {each.component: each.component_class for each in run.classified}
    counts = _findings_by_name(() if run is None else run.findings)
    rows = [Row(each, classes.get(each.name, ""), counts.get(each.name, 0)) for each in session.board.components]
    kept = [row for row in rows if _fits(row, wanted.strip().lower())]
    return sorted(kept, key=lambda row: -min(row.findings, 1))


def rows_html(rows: Sequence[Row]) -> str:
    """The list."""
    if not rows:
        return _note("No component fits; clear the filter to see all.")
    head = "".join(f"<th style='{_CELL};{_QUIET};text-align:left;font-weight:400'>{name}</th>" for name in _HEADINGS)
    body = "".join(_row(row) for row in rows[:_MOST_ROWS])
    more = _note(f"and {len(rows) - _MOST_ROWS} more; filter to see them") if len(rows) > _MOST_ROWS else ""
    table = f"<table style='border-collapse:collapse;font-size:12px'><tr>{head}</tr>{body}</table>"
    return f"<div style='max-height:38vh;overflow:auto;padding:0 12px'>{table}</div>{more}"


def component_html(session: Session, name: str) -> str:
    """The card of one component; what to do where none is chosen."""
    component = next((each for each in session.board.components if each.name == name), None)
    if component is None:
        return _note("Click a part in the picture, or choose one above.")
    run = session.run
    known = None if run is None else next((each for each in run.classified if each.component == name), None)
    served = [] if run is None else served_by(run.plan.items).get(name, [])
    facts = [*_facts(component, known), ("served by", _listed(served) if run is not None else "…")]
    said = [] if run is None else [each for each in run.findings if name in _names(each)]
    findings = "".join(f"<div style='margin-top:6px'>{escape(each.message)}</div>" for each in said[:3])
    return f"<div style='padding:0 12px;font-size:13px'><b>{escape(name)}</b>{facts_html(facts)}{findings}</div>"


def board_html(board: Board) -> str:
    """What was understood of a board, and what was found on the way."""
    worst = sorted(board.findings, key=lambda each: _WORST[each.severity])
    said = "".join(
        f"<div style='margin-top:6px'><span style='{_QUIET}'>{each.severity}</span> {escape(each.message)}</div>"
        for each in worst[:6]
    )
    more = f"<div style='{_QUIET}'>and {len(worst) - 6} more findings</div>" if len(worst) > 6 else ""
    facts = facts_html(board_facts(board).items())
    return f"<div style='padding:0 12px;font-size:13px'><b>{escape(board.name)}</b>{facts}{said}{more}</div>"


def facts_html(facts: Iterable[tuple[str, str]]) -> str:
    """Two columns: what it is, and what there is to say."""
    rows = "".join(
        f"<tr><td style='{_CELL};{_QUIET};white-space:nowrap'>{escape(name)}</td>"
        f"<td style='{_CELL};overflow-wrap:anywhere'>{escape(value)}</td></tr>"
        for name, value in facts
    )
    return f"<table style='border-collapse:collapse'>{rows}</table>"


_HEADINGS = ("part", "package", "class", "h mm")


def _facts(component: Component, known: Classified | None) -> list[tuple[str, str]]:
    x_min, y_min, x_max, y_max = component.footprint.bounds
    gap = "unknown" if component.standoff_mm is None else f"{component.standoff_mm:.3f} mm, {component.standoff_source}"
    near = ", ".join(f"{name} {distance:.2f} mm" for name, distance in component.neighbours[:3])
    return [
        ("package", component.package or "unknown"),
        *([("value", component.value)] if component.value else []),
        ("class", "…" if known is None else known.component_class),
        ("because", "…" if known is None else known.because),
        ("size", f"{x_max - x_min:.2f} x {y_max - y_min:.2f} x {component.height_mm:.2f} mm"),
        ("side", component.side),
        ("pins", f"{component.pins} ({component.pins_source})"),
        ("standoff", gap),
        ("nearest", near or "alone on its side"),
    ]


def _row(row: Row) -> str:
    mark = "font-weight:600;color:#c8442c" if row.findings else ""
    cells = (row.component.name, row.component.package, row.component_class, f"{row.component.height_mm:.2f}")
    styles = (mark, "max-width:120px;overflow:hidden;text-overflow:ellipsis;white-space:nowrap", "", "text-align:right")
    return (
        "<tr>"
        + "".join(f"<td style='{_CELL};{style}'>{escape(cell)}</td>" for cell, style in zip(cells, styles, strict=True))
        + "</tr>"
    )


def _fits(row: Row, wanted: str) -> bool:
    texts = (row.component.name.lower(), row.component.package.lower(), row.component_class.lower())
    if any(sign in wanted for sign in _WILD):
        return any(fnmatchcase(text, wanted) for text in texts)
    return any(wanted in text for text in texts)


def _findings_by_name(findings: Sequence[Finding]) -> dict[str, int]:
    counts: dict[str, int] = {}
    for finding in findings:
        if finding.severity != "info":
            for name in _names(finding):
                counts[name] = counts.get(name, 0) + 1
    return counts


def _names(finding: Finding) -> list[str]:
    """Components that the maker of a finding stands for."""
    parts = finding.made_by.split("/")
    return parts[2].split("+") if len(parts) > 2 else []


def _listed(places: Sequence[str]) -> str:
    return ", ".join(places) if places else "no pass of its own"


def _note(text: str) -> str:
    return f"<div style='padding:2px 12px;font-size:13px;{_QUIET}'>{escape(text)}</div>"
