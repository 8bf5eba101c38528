"""Undersides by package family: bounds of the gap height, and the layout of the joints (``undersides.yaml``)."""

from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypeAlias, cast

from boards.packages.families import PackageFamily, package_family, package_sizes, read_table

Layout: TypeAlias = Literal[
    "outside", "ends", "folded", "corners", "quad", "dual", "balls", "lands", "tab", "unknown", "none"
]

FINE_PITCH_MM = 0.5
STATED = "stated"
UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class UndersideFamily:
    """One row of ``undersides.yaml``."""

    joints: Layout
    source: str
    """The document of the gap height."""
    gap_height_mm: tuple[float, float] | None = None
    """Least and largest; ``None`` where no document fixes it."""
    fine_mm: tuple[float, float] | None = None
    """The same for pitches up to ``FINE_PITCH_MM``, where that differs."""
    share: float = 0.0
    """Part of the underside that two terminations take together."""
    size: tuple[float, float] = (0.0, 0.0)
    """Length and width of one terminal as parts of the underside's."""
    body_mm: tuple[float, float] | None = None
    """Nominal length and width."""

    def gap_heights_mm(self, pitch_mm: float | None) -> tuple[float, float] | None:
        """Least and largest gap height of a package with this pitch."""
        fine = self.fine_mm is not None and pitch_mm is not None and pitch_mm <= FINE_PITCH_MM
        return self.fine_mm if fine else self.gap_height_mm


_UNKNOWN = UndersideFamily("unknown", "no document")


def underside_family(family: PackageFamily | None) -> UndersideFamily:
    """Look up the underside of a family; joints and gap are unknown where none is known."""
    if family is None:
        return _UNKNOWN
    # Resistors and other chips of one size have the same gap.
    chip = family.name.startswith("chip ")
    return _table().get(f"chip {family.name.rsplit(' ', 1)[-1]}" if chip else family.name, _UNKNOWN)


def underside_families() -> tuple[str, ...]:
    """Name every family of the table, chips by ``chip`` and their code, in the table's order."""
    return tuple(_table())


@cache
def _table() -> dict[str, UndersideFamily]:
    data = read_table("undersides.yaml")
    table = {
        name: _row(entry, entry["joints"], entry.get("body_mm"))
        for entry in data["families"]
        for name in entry["names"]
    }
    return table | {
        f"chip {code}": _row(entry, "ends", body)
        for entry in data["chips"]
        for code, body in cast(dict[str, list[float]], entry["body_mm"]).items()
    }


def _row(entry: dict[str, Any], joints: Layout, body_mm: list[float] | None) -> UndersideFamily:
    return UndersideFamily(
        joints,
        entry["source"],
        gap_height_mm=_pair(entry.get("standoff_mm")),
        fine_mm=_pair(entry.get("fine_mm")),
        share=entry.get("share", 0.0),
        size=_pair(entry.get("size")) or (0.0, 0.0),
        body_mm=_pair(body_mm),
    )


def _pair(values: list[float] | None) -> tuple[float, float] | None:
    return None if values is None else (values[0], values[1])


@dataclass(frozen=True, slots=True)
class GapHeight:
    """Gap between the board and the underside of a body."""

    nominal_mm: float | None
    """For lists and filters: as stated (the least of a range), or the family's nominal height."""
    source: str
    """``"stated"``, ``"stated in the parameter set"``, ``"family SOIC (JEDEC MS-012)"``, or ``"unknown"``."""
    bounds_mm: tuple[float, float] | None
    """Least and largest; equal where one value is stated, ``None`` where no document fixes them."""
    bounds_source: str
    """As ``source``; of a family it gives both bounds."""


def gap_height(
    package: str, board_file_mm: float | None, parameter_set_mm: tuple[float, float] | None = None
) -> GapHeight:
    """Height of the gap from the first source that has one: parameter set, board file, package family.

    Args:
        package: Name of the package; empty if unknown.
        board_file_mm: What the board file or its parts table states.
        parameter_set_mm: Least and largest that a cleaning parameter set states for the part.
    """
    if parameter_set_mm is not None:
        source = f"{STATED} in the parameter set"
        return GapHeight(parameter_set_mm[0], source, parameter_set_mm, source)
    if board_file_mm is not None:
        return GapHeight(board_file_mm, STATED, (board_file_mm, board_file_mm), STATED)
    family = package_family(package) if package else None
    if family is None:
        return GapHeight(None, UNKNOWN, None, UNKNOWN)
    underside = underside_family(family)
    bounds = underside.gap_heights_mm(package_sizes(package).pitch_mm)
    return GapHeight(
        family.gap_height_mm,
        UNKNOWN if family.gap_height_mm is None else f"family {family.name} ({family.source})",
        bounds,
        UNKNOWN if bounds is None else f"family {family.name}: {bounds[0]:g} to {bounds[1]:g} mm ({underside.source})",
    )
