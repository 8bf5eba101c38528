"""Undersides by package family: bounds of the gap height, and the layout of the joints (``undersides.yaml``)."""

from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, TypeAlias, cast

from boards.packages.families import PackageFamily, read_table

Layout: TypeAlias = Literal[
    "outside", "ends", "folded", "corners", "quad", "dual", "balls", "lands", "tab", "unknown", "none"
]

FINE_PITCH_MM = 0.5


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
