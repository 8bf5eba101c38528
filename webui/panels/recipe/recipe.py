"""Forms for all entries of a recipe."""

from collections.abc import Mapping

from specs.errors import JobError, LocatedError
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.forms import entries
from webui.forms.entries import SECTIONS, Entry, default_entry, kinds_of
from webui.forms.fields import Field, describe, field_at
from webui.forms.spec_form import SpecForm, reason_of
from webui.page.page import Page
from webui.page.session import READ_ONLY, Change, Session
from webui.panels.recipe.entry_card import card_html
from webui.panels.recipe.part_mask import PartMask
from webui.panels.widgets.choices import on_choice
from webui.panels.widgets.dialog import Dialog
from webui.scene.scene import Scene
from webui.theme.html import quiet_html

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

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page, self._scene = page, scene
        self._at: YamlPath = ("templates", "")
        """Path of the entry that is shown; of its section, if it does not exist any more."""
        self._entry: Entry | None = None
        gui = page.client.gui
        with gui.add_folder(None):  # as deep as the form, so that all inputs are aligned
            self._mask = PartMask(page)
            self._section = gui.add_dropdown("Section", SECTIONS, initial_value="Templates", hint="Part of the recipe.")
            self._choice = gui.add_dropdown("Entry", (_NOTHING,), hint="What the form below is about.")
            self._edit = gui.add_button_group("Edit", (_ADD, _DUPLICATE, _RENAME, _REMOVE))
            self._order = gui.add_button_group("Order", (_UP, _DOWN), hint="Place among the others of its section.")
        self._card = gui.add_html("")
        self._form = SpecForm(gui, self._apply)
        on_choice(self._section, lambda section: self._open(section, ""))
        on_choice(self._choice, lambda label: self._open(self._section.value, label))
        self._edit.on_click(lambda event: self._do(event.target.value))
        self._order.on_click(lambda event: self._do(event.target.value))

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session; the form follows the stroke that is selected."""
        self._mask.show(session)
        if session.shown is not None or (before is not None and before.shown is not None):
            self._lock(session)
            return
        selected = before is not None and session.selection.made_by != before.selection.made_by
        self._at = (entries.entry_at(session.recipe, session.selection.made_by) if selected else None) or self._at
        shown = None if self._entry is None else self._entry.path
        if shown != self._at or before is None or session.loaded is not before.loaded:
            self._show_entry(session)
        elif session.run is not before.run:
            self._card.content = card_html(session, self._entry, self._section.value)
        if self._entry is not None and self._entry.path != shown:
            self._form.reset()

    def _lock(self, session: Session) -> None:
        """Take the inputs away while a robot's program is shown; the reason stands in their place."""
        locked = session.shown is not None
        self._section.visible = not locked
        if not locked:
            self._show_entry(session)
            return
        self._choice.visible = self._edit.visible = self._order.visible = False
        self._card.content = quiet_html(READ_ONLY)
        self._form.show((), {})

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
        self._card.content = card_html(session, self._entry, section)
        self._form.show(*describe_entry(session, self._entry))

    def _open(self, section: str, label: str) -> None:
        """Show the entry of a label; without one the first of the section."""
        there = entries.entries(self._page.session.recipe, section)
        first = there[0].path if there else (section.lower(), "")
        self._at = next((each.path for each in there if each.label == label), self._at if label else first)
        self._page.refresh()

    def _apply(self, changes: dict[YamlPath, Tree]) -> None:
        """Write the changes of the form, or show at its field why they are refused."""
        values = {(*self._at, *path): value for path, value in changes.items()}
        if self._page.attempt(lambda session: session.set_values(values), self._refuse):
            self._form.accept()

    def _refuse(self, error: JobError) -> None:
        fields, _ = describe_entry(self._page.session, self._entry)
        field = field_at(fields, self._at, error.path) if isinstance(error, LocatedError) else None
        at = "" if field is None else spell_path((*self._at, *field.path))
        self._form.refuse(field, reason_of(error, at))

    def _do(self, what: str) -> None:
        entry = self._entry
        if what == _ADD:
            self._open_dialog(self._section.value)
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

    def _open_dialog(self, section: str) -> None:
        """Open the dialog for a new entry; a step is added without one."""
        if section == "Sequence":
            self._page.attempt(self._add(section, "", ""))
            return
        dialog = Dialog(self._page, f"New {_SINGULAR[section]}")
        if section != "Masks":
            dialog.name("Name", "", _NAME_HINT)
        dialog.choice(_KIND_LABEL.get(section, "Kind"), kinds_of(section.lower()), "It cannot be changed later.")
        dialog.buttons({"Add": lambda name, kind: self._add(section, name, kind)})

    def _add(self, section: str, name: str, kind: str) -> Change:
        def change(session: Session) -> Session:
            value = default_entry(session.recipe, session.workpiece, section.lower(), kind, name)
            return self._opened(*entries.added(session, section, name, value))

        return change

    def _opened(self, session: Session, path: YamlPath) -> Session:
        """Show the entry together with its session."""
        self._at = path
        return session
