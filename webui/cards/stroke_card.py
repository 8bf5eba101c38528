"""What the page says about strokes: legend, card, neighbours in the program."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from webui.cards.component_card import findings_html
from webui.cards.recipe_location import recipe_line
from webui.forms.cycle import step_around
from webui.layers.paths.markers import COLOURS
from webui.layers.paths.strokes import StrokeLine, Tint
from webui.layers.paths.timeline import Span, clock, spray_spans
from webui.page.session import Session
from webui.theme.palette import ACCENT, INK, QUIET, to_hex

_MOST_FINDINGS = 4


def legend_html(tints: Mapping[str, Tint]) -> str:
    """Say what colours mean."""
    shape = "width:14px;height:4px;border-radius:2px;margin-right:5px"
    return _legend_html(shape, [(tint, escape(name)) for name, tint in tints.items()])


def marker_legend_html() -> str:
    """Say what markers mean."""
    words = {"pause": "pause, larger if longer"}
    shape = "width:8px;height:8px;transform:rotate(45deg);margin:0 7px 0 3px"
    return _legend_html(shape, [(tint, words.get(kind, kind)) for kind, tint in COLOURS.items()])


def _legend_html(shape: str, items: Iterable[tuple[Tint, str]]) -> str:
    told = "".join(
        '<span style="display:inline-flex;align-items:center;margin:0 12px 2px 0">'
        f'<span style="{shape};background:{to_hex(tint)}"></span>{text}</span>'
        for tint, text in items
    )
    return f'<div style="margin:0 12px;font-size:12px;color:{to_hex(INK)};line-height:1.6">{told}</div>'


def makers_in_order(lines: Sequence[StrokeLine]) -> list[str]:
    """Name the makers of strokes, each once, in the order of the program."""
    return list(dict.fromkeys(line.made_by for line in lines))


def step_stroke(lines: Sequence[StrokeLine], made_by: str, steps: int) -> str:
    """Give the maker that comes next (1) or before (-1), around the end; the first or last where none is chosen."""
    return step_around(makers_in_order(lines), made_by, steps)


def card_html(session: Session, lines: Sequence[StrokeLine]) -> str:
    """Say what is known about the strokes of the maker that is selected."""
    chosen = [line for line in lines if line.made_by == session.selection.made_by]
    if session.run is None or not chosen:
        return _box(
            f'<span style="color:{to_hex(QUIET)}">No stroke is selected. Click one, or go through them in order.</span>'
        )
    made_by = chosen[0].made_by
    spans = [span for span in spray_spans(session.run.program) if span.made_by == made_by]
    facts = {**_facts(session, chosen), **_times(spans)}
    rows = "".join(
        f'<tr style="vertical-align:top"><td style="color:{to_hex(QUIET)};padding-right:10px;white-space:nowrap">'
        f"{name}</td>"
        f"<td>{escape(value)}</td></tr>"
        for name, value in facts.items()
    )
    _, _, name = made_by.partition("/")
    title = escape(name.replace("/", " \N{MIDDLE DOT} ") or made_by)
    found = findings_html([finding for finding in session.run.findings if finding.made_by == made_by], _MOST_FINDINGS)
    return _box(
        f'<div style="font-weight:600;color:{to_hex(ACCENT)};overflow-wrap:anywhere">{title}</div>'
        f'<table style="border-collapse:collapse;font-size:12px">{rows}</table>{found}'
    )


def _facts(session: Session, chosen: Sequence[StrokeLine]) -> dict[str, str]:
    first = chosen[0]
    surface = session.board.surface_z_mm(first.side)
    heights = [abs(float(z) - surface) for line in chosen for z in (line.points[:, 2].min(), line.points[:, 2].max())]
    spec = session.recipe.templates.get(first.template)
    facts = {
        "Recipe": recipe_line(session.loaded, first.made_by),
        "Path": spec.path.replace("_", " ") if spec is not None else first.template,
        "Function": f"{first.function}, nozzle {first.nozzle}, {first.side} side",
        "Speed": _range([line.speed_mm_s for line in chosen], "mm/s"),
        "Height": _range(heights, "mm"),
        "Tilt": _range([line.tilt_deg for line in chosen], "\N{DEGREE SIGN}"),
        "Passes": _range([float(line.laps) for line in chosen], ""),
    }
    pauses = sum(line.pauses for line in chosen)
    if pauses:
        facts["Pauses"] = f"{pauses}, together {sum(line.paused_s for line in chosen):.1f} s"
    strokes = f" in {len(chosen)} strokes" if len(chosen) > 1 else ""
    return facts | {"Length": f"{sum(line.length_mm for line in chosen):.0f} mm{strokes}"}


def _times(spans: Sequence[Span]) -> dict[str, str]:
    if not spans:
        return {}
    lasting = sum(span.end_s - span.begin_s for span in spans)
    return {"Time": f"{clock(lasting)}, from {clock(spans[0].begin_s)} on"}


def _range(values: Sequence[float], unit: str) -> str:
    low, high = f"{min(values):.4g}", f"{max(values):.4g}"
    space = "" if unit in ("", "\N{DEGREE SIGN}") else " "
    return f"{low}{space}{unit}" if low == high else f"{low} to {high}{space}{unit}"


def _box(inner: str) -> str:
    return f'<div style="margin:0 12px 4px;font-size:12px;color:{to_hex(INK)};line-height:1.45">{inner}</div>'
