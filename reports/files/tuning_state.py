"""State of a tuning on disk, from which it goes on after an interrupt: trials one after the other in one file.

The first line is what the tuning depends on, as JSON. Each record after it has a checksum: of one that was being
written when the process ended nothing is read. The file is locked while a tuning uses it, and removed at its end.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from struct import Struct, error
from typing import TYPE_CHECKING

from cleaning.parameters.load import parameters_sha256
from recipes.load import parse_recipe, recipe_sha256
from robotcell.cell.load import cell_sha256
from rulesengine.tuning.trial.request import request_sha256
from specs.errors import JobError, printable
from specs.input_file import InputFile
from specs.json import content_sha256
from specs.output_file import OutputError, OutputFile, output_errors

if TYPE_CHECKING:
    from boards.board import Board
    from cleaning.parameters.model import Parameters
    from robotcell.cell.load import LoadedCell
    from rulesengine.tuning.trial.request import TuningRequest

_VERSION = 1
_NAME = "washboard_tuning_state"
_HEAD = Struct(">c32sQ")
"""Kind, SHA-256 of the recipe's text or of an output, length of the record."""
_TRIAL, _WRITTEN = b"T", b"W"
_DIGEST = 32
_MOST_HEAD = 10_000
SUFFIX = ".tuning"


class StateError(JobError):
    """A tuning cannot go on from its state."""

    def __init__(self, path: Path, reason: str, advice: str) -> None:
        """State which file, why, and what to do."""
        super().__init__(printable(f"{path}: the tuning cannot go on from it: {reason}. {advice}"))
        self.path = path


def state_place(output: Path) -> Path:
    """Where the state of a tuning is kept that writes a recipe."""
    return output.with_name(output.name + SUFFIX)


def fingerprints_of(
    recipe: tuple[Path, str], board: Board, parameters: Parameters, cell: LoadedCell | None, request: TuningRequest
) -> dict[str, str]:
    """Fingerprints of all that a tuning depends on, by name.

    Raises:
        RecipeError: the text, which stands in the file or in its place, cannot be used.
    """
    file, text = recipe
    return {
        "version": version("washboard"),
        "board": board.sha256,
        "recipe": content_sha256([recipe_sha256(parse_recipe(text, file=file)), text]),
        "parameter set": parameters_sha256(parameters),
        "cell": "" if cell is None else cell_sha256(cell),
        "choice of options": request_sha256(request),
    }


class TuningState:
    """Records of trials, by the text of the recipe, and of outputs; a ``TrialStore``."""

    def __init__(self, path: Path, descriptor: int) -> None:
        """Read a state that is open and locked; what follows the last whole record is cut off."""
        self.path, self._file = path, descriptor
        self._places: dict[bytes, tuple[int, int]] = {}
        """Of trials: offset and length."""
        self._written: set[bytes] = set()
        self._end = self._read()
        os.ftruncate(descriptor, self._end)

    def __len__(self) -> int:
        """Count the trials."""
        return len(self._places)

    def find(self, text: str) -> bytes | None:
        """Record of a recipe; ``None`` where there is none."""
        place = self._places.get(_hash(text.encode()))
        return None if place is None else os.pread(self._file, place[1], place[0])

    def add(self, text: str, record: bytes) -> None:
        """Keep a record."""
        key = _hash(text.encode())
        self._places[key] = self._append(_TRIAL, key, record), len(record)

    def note_output(self, content: bytes) -> None:
        """Keep in mind what is about to be written as the recipe."""
        key = _hash(content)
        if key not in self._written:
            self._append(_WRITTEN, key, b"")
            self._written.add(key)

    def has_written(self, content: bytes) -> bool:
        """Whether the tuning has written this as its recipe."""
        return _hash(content) in self._written

    def remove(self) -> None:
        """Remove the file: the tuning is done."""
        OutputFile(self.path).remove()

    def _append(self, kind: bytes, key: bytes, record: bytes) -> int:
        head = _HEAD.pack(kind, key, len(record))
        with output_errors(self.path):
            _write(self._file, head + record + _hash(head + record), self._end)
            os.fsync(self._file)
        begin = self._end + len(head)
        self._end = begin + len(record) + _DIGEST
        return begin

    def _read(self) -> int:
        """Read the places of all whole records; returns where they end."""
        size, at = os.fstat(self._file).st_size, len(_first_line(self._file))
        while at < size:
            head = os.pread(self._file, _HEAD.size, at)
            try:
                kind, key, length = _HEAD.unpack(head)
            except error:
                break
            begin = at + _HEAD.size
            if length > size - begin - _DIGEST:
                break
            record = os.pread(self._file, length, begin)
            if os.pread(self._file, _DIGEST, begin + length) != _hash(head + record):
                break
            if kind == _TRIAL:
                self._places[key] = begin, length
            else:
                self._written.add(key)
            at = begin + length + _DIGEST
        return at


@contextmanager
def open_state(path: Path, fingerprints: Mapping[str, str], *, resume: bool) -> Generator[TuningState]:
    """Open the state of a tuning, locked, to go on from it or as a new one.

    Args:
        path: The file.
        fingerprints: What the tuning depends on, by its name.
        resume: Whether to go on from what is there.

    Raises:
        StateError: there is none to go on from, or it is of something else.
        OutputError: it cannot be written there, or another process has it.
    """
    if resume and not path.exists():
        raise StateError(path, "there is none", "Leave out --resume to begin.")
    if not os.path.lexists(path):
        OutputFile(path).write(_line(fingerprints))
    with OutputFile(path).locked() as descriptor:
        with output_errors(path):
            if not resume:
                os.ftruncate(descriptor, 0)
                _write(descriptor, _line(fingerprints), 0)
            _check(path, descriptor, fingerprints)
            state = TuningState(path, descriptor)
        try:
            yield state
        except JobError:
            if not resume and not len(state):  # refused before the first trial: there is nothing to go on from
                state.remove()
            raise


def check_output(state: TuningState, output: Path) -> None:
    """Refuse to write over a recipe that is not as an interrupted tuning has left it.

    Raises:
        OutputError: it is another one.
    """
    if output.exists() and not state.has_written(InputFile(output, noun="recipe").read()):
        reason = "it was changed since the tuning was interrupted"
        raise OutputError(output, reason, "Move it away, or name a new file.")


def _line(fingerprints: Mapping[str, str]) -> bytes:
    return json.dumps({_NAME: _VERSION, **fingerprints}, sort_keys=True).encode() + b"\n"


def _first_line(descriptor: int) -> bytes:
    first, found, _ = os.pread(descriptor, _MOST_HEAD, 0).partition(b"\n")
    return first + found


def _check(path: Path, descriptor: int, fingerprints: Mapping[str, str]) -> None:
    advice = "Name another file with -o, or remove it and leave out --resume."
    try:
        known = json.loads(_first_line(descriptor))
    except ValueError:
        known = None
    if not isinstance(known, dict) or known.get(_NAME) != _VERSION:
        raise StateError(path, "it is no state of a tuning by this version", advice)
    differing = [name for name, value in fingerprints.items() if known.get(name) != value]
    if differing:
        raise StateError(path, f"it is of {' and '.join(f'another {name}' for name in differing)}", advice)


def _write(descriptor: int, data: bytes, offset: int) -> None:
    while data:
        written = os.pwrite(descriptor, data, offset)
        data, offset = data[written:], offset + written


def _hash(data: bytes) -> bytes:
    return hashlib.sha256(data).digest()
