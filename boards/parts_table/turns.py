"""Turns that a parts table states, compared with the copper: how the pads of parts of one package lie in that frame."""

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from boards.board import Pad, Side
from boards.formats.names import natural_key, some
from boards.parts_table.read import Row
from boards.parts_table.tables import Statements
from specs.finding import Finding
from specs.finding_rules import PARTS_TURN

_SAME_MM = 0.15
"""Pads of two parts of one package lie upon each other within this."""
_CROSSWISE = 0.8
"""A quarter turn that makes the boxes of bodies and pads as small is taken."""
_QUARTER = math.pi / 2.0


@dataclass(frozen=True, slots=True, eq=False)
class TurnedPart:
    """A part whose turn a table states, with its pads. Board frame, mm."""

    row: Row
    side: Side
    pads: tuple[tuple[str, Pad], ...]
    """Pin, empty where it is not known, and pad."""
    stated_rad: float

    def pattern(self, turn_rad: float) -> NDArray[np.float64]:
        """Middles and sizes of its pads (n, 3) in its own frame, about their mean."""
        spots = np.array([(pad.x_mm, pad.y_mm) for _, pad in self.pads])
        cos, sin = math.cos(turn_rad), math.sin(turn_rad)
        turned = (spots - spots.mean(axis=0)) @ np.array([[cos, -sin], [sin, cos]])
        return np.column_stack([turned, [math.sqrt(pad.length_mm * pad.width_mm) for _, pad in self.pads]])


@dataclass(frozen=True, slots=True)
class Turns:
    """What the copper settles of the turns."""

    signs: dict[Side, float]
    """1 where the stated angles of a side are anticlockwise as seen from the top, else -1."""
    quarters: dict[str, int]
    """Quarter turns that are added, by designator; none of the others."""

    def turn_rad(self, row: Row, side: Side) -> float | None:
        """Turn of a part as seen from the top; ``None`` where no table states it."""
        if row.turn_deg is None:
            return None
        return self.signs.get(side, 1.0) * math.radians(row.turn_deg) + self.quarters.get(row.ref, 0) * _QUARTER


def judge_turns(
    parts: Sequence[TurnedPart], given: Statements, area: Callable[[TurnedPart, float], float] | None = None
) -> tuple[Turns, list[Finding]]:
    """Find how turns are counted, and the parts whose pads contradict their turn.

    Programs count turns of the bottom from above or from below, libraries from different quarters. The sense is the one
    under which the pads of parts of one package lie alike; the quarter is the one under which bodies lie along their
    pads. A part whose pads lie otherwise than those of most of its package is turned as they do.

    Args:
        parts: With pads and a turn.
        given: Takes what contradicts the copper.
        area: Of the box around body and pads of a part, for a turn; left out where bodies are known.
    """
    turns, counted, decided = Turns({}, {}), list[str](), set[str]()
    sides: tuple[Side, ...] = ("top", "bottom")
    for side in sides:
        here = [part for part in parts if part.side == side]
        groups: dict[str, list[TurnedPart]] = {}
        for part in here:
            groups.setdefault(part.row.package.casefold() or part.row.ref, []).append(part)
        sign, found = _sense(here, [*groups.values()])
        turns.signs[side] = sign
        if sign < 0.0:
            counted.append(f"those of the {side} {'clockwise' if side == 'top' else 'as seen from below'}")
        for group, compared in zip(groups.values(), found, strict=True):
            base = 0 if area is None else _quarter(group, sign, area)
            if base and len(group) > 1:
                counted.append(f"those of {group[0].row.package} from 90 degrees")
            for part, (quarters, is_decided) in zip(group, compared, strict=True):
                decided |= {part.row.ref} if is_decided else set()
                turns.quarters[part.row.ref] = taken = base + (quarters or 0)
                if quarters or (base and len(group) == 1):
                    angle = round(math.degrees(part.stated_rad) + sign * 90.0 * taken, 1) % 360.0
                    stated = f"{math.degrees(part.stated_rad):g} degrees", part.row.source("turn_deg")
                    given.contradict(part.row, "turn", (f"{angle:g} degrees", "copper"), stated)
    return turns, _noted(parts, counted, decided)


def _sense(
    parts: Sequence[TurnedPart], groups: Sequence[Sequence[TurnedPart]]
) -> tuple[float, list[list[tuple[int | None, bool]]]]:
    """Sense in which the angles of a side are counted, and what comes of each part in it."""
    compared = [_compare(group, 1.0) for group in groups]
    boxes = {sign: _boxes(parts, sign) for sign in (1.0, -1.0)}
    odd = _misfit(compared)
    if odd or boxes[-1.0] < boxes[1.0]:
        other = [_compare(group, -1.0) for group in groups]
        # On the top hardly any program counts clockwise: one part that would lie so is turned wrongly itself.
        if (_misfit(other) + (parts[0].side == "top"), boxes[-1.0]) < (odd, boxes[1.0]):
            return -1.0, other
    return 1.0, compared


def _quarter(group: Sequence[TurnedPart], sign: float, area: Callable[[TurnedPart, float], float]) -> int:
    """Whether the bodies of a package lie across their pads: libraries differ in what they call no turn."""
    along, across = (
        sum(area(part, sign * part.stated_rad + quarter * _QUARTER) for part in group) for quarter in (0, 1)
    )
    return int(across < _CROSSWISE * along)


def _misfit(compared: Sequence[Sequence[tuple[int | None, bool]]]) -> int:
    """Count parts that do not lie as those of their package."""
    return sum(quarters != 0 for group in compared for quarters, _ in group)


def _boxes(parts: Sequence[TurnedPart], sign: float) -> float:
    """Area of the boxes around the pads of all parts, each in its own frame, mm²."""
    patterns = (part.pattern(sign * part.stated_rad)[:, :2] for part in parts)
    return round(sum(float(np.prod(np.ptp(each, axis=0))) for each in patterns), 2)


def _compare(group: Sequence[TurnedPart], sign: float) -> list[tuple[int | None, bool]]:
    """Of each part the quarter turns by which it lies otherwise than most, ``None`` where its pads are others.

    And whether its pads decide between it and half a turn.
    """
    first = group[0].pattern(sign * group[0].stated_rad)
    tree = KDTree(first)
    fitting: list[list[int]] = []
    for part in group:
        stated = sign * part.stated_rad
        patterns = (part.pattern(stated + quarter * _QUARTER) for quarter in range(4))
        fitting.append([number for number, each in enumerate(patterns) if _is_alike(part, each, group[0], tree)])
    lowest = Counter(min(each) for each in fitting if each)
    usual = max(lowest, key=lambda each: (lowest[each], -each), default=0)
    off = [0 if usual in each else (min(each) - usual) % 4 if each else None for each in fitting]
    one_way = [len(group) > 1 and bool(each) and not any((turn + 2) % 4 in each for turn in each) for each in fitting]
    return list(zip(off, one_way, strict=True))


def _is_alike(part: TurnedPart, pattern: NDArray[np.float64], other: TurnedPart, reference: KDTree) -> bool:
    if len(pattern) != reference.n:
        return False
    pins, others = ([pin for pin, _ in each.pads] for each in (part, other))
    if all(pins) and len(set(pins)) == len(pins) and sorted(pins) == sorted(others):
        order = [others.index(pin) for pin in pins]
        return float(np.abs(pattern - reference.data[order]).max()) <= _SAME_MM
    far, nearest = reference.query(pattern)
    return float(np.max(far)) <= _SAME_MM and len(set(np.atleast_1d(nearest).tolist())) == len(pattern)


def _noted(parts: Sequence[TurnedPart], counted: Sequence[str], decided: set[str]) -> list[Finding]:
    open_ends = sorted((part.row.ref for part in parts if part.row.ref not in decided), key=natural_key)
    words = [f"Turns are counted as the pads settle it: {', '.join(counted)}."] if counted else []
    if open_ends:
        text = f"Which end is which is decided by pads or pin names for {len(decided)} of {len(parts)} components, and "
        words.append(f"undecided for {some(open_ends)}.")
        words[-1] = text + words[-1]
    return [Finding(PARTS_TURN, " ".join(words))] if words else []
