"""Package families by name: height, gap height and number of pins; and the sizes that names state.

The table is ``packages.yaml``; names are those of KiCad, of IPC-7351 and the loose ones people type.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Any, cast

import yaml

from specs.input_file import own_text


@dataclass(frozen=True, slots=True)
class PackageSizes:
    """What a name such as ``QFN-32-1EP_5x5mm_P0.5mm_EP3.45x3.45mm`` states. mm; ``None`` where it does not."""

    body_mm: tuple[float, float] | None
    """Across the rows of leads and along them, as KiCad orders them; not stated by IPC-7351, which gives the span."""
    pitch_mm: float | None
    ball_mm: float | None
    layout: tuple[int, int] | None
    """Columns and rows of a grid."""
    pad_mm: tuple[float, float] | None
    """The exposed pad, in the order of the body."""
    has_pad: bool | None
    """Whether there is an exposed pad; ``None`` where the name is too short."""


FINEST_MM = 0.2
"""No pitch of what is soldered to boards is finer."""

_WIDEST_MM = 2.6
"""No pitch of what is soldered flat is wider; ``P8MM`` means 0.8 mm to some and is ignored."""

LONGEST_TEXT = 2000
"""Characters of a name or a description that are read: patterns are searched for at each of them."""

_NUMBER = r"(\d{1,2}(?:\.\d{1,4})?)"
_BODY = re.compile(rf"(?:^|[-_ ]){_NUMBER}x{_NUMBER}(?:x[\d.]+)?mm")
_BARE_BODY = re.compile(
    r"(?:q[fn]|so[nip]|sop|dfn|bga|lga).*?[-_ ](\d{1,2}(?:[.p]\d{1,3})?)x(\d{1,2}(?:[.p]\d{1,3})?)(?![\dp.x])"
)
_PITCH = re.compile(rf"(?:^|[-_ ])p{_NUMBER}mm")
_IPC = re.compile(r"^[a-z]{3,7}(\d{2,3})p(\d{2,4})x(\d{2,4})x\d{2,4}-")
_IPC_LEADLESS = re.compile(r"^[a-z]*(?:qfn|son|bga|lga|dfn)")
_BALL = re.compile(rf"ball{_NUMBER}mm")
_LAYOUT = re.compile(r"layout(\d{1,2})x(\d{1,2})(?![\dy])")
_PAD = re.compile(rf"[-_ ]ep{_NUMBER}x{_NUMBER}(?:mm)?")
_HAS_PAD = re.compile(
    r"\dep(?![a-z])|[-_ ]ep[\d_-]|power-?pad|^(?:h[tvlms]?s{1,2}op|hsoic|hso[p-]|h[tlv]qf?p|hmsop|htqfp)"
)
_HEADER = re.compile(r"pin(?:header|socket)_(\d{1,2})x(\d{1,2})_")
_CAN = re.compile(rf"_elec_{_NUMBER}x\d")
_CAN_BASE_MM = 0.3
"""How much wider the base of an aluminium can is than its diameter: 6.6 mm for 6.3 mm (makers' catalogues)."""
_BARE_COIL = re.compile(rf"^l_{_NUMBER}x{_NUMBER}(?:_|$)")
_LENGTH, _WIDTH, _DIAMETER = (re.compile(rf"_{letter}{_NUMBER}mm") for letter in "lwd")


@lru_cache(maxsize=4096)
def package_sizes(package: str) -> PackageSizes:
    """Read the sizes out of a package's name: KiCad's and those of IPC-7351."""
    name = without_library(package).lower()
    ipc = _IPC.search(name)
    pitch = _sole(_PITCH, name) or (int(ipc[1]) / 100.0 if ipc else None)
    body = _pair(_BODY, name) or _pair(_BARE_BODY, name)
    if body is None and ipc and _IPC_LEADLESS.search(name):
        body = (int(ipc[2]) / 100.0, int(ipc[3]) / 100.0)
    layout = _LAYOUT.search(name)
    pad = _pair(_PAD, name)
    stated = pad is not None or _HAS_PAD.search(name) is not None
    return PackageSizes(
        body_mm=body,
        pitch_mm=pitch if pitch and FINEST_MM <= pitch <= _WIDEST_MM else None,
        ball_mm=_sole(_BALL, name) or None,
        layout=(int(layout[1]), int(layout[2])) if layout else None,
        pad_mm=pad,
        has_pad=True if stated else False if _PITCH.search(name) else None,
    )


@lru_cache(maxsize=4096)
def plan_size(package: str) -> tuple[float, float] | None:
    """Length and width of a body in the frame of its package, as far as the name states them, mm; else ``None``.

    Besides the sizes of ``package_sizes``: KiCad's ``_D10.0mm``, ``_L18.0mm_D6.5mm``, ``_L7.0mm_W2.5mm`` and
    ``L_6.3x6.3``, and cans of a diameter on their square base.
    """
    name = without_library(package).lower()
    is_upright = "horizontal" not in name
    if (can := _sole(_CAN, name)) is not None:
        return can + _CAN_BASE_MM, can + _CAN_BASE_MM
    body = package_sizes(package).body_mm or _pair(_BARE_COIL, name)
    if body is not None:
        return body
    length, width, diameter = _sole(_LENGTH, name), _sole(_WIDTH, name), _sole(_DIAMETER, name)
    if length and (width or diameter):
        return (length, width or diameter or 0.0) if width or not is_upright else None
    return (diameter, diameter) if diameter and is_upright else None


def header_size(package: str) -> tuple[float, float] | None:
    """Least and largest side of an upright header of so many pins by their pitch, mm; ``None`` of all else.

    Libraries draw headers along either axis.
    """
    name = without_library(package).lower()
    pins, pitch = _HEADER.search(name), _sole(_PITCH, name)
    if pins is None or pitch is None or "horizontal" in name:
        return None
    counts = sorted((int(pins[1]), int(pins[2])))
    return counts[0] * pitch, counts[1] * pitch


def without_library(package: str) -> str:
    """Name of a package without the library before its colon; ``MICROSD_1:1`` states a scale and stays as it is."""
    library, _, name = package[:LONGEST_TEXT].rpartition(":")
    is_scale = bool(library) and len(name) <= 3 and not any(map(str.isalpha, name))
    return (f"{library}:{name}" if is_scale else name).strip()


def _sole(pattern: re.Pattern[str], name: str) -> float | None:
    found = pattern.search(name)
    return float(found[1]) if found else None


def _pair(pattern: re.Pattern[str], name: str) -> tuple[float, float] | None:
    found = pattern.search(name)
    if found is None or not (_number(found[1]) and _number(found[2])):
        return None
    return _number(found[1]), _number(found[2])


def _number(text: str) -> float:
    """Read a number that may have ``P`` for its point, as in ``8X12P5``."""
    return float(text.replace("p", "."))


@dataclass(frozen=True, slots=True)
class PackageFamily:
    """Nominal sizes of a family of packages."""

    name: str
    height_mm: float
    """Largest seated height above the board, for makers' parts of every height in the family."""
    gap_height_mm: float | None
    """Gap between the board and the underside of the body; ``None`` where no document fixes it."""
    source: str
    """The document the numbers are from."""
    loose: bool = False
    """Found by a single word only, so that the size may be anything."""

    @property
    def has_body(self) -> bool:
        """Whether its members stand on the board: others are copper, paint or holes."""
        return self.source != "no body"


@dataclass(frozen=True, slots=True)
class _Row:
    """One line of the table, ready to be searched for."""

    family: PackageFamily
    match: re.Pattern[str]
    also: re.Pattern[str]
    pins: int | None


@dataclass(frozen=True, slots=True)
class _Table:
    families: tuple[_Row, ...]
    loose: tuple[_Row, ...]
    imperial: dict[str, dict[str, Any]]
    metric: dict[str, dict[str, Any]]


_IPC_PINS = re.compile(r"^[a-z]{3,7}\d+p\d+x\d+(?:x\d+)?-(\d{1,4})[abclmn]*$")
_STATED_PINS = re.compile(r"-(\d{1,4})-?p(?:ins?)?\b")
_ROWS_AND_COLUMNS = re.compile(r"(?<![\d.])([1-9])x(\d{1,2})(?![\d.]|mm)")
_IPC_CHIP = re.compile(r"^(?:cap|res|ind|led|dio|fus|bead|thrm|var)c(\d{4})x")
_CODES = re.compile(r"(?<!\d)\d{4,5}(?!\d)")
_RESISTOR = re.compile(r"(?:\b|-)(?:cr|r|res|resc|rc)(?![a-z])|resistor")
_CAPACITOR = re.compile(r"^(?:sm[dt]-)?c(?:ap[a-z]*)?(?=-|\d)")
_ARRAY = re.compile(r"\b(\d)x\d{4}\b")


def package_family(package: str) -> PackageFamily | None:
    """Find the family of a package by its name; ``None`` when no pattern fits.

    The height is the family's; one that the name itself states is read by ``body_height``.
    """
    found = _find(normalise(package))
    return None if found is None else found[0]


_BARE_NAME = re.compile(
    r"(?:^|[^a-z])(?:b?fid|tp\d|art_tp|test|mtg|mth\d?|mh|mnt|mount|hole|logo|label|mark|via|tooling)", re.IGNORECASE
)
_BARE_REFERENCE = re.compile(r"(?:MTG|MTH|MH|FID|FD|TP|HOLE|H|LOGO|LBL|VIA|TOOL)[-_]?\d", re.IGNORECASE)
_BARE_MM = 0.3
"""What layout tools state as the height of copper and print."""


def is_bare(names: Sequence[str], reference: str, pins: int, height_mm: float | None) -> bool:
    """Whether something that is placed is copper, print or a hole, with nothing soldered to it.

    Args:
        names: Of its package and part.
        reference: Reference designator.
        pins: How many it has; 0 where it is not known.
        height_mm: As stated: what is higher than print has a body whatever its name.
    """
    family = next(filter(None, map(package_family, names)), None)
    if family is not None and not family.has_body:
        return True
    if height_mm is None:
        if family is not None:
            return False
    elif not 0.0 <= height_mm <= _BARE_MM:
        return False
    called = any(map(_BARE_NAME.search, names)), _BARE_REFERENCE.match(reference) is not None
    return all(called) or (any(called) and pins <= 1)


def pins_of(package: str) -> int | None:
    """Return the number of pins that the name states or the family always has; exposed pads are not counted."""
    found = _find(normalise(package))
    return None if found is None else found[1]


def other_chip(family: PackageFamily) -> PackageFamily:
    """Return the family of capacitors, beads and diodes in the size of a chip resistor; any other family unchanged."""
    kind, _, code = family.name.rpartition(" ")
    return _chip_family(_table().imperial[code], "part") if kind == "chip resistor" else family


def package_families() -> tuple[PackageFamily, ...]:
    """Return every family of the table, in the order in which they are tried."""
    table = _table()
    chips = [_chip_family(row, kind) for row in table.metric.values() for kind in ("resistor", "part")]
    rows = (*(row.family for row in table.families), *chips, *(row.family for row in table.loose))
    return tuple(dict.fromkeys(rows))


def normalise(package: str) -> str:
    """Lower case, no library prefix, one hyphen for blanks and underscores."""
    return re.sub(r"[\s_]+", "-", without_library(package).lower())


@lru_cache(maxsize=4096)
def _find(name: str) -> tuple[PackageFamily, int | None] | None:
    table = _table()
    return _first(table.families, name) or _find_chip(table, name) or _first(table.loose, name)


def _first(rows: tuple[_Row, ...], name: str) -> tuple[PackageFamily, int | None] | None:
    for row in rows:
        hit = row.match.search(name)
        if hit and row.also.search(name):
            pins, count = row.pins, hit["after"] or hit["before"]
            if stated := _IPC_PINS.search(name) or _STATED_PINS.search(name):
                pins = int(stated[1])
            elif count is not None and row.pins != 2:
                pins = int(count)
            elif row.pins is None and (grid := _ROWS_AND_COLUMNS.search(name)):
                pins = int(grid[1]) * int(grid[2])
            return row.family, pins
    return None


def _find_chip(table: _Table, name: str) -> tuple[PackageFamily, int] | None:
    ipc = _IPC_CHIP.search(name)
    rows = [table.metric.get(ipc[1])] if ipc else []
    # A code means inches unless only the metric table has it, or the word `metric` follows.
    for code in () if ipc else _CODES.finditer(name):
        known = {} if name.startswith("metric", code.end()) else table.imperial
        rows.append(known.get(code[0], table.metric.get(code[0])))
    row = next((row for row in rows if row is not None), None)
    if row is None:
        return None
    array = _ARRAY.search(name)
    kind = "resistor" if _RESISTOR.search(name) and not _CAPACITOR.search(name) else "part"
    return _chip_family(row, kind), 2 * int(array[1]) if array else 2


def _chip_family(row: dict[str, Any], kind: str) -> PackageFamily:
    height_mm = row["resistor_mm"] if kind == "resistor" else row["other_mm"]
    return PackageFamily(
        f"chip {kind} {row['imperial']}", height_mm, row["standoff_mm"], "EIA size code, gap as soldered"
    )


def read_table(name: str) -> dict[str, list[dict[str, Any]]]:
    """Read one of the YAML tables beside the package ``boards``; libyaml is several times as fast as Python."""
    text = own_text("boards", name)
    return cast(dict[str, list[dict[str, Any]]], yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader)))


@cache
def _table() -> _Table:
    data = read_table("packages.yaml")
    imperial: dict[str, dict[str, Any]] = {}
    for chip in data["chips"]:
        imperial.setdefault(chip["imperial"], chip)
    return _Table(
        families=tuple(_row(entry) for entry in data["families"]),
        loose=tuple(_row(entry, loose=True) for entry in data["loose"]),
        imperial=imperial,
        metric={chip["metric"]: chip for chip in data["chips"]},
    )


def _row(entry: dict[str, Any], *, loose: bool = False) -> _Row:
    """Wrap a pattern so that it begins at a word and sees the number before or after it.

    A number that belongs to a size or a pitch (``7x7``, ``6.3``, IPC's ``50P``) is not a number of pins.
    """
    match = (
        rf"(?<![a-z0-9])(?:(?P<before>\d{{1,4}})-?)?(?:{entry['match']})(?![a-z])"
        r"(?:-?(?P<after>\d{1,4})(?![\d.px]|mm))?"
    )
    family = PackageFamily(entry["name"], entry["height_mm"], entry.get("standoff_mm"), entry["source"], loose)
    return _Row(family, re.compile(match), re.compile(entry.get("also", "")), entry.get("pins"))
