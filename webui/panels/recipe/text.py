"""The YAML text of the recipe; undo, redo, open, save; unsaved edits that an ended server left behind."""

import hashlib
import logging
import threading
import time
from dataclasses import dataclass
from html import escape
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE
from specs.errors import JobError
from specs.output_file import OutputError, OutputFile, OutputFolder
from specs.progress import Progress, no_progress
from specs.yaml.load import read_text
from webui.forms.spec_form import reason_of
from webui.page.document import Document
from webui.page.page import BrowserIdentity, Page
from webui.page.session import READ_ONLY, Change, Session
from webui.panels.widgets.choices import buttons, html, show_while
from webui.panels.widgets.job import Dialog
from webui.scene.scene import Scene
from webui.theme.html import box_html, quiet_html, remark_html, sticky_html
from webui.theme.palette import ACCENT, QUIET, css_colour
from webui.threads.threads import Worker

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


_FOLDER = Path(".washboard") / "unsaved"
_MOST = 50
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Draft:
    """An unsaved text that an earlier server left behind."""

    path: Path
    text: str
    written: str
    """Local time, such as ``2026-11-21 17:42``."""


class Drafts:
    """Unsaved texts by browser and recipe file; their file names are digests, which are always valid.

    Where they cannot be written, the page works without them.
    """

    def __init__(self, project: Path) -> None:
        """Find the texts that earlier servers left in a project folder, newest first; very many are not kept.

        Args:
            project: Absolute, links resolved.
        """
        self._folder = project / _FOLDER
        self._usable = self._folder.resolve() == self._folder  # else a link leads somewhere else
        self._lock = threading.Lock()
        found: list[Path] = []
        try:
            found = [path for path in self._folder.glob("*.yaml") if path.is_file() and not path.is_symlink()]
            found.sort(key=lambda path: -path.stat().st_mtime_ns)
        except OSError:
            found = []
        self._left = found[:_MOST] if self._usable else []
        for path in found[_MOST:]:
            self._remove(path)

    def keep(self, identity: BrowserIdentity, file: Path, text: str) -> None:
        """Store a browser's unsaved text of a file."""
        path = self._path(identity, file)
        if not self._usable or not identity.browser:
            return
        try:
            with self._lock:
                OutputFolder(self._folder).make()
                OutputFile(path).write(text)
        except OutputError as error:
            self._usable = False
            _log.warning("unsaved edits are not kept: %s", error)

    def forget(self, identity: BrowserIdentity, file: Path) -> None:
        """Remove a browser's text of a file: it is saved, or undone."""
        self._remove(self._path(identity, file))

    def left_by(self, identity: BrowserIdentity, file: Path) -> Draft | None:
        """Newest text of a file that a browser did not save before an earlier server ended."""
        begin = f"{_digest(identity.browser)}-{_digest(str(file))}-"
        for path in self._left if identity.browser else []:
            if path.name.startswith(begin) and path.is_file():
                try:
                    written = time.strftime("%Y-%m-%d %H:%M", time.localtime(path.stat().st_mtime))
                    return Draft(path, read_text(path, RECIPE), written)
                except (OSError, RecipeError):  # it was changed by somebody else
                    continue
        return None

    def discard(self, draft: Draft) -> None:
        """Remove a text that was restored or discarded."""
        with self._lock:
            self._left = [path for path in self._left if path != draft.path]
        self._remove(draft.path)

    def _path(self, identity: BrowserIdentity, file: Path) -> Path:
        return self._folder / f"{_digest(identity.browser)}-{_digest(str(file))}-{_digest(identity.tab)}.yaml"

    def _remove(self, path: Path) -> None:
        if self._usable:
            try:
                OutputFile(path).remove()
            except OutputError as error:
                _log.warning("%s", error)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()[:16]


class UnsavedEdits:
    """Stores unsaved edits in the background, and offers those of an earlier server at first."""

    def __init__(self, page: Page, drafts: Drafts, identity: BrowserIdentity) -> None:
        """Set up the background worker."""
        self._page, self._drafts, self._identity = page, drafts, identity
        self._worker: Worker[None] = Worker(no_progress)
        self._before: Document | None = None
        """Document that was shown last."""
        page.follow(self._show, lambda now: now.document)

    def _show(self, session: Session) -> None:
        """Store the text of a session, or remove it when it is saved."""
        document, before, self._before = session.document, self._before, session.document
        if before is None and not document.dirty:
            draft = self._drafts.left_by(self._identity, document.file)
            if draft is not None and draft.text != document.text:
                self._offer(draft)
            return

        def store(_progress: Progress) -> None:
            if before is not None and before.file != document.file:
                self._drafts.forget(self._identity, before.file)
            if document.dirty:
                self._drafts.keep(self._identity, document.file, document.text)
            else:
                self._drafts.forget(self._identity, document.file)

        self._worker.start(store, lambda _: None, self._page.report)

    def _offer(self, draft: Draft) -> None:
        name = self._page.session.document.file.name
        note = f"The server ended before your edits of {name} were saved. They are from {draft.written}."

        def finish(*, restore: bool) -> Change:
            def change(session: Session) -> Session:
                after = session.edited(draft.text) if restore else session
                self._drafts.discard(draft)
                return after

            return change

        restored, discarded = finish(restore=True), finish(restore=False)
        dialog = Dialog(self._page, "Unsaved edits", note)
        dialog.buttons(
            {"Restore them": lambda _name, _choice: restored, "Discard them": lambda _name, _choice: discarded}
        )
