"""Eagle boards, versions 6 to 9: ``.brd``."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from boards.board import Body
from boards.bounds import check_crowds, number_within
from boards.errors import BoardError
from boards.formats.eagle.elements import Element, drawn, read_elements
from boards.formats.eagle.package import (
    EDGE,
    Placement,
    body_outline,
    description_of,
    drill_loops,
    flat_pads,
    has_contacts,
    is_copper,
)
from boards.formats.layout import (
    THICKNESS_MM,
    LayoutNotes,
    LayoutPart,
    LayoutWords,
    build_bodies,
    part_number,
    plain_key,
    read_outline,
    stated_height,
)
from boards.formats.loops import Point2
from boards.packages.families import package_family
from boards.packages.heights import HeightEvidence
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import EAGLE_VERSION

_LAST_VERSION = 9
_THICKNESS_MM = (0.1, 10.0)
_UNITS_MM = {"mm": 1.0, "mil": 0.0254, "mic": 0.001, "inch": 25.4, "in": 25.4}


def _spot(point: Point2) -> str:
    return f"x {point[0]:.3f}, y {point[1]:.3f} mm"


_WORDS = LayoutWords("Eagle", "layer 20 (Dimension)", "layer 51 (tDocu)", _spot, "pads and lines")


@dataclass(frozen=True, slots=True, eq=False)
class _Placed:
    """An element with its package."""

    element: Element
    package: Element
    placement: Placement

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
    check_crowds([each.placement.origin for each in placed], path)
    notes = LayoutNotes()
    edges, drills = _read_edges(board, placed)
    outline = read_outline(edges, drills, path, _WORDS, notes)
    variant = next((item.word("name") for item in board.inside("variantdefs") if item.word("current") == "yes"), "")
    models = {item.word("urn"): item.word("name") for item in board.inside("libraries", "library", "packages3d")}
    parts = [_part(each, models, notes) for each in placed if _is_part(each, variant, notes)]
    solid = [part for part in parts if part is not None]
    bodies, findings = build_bodies(outline, _thickness(board), solid, _WORDS, notes)
    return bodies, (*_version_findings(top.word("version")), *findings)


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
        yield _Placed(element, found, Placement(element.point(), element.turn()))


def _read_edges(board: Element, placed: Sequence[_Placed]) -> tuple[list[Points2], list[Points2]]:
    """Collect everything that is drawn on the layer of the edge, packages included, and the drilled holes."""
    plain = board.first("plain")
    edges = drawn(plain.children, EDGE) if plain is not None else []
    drills = drill_loops(plain) if plain is not None else []
    for each in placed:
        edges.extend(each.placement.place(line) for line in drawn(each.package.children, EDGE))
        drills.extend(each.placement.place(loop) for loop in drill_loops(each.package))
    return edges, drills


def _is_part(each: _Placed, variant: str, notes: LayoutNotes) -> bool:
    """Whether an element carries a body that is mounted; what does not is noted."""
    family = package_family(each.package.word("name"))
    flat = family is not None and not family.has_body
    choice = next((item for item in each.element.all("variant") if variant and item.word("name") == variant), None)
    left = "no" in (each.element.word("populate"), "" if choice is None else choice.word("populate"))
    bare = not has_contacts(each.package) or (family is None and is_copper(each.package))
    if flat or left or bare:
        notes.left_out.append(each.name)
        return False
    return True


def _part(each: _Placed, models: dict[str, str], notes: LayoutNotes) -> LayoutPart | None:
    outline, is_box = body_outline(each.package)
    if outline is None:
        notes.left_out.append(each.name)
        return None
    x0, y0, x1, y1 = outline.bounds
    model = models.get(each.element.word("package3d_urn"), "")
    evidence = HeightEvidence(
        each.package.word("name"),
        each.element.word("name"),
        (model,) if model else (),
        description_of(each.package),
        each.package.first("pad") is not None,
        max(x1 - x0, y1 - y0),
    )
    stated = {plain_key(item.word("name")): item.word("value") for item in each.element.all("attribute")}
    return LayoutPart(
        each.name,
        each.placement.place_outline(outline),
        each.placement.side,
        evidence,
        is_box,
        part=part_number(stated),
        value=each.element.word("value"),
        pins=len({item.word("name") for item in each.package.all("pad", "smd")}) or None,
        pads=flat_pads(each.package, each.placement),
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
    return round(total, 4) if _THICKNESS_MM[0] <= total <= _THICKNESS_MM[1] else THICKNESS_MM


def _lengths(text: str) -> list[float]:
    """Lengths with their units, such as ``0.035mm 1.4mil``, in mm; none if one cannot be read."""
    found = [re.fullmatch(r"([\d.]+)([a-z]*)", word) for word in text.split()[:64]]
    lengths = [
        math.nan if hit is None else number_within(hit[1], _THICKNESS_MM[1], _UNITS_MM.get(hit[2], math.nan))
        for hit in found
    ]
    return [] if any(map(math.isnan, lengths)) else lengths


def _version_findings(version: str) -> list[Finding]:
    major = re.match(r"\d{1,3}", version)
    if major is not None and int(major[0]) <= _LAST_VERSION:
        return []
    known = f"versions 6 to {_LAST_VERSION} of Eagle are known"
    return [Finding(EAGLE_VERSION, f"The file is of version {version[:40]!r}; {known}. Check what was read.")]
