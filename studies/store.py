"""Finished results of a study on disk: one file for each job, by its key, whole or not there."""

import fcntl
import json
import os
import re
from collections.abc import Generator
from contextlib import contextmanager
from itertools import islice
from pathlib import Path

from reports.files.atomic_write import OutputError, output_errors, write_bytes_atomically
from reports.files.write_run import check_folder, json_bytes
from studies.errors import StudyError
from studies.job import JobResult

RESULTS = "results"
_SHARE = 2
"""Letters of the key that name the folder of its result: a folder stays small."""
_SHARED = re.compile(f"[0-9a-f]{{{_SHARE}}}")
_LOOKED_AT = 4


class ResultStore:
    """Results in a folder; equal jobs share one."""

    def __init__(self, folder: Path) -> None:
        """Use the folder of a study."""
        self._results = folder / RESULTS

    def find(self, key: str) -> JobResult | None:
        """Read the result of a job; ``None`` where there is none, or a file that is something else."""
        try:
            data = json.loads(self._place(key).read_bytes())
            result = JobResult.of(data)
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return None
        return result if result.job == key else None

    def keep(self, result: JobResult) -> None:
        """Write a result.

        Raises:
            OutputError: it cannot be written, as on a full disk; those that are there stay.
        """
        place = self._place(result.job)
        with output_errors(place):
            place.parent.mkdir(parents=True, exist_ok=True)
        write_bytes_atomically(place, json_bytes(result.data()), known_as=self._results)

    def _place(self, key: str) -> Path:
        return self._results / key[:_SHARE] / f"{key}.json"


def holds_results(folder: Path) -> bool:
    """Whether a folder is that of a study's results: as many files as there are jobs, which nobody names."""
    if folder.name != RESULTS:
        return False
    try:
        with os.scandir(folder) as entries:
            return all(_SHARED.fullmatch(entry.name) is not None for entry in islice(entries, _LOOKED_AT))
    except OSError:
        return False


@contextmanager
def open_store(folder: Path) -> Generator[ResultStore]:
    """Open the folder of a study, made where there is none, and keep other studies out of it.

    Raises:
        OutputError: it cannot be written, or holds something that is no study.
        StudyError: another study uses it.
    """
    check_folder(folder)
    with output_errors(folder):
        if folder.is_dir() and not (folder / RESULTS).is_dir() and any(folder.iterdir()):
            raise OutputError(folder, "the folder holds something else", "Name a folder of its own.")
        (folder / RESULTS).mkdir(parents=True, exist_ok=True)
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise StudyError("another study uses this folder. Wait for it, or name another.", file=folder) from None
        yield ResultStore(folder)
    finally:
        os.close(descriptor)
