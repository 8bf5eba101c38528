"""What an entry of a recipe is, above its form."""

from collections import Counter
from html import escape

from specs.spec import Spec
from webui.cards.nozzle_svg import sketch_nozzle
from webui.forms.entries import Entry, spec_at, users_of
from webui.page.session import Session
from webui.theme.palette import ACCENT, INK, QUIET, to_hex

_GENERAL = "What the recipe is called and what it builds on."


def card_html(session: Session, entry: Entry | None, section: str) -> str:
    """Say what an entry is, where it is used, and what it does on this board."""
    if entry is None:
        return _framed(f'<span style="color:{to_hex(QUIET)}">No {escape(section.lower())} yet.</span>')
    spec = spec_at(session.recipe, entry.path)
    parts = [f"<div>{escape(_tell_kind(spec))}</div>" if entry.path else f"<div>{_GENERAL}</div>"]
    if entry.section == "Classes":
        parts.append(_members(session, entry.name))
    elif entry.named:
        parts.append(_uses(session, entry))
    if entry.section == "Nozzles":
        parts.append(sketch_nozzle(session.recipe.nozzles[entry.name]))
    return _framed("".join(parts))


def _tell_kind(spec: type[Spec]) -> str:
    """First sentence of what the specification says of itself, and the word the recipe uses for it."""
    told = (spec.__doc__ or "").split("\n")[0].strip()
    key = next((key for key in ("path", "pattern") if key in spec.model_fields), None)
    return told if key is None else f"{str(spec.model_fields[key].default).replace('_', ' ').capitalize()}: {told}"


def _uses(session: Session, entry: Entry) -> str:
    steps = sorted({int(path[1]) for path in users_of(session.recipe, entry.path)})
    listed = ", ".join(f"{step + 1} ({session.recipe.sequence[step].function})" for step in steps)
    text = f"Used in step {listed}" if steps else "No step uses it"
    return f'<div style="color:{to_hex(QUIET)}">{escape(text)}</div>'


def _members(session: Session, chosen: str) -> str:
    """All classes in their order with how many components each takes; the chosen one stands out."""
    counts = Counter(each.component_class for each in session.run.classified) if session.run is not None else None
    rows: list[str] = []
    for place, name in enumerate(session.recipe.classes):
        colour = to_hex(ACCENT) if name == chosen else to_hex(INK)
        weight = 600 if name == chosen else 400
        count = "…" if counts is None else str(counts[name])
        rows.append(
            f'<tr style="color:{colour};font-weight:{weight}"><td style="width:1.6em">{place + 1}</td>'
            f'<td>{escape(name)}</td><td style="text-align:right">{count}</td></tr>'
        )
    head = f'<tr style="color:{to_hex(QUIET)}"><td></td><td>class</td><td style="text-align:right">components</td></tr>'
    return f'<table style="width:100%;border-collapse:collapse;margin-top:6px">{head}{"".join(rows)}</table>'


def _framed(content: str) -> str:
    return f'<div style="margin:0 10px 10px;font-size:13px;line-height:1.5;color:{to_hex(INK)}">{content}</div>'
