"""Eagle boards, versions 6 to 9: ``.brd``."""

import html
import math
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from shapely import MultiPolygon, Polygon

from boards.board import Body, Pad
from boards.bounds import MOST_TURN_DEG, check_crowds, number_within
from boards.errors import BoardError, read_bytes
from boards.formats.layout import (
    THICKEST_MM,
    THICKNESS_MM,
    EdgeDrawing,
    LayoutNotes,
    LayoutPart,
    LayoutWords,
    build_bodies,
    evidence_of,
    first_thickness,
    part_number,
    plain_key,
    read_outline,
    stated_height,
)
from boards.formats.loops import DRILL_MM, Point2, arc_between, box_around, circle, enclosed, is_too_far
from boards.formats.placed import LEAST_PAD_MM, Pose, has_leads, is_between
from boards.formats.xml_tree import XmlElement, XmlWords, read_xml
from boards.packages.families import is_bare, package_family
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import EAGLE_VERSION

_LAST_VERSION = 9
_UNITS_MM = {"mm": 1.0, "mil": 0.0254, "mic": 0.001, "inch": 25.4, "in": 25.4}
_EDGE = "20"
_BODY = ("21", "51")
"""tPlace and tDocu: print, and the drawing of the part."""

_KEEPOUT = ("39",)
_SCORES = ("46", "47", "48", "49", *map(str, range(100, 256)))
"""Layers on which the scores of a panel are drawn: milling, measures, documents, and those of one's own."""
_COPPER = "1"
_LEAST_BODY = 0.25
"""Part of the box around the pads that the drawing of a body covers at least; pins alone cover less."""
_RIM = 1.7
"""Diameter of a pad as a multiple of its drill, where the file leaves it to the design rules."""

_WORDS = LayoutWords("Eagle", "layer 20 (Dimension)", "layer 51 (tDocu)", box="pads and lines")
_BINARY = (b"\x10\x00", b"\x10\x80")
_SAVE = "Open it in Eagle 6 or newer, or in KiCad, and save it there."


_XML = XmlWords(
    "Eagle board",
    "Save the board in Eagle again.",
    frozenset({"signals", "schematic", "autorouter", "errors", "classes", "symbols", "devicesets"}),
    deepest=30,  # Eagle nests about ten elements
    most_elements=5_000_000,
    most_kept=5_000_000,
    kept_texts=frozenset({"description"}),
)
"""Left out are copper, rules and circuit diagrams: most of a usual file."""


@dataclass(frozen=True, slots=True)
class _Element(XmlElement):
    """One element of an Eagle file."""

    def point(self, mark: str = "") -> Point2:
        """Return the point of the attributes ``x`` and ``y``, with a number behind them if one is given, mm."""
        return np.array([self.number(f"x{mark}"), self.number(f"y{mark}")])

    def pose(self, at: Point2 | None = None) -> Pose:
        """Pose at a place, or at ``x`` and ``y``, by ``rot``: spin and mirror letters, ``R`` and degrees.

        ``MR90`` is turned by 90° as _drawn, and its x then changes its sign.

        Raises:
            BoardError: It cannot be read.
        """
        text = self.word("rot").upper()
        letters, mark, degrees = text.rpartition("R")
        value = number_within(degrees, MOST_TURN_DEG) if text else 0.0
        if not math.isfinite(value) or set(letters) - {"S", "M"} or (text and not mark):
            raise self.error(f"rot of <{self.tag}> is {text[:40]!r}, not such as R90 or MR180. Save the board again.")
        x, y = (self.point() if at is None else at).tolist()
        return Pose(x, y, math.radians(-value if "M" in letters else value), "M" in letters)


def _read_elements(path: Path) -> _Element:
    """Read the tree of an Eagle file without its copper; entities are never expanded, nothing else is opened.

    Returns:
        The element ``eagle``.

    Raises:
        BoardError: The file cannot be read, is no Eagle file of version 6 or later, or declares entities.
    """
    data = read_bytes(path)
    if data[:2] in _BINARY:
        raise BoardError(f"a board of Eagle 5 or older, in its binary format. {_SAVE}", file=path)
    if not data.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<"):
        raise BoardError(f"not a board of Eagle 6 or newer, which is XML. {_SAVE}", file=path)
    top = read_xml([data], path, _XML, _Element)
    if top.tag != "eagle":
        raise top.error(f"not an Eagle board: it begins with <{top.tag[:40]}>. {_SAVE}")
    return top


def _drawn(items: Iterable[_Element], *layers: str) -> list[Points2]:
    """Polylines ``(n, 2)`` of what is _drawn on some layers, mm; closed shapes end on their first point."""
    lines = (_polyline(item) for item in items if item.word("layer") in layers)
    return [line for line in lines if line is not None]


def _polyline(item: _Element) -> Points2 | None:
    match item.tag:
        case "wire":
            return _stretch(item.point("1"), item.point("2"), item)
        case "circle":
            ring = circle(item.point(), item.number("radius"))
            return np.concatenate([ring, ring[:1]])
        case "rectangle":
            (ax, ay), (bx, by) = item.point("1"), item.point("2")
            middle = np.array([ax + bx, ay + by]) / 2.0
            return item.pose(middle).place(np.array([[ax, ay], [bx, ay], [bx, by], [ax, by], [ax, ay]]) - middle)
        case "polygon":
            corners = list(item.all("vertex"))
            if len(corners) < 3:
                raise item.error("a polygon has fewer than three corners. Save the board in Eagle again.")
            pieces = [_stretch(a.point(), b.point(), a)[:-1] for a, b in pairwise([*corners, corners[0]])]
            return np.concatenate([*pieces, pieces[0][:1]])
        case _:
            return None


def _stretch(start: Point2, end: Point2, item: _Element) -> Points2:
    """Line or arc; a positive ``curve`` turns counter-clockwise."""
    curve = item.number("curve", 360.0) if "curve" in item.attributes else 0.0
    if is_too_far(start, end, math.radians(curve)):
        raise item.error(
            f"curve of <{item.tag}> is {curve:g} degrees between two places: such an arc leads more than 10 m away. "
            "Draw a circle, or save the board in Eagle again."
        )
    return arc_between(start, end, math.radians(curve))


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """An element with its package."""

    element: _Element
    package: _Element
    pose: Pose

    @property
    def name(self) -> str:
        """Reference designator, without the blanks that no board file can hold."""
        return "".join(self.element.word("name").split()) or self.package.word("name") or "unnamed"


def read_eagle(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read an Eagle board: outline, and one prism a component.

    The frame is that of the file, which is in mm whatever its grid: x right, y back, with the board's underside at
    z = 0. A body's outline is what tPlace and tDocu draw of it, else its keep-out, else the box around pads and lines.
    Its height and the gap beneath it are nominal, from the names of the package and of its 3-D package. Pads that are
    soldered flat come along. Drilled holes from 1 mm across are cut out of the board. The thickness is the sum of the
    layer setup's copper and isolation, 1.6 mm if none is stated. Milling (layer 46) is not read.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, is no board of Eagle 6 or newer, or its outline is missing, open or
            crosses itself.
    """
    top = _read_elements(path)
    board = next((item for item in top.inside("drawing") if item.tag == "board"), None)
    if board is None:
        kind = next((item.tag for item in top.inside("drawing") if item.tag == "library"), "schematic")
        raise BoardError(f"an Eagle {kind}, not a board. Name the .brd file of the board.", file=path)
    placed = list(_placed(board))
    check_crowds([(each.pose.x_mm, each.pose.y_mm) for each in placed], path)
    notes = LayoutNotes()
    edges: list[Points2] = []
    drills: list[Points2] = []
    plain = board.first("plain")
    # Whatever is _drawn on the layer of the edge, packages included, and the drilled holes.
    drawings = [(each.package, each.pose) for each in placed]
    for item, pose in [(plain, None), *drawings] if plain is not None else drawings:
        lines = _drawn(item.children, _EDGE)
        drilled = ((each, each.number("drill")) for each in item.all("hole", "pad"))
        holes = [circle(each.point(), drill_mm / 2.0) for each, drill_mm in drilled if drill_mm >= DRILL_MM]
        edges += lines if pose is None else map(pose.place, lines)
        drills += holes if pose is None else map(pose.place, holes)
    wires = (item for item in (plain.all("wire") if plain is not None else ()) if item.word("layer") == _EDGE)
    pens = [item.number("width") for item in wires if "width" in item.attributes]
    soldered = [(each.pose.x_mm, each.pose.y_mm) for each in placed if len(list(each.package.all("pad", "smd"))) > 1]
    edge = EdgeDrawing(edges, drills, pens, np.array(soldered).reshape(-1, 2))
    outline = read_outline(edge, path, _WORDS, notes)
    notes.lines += _drawn(plain.all("wire") if plain is not None else (), *_SCORES)
    variant = next((item.word("name") for item in board.inside("variantdefs") if item.word("current") == "yes"), "")
    models = {item.word("urn"): item.word("name") for item in board.inside("libraries", "library", "packages3d")}
    parts = [_part(each, models, notes) for each in placed if _is_part(each, variant, notes)]
    solid = [part for part in parts if part is not None]
    bodies, findings = build_bodies(outline, _thickness(board), solid, _WORDS, notes)
    version = top.word("version")
    major = re.match(r"\d{1,3}", version)
    if major is not None and int(major[0]) <= _LAST_VERSION:
        return bodies, findings
    known = f"versions 6 to {_LAST_VERSION} of Eagle are known"
    text = f"The file is of version {version[:40]!r}; {known}. Check what was read."
    return bodies, (Finding(EAGLE_VERSION, text), *findings)


def _placed(board: _Element) -> Iterator[_Placed]:
    packages: dict[tuple[str, str, str], _Element] = {}
    for library in board.inside("libraries"):
        name, urn = library.word("name"), library.word("urn")
        for package in library.inside("packages"):
            packages[name, urn, package.word("name")] = package
            packages.setdefault((name, "", package.word("name")), package)
    for element in board.inside("elements"):
        if element.tag != "element":
            continue
        name, package = element.word("library"), element.word("package")
        found = packages.get((name, element.word("library_urn"), package)) or packages.get((name, "", package))
        if found is None:
            label = f"{element.word('name')[:40]!r} is of the package {package[:60]!r}, which is in no library"
            raise element.error(f"{label} of the file. Save the board in Eagle again.")
        yield _Placed(element, found, element.pose())


def _is_part(each: _Placed, variant: str, notes: LayoutNotes) -> bool:
    """Whether an element carries a body that is mounted; what does not is noted."""
    family = package_family(each.package.word("name"))
    flat = family is not None and not family.has_body
    choice = next((item for item in each.element.all("variant") if variant and item.word("name") == variant), None)
    left = "no" in (each.element.word("populate"), "" if choice is None else choice.word("populate"))
    notes.not_fitted += [each.name] * left
    contacts = len(list(each.package.all("pad", "smd")))
    # Nothing but one pad is a fiducial, a test point or a wire pad.
    bare = not contacts or (family is None and contacts < 2 and not _drawn(each.package.children, *_BODY))
    if flat or left or bare or is_bare([each.package.word("name")], each.name, contacts, None):
        notes.left_out.append(each.name)
        return False
    return True


def _part(each: _Placed, models: dict[str, str], notes: LayoutNotes) -> LayoutPart | None:
    outline, is_box = _body_outline(each.package)
    if outline is None:
        notes.left_out.append(each.name)
        return None
    model = models.get(each.element.word("package3d_urn"), "")
    described = each.package.first("description")  # HTML inside XML
    evidence = evidence_of(
        outline,
        each.package.word("name"),
        each.element.word("name"),
        has_leads(_copper(each.package, "pad"), _copper(each.package, "smd")),
        "" if described is None else html.unescape("".join(described.words))[:2000],
        (model,) if model else (),
    )
    stated = {plain_key(item.word("name")): item.word("value") for item in each.element.all("attribute")}
    return LayoutPart(
        each.name,
        each.pose.place_outline(outline),
        "bottom" if each.pose.is_mirrored else "top",
        evidence,
        is_box,
        part=part_number(stated),
        value=each.element.word("value"),
        pins=len({item.word("name") for item in each.package.all("pad", "smd")}) or None,
        pads=_flat_pads(each.package, each.pose),
        stated_height_mm=stated_height(stated),
    )


def _thickness(board: _Element) -> float:
    """Sum of copper and isolation of the layers in use, mm."""
    stated = {item.word("name"): item.word("value") for item in board.inside("designrules") if item.tag == "param"}
    used = [int(number) for number in re.findall(r"\d{1,2}", stated.get("layerSetup", "")[:200])]
    copper, isolation = (
        [
            math.nan if hit is None else number_within(hit[1], THICKEST_MM, _UNITS_MM.get(hit[2], math.nan))
            for hit in (re.fullmatch(r"([\d.]+)([a-z]*)", word) for word in stated.get(name, "").split()[:64])
        ]
        for name in ("mtCopper", "mtIsolate")
    )
    if not used or max(used) > len(copper) or max(used) - 1 > len(isolation) or min(used) < 1:
        return THICKNESS_MM
    # What lies beneath layer n comes n-th; there is nothing beneath the last one.
    total = sum(copper[layer - 1] for layer in used) + sum(isolation[layer - 1] for layer in used[:-1])
    return first_thickness([round(total, 4)])


def _body_outline(package: _Element) -> tuple[Polygon | MultiPolygon | None, bool]:
    """Outline of the body in the package's frame: its drawing, else its keep-out, else the box around pads and lines.

    A drawing that is small beside the pads is a mark, not a body.

    Returns:
        The outline (``None`` if nothing has an area), and whether it is only the box around pads and lines.
    """
    lines = _drawn(package.children, *_BODY)
    coppers = _copper(package, "pad", "smd")
    contacts = [Pose(pad.x_mm, pad.y_mm, pad.turn_rad).rectangle(pad.length_mm, pad.width_mm) for pad in coppers]
    pads = box_around(contacts)
    for drawing in (lines, _drawn(package.children, *_KEEPOUT)):
        body = enclosed(drawing)
        is_print = body is not None and coppers and package.first("pad") is None and is_between(body, coppers)
        if body is not None and not is_print and (pads is None or body.area >= _LEAST_BODY * pads.area):
            return body, False
    return box_around([*contacts, *lines]), True


def _copper(package: _Element, *tags: str) -> list[Pad]:
    """Rectangles around contacts in the package's frame; mm."""
    pads: list[Pad] = []
    for item in package.all(*tags):
        stated = "diameter" in item.attributes and item.word("diameter") != "0"
        across = ("dx", "dy") if item.tag == "smd" else ("diameter",) * 2 if stated else ("drill",) * 2
        rim = 1.0 if item.tag == "smd" or stated else _RIM
        pose = item.pose()
        sizes = (rim * item.number(across[0]), rim * item.number(across[1]))
        pads.append(Pad(pose.x_mm, pose.y_mm, *sizes, pose.turn_rad))
    return pads


def _flat_pads(package: _Element, placement: Pose) -> tuple[Pad, ...]:
    """Surface-mount pads on the element's own side, in file order. Board frame, mm."""
    pads: list[Pad] = []
    for item in (item for item in package.all("smd") if item.word("layer") == _COPPER):
        length, width = item.number("dx"), item.number("dy")
        if min(length, width) >= LEAST_PAD_MM:
            x, y = placement.place(item.point()).tolist()
            roundness = item.number("roundness", 100.0) if "roundness" in item.attributes else 0.0
            is_round = roundness >= 100.0 and abs(length - width) < LEAST_PAD_MM
            own = item.pose()
            turn = placement.turn(-own.turn_rad if own.is_mirrored else own.turn_rad)
            pads.append(Pad(x, y, length, width, turn, is_round))
    return tuple(pads)
