"""Forms for what stands in a cell: board, base, tools, fixtures; what is applied is in the cell's file at once."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

import viser

from robotcell.cell.cell_edits import CellEdit
from robotcell.cell.load import LoadedCell
from robotcell.cell.spec import CellSpec, Hold, Place, ToolSpec
from specs.errors import JobError, LocatedError
from specs.spec import Spec
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.forms.fields import Field, describe, field_at
from webui.forms.spec_form import SpecForm, reason_of
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import offer, on_choice
from webui.theme.html import quiet_html

_NOTHING: tuple[str, ...] = ("",)
_SAVED = "Apply writes the cell's file; Undo takes it back."
_COPIED = "Apply writes a copy of this cell into the project folder, which is used from then on; Undo takes it back."


@dataclass(frozen=True, slots=True)
class Editable:
    """Something of a cell that a form edits."""

    label: str
    path: YamlPath
    spec: type[Spec]
    keys: tuple[str, ...] = ()
    """Keys of the specification that the form has; all of them if none is named."""


def places_of(cell: LoadedCell) -> tuple[Editable, ...]:
    """What the forms of a cell are about; a board that is held by measured points has none."""
    spec = cell.spec
    board = () if spec.board.pose is None else (Editable("Board", ("board",), Hold, ("hold", "pose")),)
    tools = (
        Editable(f"Tool {number}: {tool.name}", ("tools", str(number)), ToolSpec, ("tcp", "mass_kg"))
        for number, tool in sorted(spec.tools.items())
    )
    fixtures = (Editable(f"Fixture: {name}", ("fixtures", name), type(body)) for name, body in spec.fixtures.items())
    base = Editable("Base of the robot", ("base",), Place)
    return (*board, base, *tools, *fixtures, Editable("Margin", (), CellSpec, ("margin_mm",)))


def fields_of(cell: LoadedCell, place: Editable) -> tuple[tuple[Field, ...], Mapping[str, Tree]]:
    """Inputs for something of a cell, and the values that its file states there."""
    node = cell.root.find(place.path) if place.path else cell.root
    plain = None if node is None else node.plain()
    stated = cast("Mapping[str, Tree]", plain) if isinstance(plain, dict) else {}
    return describe(place.spec, stated, {}, place.keys), stated


class CellForm:
    """A form for what stands in the cell."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where there is a cell."""
        self._page = page
        self._places: tuple[Editable, ...] = ()
        self._cell: LoadedCell | None = None
        gui = page.client.gui
        self._folder = gui.add_folder("Edit the cell", visible=False, expand_by_default=False)
        with self._folder:
            self._choice: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "Edit", _NOTHING, hint="What stands in the cell, and where."
            )
            self._form = SpecForm(gui, self._apply)
            self._note = gui.add_html("")
        on_choice(self._choice, lambda _: self._show_form())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is not None and session.cell is before.cell:
            return
        cell = self._cell = session.cell
        self._folder.visible = cell is not None
        if cell is None:
            return
        self._places = places_of(cell)
        labels = tuple(each.label for each in self._places)
        offer(self._choice, labels, self._choice.value if self._choice.value in labels else labels[0])
        own = self._page.project.owns_cell(cell)
        self._note.content = quiet_html(_SAVED if own else _COPIED)
        self._show_form()

    @property
    def _place(self) -> Editable:
        return next(each for each in self._places if each.label == self._choice.value)

    def _show_form(self) -> None:
        if self._cell is not None:
            self._form.show(*fields_of(self._cell, self._place))
            self._form.reset()

    def _apply(self, changes: dict[YamlPath, Tree]) -> None:
        """Write the changes of the form, or show at its field why they are refused."""
        path, project = self._place.path, self._page.project
        edits = [CellEdit((*path, *key), value) for key, value in changes.items()]
        if edits and self._page.attempt(lambda session: session.edit_cell(edits, project), self._refuse):
            self._form.accept()
            self._page.notify("Cell saved", f"{self._page.session.cell_name} is written. Undo takes it back.")

    def _refuse(self, error: JobError) -> None:
        if self._cell is None:
            return
        path = self._place.path
        fields, _ = fields_of(self._cell, self._place)
        field = field_at(fields, path, error.path) if isinstance(error, LocatedError) else None
        at = "" if field is None else spell_path((*path, *field.path))
        self._form.refuse(field, reason_of(error, at))
