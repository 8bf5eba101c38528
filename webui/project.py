"""The folder a page may read from and write to, and nothing outside of it."""

import re
from dataclasses import dataclass
from pathlib import Path

from boards.load import SUFFIXES, board_library
from geometry.errors import JobError
from recipes.load import recipe_library
from rulesengine.output import write_bytes_atomically

_LARGEST_UPLOAD = 200_000_000
_MOST_FILES = 500
_DEEPEST = 4
_NAME = re.compile(r"[\w][\w .+@()-]{0,120}")
_RECIPES = (".yaml", ".yml")


class ProjectError(JobError):
    """A file that the browser names cannot be used."""


@dataclass(frozen=True, slots=True)
class Project:
    """A folder with boards and recipes, besides the libraries that come along."""

    folder: Path
    """Absolute, links resolved."""

    def boards(self) -> list[str]:
        """Names to choose from: samples first, then files of the folder, relative to it."""
        return [*board_library(), *self._files(SUFFIXES)]

    def recipes(self) -> list[str]:
        """Names to choose from: library recipes first, then files of the folder, relative to it."""
        return [*recipe_library(), *self._files(_RECIPES)]

    def locate(self, name: str) -> Path:
        """Find the file of a name that a browser sent.

        Raises:
            ProjectError: it is not a plain relative path to something inside the folder.
        """
        if not name or "\0" in name or len(name) > 400:
            raise ProjectError(f"{name[:40]!r} cannot name a file; choose one of the list.")
        path = (self.folder / name).resolve()
        if not path.is_relative_to(self.folder) or path == self.folder:
            raise ProjectError(f"{name} is outside the project folder {self.folder}; copy it there first.")
        return path

    def store(self, name: str, content: bytes) -> str:
        """Keep an uploaded board in the folder; a file of that name that holds something else stays.

        Returns:
            The name under which it is kept.

        Raises:
            ProjectError: name, kind or size cannot be used.
            OutputError: it cannot be written.
        """
        if _NAME.fullmatch(name) is None:
            raise ProjectError(f"{name[:40]!r} cannot be kept; use letters, digits, blanks and . _ - + in its name.")
        if not name.lower().endswith(SUFFIXES):
            raise ProjectError(f"{name}: no reader for this kind of file. Known are {', '.join(SUFFIXES)}.")
        if len(content) > _LARGEST_UPLOAD:
            megabytes = len(content) / 1e6
            raise ProjectError(f"{name}: {megabytes:.0f} MB are too many to upload; copy it into {self.folder}.")
        path = self._free(name, content)
        write_bytes_atomically(path, content)
        return path.name

    def _free(self, name: str, content: bytes) -> Path:
        stem, dot, suffix = name.partition(".")
        for number in range(1, _MOST_FILES):
            path = self.folder / (name if number == 1 else f"{stem}-{number}{dot}{suffix}")
            if not path.exists() or (path.is_file() and path.read_bytes() == content):
                return path
        raise ProjectError(f"{name}: too many files of this name are in {self.folder}; remove some.")

    def _files(self, suffixes: tuple[str, ...]) -> list[str]:
        found: list[str] = []
        folders = [self.folder]
        while folders and len(found) < _MOST_FILES:
            here = folders.pop(0)
            try:
                entries = sorted(here.iterdir())
            except OSError:
                continue
            for entry in entries:
                if entry.name.startswith(".") or entry.is_symlink():
                    continue
                if entry.is_dir() and len(entry.relative_to(self.folder).parts) < _DEEPEST:
                    folders.append(entry)
                elif entry.is_file() and entry.name.lower().endswith(suffixes):
                    found.append(str(entry.relative_to(self.folder)))
        return found[:_MOST_FILES]


def open_project(folder: Path) -> Project:
    """Open a folder.

    Raises:
        ProjectError: there is no such folder.
    """
    if not folder.is_dir():
        raise ProjectError(f"{folder}: no such folder; name the one that holds your boards and recipes.")
    return Project(folder.resolve())
