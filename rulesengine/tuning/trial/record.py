"""Records of trials as bytes, from which a tuning that was interrupted goes on without analysing them again.

A record holds what an analysis gave and a plan does not. It is plain data, JSON and 32-bit floats, and is checked where
it is read: nothing in it is executed.
"""

import json
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from typing import Protocol, cast

import numpy as np
from pydantic import TypeAdapter

from boards.board import Side
from cleaning.prepared_board import PreparedBoard
from rulesengine.tuning.trial.outcome import (
    Deposit,
    Deposits,
    Outcome,
    Planned,
    StepSummary,
    classes_of,
    judged_cells,
    sides_of,
)
from rulesengine.tuning.trial.requirements import BOARD, MetRequirement, UnmetRequirement
from rulesengine.tuning.trial.robot_times import ProgramTimes
from specs.source import Source

_LEVEL = 1
"""Of the compression: amounts hardly compress, the cells of the other side do."""
_FLOAT = np.dtype("<f4")


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
class _Content:
    """What a record holds besides amounts."""

    unmet: tuple[UnmetRequirement, ...]
    met: tuple[MetRequirement, ...]
    steps: tuple[StepSummary, ...]
    makers: dict[str, tuple[tuple[Source, float], ...]]
    residues: dict[str, float]
    excluded: frozenset[str]
    total: int
    seconds: float
    litres: float
    shortfall: float
    deposits: tuple[tuple[str, str, float], ...]
    """Step, template and seconds of each."""
    board_sides: tuple[Side, ...]
    """Sides whose bare board has cells."""
    robot: tuple[float, float, tuple[tuple[str, str, float], ...]] | None
    """Seconds, litres and spraying times of the robot's program, with a cell."""


@dataclass(frozen=True, slots=True)
class Infeasible:
    """Record of a recipe that the robot cannot carry out."""

    reason: str


_CONTENT = TypeAdapter(_Content)


def encode_infeasible(reason: str) -> bytes:
    """Record that the robot cannot carry out a recipe."""
    return _pack({"infeasible": reason}, b"")


def encode_outcome(outcome: Outcome, robot: ProgramTimes | None) -> bytes:
    """Record what an analysis gave, and what the robot of a cell takes."""
    deposits = outcome.deposits
    content = _Content(
        outcome.unmet,
        outcome.met,
        outcome.steps,
        dict(outcome.makers),
        dict(outcome.residues),
        outcome.excluded,
        outcome.total,
        outcome.seconds,
        outcome.litres,
        outcome.shortfall,
        tuple((each.step, each.template, each.seconds) for each in deposits.each),
        tuple(side for name, side in deposits.cells if name == BOARD),
        None if robot is None else (robot.seconds, robot.litres, _rows(robot.sprayed)),
    )
    amounts = b"".join(each.volume_mm.astype(_FLOAT).tobytes() for each in deposits.each)
    return _pack(content, amounts)


def decode(
    record: bytes, planned: Planned, prepared: PreparedBoard, text: str
) -> Infeasible | tuple[Outcome, ProgramTimes | None]:
    """Restore an outcome and the robot's times, or that the robot cannot carry the recipe out.

    Raises:
        ValueError: it is no record of this board.
    """
    head, amounts = _unpack(record)
    if "infeasible" in head:
        return Infeasible(str(head["infeasible"]))
    content = _CONTENT.validate_python(head)
    facets = prepared.facets
    count = len(facets.cell_areas_mm2)
    volumes = np.frombuffer(amounts, _FLOAT).reshape(len(content.deposits), count).astype(np.float32)
    each = tuple(Deposit(*names, volume) for names, volume in zip(content.deposits, volumes, strict=True))
    cells = judged_cells(facets, prepared.board, content.board_sides)
    outcome = Outcome(
        text=text,
        recipe=planned.fitted,
        unmet=content.unmet,
        met=content.met,
        steps=content.steps,
        classes=classes_of(planned),
        sides=sides_of(planned),
        makers=content.makers,
        residues=content.residues,
        excluded=content.excluded,
        total=content.total,
        seconds=content.seconds,
        litres=content.litres,
        shortfall=content.shortfall,
        deposits=Deposits(each, facets.cell_areas_mm2, cells),
    )
    if content.robot is None:
        return outcome, None
    seconds, litres, rows = content.robot
    return outcome, ProgramTimes(seconds, litres, {(step, template): each for step, template, each in rows})


def _rows(sprayed: Mapping[tuple[str, str], float]) -> tuple[tuple[str, str, float], ...]:
    return tuple((*key, seconds) for key, seconds in sprayed.items())


def _pack(head: Mapping[str, object] | _Content, amounts: bytes) -> bytes:
    text = json.dumps(head, separators=(",", ":"), default=_plain).encode()
    return zlib.compress(text + b"\n" + amounts, _LEVEL)


def _plain(value: object) -> object:
    """Sets as lists, in an order that does not depend on the process; nouns by the names of their fields.

    ``asdict`` would copy all that they hold first.
    """
    if isinstance(value, frozenset):
        return sorted(cast("frozenset[str]", value))
    if is_dataclass(value):
        return {each.name: getattr(value, each.name) for each in fields(value)}
    raise TypeError(type(value))


def _unpack(record: bytes) -> tuple[dict[str, object], bytes]:
    try:
        text, _, amounts = zlib.decompress(record).partition(b"\n")
    except zlib.error as error:
        raise ValueError(str(error)) from None
    return cast("dict[str, object]", json.loads(text)), amounts
