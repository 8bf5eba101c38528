"""The card of a recipe entry: its kind, its uses, and the footprint of a nozzle."""

from collections import Counter
from html import escape
from itertools import pairwise

import numpy as np

from geometry.arrays import Points2
from recipes.footprint import core_footprint, footprint
from recipes.nozzles import HollowCone, Nozzle
from reports.tables.table import Table, Text
from specs.yaml.located import spell_path
from webui.forms.entries import Entry, spec_at, users_of
from webui.page.session import Session
from webui.theme.html import box_html, grey_html, table_html
from webui.theme.palette import ACCENT, PAPER, QUIET, css_colour

_GENERAL = "What the recipe is called and what it builds on."
_SIZE = 150.0
_MARGIN = 16.0
_RULER_MM = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_DOWN = np.array([0.0, 0.0, -1.0])
_ALONG = np.array([1.0, 0.0, 0.0])
_HEIGHT_MM = 50.0


def card_html(session: Session, entry: Entry | None, section: str) -> str:
    """Card of an entry: its kind, its uses, and its effect on this board."""
    style = "margin:0 10px 10px;font-size:13px;line-height:1.5"
    if entry is None:
        return box_html(grey_html(f"No {escape(section.lower())} yet."), style)
    spec = spec_at(session.recipe, entry.path)
    kind = (spec.__doc__ or "").split("\n")[0].strip() if entry.path else _GENERAL
    key = next((key for key in ("path", "pattern") if key in spec.model_fields), None)
    if key is not None:
        kind = f"{str(spec.model_fields[key].default).replace('_', ' ').capitalize()}: {kind}"
    card = f"<div data-entry='{escape(spell_path(entry.path), quote=True)}'>{escape(kind)}</div>"
    if entry.section == "Classes":
        card += _classes_html(session, entry.name)
    elif entry.named:
        steps = sorted({int(path[1]) for path in users_of(session.recipe, entry.path)})
        listed = ", ".join(f"{step + 1} ({session.recipe.sequence[step].function})" for step in steps)
        card += grey_html(escape(f"Used in step {listed}" if steps else "No step uses it"))
    if entry.section == "Nozzles":
        card += sketch_nozzle(session.recipe.nozzles[entry.name])
    return box_html(card, style)


def _classes_html(session: Session, chosen: str) -> str:
    """All classes in their order with the number of their components; the chosen one is highlighted."""
    counts = Counter(each.component_class for each in session.run.classified) if session.run else None
    names = list(session.recipe.classes)
    numbers = ["…" if counts is None else str(counts[name]) for name in names]
    rows = [
        tuple(Text(text, "strong" if name == chosen else "") for text in (f"{at}  {name}", number))
        for at, (name, number) in enumerate(zip(names, numbers, strict=True), start=1)
    ]
    return table_html(Table.of(("class", ">components"), rows))


def sketch_nozzle(nozzle: Nozzle) -> str:
    """SVG drawing of the footprint on a plate at right angles, with a ruler.

    A measured ring is drawn at the height of its measurement, everything else at 50 mm.
    """
    measured = nozzle.wavefront if isinstance(nozzle, HollowCone) else None
    height = _HEIGHT_MM if measured is None else measured.height_mm
    outer = footprint(nozzle, height, _DOWN, _ALONG)
    reach = float(np.abs(outer).max())
    scale = (_SIZE / 2 - _MARGIN) / reach
    shapes = _polygon(outer, scale, fill=css_colour(ACCENT), opacity=0.22)
    origin = "edge"
    if isinstance(nozzle, HollowCone):
        middle = core_footprint(nozzle, height, _DOWN, _ALONG)
        inner, origin = 2 * middle - outer, "from the half angle"
        if measured is not None:
            azimuth, radius, _ = np.array(measured.points).T
            angle = np.radians(azimuth)
            inner, origin = np.column_stack([radius * np.cos(angle), -radius * np.sin(angle)]), "measured"
        shapes += _polygon(inner, scale, fill=PAPER, opacity=1.0) + _polygon(middle, scale, fill="none", opacity=1.0)
    at, low, quiet = _SIZE / 2, _SIZE - 4, css_colour(QUIET)
    length = next((small for small, large in pairwise(_RULER_MM) if large > reach), _RULER_MM[-1])
    return (
        f'<svg viewBox="0 0 {_SIZE:g} {_SIZE:g}" width="{_SIZE:g}" height="{_SIZE:g}" role="img" '
        f'aria-label="Spray on a plate {height:g} mm below">{shapes}'
        f'<path d="M{at - 4:g} {at:g}h8M{at:g} {at - 4:g}v8" stroke="{quiet}"/>'
        f'<path d="M{_MARGIN / 2:g} {low:g}h{length * scale:.1f}" stroke="{quiet}" stroke-width="2"/>'
        f'<text x="{_MARGIN / 2:g}" y="{low - 4:g}" font-size="9" fill="{quiet}">{length:g} mm</text></svg>'
        f'<div style="font-size:0.8em;color:{quiet}">On a plate {height:g} mm below, {origin}</div>'
    )


def _polygon(points: Points2, scale: float, *, fill: str, opacity: float) -> str:
    corners = " ".join(f"{x:.1f},{y:.1f}" for x, y in points * [scale, -scale] + _SIZE / 2)
    line = f' stroke="{css_colour(ACCENT)}" stroke-width="1.4"' if fill == "none" else ""
    return f'<polygon points="{corners}" fill="{fill}" fill-opacity="{opacity:g}"{line}/>'
