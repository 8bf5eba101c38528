"""Unsaved edits, stored in the project folder in case the server ends, and offered again by the next one."""

import hashlib
import logging
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE
from reports.files.atomic_write import OutputError, write_text_atomically
from specs.progress import Progress, no_progress
from specs.yaml.load import read_text
from webui.page.browser_identity import BrowserIdentity
from webui.page.document import Document
from webui.page.page import Page
from webui.page.session import Change, Session
from webui.panels.widgets.dialog import Dialog
from webui.threads.worker import Worker

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
                self._folder.mkdir(parents=True, exist_ok=True)
                write_text_atomically(path, text)
        except (OSError, OutputError) as error:
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
                path.unlink(missing_ok=True)
            except OSError as error:
                _log.warning("%s: cannot be removed: %s", path, error)


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
