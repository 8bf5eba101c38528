"""The YAML text of the recipe; undo, redo, open, save."""

from html import escape

from specs.errors import JobError
from webui.forms.spec_form import reason_of
from webui.page.document import Document
from webui.page.page import Page
from webui.page.session import READ_ONLY, Session
from webui.panels.widgets.choices import buttons, html, show_while
from webui.panels.widgets.dialog import Dialog
from webui.scene.scene import Scene
from webui.theme.html import box_html, quiet_html, remark_html, sticky_html
from webui.theme.palette import ACCENT, QUIET, css_colour

_OPEN, _SAVE, _SAVE_AS, _UNDO, _REDO, _APPLY, _REVERT = (
    "Open…", "Save", "Save as…", "Undo", "Redo", "Apply text", "Revert",
)  # fmt: skip
_MARK = "washboard-yaml"
_STYLE = f"""<style>
div:has(> .{_MARK}) + div {{ padding: 0 10px 8px; }}
div:has(> .{_MARK}) + div > div > div:first-child {{ display: none; }}
div:has(> .{_MARK}) + div textarea {{
  min-height: max(240px, calc(100vh - 300px)); max-height: none !important; font-family: ui-monospace, monospace;
  font-size: 11.5px; line-height: 1.45; white-space: pre; overflow: auto; tab-size: 2;
}}
</style><div class="{_MARK}"></div>"""
"""The text that follows takes the height of the page and the width of the panel."""
_TYPED = "Not applied yet: press Apply text, or Revert."
_MEANWHILE = "The recipe was changed elsewhere since. Apply text replaces it by this text, Revert shows it."


class TextPanel:
    """The YAML text of the recipe; undo, redo, open, save."""

    def __init__(self, page: Page, _scene: Scene) -> None:
        """Build the elements in the container that is open."""
        self._page = page
        gui = page.client.gui
        html(
            page,
            lambda now: state_html(now.document) if now.shown is None else quiet_html(READ_ONLY),
            lambda now: (now.shown, now.document),
        )
        with gui.add_folder(None):  # as deep as forms, so that inputs are aligned from tab to tab
            files = buttons(gui, "File", (_OPEN, _SAVE, _SAVE_AS), self.do)
            edits = buttons(gui, "Edit", (_UNDO, _REDO), self.do)
        gui.add_html(_STYLE)
        self._text = gui.add_text("YAML", "", multiline=True)
        self._remark = gui.add_html("", visible=False)
        self._note = gui.add_html(sticky_html(_TYPED), visible=False)
        with gui.add_folder(None):
            texts = buttons(gui, "Text", (_APPLY, _REVERT), self.do, "What was typed above.")
        show_while(page, lambda now: now.shown is None, files, edits, texts)
        self._text.on_update(lambda _: self._mark())
        self._before = ""
        """Text of the recipe that was shown last."""
        self._seen = ""
        """Text of the file when a dialog about it was opened last."""
        self._dialog: Dialog | None = None
        page.on_poll(self._poll)
        page.follow(self._show, lambda now: (now.shown, now.document))
        for what, shift in ((_SAVE, ""), (_UNDO, ""), (_REDO, "+shift")):
            key = "S" if what == _SAVE else "Z"
            command = gui.add_command(what, hotkey=key, modifier="cmd/ctrl+shift" if shift else "cmd/ctrl")
            command.on_trigger(lambda _, what=what: self.do(what))

    def _show(self, session: Session) -> None:
        """Show a session; text that was typed and not applied stays."""
        self._text.disabled = session.shown is not None
        shown, text, before = self._text.value, session.document.text, self._before
        self._before = text
        if shown in (before, text):
            self._text.value = text
            self._show_remark("")
        elif text != before:
            self._show_remark(_MEANWHILE)
        self._mark()

    def do(self, what: str) -> None:
        """Perform the action of a button."""
        match what:
            case "Undo":
                self._page.attempt(Session.undone)
            case "Redo":
                self._page.attempt(Session.redone)
            case "Apply text":
                typed, file = self._text.value, str(self._page.session.document.file)

                def refuse(error: JobError) -> None:
                    self._show_remark(line_of(error) if str(error).startswith(file) else str(error))

                self._page.attempt(lambda session: session.edited(typed), refuse)
            case "Revert":
                self._text.value = self._page.session.document.text
                self._show_remark("")
            case "Save":
                self._save()
            case "Save as…":
                self._open_save_as()
            case _:
                note = "Changes that were not saved are lost." if self._page.session.document.dirty else ""
                dialog = Dialog(self._page, "Open", note)
                files, present = self._page.project, self._page.session.document.file.stem
                hint = "Of the library, or of the project folder."
                dialog.choice("Recipe", files.recipes(), hint, present, files.describe_recipe)
                dialog.buttons({"Open": lambda _, name: lambda now: now.with_document(files.open_recipe(name))})

    def _mark(self) -> None:
        """Show whether a text is typed that is not that of the recipe, unless there is a remark."""
        self._note.visible = self._text.value != self._page.session.document.text and not self._remark.visible

    def _save(self) -> None:
        document = self._page.session.document
        if document.belongs_to_library:
            self._open_save_as()
        elif document.changed_on_disk():
            note = f"{document.file.name} was changed by somebody else since it was opened. Undo brings back your text."
            dialog = Dialog(self._page, "Changed on disk", note)
            dialog.buttons(
                {"Overwrite it": lambda _name, _choice: saved, "Load the file": lambda _name, _choice: reloaded}
            )
        elif self._page.attempt(saved):
            self._page.notify("Saved", str(document.file))

    def _poll(self) -> None:
        """Open a dialog when somebody else changed the file; once for each change."""
        document = self._page.session.document
        text = document.on_disk()
        if text is None or text in (document.saved, self._seen):
            return
        self._seen = text
        if self._dialog is not None:
            self._dialog.close()
        unsaved = " You have unsaved changes; Undo brings them back." if document.dirty else ""
        note = f"{document.file.name} was changed by somebody else.{unsaved}"
        self._dialog = Dialog(self._page, "Changed on disk", note)
        self._dialog.buttons({"Load the file": lambda _name, _choice: reloaded}, "Keep this text")

    def _open_save_as(self) -> None:
        document = self._page.session.document
        note = "It belongs to the library and stays as it is." if document.belongs_to_library else ""
        dialog = Dialog(self._page, "Save as", note)
        dialog.name("File", f"my-{document.file.stem}.yaml", f"In {self._page.project.folder}.")
        files = self._page.project
        dialog.buttons(
            {"Save": lambda name, _: lambda now: now.with_document(now.document.save_as(files.recipe_file(name)))}
        )

    def _show_remark(self, remark: str) -> None:
        self._remark.content = remark_html(remark)
        self._remark.visible = bool(remark)
        self._mark()


def line_of(error: JobError) -> str:
    """Reason of an error with its line; the file is the one that is shown."""
    line = getattr(error, "line", None)
    return f"Line {line}: {reason_of(error)}" if line else reason_of(error)


def state_html(document: Document) -> str:
    """Name of the recipe, and whether it is saved."""
    if document.belongs_to_library:
        state = "changed; save it under a name of your own" if document.dirty else "of the library"
    else:
        state = "unsaved changes" if document.dirty else "saved"
    colour = css_colour(ACCENT) if document.dirty else css_colour(QUIET)
    return box_html(
        f'<b>{escape(document.file.stem)}</b> <span style="color:{colour}">{state}</span>',
        "margin:0 10px 10px;font-size:13px",
    )


def saved(session: Session) -> Session:
    """Write the recipe to its file.

    Raises:
        JobError: it cannot be written.
    """
    return session.with_document(session.document.save())


def reloaded(session: Session) -> Session:
    """Load the file again.

    Raises:
        JobError: it cannot be read.
    """
    return session.with_document(session.document.reload())
