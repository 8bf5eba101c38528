"""Gerber files of a board: its profile, and the pads of its components where X2 attributes name them."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shapely import MultiPolygon, Polygon

from boards.board import Pad, Side
from boards.bounds import number_within
from boards.errors import BoardError, read_bytes
from boards.formats.archive import is_archive, read_members
from boards.formats.gerber.text import Layer, function_of, read_layer
from boards.formats.layout import THICKNESS_MM, LayoutNotes, LayoutWords, read_outline
from boards.formats.loops import Point2

SUFFIXES = (".gbr", ".gm1", ".gko", ".gml", ".ger", ".pho", ".art")
_LAYERS = re.compile(r".*\.(g[a-z0-9]{1,3}|pho|art|gbrjob)", re.IGNORECASE)
_EDGE_NAME = re.compile(r"edge[._ -]?cuts|outline|profile|board[._ -]?edge|dimension|keep-?out", re.IGNORECASE)
_EDGE_SUFFIX = re.compile(r".*\.(gm1|gko|gml)", re.IGNORECASE)


def _spot(point: Point2) -> str:
    return f"x {point[0]:.3f}, y {point[1]:.3f} mm"


WORDS = LayoutWords("Gerber", "the profile layer", "a larger body in the library", _spot, "pads")


@dataclass(frozen=True, slots=True, eq=False)
class GerberBoard:
    """What Gerber files state of a board. Frame of the files, mm."""

    path: Path
    outline: Polygon | MultiPolygon
    thickness_mm: float
    pads: Mapping[str, tuple[tuple[str, Pad, Side, bool], ...]]
    """By reference designator: pin, pad, side, and whether it is soldered flat."""
    notes: LayoutNotes


def read_gerber(path: Path) -> GerberBoard:
    """Read the Gerber files of a board: of a folder, an archive, or the one file of its profile.

    The profile is the layer whose file function states it, else the one whose name does. The copper of the outer
    layers is read for the pads whose attributes name their component; drills are not read.

    Raises:
        BoardError: There is no profile, it does not close, or a file cannot be read.
    """
    if is_archive(path):
        _, contents = read_members(path, lambda name: _LAYERS.fullmatch(name) is not None)
    else:
        contents = {path.name: read_bytes(path)}
    functions = {name: function_of(content) for name, content in contents.items()}
    edges = [name for name, function in functions.items() if function[:1] == ("Profile",)]
    edges = edges or [name for name in contents if _EDGE_NAME.search(name) or _EDGE_SUFFIX.fullmatch(name)]
    edges = edges or (list(contents) if len(contents) == 1 else [])
    if not edges:
        raise BoardError(
            "holds no ODB++ job, no IPC-2581 file and no Gerber layer that is the board's profile by its file function "
            "or its name. Export the board's edge as well, with X2 attributes.",
            file=path,
        )
    folder = path if is_archive(path) else path.parent
    notes = LayoutNotes()
    lines = [line for name in edges for line in read_layer(contents[name], folder / name).lines]
    outline = read_outline(lines, [], path, WORDS, notes)
    pads: dict[str, list[tuple[str, Pad, Side, bool]]] = {}
    for name, function in functions.items():
        side = _outer_side(function)
        if side is not None:
            _collect_pads(read_layer(contents[name], folder / name), side, pads)
    held = {name: tuple(each) for name, each in pads.items()}
    return GerberBoard(path, outline, _thickness(contents), held, notes)


def _outer_side(function: tuple[str, ...]) -> Side | None:
    if function[:1] != ("Copper",):
        return None
    words = [word.lower() for word in function[1:]]
    return "top" if "top" in words else "bottom" if "bot" in words else None


def _collect_pads(layer: Layer, side: Side, pads: dict[str, list[tuple[str, Pad, Side, bool]]]) -> None:
    for flash in layer.flashes:
        kind = flash.function.partition(",")[0]
        if not flash.component or kind in ("ViaPad", "FiducialPad", "Conductor"):
            continue
        aperture = flash.aperture
        x, y = (flash.place + aperture.middle).tolist()
        pad = Pad(x, y, aperture.length_mm, aperture.width_mm, aperture.turn_rad, aperture.is_round)
        pads.setdefault(flash.component, []).append((flash.pin, pad, side, kind != "ComponentPad"))


def _thickness(contents: Mapping[str, bytes]) -> float:
    """Thickness that a job file states, mm; 1.6 mm without one."""
    for name, content in contents.items():
        if name.lower().endswith(".gbrjob"):
            try:
                stated = json.loads(content)["GeneralSpecs"]["BoardThickness"]
            except (ValueError, LookupError, TypeError, RecursionError):
                continue
            value = number_within(str(stated), 10.0)
            if value >= 0.1:
                return value
    return THICKNESS_MM
