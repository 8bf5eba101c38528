"""The files that may be read while a page is served, and those that a data file may name.

A file's content, or a browser, names other files: a recipe what it extends, a cell its robot and meshes, a glTF its
data. Where a page is served, nothing but the project folder and the libraries may be read by any of these ways. One
function decides, in the one place where files are read (``specs/input_file.py``), so no reader can leave it out
(docs/adr/0018).
"""

import os
import threading
from collections.abc import Generator, Iterable
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True, slots=True, eq=False)
class Confinement:
    """What may be read for one page."""

    folders: tuple[Path, ...]
    """Folders that may be read with all below, links resolved; the first one is named in messages."""
    files: frozenset[Path] = frozenset()
    """Files elsewhere that may be read too, links resolved: those that the command line named, and what they named."""


_confinements: tuple[Confinement, ...] = ()
"""Of the pages that this process serves; without any, every file may be read."""
_records: tuple[tuple[set[Path], set[Path], frozenset[Path]], ...] = ()
"""Files that are read; those that the work itself writes, which to read again makes no inputs; and all it writes."""
_LOCK = threading.Lock()
"""Held where either of them is replaced: pages read from several threads."""


def confine(confinement: Confinement) -> None:
    """Let this process read what a confinement allows and nothing else, in all threads, until it is released."""
    global _confinements
    with _LOCK:
        _confinements = (*_confinements, confinement)


def release(confinement: Confinement) -> None:
    """End a confinement; the last one that ends opens all files again."""
    global _confinements
    with _LOCK:
        _confinements = tuple(each for each in _confinements if each is not confinement)


def refusal(file: Path) -> str:
    """Reason not to read a file, the same whether it exists or not; empty where it may be read.

    Links are followed, as reading it would.
    """
    confinements = _confinements
    if not confinements:
        for record, own, written in _records:
            if (found := resolve(file)) not in own:
                record.add(found)
                if found in written:
                    return "is to be written by this command, which reads it; name another file for the output"
        return ""
    found = resolve(file)
    for each in confinements:
        if found in each.files or any(found.is_relative_to(folder) for folder in each.folders):
            return ""
    return f"is outside the project folder {confinements[0].folders[0]}; copy it there"


@contextmanager
def admit(*files: Path) -> Generator[None]:
    """Allow some files elsewhere for a while, such as temporary ones."""
    admitted = Confinement((), frozenset(map(resolve, files)))
    if not _confinements:
        yield
        return
    confine(admitted)
    try:
        yield
    finally:
        release(admitted)


@contextmanager
def record_reads(*own: Path, written: Iterable[Path] = ()) -> Generator[set[Path]]:
    """Collect the files that are read meanwhile, links resolved, but for its own, such as one edited in its place.

    Of those to be written none is read before, also where an input names it, but for its own.
    """
    global _records
    record: set[Path] = set()
    with _LOCK:
        _records = (*_records, (record, set(map(resolve, own)), frozenset(map(resolve, written))))
    try:
        yield record
    finally:
        with _LOCK:
            _records = tuple(each for each in _records if each[0] is not record)


def was_read(file: Path) -> bool:
    """Whether a file is among those that are recorded, under whatever name: a board that a panel names, for one."""
    with suppress(OSError, ValueError):
        found = file.stat()
        return any(_is_same(each, found) for record, *_ in _records for each in (*record,))
    return False


def note_own(file: Path) -> None:
    """Note a file that is written now: it may be read, and written again, as tuning does."""
    for _, own, _ in _records:
        own.add(resolve(file))


def _is_same(file: Path, found: os.stat_result) -> bool:
    with suppress(OSError, ValueError):
        return os.path.samestat(file.stat(), found)
    return False


def find_beside(name: str, file: Path) -> Path:
    """File of a name that a data file from elsewhere, such as a glTF, gives to another one.

    Args:
        name: As the file spells it: a relative path in its own folder, or in one below.
        file: The file that names it.

    Raises:
        ValueError: it is none, or leads out of that folder, also by way of a link; the message is a sentence's end.
    """
    if not name or "\0" in name:
        raise ValueError("cannot be the name of a file")
    folder, found = resolve(file.parent), resolve(file.parent / name)
    if Path(name).is_absolute() or not found.is_relative_to(folder) or found == folder:
        raise ValueError("is outside the folder of the file that names it")
    return file.parent / name


def resolve(file: Path) -> Path:
    """Resolve all links in a path; a path that cannot be followed stays as it is."""
    try:
        return file.resolve()
    except (OSError, RuntimeError, ValueError):  # links in a circle, a NUL
        return file.absolute()
