"""Netlists for the test of bare boards, IPC-D-356 and 356A: they name the component and the pin of each pad."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from boards.board import Side
from boards.bounds import FARTHEST_MM
from boards.errors import Line

_RECORD = re.compile(r"3[0-9]7.{17}(.{6})[- ](.{4})(.*)")
"""Designator, pin and the rest of the record of a place that is tested: 317 through the board, 327 on its surface."""
_PLACE = re.compile(r"A(\d\d)X([+-]?\s*\d{1,9})\s*Y([+-]?\s*\d{1,9})")
_UNITS = re.compile(r"P\s+UNITS\s+(SI|CUST\s*([012])?)", re.IGNORECASE)
_INCH_MM, _SI_MM = 25.4e-4, 1e-3
"""Of the last digit: a ten thousandth of an inch, or a micrometre."""
_LONGEST_REF = 6
_HEAD_LINES, _HEAD_BYTES = 200, 200_000
"""A text without a record in them is none of a netlist: tables of any size are looked at as well."""
SUFFIXES = (".ipc", ".d356", ".356", ".d356a", ".ipc356", ".net")


@dataclass(frozen=True, slots=True)
class NetPad:
    """A pad of a component. Frame of the netlist, mm."""

    ref: str
    """Reference designator; netlists hold no more than six letters of it."""
    pin: str
    side: Side | None
    """``None`` where it goes through the board."""
    x_mm: float
    y_mm: float


@dataclass(frozen=True, slots=True)
class Netlist:
    """What a netlist names."""

    file: Path
    pads: tuple[NetPad, ...]

    def describe(self) -> str:
        """Count what it names."""
        return f"{len(self.pads)} pads of {len({pad.ref for pad in self.pads})} components"

    def names(self, refs: Iterable[str]) -> dict[str, str]:
        """Designators by those of the netlist, which may be cut off after six letters and in any case of letters."""
        whole: dict[str, str] = {}
        begun: dict[str, list[str]] = {}
        for ref in refs:
            whole[ref.casefold()] = ref
            begun.setdefault(ref.casefold()[:_LONGEST_REF], []).append(ref)
        found: dict[str, str] = {}
        for cut in {pad.ref for pad in self.pads}:
            longer = begun.get(cut.casefold(), []) if len(cut) == _LONGEST_REF else []
            found[cut] = whole.get(cut.casefold()) or (longer[0] if len(longer) == 1 else cut)
        return found


def read_netlist(content: bytes, file: Path) -> Netlist | None:
    """Read a netlist; ``None`` where the first lines of a text hold no record of one.

    Raises:
        BoardError: A place cannot be that of a pad.
    """
    if not any(map(_RECORD.match, content[:_HEAD_BYTES].decode("latin-1").splitlines()[:_HEAD_LINES])):
        return None
    lines = content.decode("latin-1").splitlines()
    unit_mm, pads = _INCH_MM, list[NetPad]()
    for number, line in enumerate(lines, start=1):
        if (unit := _UNITS.match(line)) is not None:
            unit_mm = _SI_MM if unit[1].upper() == "SI" or unit[2] == "1" else _INCH_MM
        hit = _RECORD.match(line)
        place = None if hit is None else _PLACE.search(hit[3])
        if hit is None or place is None or not (ref := hit[1].strip()) or ref.upper() == "VIA":
            continue
        x_mm, y_mm = (float(place[axis].replace(" ", "")) * unit_mm for axis in (2, 3))
        if max(abs(x_mm), abs(y_mm)) > FARTHEST_MM:
            raise Line(file, number).error(
                f"{ref} is farther than {FARTHEST_MM / 1000.0:g} m. Export the netlist again."
            )
        is_through = line.startswith("31") or int(place[1]) == 0
        side: Side | None = None if is_through else "top" if int(place[1]) == 1 else "bottom"
        pads.append(NetPad(ref, hit[2].strip(), side, x_mm, y_mm))
    return Netlist(file, tuple(pads))
