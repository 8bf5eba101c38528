"""What is beneath the packages of a family: the range of the gap, and how the joints are laid out."""

from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, Literal, TypeAlias, cast

import yaml

from boards.packages.package_families import PackageFamily

Layout: TypeAlias = Literal[
    "outside", "ends", "folded", "corners", "quad", "dual", "balls", "lands", "tab", "unknown", "none"
]

FINE_PITCH_MM = 0.5


@dataclass(frozen=True, slots=True)
class Beneath:
    """What the table ``undersides.yaml`` says of one family."""

    joints: Layout
    source: str
    """The document the standoff is from."""
    standoff_mm: tuple[float, float] | None = None
    """Least and largest; ``None`` where no document fixes it."""
    fine_mm: tuple[float, float] | None = None
    """The same for pitches up to ``FINE_PITCH_MM``, where that differs."""
    share: float = 0.0
    """Part of the underside that two terminations take together."""
    size: tuple[float, float] = (0.0, 0.0)
    """Length and width of one terminal as parts of the underside's."""
    body_mm: tuple[float, float] | None = None
    """Nominal length and width."""

    def standoffs_mm(self, pitch_mm: float | None) -> tuple[float, float] | None:
        """Least and largest gap of a package with this pitch."""
        if self.fine_mm is not None and pitch_mm is not None and pitch_mm <= FINE_PITCH_MM:
            return self.fine_mm
        return self.standoff_mm


UNKNOWN = Beneath("unknown", "no document")
"""What is beneath a package of no known family."""


def beneath(family: PackageFamily | None) -> Beneath:
    """Look a family up."""
    return UNKNOWN if family is None else _table().get(_key(family.name), UNKNOWN)


def listed_families() -> tuple[str, ...]:
    """Name every family of the table, chips by ``chip`` and their code, in the table's order."""
    return tuple(_table())


def _key(name: str) -> str:
    """Resistors and other chips of one size stand alike."""
    return f"chip {name.rsplit(' ', 1)[-1]}" if name.startswith("chip ") else name


@cache
def _table() -> dict[str, Beneath]:
    text = files("boards").joinpath("undersides.yaml").read_text(encoding="utf-8")
    data = cast(dict[str, list[dict[str, Any]]], yaml.safe_load(text))
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


def _row(entry: dict[str, Any], joints: Layout, body_mm: list[float] | None) -> Beneath:
    return Beneath(
        joints,
        entry["source"],
        standoff_mm=_pair(entry.get("standoff_mm")),
        fine_mm=_pair(entry.get("fine_mm")),
        share=entry.get("share", 0.0),
        size=_pair(entry.get("size")) or (0.0, 0.0),
        body_mm=_pair(body_mm),
    )


def _pair(values: list[float] | None) -> tuple[float, float] | None:
    return None if values is None else (values[0], values[1])
