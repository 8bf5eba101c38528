"""Forms for all entries of a recipe, the card of an entry, and masks of the selected part."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import Literal, TypeAlias

import numpy as np

from geometry.arrays import Points2
from recipes.footprint import core_footprint, footprint
from recipes.nozzles import HollowCone, Nozzle
from recipes.recipe import Recipe
from reports.tables.table import Table, Text
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.forms import entries
from webui.forms.entries import SECTIONS, Entry, default_entry, kinds_of, spec_at, users_of
from webui.forms.fields import Field, describe
from webui.forms.spec_form import SpecForm
from webui.page.page import Page
from webui.page.session import READ_ONLY, Change, Session
from webui.panels.widgets.choices import buttons, dropdown
from webui.panels.widgets.job import Dialog
from webui.scene.scene import Scene
from webui.theme.html import box_html, grey_html, quiet_html, table_html
from webui.theme.palette import ACCENT, PAPER, QUIET, css_colour

_GENERAL = "What the recipe is called and what it builds on."
_SIZE = 150.0
_MARGIN = 16.0
_RULER_MM = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0)
_DOWNWARDS = np.array([0.0, 0.0, -1.0])
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
        card += classes_html(session, entry.name)
    elif entry.named:
        steps = sorted({int(path[1]) for path in users_of(session.recipe, entry.path)})
        listed = ", ".join(f"{step + 1} ({session.recipe.sequence[step].function})" for step in steps)
        card += grey_html(escape(f"Used in step {listed}" if steps else "No step uses it"))
    if entry.section == "Nozzles":
        card += sketch_nozzle(session.recipe.nozzles[entry.name])
    return box_html(card, style)


def classes_html(session: Session, chosen: str) -> str:
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
    outer = footprint(nozzle, height, _DOWNWARDS, _ALONG)
    reach = float(np.abs(outer).max())
    scale = (_SIZE / 2 - _MARGIN) / reach
    shapes = _polygon(outer, scale, fill=css_colour(ACCENT), opacity=0.22)
    origin = "edge"
    if isinstance(nozzle, HollowCone):
        middle = core_footprint(nozzle, height, _DOWNWARDS, _ALONG)
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


Treatment: TypeAlias = Literal["avoid", "ignore", "clean"]
_MASK: dict[str, Treatment] = {"Avoid": "avoid", "Ignore": "ignore", "Must clean": "clean"}
_UNMASK: dict[Treatment, str] = {"avoid": "Do not avoid", "ignore": "Do not ignore", "clean": "Need not clean"}
_MASK_HINT = (
    "Mask of the selected part. Avoid: the wave front keeps out, the jet closes. Ignore: no pass of its own. "
    "Must clean: a finding if no pass serves it."
)


@dataclass(frozen=True, slots=True)
class OwnMask:
    """A mask of the recipe for one part alone."""

    place: int
    """Among the masks of the recipe."""
    treatment: Treatment


def own_mask(recipe: Recipe, part: str) -> OwnMask | None:
    """The first mask that names this part and nothing else, if there is one."""
    for place, mask in enumerate(recipe.masks):
        for treatment in _MASK.values():
            if getattr(mask, treatment) == [part]:
                return OwnMask(place, treatment)
    return None


def mask_part(session: Session, part: str, treatment: Treatment) -> Session:
    """Session with a mask for one part, after the others.

    Raises:
        RecipeError: the recipe would not be one.
    """
    return session.insert(("masks", len(session.recipe.masks)), {treatment: [part]})


class PartMask:
    """Buttons that mask the selected part, or take its own mask out; hidden while no part is selected."""

    def __init__(self, page: Page) -> None:
        """Build the buttons in the container that is open."""

        def press(label: str) -> None:
            def change(session: Session) -> Session:
                part = session.component
                own = None if part is None else own_mask(session.recipe, part.name)
                if part is None or (own is None) != (label in _MASK):  # pressed before the browser heard of an edit
                    return session
                if own is not None:
                    return session.remove(("masks", own.place))
                return mask_part(session, part.name, _MASK[label])

            page.attempt(change)

        self._buttons = buttons(page.client.gui, "Mask", _MASK, press, _MASK_HINT, visible=False)
        page.follow(self._show, lambda now: now)

    def _show(self, session: Session) -> None:
        part = session.component if session.shown is None else None
        self._buttons.visible = part is not None
        if part is not None:
            own = own_mask(session.recipe, part.name)
            self._buttons.options = tuple(_MASK) if own is None else (_UNMASK[own.treatment],)
            self._buttons.label = f"Mask {part.name}"


_NOTHING: str = "none"
_ADD, _DUPLICATE, _RENAME, _REMOVE, _UP, _DOWN = "Add", "Copy", "Rename", "Remove", "Up", "Down"
_SINGULAR = {
    "Functions": "function", "Nozzles": "nozzle", "Classes": "class", "Masks": "mask", "Templates": "template",
    "Sequence": "step",
}  # fmt: skip
_KIND_LABEL = {"Templates": "Path class", "Nozzles": "Pattern", "Masks": "What to do"}
_NAME_HINT = "Begins with a letter; letters, digits and _ . - only."


def describe_entry(session: Session, entry: Entry | None) -> tuple[tuple[Field, ...], Mapping[str, Tree]]:
    """Inputs of an entry, and the values that the recipe states there."""
    if entry is None:
        return (), {}
    stated = entries.stated_at(session.loaded.root, entry.path)
    spec, names = entries.spec_at(session.recipe, entry.path), entries.names_of(session.recipe)
    return describe(spec, stated, names, () if entry.path else entries.GENERAL), stated


class RecipePanel:
    """Forms for all entries of a recipe: a section, an entry of it, its values."""

    def __init__(self, page: Page, _scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        self._at: YamlPath = ("templates", "")
        """Path of the entry that is shown; of its section, if it does not exist any more."""
        self._entry: Entry | None = None
        gui = page.client.gui
        with gui.add_folder(None):  # as deep as the form, so that all inputs are aligned
            PartMask(page)
            hint, first = "Part of the recipe.", "Templates"
            self._section = dropdown(gui, "Section", SECTIONS, hint, self._open, initial_value=first)
            self._choice = dropdown(
                gui,
                "Entry",
                (_NOTHING,),
                "What the form below is about.",
                lambda label: self._open(self._section.value, label),
            )
            self._edit = buttons(gui, "Edit", (_ADD, _DUPLICATE, _RENAME, _REMOVE), self._do)
            self._order = buttons(gui, "Order", (_UP, _DOWN), self._do, "Place among the others of its section.")
        self._card = gui.add_html("")

        def apply(changes: dict[YamlPath, Tree]) -> None:
            """Write the changes of the form, or show at its field why they are refused."""
            at = self._at
            values = {(*at, *path): value for path, value in changes.items()}
            if page.attempt(lambda session: session.set_values(values), lambda error: self._form.refuse(error, at)):
                self._form.accept()

        self._form = SpecForm(gui, apply)

        def go_to_selected(session: Session) -> None:
            self._at = entries.entry_at(session.recipe, session.selection.made_by) or self._at

        page.follow(go_to_selected, lambda now: now.selection.made_by)
        page.follow(self._show, lambda now: (now.shown, now.loaded, self._at))
        page.follow(self._show_card, lambda now: (now.shown, now.run))

    def _show(self, session: Session) -> None:
        if session.shown is not None:  # the reason stands in the place of the inputs
            self._section.visible = self._choice.visible = self._edit.visible = self._order.visible = False
            self._form.show((), {})
            return
        before = self._entry
        self._section.visible = True
        self._show_entry(session)
        if self._entry is not None and (before is None or self._entry.path != before.path):
            self._form.reset()

    def _show_card(self, session: Session) -> None:
        shown = session.shown is None
        self._card.content = card_html(session, self._entry, self._section.value) if shown else quiet_html(READ_ONLY)

    def _show_entry(self, session: Session) -> None:
        section = Entry(self._at, "").section
        there = entries.entries(session.recipe, section)
        labels = [each.label for each in there]
        nearest = there[-1 if any(isinstance(key, int) for key in self._at) else 0] if there else None
        self._entry = next((each for each in there if each.path == self._at), nearest)
        self._at = (section.lower(), "") if self._entry is None else self._entry.path
        self._section.value = section
        self._choice.options = labels or [_NOTHING]
        self._choice.value = _NOTHING if self._entry is None else self._entry.label
        self._choice.visible = section in _SINGULAR
        self._edit.visible = section in _SINGULAR
        actions = {_ADD: True, _DUPLICATE: True, _RENAME: self._entry is not None and self._entry.named, _REMOVE: True}
        self._edit.options = (
            (_ADD,) if self._entry is None else tuple(each for each, usable in actions.items() if usable)
        )
        moved = self._entry is not None and self._entry.ordered and section != "Sequence"  # steps: in the tab Job
        self._order.visible = moved and len(there) > 1
        self._show_card(session)
        self._form.show(*describe_entry(session, self._entry))

    def _open(self, section: str, label: str = "") -> None:
        """Show the entry of a label; without one the first of the section."""
        there = entries.entries(self._page.session.recipe, section)
        first = there[0].path if there else (section.lower(), "")
        self._at = next((each.path for each in there if each.label == label), self._at if label else first)
        self._page.show(self._page.session)

    def _do(self, what: str) -> None:
        entry = self._entry
        section = self._section.value
        if what == _ADD and section == "Sequence":  # a step is added without a dialog
            self._page.attempt(self._add(section, "", ""))
        elif what == _ADD:
            dialog = Dialog(self._page, f"New {_SINGULAR[section]}")
            if section != "Masks":
                dialog.name("Name", "", _NAME_HINT)
            dialog.choice(_KIND_LABEL.get(section, "Kind"), kinds_of(section.lower()), "It cannot be changed later.")
            dialog.buttons({"Add": lambda name, kind: self._add(section, name, kind)})
        elif entry is not None and what == _RENAME:
            dialog = Dialog(self._page, f"Rename {entry.name}", "References to it are renamed too.")
            dialog.name("Name", entry.name, _NAME_HINT)
            dialog.buttons(
                {
                    "Rename": lambda name, _: (
                        lambda session: self._opened(entries.renamed(session, entry, name), (entry.path[0], name))
                    )
                }
            )
        elif entry is not None and what == _DUPLICATE:
            self._page.attempt(lambda session: self._opened(*entries.copied(session, entry)))
        elif entry is not None and what == _REMOVE:
            self._page.attempt(lambda session: entries.removed(session, entry))
        elif entry is not None:
            by = -1 if what == _UP else 1
            self._page.attempt(lambda session: self._opened(*entries.moved(session, entry, by)))

    def _add(self, section: str, name: str, kind: str) -> Change:
        def change(session: Session) -> Session:
            value = default_entry(session.recipe, session.workpiece, section.lower(), kind, name)
            return self._opened(*entries.added(session, section, name, value))

        return change

    def _opened(self, session: Session, path: YamlPath) -> Session:
        """Show the entry together with its session."""
        self._at = path
        return session
