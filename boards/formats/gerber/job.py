"""Gerber job files (``.gbrjob``): what a set of layers states of itself, compared with what its layers are.

Source: Ucamco, Gerber Layer Format Specification, Gerber Job File Format, revision 2021.11; lengths are in mm.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import PurePosixPath
from typing import Any

import numpy as np
from shapely.geometry.base import BaseGeometry

from boards.board import Contradiction
from boards.bounds import FARTHEST_MM, number_within
from boards.formats.layout import THICKEST_MM

SUFFIX = ".gbrjob"
_SIZE_MM = 0.5
"""Size and outline may differ by the pen of the edge."""
_THICKNESS_MM = 0.01
_READ = ("copper", "soldermask", "profile", "vcut")
"""Kinds of layers that are looked at, with the outer ones of copper."""


@dataclass(frozen=True, slots=True)
class GerberJob:
    """What a job file states."""

    name: str = ""
    is_read: bool = False
    size_mm: tuple[float, float] | None = None
    thickness_mm: float = math.nan
    functions: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    """Function of each file by its name without folders, in small letters."""
    files: tuple[str, ...] = ()
    """As they are listed."""

    def describe(self) -> str:
        """What it states, in words."""
        if not self.is_read:
            return "no JSON that can be read"
        size = "" if self.size_mm is None else "size {:.1f} x {:.1f} mm".format(*self.size_mm)
        thickness = "" if math.isnan(self.thickness_mm) else f"{self.thickness_mm:g} mm thick"
        files = f"{len(self.files)} files" if self.files else ""
        return ", ".join(filter(None, (size, thickness, files))) or "nothing"

    def function(self, name: str) -> tuple[str, ...]:
        """Words of the function that is stated for a file; none without a statement."""
        return self.functions.get(_base(name), ())

    def missing(self, names: Sequence[str]) -> list[str]:
        """Files that are listed, would be read, and are not there."""
        there = {_base(name) for name in names}
        kinds = {
            name: [word.lower() for word in self.function(name)] for name in self.files if _base(name) not in there
        }
        return [name for name, words in kinds.items() if words[:1] and words[0] in _READ and "inr" not in words]

    def compare(
        self, outline: BaseGeometry, thickness_mm: float, functions: Mapping[str, Sequence[str]]
    ) -> list[Contradiction]:
        """What contradicts the layers; these are taken, but for the thickness.

        Args:
            outline: Of the board, mm.
            thickness_mm: That is taken, mm.
            functions: That the layers state themselves, by name.
        """
        found: list[Contradiction] = []
        x0, y0, x1, y1 = outline.bounds
        own = x1 - x0, y1 - y0
        if self.size_mm is not None and np.abs(np.sort(own) - np.sort(self.size_mm)).max() > _SIZE_MM:
            words = [f"{width:.1f} x {depth:.1f} mm" for width, depth in (own, self.size_mm)]
            found.append(Contradiction("board", "size", words[0], "edge", words[1], self.name))
        if abs(self.thickness_mm - thickness_mm) > _THICKNESS_MM:
            words = [f"{mm:g} mm" for mm in (thickness_mm, self.thickness_mm)]
            found.append(Contradiction("board", "thickness", words[0], "board", words[1], self.name))
        for name, function in functions.items():
            stated = self.function(name)
            if function and stated and _plain(function) != _plain(stated):
                words = [",".join(each) for each in (function, stated)]
                found.append(Contradiction(_base(name), "function", words[0], name, words[1], self.name))
        return found


def read_jobs(contents: Mapping[str, bytes]) -> list[GerberJob]:
    """Read the job files among files; of one that is damaged nothing but its name."""
    return [_read_job(name, content) for name, content in contents.items() if name.lower().endswith(SUFFIX)]


def _read_job(name: str, content: bytes) -> GerberJob:
    try:
        document = _mapping(json.loads(content))
    except (ValueError, RecursionError):
        return GerberJob(name)
    general = _mapping(document.get("GeneralSpecs"))
    size = _mapping(general.get("Size"))
    sides = [number_within(str(size.get(key)), FARTHEST_MM) for key in ("X", "Y")]
    stack = [_mapping(each).get("Thickness") for each in _sequence(document.get("MaterialStackup"))]
    total = sum(number_within(str(each), THICKEST_MM) for each in stack if each is not None) or math.nan
    stated = number_within(str(general.get("BoardThickness")), THICKEST_MM)
    files = [each for own in _sequence(document.get("FilesAttributes")) if (each := _mapping(own)).get("Path")]
    return GerberJob(
        name,
        is_read=True,
        size_mm=(sides[0], sides[1]) if min(sides) > 0.0 else None,
        thickness_mm=total if math.isnan(stated) else stated,
        functions={
            _base(str(each["Path"])): _words(str(each["FileFunction"])) for each in files if each.get("FileFunction")
        },
        files=tuple(str(each["Path"]) for each in files),
    )


def _mapping(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}  # pyright: ignore[reportUnknownVariableType]


def _sequence(value: object) -> list[Any]:
    return value if isinstance(value, list) else []  # pyright: ignore[reportUnknownVariableType]


def _base(name: str) -> str:
    return PurePosixPath(name.replace("\\", "/")).name.lower()


def _words(function: str) -> tuple[str, ...]:
    """Words of a function as the layers spell them; job files have ``SolderMask`` for ``Soldermask``."""
    kind, *rest = (word.strip() for word in function.split(","))
    return kind.capitalize(), *rest


def _plain(function: Sequence[str]) -> tuple[str, ...]:
    """What of a function sets layers apart: its kind, and the side of copper, mask and print."""
    words = [word.lower() for word in function]
    return *words[:1], *(word for word in words[1:] if word in ("top", "bot", "inr"))
