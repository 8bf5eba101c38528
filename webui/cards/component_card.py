"""What the page says of one component, and of a board: cards as HTML."""

from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape

from boards.board import Board, Component
from programs.plan import Dwell, Plan
from recipes.recipe import Recipe
from reports.tables.run_report import board_facts
from rulesengine.strokes.classify import Classified
from specs.finding import Finding, worst_first
from webui.cards.component_list import findings_about
from webui.cards.finding_list import tally
from webui.cards.recipe_location import yaml_path
from webui.layers.paths.strokes import StrokeLine
from webui.page.session import Session
from webui.theme.palette import ACCENT, INK, QUIET, to_hex
from webui.theme.verdict_colours import SEVERITY_COLOURS

_MOST_FINDINGS = 5
_UNSAID = "sha256"
"""A fingerprint tells an engineer nothing."""
_LATER = "\N{HORIZONTAL ELLIPSIS}"
_DOT = " \N{MIDDLE DOT} "


def component_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Say what is known of the selected component; what to do where none is.

    Args:
        session: Says which one.
        lines: The strokes of its run.
    """
    name = session.selection.component
    component = next((each for each in session.board.components if each.name == name), None)
    if component is None:
        return _box(f'<span style="color:{to_hex(QUIET)}">Click a part in the picture, or choose one above.</span>')
    run = session.run
    known = None if run is None else next((each for each in run.classified if each.component == name), None)
    facts = _facts(component, known)
    if run is not None:
        facts["Served by"] = "\n".join(_passes(name, lines, run.recipe)) or "no pass of its own"
        pauses = _pauses(name, run.plan)
        facts |= {"Pauses": f"{len(pauses)}, together {sum(pauses):.1f} s"} if pauses else {}
    findings = session.board.findings if run is None else run.findings
    said = findings_html(findings_about(findings, [component]).get(name, []))
    return _box(_title(name) + facts_html(facts.items()) + said)


def board_html(board: Board) -> str:
    """Say what was understood of a board, and what was found on the way."""
    facts = {name.capitalize(): value for name, value in board_facts(board).items() if name != _UNSAID}
    facts["Findings"] = tally(board.findings)
    return _box(_title(board.name) + facts_html(facts.items()) + findings_html(worst_first(board.findings)))


def facts_html(facts: Iterable[tuple[str, str]]) -> str:
    """Write two columns: what it is, and what there is to say, line by line."""
    rows = "".join(
        f'<tr style="vertical-align:top"><td style="color:{to_hex(QUIET)};padding-right:10px;white-space:nowrap">'
        f'{escape(name)}</td><td style="overflow-wrap:anywhere">'
        f"{'<br>'.join(map(escape, value.splitlines()))}</td></tr>"
        for name, value in facts
    )
    return f'<table style="border-collapse:collapse;font-size:12px">{rows}</table>'


def findings_html(findings: Sequence[Finding], most: int = _MOST_FINDINGS) -> str:
    """Write the first findings, and how many more there are."""
    shown = "".join(
        f'<div style="margin-top:4px;padding-left:7px;border-left:3px solid {SEVERITY_COLOURS[finding.severity]};'
        f'overflow-wrap:anywhere">{escape(finding.message)}</div>'
        for finding in findings[:most]
    )
    more = len(findings) - most
    return shown + (f'<div style="color:{to_hex(QUIET)}">and {more} more</div>' if more > 0 else "")


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
        "Height": f"{component.height_mm:.2f} mm, {component.side} side",
        "Pins": f"{component.pins}, {component.pins_source}",
        "Standoff": gap,
        "Neighbours": "\n".join(near) or "none on its side",
    }
    return {name: value for name, value in facts.items() if value}


def _passes(name: str, lines: Sequence[StrokeLine], recipe: Recipe) -> list[str]:
    """Say how often each maker of strokes goes around a component, in the order of the program."""
    laps: Counter[str] = Counter()
    speeds: dict[str, float] = {}
    for line in lines:
        if name in _group(line.made_by):
            laps[line.made_by] = max(laps[line.made_by], line.laps)
            speeds[line.made_by] = line.speed_mm_s
    return [_pass(made_by, count, speeds[made_by], name, recipe) for made_by, count in laps.items()]


def _pass(made_by: str, laps: int, speed_mm_s: float, name: str, recipe: Recipe) -> str:
    others = [each for each in _group(made_by) if each != name]
    along = f", with {', '.join(others[:3])}{' and more' if len(others) > 3 else ''}" if others else ""
    count = f"{laps} passes" if laps > 1 else "1 pass"
    return f"{_place(made_by, recipe)}{_DOT}{count} at {speed_mm_s:g} mm/s{along}"


def _place(made_by: str, recipe: Recipe) -> str:
    """Name step, function and template, such as ``1 clean · around``."""
    step, template = made_by.split("/")[:2]
    number = yaml_path(recipe, step)[1]
    function = recipe.sequence[number].function if isinstance(number, int) else ""
    return f"{int(number) + 1} {function}{_DOT}{template}"


def _pauses(name: str, plan: Plan) -> list[float]:
    """Seconds of each pause that was asked for at this component's edges."""
    return [item.duration_s for item in plan.items if isinstance(item, Dwell) and name in _group(item.made_by)]


def _group(made_by: str) -> list[str]:
    """Components that a maker stands for, as in ``"sequence[0]/around/U12+U13"``."""
    parts = made_by.split("/")
    return parts[2].split("+") if len(parts) > 2 else []


def _title(text: str) -> str:
    return f'<div style="font-weight:600;color:{to_hex(ACCENT)};overflow-wrap:anywhere">{escape(text)}</div>'


def _box(inner: str) -> str:
    return f'<div style="margin:0 12px 4px;font-size:12px;color:{to_hex(INK)};line-height:1.45">{inner}</div>'
