"""Writing several files that belong together: all of them or none."""

import os
import re
import shutil
from collections.abc import Mapping
from pathlib import Path

from reports.files.atomic_write import OutputError, write_bytes_atomically


def place_files(out: Path, names: list[str]) -> Path:
    """Say where files go: a single one to ``out``, or into it where that is a folder; several into the folder ``out``.

    Raises:
        OutputError: they cannot be written there, or something else lies there.
    """
    try:
        if len(names) == 1:
            return out / names[0] if out.is_dir() else out
        _check_folder(out, names)
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from None
    return out


def write_files(out: Path, files: Mapping[str, str]) -> list[Path]:
    """Write files so that after any failure what stood there before still does; give their paths.

    A folder that holds an earlier set of the same files is replaced as a whole.

    Raises:
        OutputError: they cannot be written.
    """
    place = place_files(out, list(files))
    if len(files) == 1:
        write_bytes_atomically(place, next(iter(files.values())).encode("ascii"))
        return [place]
    try:
        _replace_folder(Path(os.path.realpath(place)), files)
    except (OSError, ValueError) as error:
        raise OutputError(out, getattr(error, "strerror", None) or str(error)) from None
    return [place / name for name in files]


def _check_folder(out: Path, names: list[str]) -> None:
    """Refuse a place that is no folder, or one that holds anything but such files as are to be written."""
    if not out.exists():
        if not out.parent.is_dir():
            raise OutputError(out, f"there is no folder {out.parent}", "Make it, or name another place.")
        return
    if not out.is_dir():
        raise OutputError(out, f"{len(names)} files are to be written and this is one", "Name a folder.")
    known = {_family(name) for name in names}
    for entry in sorted(out.iterdir()):
        if entry.is_symlink() or not entry.is_file() or _family(entry.name) not in known:
            raise OutputError(out, f"the folder holds something else, {entry.name}", "Name a folder of its own.")


def _family(name: str) -> str:
    """A file's name without the numbers that count the parts of a program."""
    return re.sub(r"\d+", "#", name.lower())


def _replace_folder(target: Path, files: Mapping[str, str]) -> None:
    fresh = target.with_name(f".{target.name[:200]}.{os.getpid()}.new")
    stale = target.with_name(f".{target.name[:200]}.{os.getpid()}.old")
    try:
        fresh.mkdir()
        for name, text in files.items():
            with (fresh / name).open("xb") as file:
                file.write(text.encode("ascii"))
                file.flush()
                os.fsync(file.fileno())
        if target.exists():
            target.rename(stale)
        try:
            fresh.rename(target)
        except OSError:
            if stale.exists():
                stale.rename(target)
            raise
    finally:
        shutil.rmtree(fresh, ignore_errors=True)
        shutil.rmtree(stale, ignore_errors=True)
