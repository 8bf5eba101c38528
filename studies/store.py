"""Finished results of a study on disk: one file for each job, by its key, whole or not there."""

import json
import os
import re
from collections.abc import Generator
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path

from reports.files.write_run import json_bytes
from specs.errors import JobError
from specs.input_file import InputFile
from specs.json import content_sha256
from specs.output_file import OutputError, OutputFile, OutputFolder, output_errors
from studies.errors import StudyError
from studies.job import JobResult

RESULTS = "results"
_CHECKSUM = "sha256"
"""Of all else in a file: a number that was changed is computed anew."""
_SHARE = 2
"""Letters of the key that name the folder of its result: a folder stays small."""
_SHARED = re.compile(f"[0-9a-f]{{{_SHARE}}}")
_LOOKED_AT = 4
_LARGEST = 1_000_000_000


class ResultStore:
    """Results in a folder; equal jobs share one."""

    def __init__(self, folder: Path) -> None:
        """Use the folder of a study."""
        self._results = folder / RESULTS

    def find(self, key: str) -> JobResult | None:
        """Read the result of a job; ``None`` where there is none that can be read."""
        with suppress(JobError):
            return self.read(key)
        return None

    def read(self, key: str) -> JobResult:
        """Read the result of a job that was kept.

        Raises:
            StudyError: it is not there any more, cannot be read, or is something else.
        """
        file = InputFile(self._place(key), StudyError, "result of a study", _LARGEST, "start the study again")
        with suppress(ValueError, KeyError, TypeError, AttributeError):
            data = json.loads(file.read())
            checksum = data.pop(_CHECKSUM)
            result = JobResult.of(data)
            if result.job == key and checksum == content_sha256(data):
                return result
        raise StudyError("is not the result that was kept; start the study again", file=file.path)

    def keep(self, result: JobResult) -> None:
        """Write a result.

        Raises:
            OutputError: it cannot be written, as on a full disk; those that are there stay.
        """
        place = self._place(result.job)
        OutputFolder(place.parent).make()
        data = result.data()
        OutputFile(place).write(json_bytes({**data, _CHECKSUM: content_sha256(data)}), known_as=self._results)

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
        OutputError: it cannot be written, holds something that is no study, or another study uses it.
    """
    place = OutputFolder(folder)
    place.check()
    with output_errors(folder):
        names = {each.name for each in folder.iterdir()} if folder.is_dir() else set[str]()
        results = folder / RESULTS
        if names and not (holds_results(results) and (names == {RESULTS} or any(results.iterdir()))):
            raise OutputError(folder, "the folder holds something else", "Name a folder of its own.")
    OutputFolder(folder / RESULTS).make()
    with place.locked():
        yield ResultStore(folder)
