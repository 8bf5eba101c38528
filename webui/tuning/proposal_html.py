"""A proposal as HTML: totals, changes with effect and cost, the diff, and the open requirements."""

from html import escape

from reports.tables.wording import clock
from rulesengine.tuning.report import Reason, explain, is_unfinished
from rulesengine.tuning.trial.outcome import Figures
from rulesengine.tuning.trial.request import AcceptedChange, TuningResult
from rulesengine.tuning.variables.recipe_edits import recipe_diff
from webui.theme.html import box_html, quiet_html
from webui.theme.palette import ACCENT, QUIET, to_hex
from webui.tuning.quick_fix import Fix

_MOST_REASONS = 40
_ARROW = "\N{RIGHTWARDS ARROW}"
_ADDED, _REMOVED = ("#e8f3ea", "#1f6b34"), ("#fbebea", "#9a2a20")
_TABLE = "border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums"
_RIGHT = "text-align:right;white-space:nowrap;padding:1px 0 1px 14px;vertical-align:top"


def headline_of(tuned: TuningResult) -> str:
    """Result of tuning in one sentence."""
    if not tuned.within_limits:
        return "The limits cannot be kept with what may be changed."
    if tuned.last.clean:
        saved = tuned.first.clean and tuned.changes
        return "Predicted clean, and shorter than before." if saved else "Predicted clean."
    if not tuned.changes:
        return "Nothing was found that is better."
    return "Better, and not clean yet."


def totals_html(tuned: TuningResult) -> str:
    """Totals of the recipe before and after."""
    before, after = tuned.first.figures, tuned.last.figures
    rows = (
        (
            "Clean parts",
            f"{before.clean_components} of {tuned.first.total}",
            f"{after.clean_components} of {tuned.last.total}",
        ),
        ("Open requirements", f"{before.open_requirements}", f"{after.open_requirements}"),
        ("Most residue", _percent(before.worst_residue), _percent(after.worst_residue)),
        ("Time", clock(before.seconds), clock(after.seconds)),
        ("Sprayed", f"{before.litres:.2f} l", f"{after.litres:.2f} l"),
    )
    head = _row(("", "before", "after"), to_hex(QUIET))
    return box_html(
        f'<div style="font-weight:600;font-size:14px">{headline_of(tuned)}</div>'
        f'<div style="color:{to_hex(QUIET)};font-size:11px;margin-bottom:3px">A prediction of the cleaning model after '
        f"{tuned.used} analyses; it is no proof of cleanliness. Time and liquid of loops are those of once.</div>"
        f'<table style="{_TABLE}">{head}{"".join(_row(row) for row in rows)}</table>'
    )


def changes_html(changes: tuple[AcceptedChange, ...]) -> str:
    """Changes in their order, each with its own effect and cost."""
    if not changes:
        return ""
    head = _row(("Change", "open", "clean parts", "residue", "time", "liquid"), to_hex(QUIET))
    rows = "".join(_change(each) for each in changes)
    return _section("Changes, one after the other") + _rolled(
        box_html(f'<table style="{_TABLE}">{head}{rows}</table>'), "12vh"
    )


def fix_html(fix: Fix) -> str:
    """Predicted effect of one change on its part, and its cost."""
    before, after = fix.before, fix.after
    rows = (
        (fix.component, "clean" if fix.resolved else "not clean yet"),
        ("Open requirements", f"{before.open_requirements} {_ARROW} {after.open_requirements}"),
        ("Clean parts", f"{before.clean_components} {_ARROW} {after.clean_components}"),
        ("Most residue", f"{_percent(before.worst_residue)} {_ARROW} {_percent(after.worst_residue)}"),
        ("Cost", ", ".join(_cost(before, after))),
    )
    return box_html(
        f'<div style="font-weight:600;margin-top:4px;overflow-wrap:anywhere">{escape(fix.what)}</div>'
        f'<table style="{_TABLE}">{"".join(_row(row) for row in rows)}</table>'
    )


def diff_html(before: str, after: str) -> str:
    """Lines that change with those around them: removed ones in red, added ones in green."""
    lines = recipe_diff(before, after, "before", "after").splitlines()[2:]
    if not lines:
        return ""
    body = "".join(_diff_line(line) for line in lines)
    return _section("Recipe") + (
        '<div data-diff style="margin:2px 12px 4px;max-height:18vh;overflow:auto;border:1px solid #e3e7ea;'
        "border-radius:4px;font-family:ui-monospace,monospace;font-size:11.5px;line-height:1.5;white-space:pre;"
        f'tab-size:2"><div style="min-width:max-content">{body}</div></div>'
    )


def reasons_html(tuned: TuningResult) -> str:
    """Open requirement of each part that is not clean yet, and why the recipe cannot be tuned further for it."""
    reasons = explain(tuned)
    if not reasons:
        return ""
    rows = "".join(_reason(reason) for reason in reasons[:_MOST_REASONS])
    more = len(reasons) - _MOST_REASONS
    rest = f'<div style="color:{to_hex(QUIET)}">and {more} more</div>' if more > 0 else ""
    hint = (
        quiet_html("With a higher limit under Analyses at most, tuning may find more.") if is_unfinished(tuned) else ""
    )
    return _section("Not met yet, and why") + _rolled(box_html(f"{rows}{rest}"), "11vh") + hint


def _reason(reason: Reason) -> str:
    return (
        f'<div style="margin-top:4px;padding-left:7px;border-left:3px solid {to_hex(ACCENT)}">'
        f'<span style="color:{to_hex(ACCENT)};font-weight:600">{escape(reason.component)}</span> '
        f'<span style="color:{to_hex(QUIET)}">{reason.rule} {escape(reason.name)}</span> '
        f'{escape(reason.because)} <span style="color:{to_hex(QUIET)}">{escape(reason.why)}</span></div>'
    )


def _change(change: AcceptedChange) -> str:
    before, after = change.before, change.after
    clean = f"{before.clean_components} {_ARROW} {after.clean_components}"
    residue = f"{_percent(before.worst_residue)} {_ARROW} {_percent(after.worst_residue)}"
    time, litres = _cost(before, after)
    unmet = f"{before.open_requirements} {_ARROW} {after.open_requirements}"
    return _row(("\n".join(change.what), unmet, clean, residue, time, litres))


def _cost(before: Figures, after: Figures) -> tuple[str, str]:
    """Additional time and liquid."""
    return f"{after.seconds - before.seconds:+.1f} s", f"{after.litres - before.litres:+.2f} l"


def _row(texts: tuple[str, ...], colour: str = "inherit") -> str:
    first, *rest = texts
    cells = "".join(f'<td style="{_RIGHT}">{escape(text)}</td>' for text in rest)
    name = "<br>".join(escape(line) for line in first.splitlines())
    return f'<tr style="color:{colour}"><td style="overflow-wrap:anywhere">{name}</td>{cells}</tr>'


def _diff_line(line: str) -> str:
    if line.startswith("@@"):
        begin = line.split("+")[1].split(",")[0].split(" ")[0]
        return f'<div style="color:{to_hex(QUIET)};background:#f4f6f7;padding:0 8px">line {begin}</div>'
    ground, ink = {"+": _ADDED, "-": _REMOVED}.get(line[:1], ("transparent", "inherit"))
    return f'<div style="background:{ground};color:{ink};padding:0 8px">{escape(line)}</div>'


def _rolled(inner: str, height: str) -> str:
    """Keep long lists from pushing what follows out of the window."""
    return f'<div style="max-height:{height};overflow-y:auto">{inner}</div>'


def _section(title: str) -> str:
    return f'<div style="margin:8px 12px 0;font-size:12px;font-weight:600">{title}</div>'


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"
