"""Any specification as inputs: one form for all of them, made from their fields."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import viser

from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree
from webui.forms.answers import changes
from webui.forms.fields import Field, Shown
from webui.forms.refusals import note_html, remark_html

NOT_APPLIED = "Not applied yet: press Enter or Apply."
_NOT_STATED = "not stated"
_LAST = 1e9
"""Order of what stands below all inputs."""
_Input: TypeAlias = viser.GuiInputHandle[Any]
Submit: TypeAlias = Callable[[dict[YamlPath, Tree]], object]
"""Takes what an answered form changes, by path from the part it is about; ``None`` takes something out."""


class SpecForm:
    """Inputs for one part of a recipe; Enter or the button sends what was changed."""

    def __init__(self, gui: viser.GuiApi, submit: Submit) -> None:
        """Build an empty form in the container that is open."""
        self._gui, self._submit = gui, submit
        self._fields: tuple[Field, ...] = ()
        self._stated: Mapping[str, Tree] = {}
        self._inputs: list[_Input] = []
        self._folders: dict[str, viser.GuiFolderHandle] = {}
        self._remark: viser.GuiHtmlHandle | None = None
        self._form = gui.add_form(None)
        with self._form:
            self._note = gui.add_html(note_html(NOT_APPLIED), order=_LAST - 0.5, visible=False)
            self._apply = gui.add_button("Apply", order=_LAST, color="gray")
        self._apply.on_click(lambda _: self._form.submit())
        self._form.on_submit(lambda _: self._send())

    def show(self, fields: tuple[Field, ...], stated: Mapping[str, Tree]) -> None:
        """Show other values, in other inputs where these do not suit; what was typed into unchanged ones stays."""
        before, self._fields, self._stated = self._fields, fields, stated
        if _shape(before) != _shape(fields):
            self._build(before)
        else:
            for old, field, handle in zip(before, fields, self._inputs, strict=True):
                if old.value != field.value:
                    handle.value = _shown(field, field.value)
        self._mark()

    def reset(self) -> None:
        """Show what the recipe says, whatever was typed, and no remark."""
        self._take_back()
        for field, handle in zip(self._fields, self._inputs, strict=True):
            handle.value = _shown(field, field.value)
        self._mark()

    def refuse(self, field: Field | None, reason: str) -> None:
        """Say why the answers were not taken, at the field or below all of them."""
        self._take_back()
        at = next((index for index, each in enumerate(self._fields) if each == field), None)
        place = self._form if field is None else self._folders.get(field.group, self._form)
        order = _LAST - 1 if at is None else float(self._inputs[at].order) + 0.5
        with place:
            self._remark = self._gui.add_html(remark_html(reason), order=order)

    def _mark(self) -> None:
        """Say whether something is typed that the recipe does not say."""
        inputs = zip(self._fields, self._inputs, strict=False)  # while it is typed, others may be built
        typed = any(_answer(field, handle) != field.value for field, handle in inputs)
        if typed != self._note.visible:
            self._note.visible = typed
            self._apply.color = None if typed else "gray"

    def _send(self) -> None:
        shown = [_answer(field, handle) for field, handle in zip(self._fields, self._inputs, strict=True)]
        for field, handle, value in zip(self._fields, self._inputs, shown, strict=True):
            if value != field.value and not isinstance(value, bool):
                self._echo(field, handle, value)
        self._submit(changes(self._fields, shown, self._stated))

    @staticmethod
    def _echo(field: Field, handle: _Input, value: str) -> None:
        """Show what is sent: the page drops a key pressed at the same moment as Enter."""
        if field.kind != "choice":
            handle.value = value + " "
            handle.value = value

    def _build(self, before: tuple[Field, ...]) -> None:
        self._take_back()
        for field, handle in zip(before, self._inputs, strict=True):
            if not field.group:
                handle.remove()
        for folder in self._folders.values():
            folder.remove()
        self._folders = {}
        self._inputs = []
        with self._form:
            self._inputs += [self._add(field) for field in self._fields if not field.group]
            for group in dict.fromkeys(field.group for field in self._fields if field.group):
                members = [field for field in self._fields if field.group == group]
                self._folders[group] = self._gui.add_folder(group, expand_by_default=group in _used(self._fields))
                with self._folders[group]:
                    self._inputs += [self._add(field) for field in members]
        for handle in self._inputs:
            handle.on_update(lambda _: self._mark())
        self._apply.visible = bool(self._fields)

    def _add(self, field: Field) -> _Input:
        value = _shown(field, field.value)
        match field.kind:
            case "boolean":
                return self._gui.add_checkbox(field.label, bool(value), hint=field.hint)
            case "choice":
                return self._gui.add_dropdown(field.label, _choices(field), initial_value=str(value), hint=field.hint)
            case _:
                multiline = field.kind == "table"
                return self._gui.add_text(field.label, str(value), multiline=multiline, hint=field.hint)

    def _take_back(self) -> None:
        if self._remark is not None:
            self._remark.remove()
            self._remark = None


def _shape(fields: tuple[Field, ...]) -> tuple[object, ...]:
    """What inputs there are and which folders are open: where this differs they are built anew."""
    inputs = tuple(
        (each.path, each.label, each.kind, _choices(each) if each.kind == "choice" else (), each.group, each.hint)
        for each in fields
    )
    return inputs, _used(fields)


def _used(fields: tuple[Field, ...]) -> frozenset[str]:
    """Folders in which something is stated."""
    return frozenset(field.group for field in fields if field.value and field.group)


def _choices(field: Field) -> Sequence[str]:
    words = tuple(word or _NOT_STATED for word in field.options)
    current = str(field.value) or _NOT_STATED
    return words if current in words else (current, *words)


def _shown(field: Field, value: Shown) -> Shown:
    return _NOT_STATED if field.kind == "choice" and value == "" else value


def _answer(field: Field, handle: _Input) -> Shown:
    value = handle.value
    return "" if field.kind == "choice" and value == _NOT_STATED else value
