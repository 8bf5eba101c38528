"""Components of a board: the list, and the card of one."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

from boards.board import STATED_HEIGHT, Component
from programs.plan import Dwell
from recipes.recipe import Recipe
from reports.tables.table import Column, Table, Text
from rulesengine.strokes.classify import Classified
from specs.finding import Finding, Severity, worst_first
from specs.source import Source
from webui.cards.finding_list import messages_html
from webui.layers.paths.strokes import StrokeLine
from webui.page.session import Session
from webui.theme.html import box_html, facts_html, grey_html, listing_html, name_html, quiet_html

_MOST_FINDINGS = 5
_LATER = "\N{HORIZONTAL ELLIPSIS}"
_DOT = " \N{MIDDLE DOT} "
_WORD = re.compile(r"[^\s+/,;:()'\"]+")
_COLUMNS = (
    Column("Part", width="16%"),
    Column("Package", width="38%"),
    Column("Class", width="25%"),
    Column("h, mm", "right", width="21%"),
)
_RANK: dict[Severity | None, int] = {"error": 0, "warning": 1, "info": 2, None: 2}


@dataclass(frozen=True, slots=True)
class Row:
    """One component in the list."""

    component: Component
    component_class: str
    """Empty before the first run."""
    worst: Severity | None
    """Of the errors and warnings about it."""


def list_rows(session: Session, pattern: str) -> list[Row]:
    """Components whose name, package or class contains a text or matches a shell pattern.

    Components with errors come first, then those with warnings; otherwise they stay in the order of the file.
    """
    run, workpiece = session.run, session.workpiece
    classes = {} if run is None else {each.component: each.component_class for each in run.classified}
    findings = workpiece.findings if run is None else run.findings
    about = findings_about([each for each in findings if each.severity != "info"], workpiece.components)
    rows = [
        Row(each, classes.get(each.name, ""), worst[0].severity if worst else None)
        for each in workpiece.components
        for worst in [worst_first(about.get(each.name, []))]
    ]
    kept = [row for row in rows if _matches(row, pattern.strip().casefold())]
    return sorted(kept, key=lambda row: _RANK[row.worst])


def findings_about(findings: Iterable[Finding], components: Iterable[Component]) -> dict[str, list[Finding]]:
    """Findings by the component they are about: a stroke around it caused them, or their message names it."""
    names = {component.name for component in components}
    about: dict[str, list[Finding]] = {}
    for finding in findings:
        words = {word.rstrip(".") for word in _WORD.findall(finding.message)}
        named = {word for word in words if any(sign.isdigit() for sign in word)}  # a part called "side" is no word
        for name in {*(finding.made_by.components or named)} & names:
            about.setdefault(name, []).append(finding)
    return about


def rows_html(rows: Sequence[Row], selected: str) -> str:
    """The list as a table."""
    if not rows:
        return quiet_html("No component fits. Clear the filter to see all.")
    cells = [
        (
            Text(row.component.name, tone=row.worst),
            row.component.package,
            row.component_class,
            f"{row.component.height_mm:.2f}",
        )
        for row in rows
    ]
    return listing_html(Table(_COLUMNS, tuple(cells)), selected, height="34vh", more="more; filter to see them")


def component_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Card of the selected component; what to do where none is selected.

    Args:
        session: With the selection.
        lines: The strokes of its run.
    """
    component, run = session.component, session.run
    if component is None:
        return box_html(grey_html("Click a part in the picture, or choose one above."))
    name = component.name
    known = None if run is None else next((each for each in run.classified if each.component == name), None)
    facts = _facts(component, known)
    if run is not None:
        facts["Served by"] = "\n".join(_passes(name, lines, run.recipe)) or "no pass of its own"
        dwells = [item for item in run.plan.items if isinstance(item, Dwell)]
        pauses = [item.duration_s for item in dwells if name in item.made_by.components]
        facts |= {"Pauses": f"{len(pauses)}, together {sum(pauses):.1f} s"} if pauses else {}
    findings = session.workpiece.findings if run is None else run.findings
    about = findings_about(findings, [component]).get(name, [])
    return box_html(name_html(name) + facts_html(facts) + messages_html(about, _MOST_FINDINGS))


def _height_words(component: Component) -> str:
    """Source of a height that the board file does not state."""
    return "" if component.height_source == STATED_HEIGHT else f", {component.height_source}"


def _facts(component: Component, known: Classified | None) -> dict[str, str]:
    x_min, y_min, x_max, y_max = component.footprint.bounds
    gap = (
        "unknown"
        if component.gap_height_mm is None
        else f"{component.gap_height_mm:.3f} mm, {component.gap_height_source}"
    )
    near = [f"{name}, {distance:.2f} mm" for name, distance in component.neighbours[:3]]
    facts = {
        "Package": component.package or "unknown",
        "Value": component.value,
        "Class": _LATER if known is None else known.component_class,
        "Because": _LATER if known is None else known.because,
        "Size": f"{x_max - x_min:.2f} x {y_max - y_min:.2f} mm, {component.area_mm2:.1f} mm2",
        "Height": f"{component.height_mm:.2f} mm, {component.side} side{_height_words(component)}",
        "Pins": f"{component.pins}, {component.pins_source}",
        "Standoff": gap,
        "Neighbours": "\n".join(near) or "none on its side",
    }
    return {name: value for name, value in facts.items() if value}


def _passes(name: str, lines: Sequence[StrokeLine], recipe: Recipe) -> list[str]:
    """Step, template, passes and speed of each stroke around a component, in the order of the program."""
    laps: dict[Source, int] = {}
    speeds: dict[Source, float] = {}
    for line in lines:
        if name in line.made_by.components:
            laps[line.made_by] = max(laps.get(line.made_by, 0), line.laps)
            speeds[line.made_by] = line.speed_mm_s
    passes: list[str] = []
    for made_by, count in laps.items():
        others = [each for each in made_by.components if each != name]
        along = f", with {', '.join(others[:3])}{' and more' if len(others) > 3 else ''}" if others else ""
        times = f"{count} passes" if count > 1 else "1 pass"
        number = made_by.step or 0
        place = f"{number + 1} {recipe.sequence[number].function}{_DOT}{made_by.template}"
        passes.append(f"{place}{_DOT}{times} at {speeds[made_by]:g} mm/s{along}")
    return passes


def _matches(row: Row, pattern: str) -> bool:
    texts = [text.casefold() for text in (row.component.name, row.component.package, row.component_class)]
    if any(sign in pattern for sign in "*?["):
        return any(fnmatchcase(text, pattern) for text in texts)
    return any(pattern in text for text in texts)
