"""Eagle boards, versions 6 to 9: ``.brd``."""

import html
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from shapely import MultiPolygon, Polygon

from boards.board import Body, Pad
from boards.bounds import check_crowds, number_within
from boards.errors import BoardError
from boards.formats.eagle.elements import Element, drawn, read_elements
from boards.formats.layout import (
    THICKEST_MM,
    THICKNESS_MM,
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
from boards.formats.loops import DRILL_MM, box_around, circle, enclosed
from boards.formats.placed import LEAST_PAD_MM, Pose
from boards.packages.families import package_family
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import EAGLE_VERSION

_LAST_VERSION = 9
_UNITS_MM = {"mm": 1.0, "mil": 0.0254, "mic": 0.001, "inch": 25.4, "in": 25.4}
_EDGE = "20"
_BODY = ("21", "51")
"""tPlace and tDocu: print, and the drawing of the part."""

_KEEPOUT = ("39",)
_COPPER = "1"
_LEAST_BODY = 0.25
"""Part of the box around the pads that the drawing of a body covers at least; pins alone cover less."""
_RIM = 1.7
"""Diameter of a pad as a multiple of its drill, where the file leaves it to the design rules."""

_WORDS = LayoutWords("Eagle", "layer 20 (Dimension)", "layer 51 (tDocu)", box="pads and lines")


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """An element with its package."""

    element: Element
    package: Element
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
    top = read_elements(path)
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
    # Whatever is drawn on the layer of the edge, packages included, and the drilled holes.
    drawings = [(each.package, each.pose) for each in placed]
    for item, pose in [(plain, None), *drawings] if plain is not None else drawings:
        lines, holes = drawn(item.children, _EDGE), _drill_loops(item)
        edges += lines if pose is None else map(pose.place, lines)
        drills += holes if pose is None else map(pose.place, holes)
    outline = read_outline(edges, drills, path, _WORDS, notes)
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


def _placed(board: Element) -> Iterator[_Placed]:
    packages: dict[tuple[str, str, str], Element] = {}
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
    contacts = len(list(each.package.all("pad", "smd")))
    # Nothing but one pad is a fiducial, a test point or a wire pad.
    bare = not contacts or (family is None and contacts < 2 and not drawn(each.package.children, *_BODY))
    if flat or left or bare:
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
        each.package.first("pad") is not None,
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


def _thickness(board: Element) -> float:
    """Sum of copper and isolation of the layers in use, mm."""
    stated = {item.word("name"): item.word("value") for item in board.inside("designrules") if item.tag == "param"}
    used = [int(number) for number in re.findall(r"\d{1,2}", stated.get("layerSetup", "")[:200])]
    copper, isolation = (_lengths(stated.get(name, "")) for name in ("mtCopper", "mtIsolate"))
    if not used or max(used) > len(copper) or max(used) - 1 > len(isolation) or min(used) < 1:
        return THICKNESS_MM
    # What lies beneath layer n comes n-th; there is nothing beneath the last one.
    total = sum(copper[layer - 1] for layer in used) + sum(isolation[layer - 1] for layer in used[:-1])
    return first_thickness([round(total, 4)])


def _lengths(text: str) -> list[float]:
    """Lengths with their units, such as ``0.035mm 1.4mil``, in mm; none if one cannot be read."""
    found = [re.fullmatch(r"([\d.]+)([a-z]*)", word) for word in text.split()[:64]]
    lengths = [
        math.nan if hit is None else number_within(hit[1], THICKEST_MM, _UNITS_MM.get(hit[2], math.nan))
        for hit in found
    ]
    return [] if any(map(math.isnan, lengths)) else lengths


def _body_outline(package: Element) -> tuple[Polygon | MultiPolygon | None, bool]:
    """Outline of the body in the package's frame: its drawing, else its keep-out, else the box around pads and lines.

    A drawing that is small beside the pads is a mark, not a body.

    Returns:
        The outline (``None`` if nothing has an area), and whether it is only the box around pads and lines.
    """
    lines = drawn(package.children, *_BODY)
    contacts = [_corners(item) for item in package.all("pad", "smd")]
    pads = box_around(contacts)
    for drawing in (lines, drawn(package.children, *_KEEPOUT)):
        body = enclosed(drawing)
        if body is not None and (pads is None or body.area >= _LEAST_BODY * pads.area):
            return body, False
    return box_around([*contacts, *lines]), True


def _corners(item: Element) -> Points2:
    if item.tag == "smd":
        return item.pose().rectangle(item.number("dx"), item.number("dy"))
    stated = "diameter" in item.attributes and item.word("diameter") != "0"
    across = item.number("diameter") if stated else _RIM * item.number("drill")
    return item.pose().rectangle(across, across)


def _flat_pads(package: Element, placement: Pose) -> tuple[Pad, ...]:
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


def _drill_loops(items: Element) -> list[Points2]:
    """Drilled holes from 1 mm across of a package or of the board itself, in their frame, as open rings."""
    drilled = ((item, item.number("drill")) for item in items.all("hole", "pad"))
    return [circle(item.point(), drill_mm / 2.0) for item, drill_mm in drilled if drill_mm >= DRILL_MM]
