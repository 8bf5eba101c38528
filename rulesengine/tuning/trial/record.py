"""Records of trials as bytes, from which a tuning that was interrupted goes on without analysing them again.

A record holds what an analysis gave and a plan does not. It is plain data, JSON and 32-bit floats, and is checked where
it is read: nothing in it is executed.
"""

import json
import zlib
from dataclasses import dataclass
from typing import Any, Protocol, get_type_hints

import numpy as np
from pydantic import TypeAdapter

from boards.board import Side
from cleaning.prepared_board import PreparedBoard
from rulesengine.tuning.trial.outcome import (
    Deposit,
    Deposits,
    Outcome,
    Planned,
    ProgramTimes,
    assemble_outcome,
    judged_cells,
)
from rulesengine.tuning.trial.requirements import BOARD

_FOUND: dict[str, TypeAdapter[Any]] = {
    name: TypeAdapter(get_type_hints(Outcome)[name])
    for name in ("unmet", "met", "steps", "makers", "residues", "total", "seconds", "litres")
}
"""Fields of an outcome that an analysis gives and a plan does not, besides amounts."""
_LEVEL = 1
"""Of the compression: amounts hardly compress, the cells of the other side do."""
_FLOAT = np.dtype("<f4")


@dataclass(frozen=True, slots=True)
class _Rest:
    """What a record holds besides them."""

    deposits: tuple[tuple[str, str, float], ...]
    """Step, template and seconds of each."""
    board_sides: tuple[Side, ...]
    """Sides whose bare board has cells."""
    robot: tuple[float, float, tuple[tuple[str, str, float], ...]] | None
    """Seconds, litres and spraying times of the robot's program, with a cell."""


_REST = TypeAdapter(_Rest)


class TrialStore(Protocol):
    """Where the records of trials are kept, by the text of the recipe."""

    def find(self, text: str) -> bytes | None:
        """Record of a recipe; ``None`` where there is none."""
        ...

    def add(self, text: str, record: bytes) -> None:
        """Keep a record."""
        ...


class MemoryStore:
    """Records that last as long as the process."""

    def __init__(self) -> None:
        """Begin without records."""
        self._records: dict[str, bytes] = {}

    def find(self, text: str) -> bytes | None:
        """Record of a recipe; ``None`` where there is none."""
        return self._records.get(text)

    def add(self, text: str, record: bytes) -> None:
        """Keep a record."""
        self._records[text] = record


@dataclass(frozen=True, slots=True)
class Infeasible:
    """Why the robot cannot carry out a recipe."""

    reason: str


def encode(found: Infeasible | tuple[Outcome, ProgramTimes | None]) -> bytes:
    """Record what an analysis gave and what the robot of a cell takes, or that it cannot carry the recipe out."""
    if isinstance(found, Infeasible):
        head, volumes = {"infeasible": found.reason}, list[bytes]()
    else:
        outcome, robot = found
        deposits = outcome.deposits
        volumes = [each.volume_mm.astype(_FLOAT).tobytes() for each in deposits.each]
        head = {name: adapter.dump_python(getattr(outcome, name)) for name, adapter in _FOUND.items()} | {
            "deposits": [(each.step, each.template, each.seconds) for each in deposits.each],
            "board_sides": [side for name, side in deposits.cells if name == BOARD],
            "robot": None
            if robot is None
            else (robot.seconds, robot.litres, [(*key, seconds) for key, seconds in robot.sprayed.items()]),
        }
    text = json.dumps(head, separators=(",", ":")).encode()
    return zlib.compress(b"".join([text, b"\n", *volumes]), _LEVEL)


def decode(
    record: bytes, planned: Planned, prepared: PreparedBoard, text: str
) -> Infeasible | tuple[Outcome, ProgramTimes | None]:
    """Restore an outcome and the robot's times, or that the robot cannot carry the recipe out.

    Raises:
        ValueError: it is no record of this board.
    """
    try:
        line, _, amounts = zlib.decompress(record).partition(b"\n")
    except zlib.error as error:
        raise ValueError(str(error)) from None
    head = json.loads(line)
    if "infeasible" in head:
        return Infeasible(str(head["infeasible"]))
    rest = _REST.validate_python({name: value for name, value in head.items() if name not in _FOUND})
    facets = prepared.facets
    count = len(facets.cell_areas_mm2)
    volumes = np.frombuffer(amounts, _FLOAT).reshape(len(rest.deposits), count).astype(np.float32)
    each = tuple(Deposit(*names, volume) for names, volume in zip(rest.deposits, volumes, strict=True))
    cells = judged_cells(facets, prepared.board, rest.board_sides)
    outcome = assemble_outcome(
        planned,
        text,
        Deposits(each, facets.cell_areas_mm2, cells),
        **{name: adapter.validate_python(head[name]) for name, adapter in _FOUND.items()},
    )
    if rest.robot is None:
        return outcome, None
    seconds, litres, rows = rest.robot
    return outcome, ProgramTimes(seconds, litres, {(step, template): each for step, template, each in rows})
