"""One footprint of a KiCad board: where it is, its pads, and the outline of the body it carries."""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from shapely import MultiPolygon, Polygon
from shapely.affinity import affine_transform

from boards.board import Pad, Side
from boards.formats.kicad.items import Item, drawn, polyline
from boards.formats.layout import part_number, plain_key, stated_height
from boards.formats.loops import DRILL_MM, Point2, box_around, enclosed, slot
from geometry.arrays import Points2

_COURTYARD_MM = 0.25
"""Usual distance of KiCad's courtyard from the body (KiCad library convention F5.3)."""

_LEAST_PAD_MM = 1e-3
_UNSCALED = {"1", "1.0"}
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """A placed footprint. Board frame, mm, y up; what is drawn in it stays in its own frame until ``place``."""

    item: Item
    reference: str
    package: str
    """Name without the library."""
    side: Side
    origin: Point2
    turn_rad: float
    """Counter-clockwise as seen from the top, on both sides."""
    attributes: frozenset[str]
    value: str
    part: str
    stated_height_mm: float | None
    """From its properties."""
    description: str
    models: tuple[str, ...]
    """File names of the 3-D models at their own scale."""

    def place(self, points: Points2) -> Points2:
        """Bring points of the footprint's frame ``(n, 2)`` onto the board."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return points @ np.array([[cos, sin], [-sin, cos]]) + self.origin

    def place_outline(self, outline: Polygon | MultiPolygon) -> Polygon | MultiPolygon:
        """Bring an outline onto the board; every vertex keeps its place in its ring."""
        cos, sin = math.cos(self.turn_rad), math.sin(self.turn_rad)
        return affine_transform(outline, [cos, -sin, sin, cos, float(self.origin[0]), float(self.origin[1])])

    @property
    def pads(self) -> tuple[Item, ...]:
        """Every pad, plain holes included."""
        return tuple(self.item.all("pad"))

    def drawn(self, layer: str) -> list[Points2]:
        """Polylines on one layer, in the footprint's frame."""
        return drawn(self.item.items, "fp_", layer)

    @property
    def is_drawn(self) -> bool:
        """Whether a body or a courtyard is drawn on either side."""
        return any(self.drawn(layer) for layer in ("F.Fab", "B.Fab", "F.CrtYd", "B.CrtYd"))

    @property
    def pins(self) -> int | None:
        """Number of different pad numbers; ``None`` without any."""
        numbers = {pad.atoms[0] for pad in self.pads if pad.atoms and pad.atoms[0].strip()}
        return len(numbers) or None


def read_footprint(item: Item) -> Footprint:
    """Read a ``footprint`` (a ``module`` before version 6).

    Raises:
        BoardError: It has no position, or a number in it cannot be read.
    """
    at = item.first("at")
    if at is None:
        raise item.error(f"the footprint {item.atoms[:1]} has no (at x y). Save the board in KiCad again.")
    stated = [entry.atoms for entry in item.all("property") if len(entry.atoms) > 1]
    properties = {plain_key(atoms[0]): atoms[1] for atoms in stated}
    texts = {entry.atoms[0]: entry.atoms[1] for entry in item.all("fp_text") if len(entry.atoms) > 1}
    attributes = [atom for entry in item.all("attr") for atom in entry.atoms]
    return Footprint(
        item,
        reference=(properties.get("reference") or texts.get("reference") or "").strip(),
        package=(item.atoms[0] if item.atoms else "").rpartition(":")[2].strip(),
        side="bottom" if item.word("layer").startswith("B.") else "top",
        origin=at.here(),
        turn_rad=item.angle(),
        attributes=frozenset(attributes),
        value=(properties.get("value") or texts.get("value") or "").strip(),
        part=part_number(properties),
        stated_height_mm=stated_height(properties),
        description=(item.word("descr") or properties.get("description", "")).strip(),
        models=tuple(model.atoms[0] for model in item.all("model") if model.atoms and _is_to_scale(model)),
    )


def _is_to_scale(model: Item) -> bool:
    scale = model.first("scale")
    xyz = None if scale is None else scale.first("xyz")
    return xyz is None or set(xyz.atoms) <= _UNSCALED


def body_outline(footprint: Footprint) -> tuple[Polygon | MultiPolygon | None, str]:
    """Outline of the body in the footprint's frame: fabrication layer, else courtyard, else around the pads.

    A fabrication drawing that is small beside the pads is a mark, not a body.

    Returns:
        The outline (``None`` if nothing has an area) and its source: ``fab``, ``courtyard`` or ``pads``.
    """
    front = "B." if footprint.side == "bottom" else "F."
    pads = box_around([_pad_corners(pad, footprint) for pad in footprint.pads if "np_thru_hole" not in pad.atoms])
    fabricated = enclosed(footprint.drawn(f"{front}Fab"))
    if fabricated is not None and (pads is None or fabricated.area >= 0.1 * pads.area):
        return fabricated, "fab"
    courtyard = enclosed(footprint.drawn(f"{front}CrtYd"))
    if courtyard is not None:
        shrunk = courtyard.buffer(-_COURTYARD_MM, join_style="mitre")
        return (courtyard if shrunk.is_empty else shrunk), "courtyard"
    return pads, "pads"


def has_leads(footprint: Footprint) -> bool:
    """Whether a pad of the footprint has a plated hole."""
    return any("thru_hole" in pad.atoms[1:2] for pad in footprint.pads)


def is_copper(footprint: Footprint) -> bool:
    """Whether nothing but one pad is there: a via, a hole or a wire pad that was made a footprint."""
    pads = [pad for pad in footprint.pads if "np_thru_hole" not in pad.atoms]
    return len(pads) < 2 and not footprint.is_drawn and footprint.item.first("model") is None


def _pad_corners(pad: Item, footprint: Footprint) -> Points2:
    size = pad.first("size")
    if size is None:
        raise pad.error(f"a pad of {footprint.reference} has no size. Save the board in KiCad again.")
    half = np.array([size.number(0), size.number(1)]) / 2.0
    turn = pad.angle() - footprint.turn_rad  # the file states a pad's angle on the board, its place in the footprint
    cos, sin = math.cos(turn), math.sin(turn)
    corners = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]) * half
    return corners @ np.array([[cos, sin], [-sin, cos]]) + pad.point("at")


def drill_loops(footprint: Footprint) -> list[Points2]:
    """Drilled holes and slots from 1 mm across, on the board, as open rings."""
    loops: list[Points2] = []
    for pad in footprint.pads:
        drill = pad.first("drill")
        if drill is None:
            continue
        places = [place for place, atom in enumerate(drill.atoms) if _NUMBER.fullmatch(atom)]  # (drill oval 1 2)
        sizes = [size for place in places if (size := drill.number(place)) > 0.0]
        if not sizes or min(sizes) < DRILL_MM:
            continue
        width, height = sizes[0], sizes[-1]
        turn = pad.angle() + (math.pi / 2.0 if height > width else 0.0)
        centre = pad.point("at") + _drill_offset(pad)
        along = np.array([math.cos(turn), math.sin(turn)])
        half = abs(width - height) / 2.0
        loops.append(slot(footprint.place(centre[None, :])[0], along, half, min(width, height) / 2.0))
    return loops


def flat_pads(footprint: Footprint) -> tuple[Pad, ...]:
    """Read the surface-mount pads on the footprint's own side, in file order. Board frame, mm.

    Plated holes, edge contacts and openings for paste alone are left out. Whatever is not round is taken for the
    rectangle around it: ovals, rounded and free shapes as well.

    Raises:
        BoardError: A number of a pad cannot be read.
    """
    copper = {"B.Cu" if footprint.side == "bottom" else "F.Cu", "*.Cu", "F&B.Cu"}
    mounted = (item for item in footprint.pads if "smd" in item.atoms[1:2])
    items = (item for item in mounted if (layers := item.first("layers")) is not None and copper & set(layers.atoms))
    return tuple(pad for item in items for pad in _flat_pad(item, footprint))


def _flat_pad(pad: Item, footprint: Footprint) -> Iterator[Pad]:
    at = pad.first("at")
    size = pad.first("size")
    if at is None or size is None:
        raise pad.error(f"a pad of {footprint.reference} has no place or no size. Save the board in KiCad again.")
    half = np.array([size.number(0), size.number(1)]) / 2.0
    low, high = -half, half
    primitives = pad.first("primitives")  # free shapes are drawn beside their anchor
    for line in map(polyline, primitives.items if primitives is not None else ()):
        if line is not None:
            low, high = np.minimum(low, line.min(axis=0)), np.maximum(high, line.max(axis=0))
    length, width = (high - low).tolist()
    if min(length, width) < _LEAST_PAD_MM:
        return
    turn = pad.angle()
    inside = turn - footprint.turn_rad
    middle = (low + high) / 2.0 + _drill_offset(pad)
    cos, sin = math.cos(inside), math.sin(inside)
    x, y = footprint.place((at.here() + middle @ np.array([[cos, sin], [-sin, cos]]))[None, :])[0].tolist()
    shape = pad.atoms[2] if len(pad.atoms) > 2 else "rect"
    is_round = shape in ("circle", "oval") and abs(length - width) < _LEAST_PAD_MM
    yield Pad(x, y, length, width, math.remainder(turn, 2.0 * math.pi), is_round)


def _drill_offset(pad: Item) -> Points2:
    """How far the copper lies beside the drill, in the pad's frame."""
    drill = pad.first("drill")
    offset = drill.first("offset") if drill is not None else None
    return offset.here() if offset is not None else np.zeros(2)
