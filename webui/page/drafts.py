"""Edits that nobody has saved yet, kept in the project folder in case the server ends."""

import hashlib
import logging
import threading
import time
from dataclasses import dataclass
from pathlib import Path

from recipes.errors import RecipeError
from recipes.load import RECIPE
from reports.files.atomic_write import OutputError, write_text_atomically
from specs.yaml.load import read_text
from webui.page.browser_identity import Visitor

_FOLDER = Path(".washboard") / "unsaved"
_MOST = 50
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Draft:
    """An unsaved text that an earlier server left behind."""

    path: Path
    text: str
    written: str
    """When, as this machine's clock said: ``2026-11-21 17:42``."""


class Drafts:
    """Texts by who edits them and what they are of; their names on the disk are digests, so no name is an odd one.

    They are there to help: where they cannot be written, the page goes on without them.
    """

    def __init__(self, project: Path) -> None:
        """See what earlier servers left in a project folder.

        Args:
            project: Absolute, links resolved.
        """
        self._folder = project / _FOLDER
        self._usable = self._folder.resolve() == self._folder  # else a link leads somewhere else
        self._lock = threading.Lock()
        self._left = self._look() if self._usable else []

    def keep(self, visitor: Visitor, file: Path, text: str) -> None:
        """Keep the text that a visitor makes of a file."""
        path = self._path(visitor, file)
        if not self._usable or not visitor.browser:
            return
        try:
            with self._lock:
                self._folder.mkdir(parents=True, exist_ok=True)
                write_text_atomically(path, text)
        except (OSError, OutputError) as error:
            self._usable = False
            _log.warning("unsaved edits are not kept: %s", error)

    def forget(self, visitor: Visitor, file: Path) -> None:
        """Keep nothing of a visitor's any more: it is saved, or undone."""
        self._remove(self._path(visitor, file))

    def left_by(self, visitor: Visitor, file: Path) -> Draft | None:
        """Give the newest text that a browser made of a file and did not save before an earlier server ended."""
        begin = f"{_digest(visitor.browser)}-{_digest(str(file))}-"
        for path in self._left if visitor.browser else []:
            if path.name.startswith(begin) and path.is_file():
                try:
                    written = time.strftime("%Y-%m-%d %H:%M", time.localtime(path.stat().st_mtime))
                    return Draft(path, read_text(path, RECIPE), written)
                except (OSError, RecipeError):  # somebody was at it; it is no text of ours
                    continue
        return None

    def discard(self, draft: Draft) -> None:
        """Remove a text that was taken up, or that nobody wants."""
        with self._lock:
            self._left = [path for path in self._left if path != draft.path]
        self._remove(draft.path)

    def _look(self) -> list[Path]:
        """Find what is there, newest first; very many are not kept for ever."""
        try:
            found = [path for path in self._folder.glob("*.yaml") if path.is_file() and not path.is_symlink()]
            found.sort(key=lambda path: -path.stat().st_mtime_ns)
        except OSError:
            return []
        for path in found[_MOST:]:
            self._remove(path)
        return found[:_MOST]

    def _path(self, visitor: Visitor, file: Path) -> Path:
        return self._folder / f"{_digest(visitor.browser)}-{_digest(str(file))}-{_digest(visitor.tab)}.yaml"

    def _remove(self, path: Path) -> None:
        if self._usable:
            try:
                path.unlink(missing_ok=True)
            except OSError as error:
                _log.warning("%s: cannot be removed: %s", path, error)


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode(errors="surrogateescape")).hexdigest()[:16]
