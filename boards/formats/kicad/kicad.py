"""KiCad boards, versions 5 to 9: ``.kicad_pcb``."""

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, Polygon

from boards.board import Body, Pad, Side
from boards.bounds import check_crowds
from boards.formats.kicad.items import Item, drawn, pens, polyline, read_items
from boards.formats.layout import (
    THICKNESS_MM,
    EdgeDrawing,
    LayoutNotes,
    LayoutPart,
    LayoutWords,
    build_bodies,
    evidence_of,
    part_number,
    plain_key,
    read_outline,
    spot_mm,
    stated_height,
)
from boards.formats.loops import DRILL_MM, box_around, enclosed, slot
from boards.formats.placed import LEAST_PAD_MM, Pose, has_leads
from boards.packages.families import is_bare, package_family
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import KICAD_VERSION

_EDGE = "Edge.Cuts"
_FIRST_VERSION, _LAST_VERSION = 20160000, 20250300

_MADE = (_EDGE, ".Cu", ".Mask", ".Paste", ".SilkS", ".Adhes")
"""Layers of what is made; lines on others, such as Cmts.User, may score a panel."""

_NO_PART = re.compile(
    r"fiducial|mounting_?hole|test_?(?:point|pad)|solder_?jumper|^sj(?:_|$)|net_?tie|logo|symbol_|svg2mod",
    re.IGNORECASE,
)
"""Names of footprints that are copper or print only, unless they name a family of packages."""

_VIRTUAL = frozenset({"virtual", "exclude_from_bom"})
"""Attributes of what is not bought: before version 6, and since."""


_COURTYARD_MM = 0.25
"""Usual distance of KiCad's courtyard from the body (KiCad library convention F5.3)."""

_UNSCALED = {"1", "1.0"}
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)
_WORDS = LayoutWords("KiCad", _EDGE, "F.Fab", lambda point: spot_mm(point * [1.0, -1.0] + 0.0))
"""KiCad shows points with y down."""


@dataclass(frozen=True, slots=True, eq=False)
class Footprint:
    """A placed footprint. Board frame, mm, y up; what is drawn in it stays in its own frame until ``place``."""

    item: Item
    reference: str
    package: str
    """Name without the library."""
    side: Side
    pose: Pose
    attributes: frozenset[str]
    value: str
    part: str
    stated_height_mm: float | None
    """From its properties."""
    description: str
    models: tuple[str, ...]
    """File names of the 3-D models at their own scale."""

    @property
    def name(self) -> str:
        """Reference designator, without the blanks that no board file can hold."""
        return "".join(self.reference.split()) or self.package or "unnamed"

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


def read_kicad(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a KiCad board: outline, and one prism a component.

    KiCad's y points down; it is turned round (y = -y of KiCad) and the origin is kept, so that the frame is x right,
    y back, z up with the board's underside at z = 0, and positions agree with KiCad's own ``.pos`` files.
    A body's outline is the footprint's fabrication drawing, else its courtyard less 0.25 mm, else the box around its
    pads. Its height and the gap beneath it are nominal, from the names of the package and of its 3-D model: the body
    carries their source as ``x-height``, so that a parts table may replace them. ``gap_height_mm`` stays unknown, as
    KiCad does not state it. Pads that are soldered flat come along. Drilled holes and slots from 1 mm across are cut
    out of the board.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, or its outline is missing, open or crosses itself.
    """
    board, items = read_items(path)
    footprints = [_read_footprint(item) for item in items if item.head in ("footprint", "module")]
    check_crowds([(each.pose.x_mm, each.pose.y_mm) for each in footprints], path)
    general = next((item for item in items if item.head == "general"), None)
    thickness = None if general is None else general.first("thickness")
    thickness_mm = THICKNESS_MM if thickness is None else thickness.number(0)
    if thickness is not None and thickness_mm <= 0.0:
        raise thickness.error("the board's thickness must be above 0. Correct it in the board setup.")
    notes = LayoutNotes()
    edges = drawn(items, "gr_", _EDGE)  # everything that is drawn there, footprints included
    edges += [each.pose.place(line) for each in footprints for line in each.drawn(_EDGE)]
    drills = [loop for each in footprints for loop in _drill_loops(each)]
    soldered = [(each.pose.x_mm, each.pose.y_mm) for each in footprints if (each.pins or 0) > 1]
    drawing = EdgeDrawing(edges, drills, pens(items, "gr_", _EDGE), np.array(soldered).reshape(-1, 2))
    outline = read_outline(drawing, path, _WORDS, notes)
    notes.lines += [
        line
        for item in items
        if item.head == "gr_line" and not item.word("layer").endswith(_MADE)
        for line in [polyline(item)]
        if line is not None
    ]
    parts = [(part, *_body_outline(part)) for part in footprints if _is_part(part, notes)]
    notes.left_out += [part.name for part, body, _ in parts if body is None]
    solid = [_part(part, body, source == "pads") for part, body, source in parts if body is not None]
    bodies, findings = build_bodies(outline, thickness_mm, solid, _WORDS, notes)
    version = int(board.atoms[0]) if board.atoms else 0
    if _FIRST_VERSION <= version <= _LAST_VERSION:
        return bodies, findings
    text = f"The file is of format version {version}; versions 5 to 9 of KiCad are known. Check what was read."
    return bodies, (Finding(KICAD_VERSION, text), *findings)


def _is_part(part: Footprint, notes: LayoutNotes) -> bool:
    """Whether a footprint carries a body; what does not is noted."""
    family = package_family(part.package)
    flat = family is not None and not family.has_body
    bare = not part.pads and not part.is_drawn
    # Real connectors are marked virtual, too: what has two pins or more stays in the nozzle's way.
    virtual = family is None and (part.pins or 0) < 2 and bool(part.attributes & _VIRTUAL)
    # Nothing but one pad is a via, a hole or a wire pad that was made a footprint.
    lone = sum("np_thru_hole" not in pad.atoms for pad in part.pads) < 2 and not part.is_drawn
    copper = family is None and (
        (lone and part.item.first("model") is None) or _NO_PART.search(part.package) is not None
    )
    print_only = is_bare([part.package], part.reference, part.pins or 0, part.stated_height_mm)
    if is_out := "dnp" in part.attributes:
        notes.not_fitted.append(part.name)
    if flat or bare or virtual or copper or (print_only and not part.models) or is_out:
        notes.left_out.append(part.name)
        return False
    return True


def _part(part: Footprint, outline: Polygon | MultiPolygon, from_pads: bool) -> LayoutPart:
    holes = [_rectangle(pad, part) for pad in part.pads if "thru_hole" in pad.atoms[1:2]]
    leads = has_leads(holes, [_rectangle(pad, part) for pad in part.pads if "smd" in pad.atoms[1:2]] if holes else [])
    return LayoutPart(
        part.name,
        part.pose.place_outline(outline),
        part.side,
        evidence_of(outline, part.package, part.reference, leads, part.description, part.models),
        from_pads,
        part=part.part,
        value=part.value,
        pins=part.pins,
        pads=_flat_pads(part),
        stated_height_mm=part.stated_height_mm,
    )


def _read_footprint(item: Item) -> Footprint:
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
    x, y = at.here().tolist()
    return Footprint(
        item,
        reference=(properties.get("reference") or texts.get("reference") or "").strip(),
        package=(item.atoms[0] if item.atoms else "").rpartition(":")[2].strip(),
        side="bottom" if item.word("layer").startswith("B.") else "top",
        pose=Pose(x, y, item.angle()),
        attributes=frozenset(attributes),
        value=(properties.get("value") or texts.get("value") or "").strip(),
        part=part_number(properties),
        stated_height_mm=stated_height(properties),
        description=(item.word("descr") or properties.get("description", "")).strip(),
        models=tuple(
            model.atoms[0]
            for model in item.all("model")
            if model.atoms and all(set(xyz.atoms) <= _UNSCALED for s in model.all("scale") for xyz in s.all("xyz"))
        ),
    )


def _body_outline(footprint: Footprint) -> tuple[Polygon | MultiPolygon | None, str]:
    """Outline of the body in the footprint's frame: fabrication layer, else courtyard, else around the pads.

    A fabrication drawing that is small beside the pads is a mark, not a body.

    Returns:
        The outline (``None`` if nothing has an area) and its source: ``fab``, ``courtyard`` or ``pads``.
    """
    front = "B." if footprint.side == "bottom" else "F."
    plated = [pad for pad in footprint.pads if "np_thru_hole" not in pad.atoms]
    pads = box_around([_pose_of(pad, footprint).rectangle(*_size_of(pad, footprint)) for pad in plated])
    fabricated = enclosed(footprint.drawn(f"{front}Fab"))
    if fabricated is not None and (pads is None or fabricated.area >= 0.1 * pads.area):
        return fabricated, "fab"
    courtyard = enclosed(footprint.drawn(f"{front}CrtYd"))
    if courtyard is not None:
        shrunk = courtyard.buffer(-_COURTYARD_MM, join_style="mitre")
        return (courtyard if shrunk.is_empty else shrunk), "courtyard"
    return pads, "pads"


def _size_of(pad: Item, footprint: Footprint) -> tuple[float, float]:
    size = pad.first("size")
    if size is None:
        raise pad.error(f"a pad of {footprint.reference} has no size. Save the board in KiCad again.")
    return size.number(0), size.number(1)


def _pose_of(pad: Item, footprint: Footprint) -> Pose:
    """Pose of a pad in its footprint: the file states its place there, but its angle on the board."""
    x, y = pad.point("at").tolist()
    return Pose(x, y, pad.angle() - footprint.pose.turn_rad)


def _rectangle(pad: Item, footprint: Footprint) -> Pad:
    """Rectangle around the copper of a pad, in the footprint's frame."""
    pose = _pose_of(pad, footprint)
    return Pad(pose.x_mm, pose.y_mm, *_size_of(pad, footprint), pose.turn_rad)


def _drill_loops(footprint: Footprint) -> list[Points2]:
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
        centre, along = footprint.pose.place(pad.point("at")), np.array([math.cos(turn), math.sin(turn)])
        loops.append(slot(centre, along, abs(width - height) / 2.0, min(width, height) / 2.0))
    return loops


def _flat_pads(footprint: Footprint) -> tuple[Pad, ...]:
    """Read the surface-mount pads on the footprint's own side, in file order. Board frame, mm.

    Plated holes, edge contacts and openings for paste alone are left out. Whatever is not round is taken for the
    rectangle around it: ovals, rounded and free shapes as well.

    Raises:
        BoardError: A number of a pad cannot be read.
    """
    copper = {"B.Cu" if footprint.side == "bottom" else "F.Cu", "*.Cu", "F&B.Cu"}
    mounted = (item for item in footprint.pads if "smd" in item.atoms[1:2])
    items = (item for item in mounted if (layers := item.first("layers")) is not None and copper & set(layers.atoms))
    pads: list[Pad] = []
    for pad in items:
        half = np.array(_size_of(pad, footprint)) / 2.0
        low, high = -half, half
        primitives = pad.first("primitives")  # free shapes are drawn beside their anchor
        for line in map(polyline, primitives.items if primitives is not None else ()):
            if line is not None:
                low, high = np.minimum(low, line.min(axis=0)), np.maximum(high, line.max(axis=0))
        length, width = (high - low).tolist()
        if min(length, width) < LEAST_PAD_MM:
            continue
        # The copper may lie beside the drill, which is where the file places the pad.
        offset = next((each.here() for drill in pad.all("drill") for each in drill.all("offset")), np.zeros(2))
        x, y = footprint.pose.place(_pose_of(pad, footprint).place((low + high) / 2.0 + offset)).tolist()
        is_round = pad.atoms[2:3] in (("circle",), ("oval",)) and abs(length - width) < LEAST_PAD_MM
        pads.append(Pad(x, y, length, width, math.remainder(pad.angle(), 2.0 * math.pi), is_round))
    return tuple(pads)
