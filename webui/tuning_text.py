"""What the page says of a proposal: totals, changes with effect and cost, the diff, and what is still wanting."""

import difflib
from html import escape

from rulesengine.summary import clock
from rulesengine.tuning.goals import Want
from rulesengine.tuning.tuned import Change, Figures, Tuned, figures_of
from webui.cleaning_list import box_html
from webui.palette import ACCENT, QUIET, to_hex
from webui.verdict_colours import VERDICT_COLOURS

_AROUND = 2
"""Lines of the recipe that are shown to each side of a change."""
_MOST_WANTS = 40
_ADDED, _REMOVED = ("#e8f3ea", "#1f6b34"), ("#fbebea", "#9a2a20")
_TABLE = "border-collapse:collapse;width:100%;font-variant-numeric:tabular-nums"
_RIGHT = "text-align:right;white-space:nowrap;padding:1px 0 1px 14px;vertical-align:top"


def headline_of(tuned: Tuned) -> str:
    """Say in one sentence what came of tuning."""
    if not tuned.within:
        return "The limits cannot be kept with what may be changed."
    if tuned.last.clean:
        saved = tuned.first.clean and tuned.changes
        return "Predicted clean, and shorter than before." if saved else "Predicted clean."
    if not tuned.changes:
        return "Nothing was found that is better."
    return "Better, and not clean yet."


def totals_html(tuned: Tuned) -> str:
    """Lay out what the recipe comes to before and after."""
    before, after = figures_of(tuned.first), figures_of(tuned.last)
    rows = (
        ("Parts that lack nothing", f"{before.held} of {tuned.first.total}", f"{after.held} of {tuned.last.total}"),
        ("Judgements to go", f"{before.wanting}", f"{after.wanting}"),
        ("Most residue", _percent(before.worst_residue), _percent(after.worst_residue)),
        ("Time", clock(before.seconds), clock(after.seconds)),
        ("Sprayed", f"{before.litres:.2f} l", f"{after.litres:.2f} l"),
    )
    head = _row(("", "before", "after"), to_hex(QUIET))
    return box_html(
        f'<div style="font-weight:600;font-size:14px">{headline_of(tuned)}</div>'
        f'<div style="color:{to_hex(QUIET)};font-size:11px;margin-bottom:3px">A prediction of the cleaning model after '
        f"{tuned.used} analyses; it is no proof of cleanliness. Loops count once.</div>"
        f'<table style="{_TABLE}">{head}{"".join(_row(row) for row in rows)}</table>'
    )


def changes_html(changes: tuple[Change, ...]) -> str:
    """List changes in their order, each with what it did by itself: effect and cost."""
    if not changes:
        return ""
    head = _row(("Change", "to go", "lack nothing", "residue", "time", "liquid"), to_hex(QUIET))
    rows = "".join(_change(each) for each in changes)
    return _section("Changes, one after the other") + _rolled(
        box_html(f'<table style="{_TABLE}">{head}{rows}</table>'), "20vh"
    )


def cost_text(before: Figures, after: Figures) -> tuple[str, str]:
    """Say how much longer it takes, and how much more it sprays."""
    return f"{after.seconds - before.seconds:+.1f} s", f"{after.litres - before.litres:+.2f} l"


def diff_html(before: str, after: str) -> str:
    """Show the lines that change with those around them, what is taken out in red and what comes in green."""
    lines = list(difflib.unified_diff(before.splitlines(), after.splitlines(), lineterm="", n=_AROUND))[2:]
    if not lines:
        return ""
    body = "".join(_diff_line(line) for line in lines)
    return _section("Recipe") + (
        '<div data-diff style="margin:2px 12px 4px;max-height:26vh;overflow:auto;border:1px solid #e3e7ea;'
        "border-radius:4px;font-family:ui-monospace,monospace;font-size:11.5px;line-height:1.5;white-space:pre;"
        f'tab-size:2"><div style="min-width:max-content">{body}</div></div>'
    )


def wants_html(tuned: Tuned) -> str:
    """Say what is still wanting and why: the judgements of the best recipe, what ended the search."""
    wants = tuned.last.wants
    if not wants:
        return ""
    ended = f"No analysis was left of {tuned.used}: allow more of them." if tuned.spent else _EXHAUSTED
    rows = "".join(_want(want) for want in wants[:_MOST_WANTS])
    more = len(wants) - _MOST_WANTS
    rest = f'<div style="color:{to_hex(QUIET)}">and {more} more</div>' if more > 0 else ""
    return _section("Still wanting") + _rolled(box_html(f"{ended}{rows}{rest}"), "18vh")


def _want(want: Want) -> str:
    judgement = want.judgement
    colour = to_hex(VERDICT_COLOURS[judgement.verdict])
    return (
        f'<div style="margin-top:4px;padding-left:7px;border-left:3px solid {colour}">'
        f'<span style="color:{to_hex(ACCENT)};font-weight:600">{escape(want.component)}</span> '
        f'<span style="color:{to_hex(QUIET)}">{judgement.rule} {escape(judgement.name)}</span> '
        f"{escape(judgement.because)}</div>"
    )


def _change(change: Change) -> str:
    before, after = change.before, change.after
    held = f"{before.held} \N{RIGHTWARDS ARROW} {after.held}"
    residue = f"{_percent(before.worst_residue)} \N{RIGHTWARDS ARROW} {_percent(after.worst_residue)}"
    time, litres = cost_text(before, after)
    wanting = f"{before.wanting} \N{RIGHTWARDS ARROW} {after.wanting}"
    return _row(("\n".join(change.what), wanting, held, residue, time, litres))


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


_EXHAUSTED = "None of the changes that are allowed takes more of this away."
