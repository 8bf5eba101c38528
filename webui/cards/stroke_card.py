"""The card of the selected stroke."""

from collections.abc import Sequence

from webui.cards.finding_list import messages_html
from webui.cards.recipe_location import recipe_line
from webui.layers.paths.strokes import StrokeLine
from webui.layers.paths.timeline import clock, spray_spans
from webui.page.session import Session
from webui.theme.html import box_html, facts_html, grey_html, name_html

_MOST_FINDINGS = 4


def card_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Card of the selected stroke: its recipe line, speed, height, tilt, time and findings."""
    chosen = [line for line in lines if line.made_by == session.selection.made_by]
    if session.run is None or not chosen:
        return box_html(grey_html("No stroke is selected. Click one, or go through them in order."))
    made_by = chosen[0].made_by
    facts = _facts(session, chosen)
    spans = [span for span in spray_spans(session.run.program) if span.made_by == made_by]
    if spans:
        duration_s = sum(span.end_s - span.begin_s for span in spans)
        facts["Time"] = f"{clock(duration_s)}, from {clock(spans[0].begin_s)} on"
    found = messages_html([each for each in session.run.findings if each.made_by == made_by], _MOST_FINDINGS)
    names = filter(None, [made_by.template, "+".join(made_by.components), made_by.motion])
    title = " \N{MIDDLE DOT} ".join(names) or str(made_by)
    return box_html(name_html(title) + facts_html(facts) + found)


def _facts(session: Session, chosen: Sequence[StrokeLine]) -> dict[str, str]:
    first = chosen[0]
    surface = session.board.surface_z_mm(first.side)
    heights = [abs(float(z) - surface) for line in chosen for z in (line.points[:, 2].min(), line.points[:, 2].max())]
    spec = session.recipe.templates.get(first.template)
    facts = {
        "Recipe": recipe_line(session.loaded, first.made_by),
        "Path": spec.path.replace("_", " ") if spec is not None else first.template,
        "Function": f"{first.function}, nozzle {first.nozzle}, {first.side} side",
        "Speed": _range([line.speed_mm_s for line in chosen], " mm/s"),
        "Height": _range(heights, " mm"),
        "Tilt": _range([line.tilt_deg for line in chosen], "\N{DEGREE SIGN}"),
        "Passes": _range([float(line.laps) for line in chosen], ""),
    }
    pauses = sum(line.pauses for line in chosen)
    if pauses:
        facts["Pauses"] = f"{pauses}, together {sum(line.paused_s for line in chosen):.1f} s"
    strokes = f" in {len(chosen)} strokes" if len(chosen) > 1 else ""
    return facts | {"Length": f"{sum(line.length_mm for line in chosen):.0f} mm{strokes}"}


def _range(values: Sequence[float], unit: str) -> str:
    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
    return f"{low}{unit}" if low == high else f"{low} to {high}{unit}"
