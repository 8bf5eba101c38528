"""The project folder, which a page reads and writes, and nothing outside of it."""

import os
import re
import unicodedata
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path, PurePath

from boards.load import SUFFIXES, board_library
from boards.part.sources import CLOUD_SUFFIXES, part_library
from cleaning.parameters.load import load_parameters, parameter_library
from cleaning.parameters.model import Parameters
from programs.foreign import suffixes
from recipes.load import recipe_library
from robotcell.cell.load import LoadedCell, cell_library, read_cell
from robotcell.cell.robot_library import robot_library
from specs.confinement import admit, resolve
from specs.errors import JobError
from specs.input_file import InputFile
from specs.output_file import OutputFile
from specs.temporary import temporary_folder, write_temporary
from studies.results.read_tables import begins_runs
from studies.store import holds_results
from webui.page.document import Document, open_document

LARGEST_UPLOAD = 200_000_000
"""Bytes of one file."""
_LARGEST_TABLE = 20_000_000
_MOST_FILES = 500
_MOST_FOLDERS = 2000
_DEEPEST = 4
_LONGEST_NAME = 400
_LONGEST_FILE = 200
"""Bytes of an uploaded file's name: file systems take 255, and what is written goes by a longer name for a moment."""
_NAME = re.compile(r"\w[\w .+@()-]*")
_RECIPES = (".yaml", ".yml")
_MATRIX = "matrix/matrix"
"""File that every ODB++ job has."""
_HEAD = 20_000
_POINT = rb"^[ \t]*[-+.\d][-+.\deE]*(?:[ \t]*[ \t,;][ \t]*[-+.\d][-+.\deE]*){2}"
"""A line of a cloud of points: other texts are no workpieces."""
_WORKPIECES = (*SUFFIXES, *CLOUD_SUFFIXES)
"""What the name of an upload may end with."""


class ProjectError(JobError):
    """A file that the browser names cannot be used."""


@dataclass(frozen=True, slots=True)
class Stored:
    """A stored upload."""

    name: str
    """Its name in the folder."""
    fresh: bool
    """Whether it was not there before."""


@dataclass(frozen=True, slots=True)
class Project:
    """A folder with boards, parts and recipes, besides the libraries that come along."""

    folder: Path
    """Absolute, links resolved."""

    def workpieces(self) -> list[str]:
        """Names to choose from: sample boards and parts first, then files of the folder, relative to it.

        ODB++ jobs are folders, whose names end with ``/``.
        """
        return [*board_library(), *part_library(), *self.own_workpieces()]

    def own_workpieces(self) -> list[str]:
        """Names of the boards and parts that are files or folders of the project."""
        files = [name for key in ("panel", "part") for name in self._files_with_key(key)]
        jobs = [name[: -len(_MATRIX)] for name in self._files((f"/{_MATRIX}",))]
        clouds = self._files_with(_POINT, CLOUD_SUFFIXES)
        return [*self._files(SUFFIXES), *clouds, *jobs, *files]

    def workpiece_source(self, name: str) -> str | Path:
        """Name of a library, or file or folder in the folder, of a name that a browser sent.

        Raises:
            ProjectError: it is outside the folder.
        """
        return name if name in board_library() or name in part_library() else self.locate_entry(name)

    def recipes(self) -> list[str]:
        """Names to choose from: library recipes first, then files of the folder, relative to it."""
        return [*recipe_library(), *self._files(_RECIPES)]

    def cells(self) -> list[str]:
        """Names to choose from: library cells first, then files of the folder with the key ``cell``."""
        return [*cell_library(), *self._files_with_key("cell")]

    def open_cell(self, name: str) -> LoadedCell:
        """Read a cell by a name that a browser sent.

        Raises:
            ProjectError: it is outside the folder.
            CellError: it cannot be used.
        """
        return read_cell(name if name in cell_library() else self.locate(name))

    def programs(self) -> list[str]:
        """Programs in robots' languages to choose from: folders that hold some, ending with ``/``, then files."""
        files = self._files(tuple(sorted(suffixes())))
        folders = sorted({f"{PurePath(name).parent.as_posix()}/" for name in files if "/" in name})
        return [*folders, *files][:_MOST_FILES]

    def locate_entry(self, name: str) -> Path:
        """File or, with ``/`` at its end, folder of a name that a browser sent.

        Raises:
            ProjectError: it is not inside the folder, or is neither.
        """
        if not name.endswith("/"):
            return self.locate(name)
        folder = self.locate(f"{name}file").parent
        if not folder.is_dir():
            raise ProjectError(f"{name!r} is no folder; choose one of the list.")
        return folder

    def studies(self) -> list[str]:
        """Tables of the runs of studies to choose from."""
        return [name for name in self._files((".csv",)) if begins_runs(self._head(name))]

    def find_named(self, name: str, beside: str) -> str:
        """Name in the folder of a file that a study names: looked for from the folder of its table on up.

        Args:
            name: As the study has it, relative to its own folder, which the table does not name.
            beside: Name of the study's table.

        Raises:
            ProjectError: no folder above the table has such a file.
        """
        if PurePath(name).is_relative_to(self.folder):
            return PurePath(name).relative_to(self.folder).as_posix()
        for folder in PurePath(beside).parents:
            place = os.path.normpath(folder / name)
            with suppress(ProjectError):
                if self.locate(place).exists():
                    return PurePath(place).as_posix()
        raise ProjectError(f"{name[:80]!r} is not in {self.folder}, or in no folder above the study's; copy it there.")

    def owns_cell(self, loaded: LoadedCell) -> bool:
        """Whether the file of a cell is in the folder and none of the library."""
        file = resolve(Path(loaded.root.mark.file))
        return file not in map(resolve, cell_library().values()) and file.is_relative_to(self.folder)

    def place_of_edited_cell(self, loaded: LoadedCell) -> tuple[str, Path]:
        """Name and file that a cell gets when it is edited: its own in the folder, else those of a copy.

        Raises:
            ProjectError: too many copies are there.
        """
        file = resolve(Path(loaded.root.mark.file))
        if self.owns_cell(loaded):
            return file.relative_to(self.folder).as_posix(), file
        for number in range(1, _MOST_FILES):
            name = f"my-{file.stem}{'' if number == 1 else f'-{number}'}.yaml"
            if not os.path.lexists(self.folder / name):
                return name, self.folder / name
        raise ProjectError(f"my-{file.stem}.yaml: too many copies are in {self.folder}; remove some.")

    def parameter_sets(self) -> list[str]:
        """Names to choose from: sets of the library first, then files of the folder with the key ``parameters``."""
        return [*parameter_library(), *self._files_with_key("parameters")]

    def open_parameters(self, name: str) -> Parameters:
        """Read a parameter set by a name that a browser sent.

        Raises:
            ProjectError: it is outside the folder.
            CleaningError: it cannot be used.
        """
        return load_parameters(name if name in parameter_library() else self.locate(name))

    def locate(self, name: str) -> Path:
        """File of a name that a browser sent; it need not exist yet.

        Raises:
            ProjectError: it is not a plain relative path to a file inside the folder.
        """
        if not _can_name(name):
            raise ProjectError(f"{name[:40]!r} cannot name a file; choose one of the list.")
        parts = PurePath(name).parts
        if not parts or any(part.startswith(".") and part != ".." for part in parts):
            raise ProjectError(f"{name!r}: hidden files and folders are left alone; choose one of the list.")
        try:
            path = (self.folder / name).resolve()
        except (OSError, RuntimeError):  # links that run in circles
            raise ProjectError(f"{name!r} leads nowhere; choose one of the list.") from None
        if PurePath(name).is_absolute() or ".." in parts or not path.is_relative_to(self.folder):
            raise ProjectError(f"{name!r} is outside the project folder {self.folder}; copy it there first.")
        try:
            exists = path.exists()
        except OSError as error:
            reason = f"({error.strerror}); choose another name."
            raise ProjectError(f"{path.name[:40]!r} cannot name a file {reason}") from None
        if exists and not path.is_file():
            raise ProjectError(f"{name!r} is no file; choose one of the list.")
        return path

    def open_recipe(self, name: str) -> Document:
        """Open a recipe by a name that a browser sent.

        Raises:
            ProjectError: it is outside the folder.
            RecipeError: it cannot be used.
        """
        return open_document(name if name in recipe_library() else self.locate(name))

    def describe_recipe(self, name: str) -> str:
        """What a recipe of the list is for, in its own words; else the mistake that keeps it from being opened."""
        try:
            recipe = self.open_recipe(name).read().recipe
        except JobError as error:
            return str(error)
        return recipe.description or "It has no description."

    def recipe_file(self, name: str) -> Path:
        """File for a recipe under a name that a browser sent, with the suffix of recipes.

        Raises:
            ProjectError: it is not inside the folder.
        """
        return self.locate(name if name.endswith(_RECIPES) else f"{name}.yaml")

    def store(self, name: str, content: bytes) -> Stored:
        """Store an uploaded board or part in the folder; a file of that name with other content stays.

        Raises:
            ProjectError: name, kind or size cannot be used.
            OutputError: it cannot be written.
        """
        name = unicodedata.normalize("NFC", name)  # some systems send letters and their accents apart
        check_name(name)
        if not name.lower().endswith(_WORKPIECES):
            raise ProjectError(f"{name}: no reader for this kind of file. Known are {', '.join(_WORKPIECES)}.")
        if len(content) > LARGEST_UPLOAD:
            megabytes = len(content) / 1e6
            raise ProjectError(f"{name}: {megabytes:.0f} MB are too many to upload; copy it into {self.folder}.")
        path = self._free(name, content)
        fresh = not path.exists()
        if fresh:
            OutputFile(path).write(content)
        return Stored(path.name, fresh)

    def discard(self, name: str) -> None:
        """Remove a stored file that is no workpiece.

        Raises:
            ProjectError: the name is none that could have been stored.
            OutputError: it cannot be removed.
        """
        OutputFile(self.locate(name)).remove()

    def _free(self, name: str, content: bytes) -> Path:
        """Path of that name that is not taken, or is a file with the same content; links are left alone."""
        suffix = max((each for each in _WORKPIECES if name.lower().endswith(each)), key=len)
        stem, ending = name[: -len(suffix)], name[-len(suffix) :]
        for number in range(1, _MOST_FILES):
            path = self.folder / (name if number == 1 else f"{stem}-{number}{ending}")
            if not os.path.lexists(path) or OutputFile(path).holds(content):
                return path
        raise ProjectError(f"{name}: too many files of this name are in {self.folder}; remove some.")

    def _files(self, suffixes: tuple[str, ...]) -> list[str]:
        """Files by their suffix, shallow ones first; links and hidden ones are left out."""
        found: list[str] = []
        folders = [""]
        for visited, here in enumerate(folders):
            if visited == _MOST_FOLDERS or len(found) >= _MOST_FILES:
                break
            entries = _entries(self.folder / here)
            is_job = {"matrix", "steps"} <= {entry.name.lower() for entry in entries}
            for entry in entries:
                name = f"{here}{entry.name}"
                if is_job and entry.name.lower() != "matrix":  # nobody names the files of an ODB++ job
                    continue
                if entry.is_dir(follow_symlinks=False) and name.count("/") < _DEEPEST:
                    if not holds_results(self.folder / name):
                        folders.append(f"{name}/")
                elif entry.is_file(follow_symlinks=False) and name.lower().endswith(suffixes):
                    found.append(name)
        return found[:_MOST_FILES]

    def _files_with_key(self, key: str) -> list[str]:
        """YAML files with a key near their beginning."""
        return self._files_with(rb"^" + key.encode() + rb"\s*:", _RECIPES)

    def _files_with(self, pattern: bytes, suffixes: tuple[str, ...]) -> list[str]:
        """Files by their suffix with a pattern near their beginning, without parsing them."""
        return [name for name in self._files(suffixes) if re.search(pattern, self._head(name), re.MULTILINE)]

    def _head(self, name: str) -> bytes:
        """The beginning of a file; nothing of one that cannot be read, which is an entry of no list."""
        with suppress(JobError):
            return InputFile(self.folder / name).head(_HEAD)
        return b""


def library_folders() -> tuple[Path, ...]:
    """Folders of the boards, parts, recipes, parameter sets, cells and robots that come along."""
    libraries = board_library(), part_library(), recipe_library(), parameter_library(), cell_library(), robot_library()
    return tuple(sorted({resolve(file.parent) for library in libraries for file in library.values()}))


def open_project(folder: Path) -> Project:
    """Open a folder.

    Raises:
        ProjectError: there is no such folder.
    """
    if not folder.is_dir():
        raise ProjectError(f"{folder}: no such folder; name the one that holds your boards and recipes.")
    return Project(folder.resolve())


@contextmanager
def uploaded_table(name: str, content: bytes, stored: str, what: str) -> Generator[Path]:
    """An uploaded table as a file of another name, which may be read until it is removed at the end.

    Raises:
        ProjectError: it is too large.
    """
    if len(content) > _LARGEST_TABLE:
        raise ProjectError(f"{name[:40]!r}: {len(content) / 1e6:.0f} MB are too many for {what}.")
    with temporary_folder() as folder:
        table = write_temporary(folder, stored, content)
        with admit(table):
            yield table


def check_name(name: str) -> None:
    """Refuse the name of an upload that cannot be that of a file everywhere.

    Raises:
        ProjectError: it is none.
    """
    if _NAME.fullmatch(name) is None:
        raise ProjectError(f"{name[:40]!r} cannot be kept; use letters, digits, blanks and . _ - + in its name.")
    if len(name.encode()) > _LONGEST_FILE:
        raise ProjectError(f"{name[:40]!r}… is too long a name; shorten it to {_LONGEST_FILE} bytes.")


def _can_name(name: str) -> bool:
    """Whether a name may be that of a file; lone surrogates can neither be sent to a browser nor come from one."""
    try:
        name.encode()
    except UnicodeEncodeError:
        return False
    return bool(name) and len(name) <= _LONGEST_NAME and name.isprintable()


def _entries(folder: Path) -> list[os.DirEntry[str]]:
    """Entries of a folder that can be listed, by name; none where it must not be read."""
    try:
        with os.scandir(folder) as entries:
            seen = [entry for entry in entries if not entry.name.startswith(".") and _can_name(entry.name)]
    except OSError:
        return []
    return sorted(seen, key=lambda entry: entry.name)
