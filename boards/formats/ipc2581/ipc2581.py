"""IPC-2581 boards, revisions B and C: ``.xml`` and ``.cvg``."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from boards.board import Body
from boards.bounds import MOST_TURN_DEG, check_crowds
from boards.errors import MAX_BYTES, BoardError
from boards.formats.ipc2581.components import (
    BomEntry,
    Component,
    Copper,
    conventions_of,
    is_seen_through,
    place_component,
    read_bom,
    read_components,
    read_package,
)
from boards.formats.ipc2581.elements import (
    WORDS,
    Drawing,
    Element,
    ScoreLayers,
    drawn_lines,
    read_dictionaries,
    unit_mm,
)
from boards.formats.layout import LayoutNotes, LayoutWords, build_bodies, first_thickness, spot_mm
from boards.formats.loops import DRILL_MM, circle, outline_of
from boards.formats.placed import PackageShape, StepPanel, StepPlace, StepRepeats, stand_parts
from boards.formats.xml_tree import XmlElement, read_xml
from geometry.arrays import Points2
from specs.finding import Finding
from specs.input_file import InputFile

_CHUNK = 1 << 20
_ROUNDED_MM = 1e-4
"""Files in inches round 1 mm."""


_WORDS = LayoutWords("IPC-2581", "the Profile", "an AssemblyDrawing")


def _chunks(path: Path) -> Iterator[bytes]:
    """Pieces of a file."""
    with InputFile(path, BoardError, "board file", MAX_BYTES).stream() as stream:
        while chunk := stream.read(_CHUNK):
            yield chunk


def read_ipc2581(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read an IPC-2581 file: profile, and one prism a component.

    The frame is that of the step, in mm: x right, y back, with the board's underside at z = 0. Of several steps the
    first one with components is taken that the file's content names. Holes from 1 mm across are cut out. Bodies and
    pads are those of the packages; their heights are stated, or nominal by their names. Where the file places the
    copper of pins, rotations on each side are understood such that the pins come to lie on it.

    Returns:
        The board and its components in file order, and what was noticed.

    Raises:
        BoardError: The file cannot be read, is no IPC-2581 file, or has no step with a profile.
    """
    copper = Copper()
    top, data, step, drawing = _read_step(path, copper)
    outline = outline_of(*_read_loops(step, drawing), file=path, spot=spot_mm)
    components = read_components(step, data, drawing)
    check_crowds([each.place for each in components], path)
    packages, seen_through = _read_packages(top, data, step, components, drawing)
    conventions = conventions_of(components, packages, copper, drawing, seen_through)
    notes = LayoutNotes()
    bom = read_bom(top)
    # What KiCad puts before every reference designator, where all have it.
    names = [each.reference for each in components]
    fitting = (each for each in ("CMP_", "CMP:") if all(name.startswith(each) and name != each for name in names))
    prefix = next(fitting, "")
    entries = [bom.get(each.reference, BomEntry()) for each in components]
    placed = (
        (
            place_component(each, conventions[each.side], each.reference.removeprefix(prefix), entry, drawing),
            _named(packages[each.package], entry),
            entry.is_populated,
        )
        for each, entry in zip(components, entries, strict=True)
    )
    stacks = (each for each in data.all("Stackup") if "overallThickness" in each.attributes)
    thickness_mm = first_thickness(each.number("overallThickness", scale=drawing.scale_mm) for each in stacks)
    notes.lines += drawn_lines(step, drawing)
    bodies, findings = build_bodies(outline, thickness_mm, list(stand_parts(placed, notes)), _WORDS, notes)
    return bodies, (*findings, *_repeats(data, step, drawing).findings())


def _read_step(path: Path, copper: Copper) -> tuple[Element, Element, Element, Drawing]:
    """Read the tree of a file: its top, its layout, the step of its board, and its unit."""
    top = read_xml(_chunks(path), path, WORDS, XmlElement, {"Pad": copper.take}, ScoreLayers().is_kept)
    if top.tag != "IPC-2581":
        raise top.error(f"not an IPC-2581 file: it begins with <{top.tag[:40]}>. {WORDS.again}")
    ecad = top.first("Ecad")
    header = None if ecad is None else ecad.first("CadHeader")
    data = None if ecad is None else ecad.first("CadData")
    if header is None or data is None:
        raise top.error(f"there is no <CadHeader> or no <CadData>: the file holds no layout. {WORDS.again}")
    return top, data, _choose_step(top, data), Drawing(unit_mm(header))


def read_ipc2581_panel(path: Path) -> StepPanel | None:
    """Read how another step repeats that of the board; ``None`` where none does.

    Raises:
        BoardError: As for the board; or the panel has too many boards.
    """
    _, data, board, drawing = _read_step(path, Copper())
    repeats = _repeats(data, board, drawing)
    if (name := repeats.panel) is None:
        return None
    step = next(each for each in data.all("Step") if each.word("name") == name)
    loops, _ = _read_loops(step, drawing)
    outline = outline_of(loops, [], file=path, spot=spot_mm) if loops else None
    return StepPanel(repeats.places(), outline, repeats.others())


def _repeats(data: Element, board: Element, drawing: Drawing) -> StepRepeats:
    return StepRepeats(
        board.word("name"),
        {
            step.word("name"): [
                (each.word("stepRef"), partial(_places, each, drawing)) for each in step.all("StepRepeat")
            ]
            for step in data.all("Step")
        },
    )


def _places(repeat: Element, drawing: Drawing) -> list[StepPlace]:
    nx, ny = (int(repeat.number(key, 1e6)) if key in repeat.attributes else 1 for key in ("nx", "ny"))
    x, y = drawing.point(repeat).tolist()
    dx, dy = (repeat.number(key, scale=drawing.scale_mm) if key in repeat.attributes else 0.0 for key in ("dx", "dy"))
    turn = math.radians(repeat.number("angle", MOST_TURN_DEG)) if "angle" in repeat.attributes else 0.0
    over = repeat.word("mirror").lower() == "true"
    return StepPanel.grid((nx, ny), StepPlace(x, y, -turn if over else turn, over), (dx, dy), repeat)


def _choose_step(top: Element, data: Element) -> Element:
    """Return the step of the board: of those with a profile the first with components that the content names."""
    content = top.first("Content")
    named = [each.word("name") for each in content.all("StepRef")] if content is not None else []
    steps = [step for step in data.all("Step") if step.first("Profile") is not None]
    if not steps:
        raise data.error(f"no <Step> has a <Profile>: the edge of the board is missing. {WORDS.again}")
    places = {name: place for place, name in reversed(list(enumerate(named)))}

    def rank(step: Element) -> tuple[bool, int]:
        return step.first("Component") is None, places.get(step.word("name"), len(named))

    return min(steps, key=rank)


def _read_loops(step: Element, drawing: Drawing) -> tuple[list[Points2], list[Points2]]:
    """Loops of the profile, and of the drilled holes from 1 mm across."""
    loops: list[Points2] = []
    for profile in step.all("Profile"):
        loops += [ring for each in profile.all("Polygon", "Cutout") if len(ring := drawing.ring(each)) > 2]
    holes = (
        hole
        for feature in step.all("LayerFeature")
        for each in feature.all("Set")
        for hole in each.all("Hole")
        if hole.word("platingStatus").upper() != "VIA"
    )
    drills: list[Points2] = []
    for hole in holes:
        radius = hole.number("diameter", scale=drawing.scale_mm) / 2.0
        if 2.0 * radius >= DRILL_MM - _ROUNDED_MM:
            drills.append(circle(drawing.point(hole), radius))
    return loops, drills


def _read_packages(
    top: Element, data: Element, step: Element, components: Sequence[Component], drawing: Drawing
) -> tuple[dict[str, PackageShape], frozenset[str]]:
    """Read the packages that are placed, by name, and which of them are drawn as seen through the board."""
    primitives = read_dictionaries(top.first("Content"))
    elements = {each.word("name"): each for owner in (data, step) for each in owner.all("Package")}
    needed = dict.fromkeys(each.package for each in components)
    for component in components:
        if component.package not in elements:
            label = f"{component.reference[:40]} is of the package {component.package[:60]!r}, which the file lacks"
            raise component.element.error(f"{label}. {WORDS.again}")
    shapes = {name: read_package(elements[name], primitives, drawing) for name in needed}
    return shapes, frozenset(name for name in needed if is_seen_through(elements[name]))


def _named(package: PackageShape, entry: BomEntry) -> PackageShape:
    """Take a package's name from the bill of materials, where its own is that with a number; KiCad numbers them."""
    own = package.name.rpartition(":")[2]
    stated = entry.package.removeprefix("PKG_").removeprefix("PKG:")
    base, _, number = own.rpartition("_")
    name = stated if stated and stated == base and number.isdigit() else own
    return package if name == package.name else replace(package, name=name)
