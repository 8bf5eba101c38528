"""Any specification as inputs: one form for all of them, made from their fields."""

import re
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import viser

from specs.errors import JobError, LocatedError
from specs.yaml.located import YamlPath, spell_path
from specs.yaml.tree import Tree
from webui.forms.fields import Field, InputValue, changes, field_at
from webui.theme.html import remark_html, sticky_html

NOT_APPLIED = "Not applied yet: press Enter or Apply."
_NOT_STATED = "not stated"
_LAST = 1e9
"""Order below all inputs."""
_Input: TypeAlias = viser.GuiInputHandle[Any]
Submit: TypeAlias = Callable[[dict[YamlPath, Tree]], object]
"""Takes the changes of a form, by path relative to the part that it edits; ``None`` takes something out."""


def reason_of(error: JobError, at: str = "") -> str:
    """Reason of an error alone: the page shows the file, and the input at a path needs no path.

    Args:
        error: The error.
        at: Path of the input beside which the reason is shown.
    """
    text = str(error)
    if not isinstance(error, LocatedError):
        return text
    if error.file is not None:
        text = re.sub(re.escape(str(error.file)) + r":(\d+: )?\s*", "", text)
    return text.removeprefix(f"{at}: ") if at else text


class SpecForm:
    """Inputs for one part of a recipe; Enter or the button sends what was changed."""

    def __init__(self, gui: viser.GuiApi, submit: Submit) -> None:
        """Build an empty form in the container that is open."""
        self._gui, self._submit = gui, submit
        self._fields: tuple[Field, ...] = ()
        self._stated: Mapping[str, Tree] = {}
        self._inputs: list[_Input] = []
        self._sending = threading.Lock()
        """Enter and the button are served in several threads: what one submits must not pass for what another did."""
        self._sent: list[InputValue] = []
        """Values that were submitted last, or shown where none were."""
        self._folders: dict[str, viser.GuiFolderHandle] = {}
        self._remark: viser.GuiHtmlHandle | None = None
        self._form = gui.add_form(None)
        with self._form:
            self._note = gui.add_html(sticky_html(NOT_APPLIED), order=_LAST - 0.5, visible=False)
            self._apply = gui.add_button("Apply", order=_LAST, color="gray")
        self._apply.on_click(lambda _: self._form.submit())
        self._form.on_submit(lambda _: self._send())

    def show(self, fields: tuple[Field, ...], stated: Mapping[str, Tree]) -> None:
        """Show other values, in other inputs where these do not suit; what is typed and not submitted stays."""
        before, self._fields, self._stated = self._fields, fields, stated
        if _shape(before) != _shape(fields):
            self._build(before)
        else:
            for old, field, handle, sent in zip(before, fields, self._inputs, self._sent, strict=True):
                if old.value != field.value and _value_of(field, handle) in (old.value, sent):
                    handle.value = _shown(field)
        self._mark()

    def reset(self) -> None:
        """Show the values of the recipe, whatever was typed, and no remark."""
        self._sent = [_value_of(field, handle) for field, handle in zip(self._fields, self._inputs, strict=True)]
        self.accept()

    def accept(self) -> None:
        """Show the values of the recipe, which was edited as submitted, and no remark; what was typed since stays."""
        self._clear_remark()
        for field, handle, sent in zip(self._fields, self._inputs, self._sent, strict=True):
            if _value_of(field, handle) == sent:
                handle.value = _shown(field)
        self._mark()

    def refuse(self, error: JobError, base: YamlPath) -> None:
        """Show why the values were refused, at the field that an error is about or below all of them.

        Args:
            error: Why.
            base: Path of the part that the form edits.
        """
        self._clear_remark()
        field = field_at(self._fields, base, error.path) if isinstance(error, LocatedError) else None
        reason = reason_of(error, "" if field is None else spell_path((*base, *field.path)))
        at = None if field is None else self._fields.index(field)
        place = self._form if field is None else self._folders.get(field.group, self._form)
        order = _LAST - 1 if at is None else float(self._inputs[at].order) + 0.5
        with place:
            self._remark = self._gui.add_html(remark_html(reason), order=order)

    def _mark(self) -> None:
        """Show whether a value is typed that the recipe does not have."""
        inputs = zip(self._fields, self._inputs, strict=False)  # while it is typed, others may be built
        typed = any(_value_of(field, handle) != field.value for field, handle in inputs)
        self._note.visible = typed
        self._apply.color = None if typed else "gray"

    def _send(self) -> None:
        """Submit the values, and show again what is sent: the page drops a key pressed at the same moment as Enter.

        What was typed meanwhile stays, for the next time.
        """
        with self._sending:
            values = [_value_of(field, handle) for field, handle in zip(self._fields, self._inputs, strict=True)]
            self._sent = values
            for field, handle, value in zip(self._fields, self._inputs, values, strict=True):
                typed = value != field.value and handle.value == value
                if typed and not isinstance(value, bool) and field.kind != "choice":
                    handle.value = value + " "
                    handle.value = value
            self._submit(changes(self._fields, values, self._stated))

    def _build(self, before: tuple[Field, ...]) -> None:
        self._clear_remark()
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
        self._sent = [field.value for field in self._fields]
        for handle in self._inputs:
            handle.on_update(lambda _: self._mark())
        self._apply.visible = bool(self._fields)

    def _add(self, field: Field) -> _Input:
        value = _shown(field)
        match field.kind:
            case "boolean":
                return self._gui.add_checkbox(field.label, bool(value), hint=field.hint)
            case "choice":
                return self._gui.add_dropdown(field.label, _choices(field), initial_value=str(value), hint=field.hint)
            case _:
                multiline = field.kind == "table"
                return self._gui.add_text(field.label, str(value), multiline=multiline, hint=field.hint)

    def _clear_remark(self) -> None:
        if self._remark is not None:
            self._remark.remove()
            self._remark = None


def _shape(fields: tuple[Field, ...]) -> tuple[object, ...]:
    """Which inputs there are and which folders are open: where this differs they are built anew."""
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


def _shown(field: Field) -> InputValue:
    return _NOT_STATED if field.kind == "choice" and field.value == "" else field.value


def _value_of(field: Field, handle: _Input) -> InputValue:
    value = handle.value
    return "" if field.kind == "choice" and value == _NOT_STATED else value
