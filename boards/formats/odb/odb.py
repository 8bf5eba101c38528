"""ODB++ boards, version 7 and 8: a job as a folder, ``.tgz`` or ``.zip``."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from boards.board import Body
from boards.bounds import FARTHEST_MM, MOST_TURN_DEG, check_crowds, number_within
from boards.errors import BoardError, Line
from boards.formats.archive import read_members
from boards.formats.layout import THICKEST_MM, LayoutNotes, LayoutWords, build_bodies, first_thickness, spot_mm
from boards.formats.loops import DRILL_MM, SCORE_NAME, outline_of, slot
from boards.formats.odb.components import (
    Component,
    conventions_of,
    is_mounted,
    place_component,
    read_components,
    read_packages,
)
from boards.formats.odb.text import (
    AGAIN,
    Array,
    Record,
    read_contours,
    read_records,
    read_structure,
    unit_mm,
)
from boards.formats.placed import StepPanel, StepPlace, StepRepeats, stand_parts
from geometry.arrays import Points2
from specs.finding import Finding

_MATRIX = re.compile(r"(?:(.*)/)?matrix/matrix", re.IGNORECASE)
_INCH_MM = 25.4
_ROUNDED_MM = 1e-4
_ROUND_SYMBOL = re.compile(r"r(\d+(?:\.\d+)?)", re.IGNORECASE)


_WORDS = LayoutWords("ODB++", "the profile", "the package")


@dataclass(frozen=True, slots=True)
class Job:
    """The text files of a job that matter, by their paths below its root in small letters."""

    path: Path
    root: str
    names: tuple[str, ...]
    contents: Mapping[str, bytes]
    unit_mm: float
    """Where a file states none."""

    def records(self, name: str) -> list[Record]:
        """Records of a file; none if the job has no such file."""
        return list(read_records(self.contents.get(name, b""), self.path / name, self.unit_mm))

    def structure(self, name: str) -> tuple[dict[str, str], list[Array]]:
        """Keys and arrays of a file; none if the job has no such file."""
        return read_structure(self.contents.get(name, b""), self.path / name)


def roots_of(names: Sequence[str]) -> list[str]:
    """Folders of the jobs among the paths of an archive or a folder, with ``/``; empty for one that is all of it."""
    roots = {(hit[1] + "/") if hit[1] else "" for name in names if (hit := _MATRIX.fullmatch(name)) is not None}
    return sorted(roots, key=lambda root: (len(root), root))


def read_odb(path: Path) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read an ODB++ job: profile, and one prism a component.

    The frame is that of the step, in mm: x right, y back, with the board's underside at z = 0. Of several steps the
    first one with components is taken. Drilled holes and slots from 1 mm across are cut out. Bodies and pads are
    those of the packages; their heights are stated, or nominal by their names. Rotations on each side are understood
    such that pins lie on their toeprints.

    Returns:
        The board and its components, those of the top first, and what was noticed.

    Raises:
        BoardError: The job cannot be read, or it has no step with a profile.
    """
    job, steps, layers = read_job(path)
    step = choose_step(job, steps)
    folder = f"steps/{step}"
    loops = [contour.ring for contour in read_contours(job.records(f"{folder}/profile"))]
    drilled = [job.records(f"{folder}/layers/{each.named}/features") for each in layers if each.kind == "DRILL"]
    outline = outline_of(loops, [loop for each in drilled for loop in _read_drills(each)], file=path, spot=spot_mm)
    packages = read_packages(job.records(f"{folder}/eda/data"))
    components = _read_components(job, folder, layers)
    for each in components:
        if each.package >= len(packages):
            raise each.head.error(f"{each.name[:40]} is of package {each.package}, which eda/data lacks. {AGAIN}")
    check_crowds([each.place for each in components], path)
    conventions = conventions_of(components, packages)
    notes = LayoutNotes()
    placed = (
        (place_component(each, conventions[each.side]), packages[each.package], is_mounted(each)) for each in components
    )
    stated = [_attribute(job, name, ".board_thickness") for name in (f"{folder}/attrlist", "misc/attrlist")]
    between = [_attribute(job, f"{folder}/layers/{each.named}/attrlist", ".layer_dielectric") for each in layers]
    thickness_mm = first_thickness([*stated, round(sum(between), 4)])
    for each in layers:
        if _may_score(each):
            notes.lines += _read_lines(job.records(f"{folder}/layers/{each.named}/features"))
    bodies, findings = build_bodies(outline, thickness_mm, list(stand_parts(placed, notes)), _WORDS, notes)
    return bodies, (*findings, *_repeats(job, step, steps).findings())


def read_job(path: Path) -> tuple[Job, list[str], list[Array]]:
    """Read the files of a job that describe boards.

    Returns:
        The job, the names of its steps in small letters, and the layers of its matrix.

    Raises:
        BoardError: It is no job, or cannot be read.
    """
    names, first = read_members(path, lambda name: _MATRIX.fullmatch(name) is not None)
    roots = roots_of(names)
    if not roots:
        raise BoardError("not an ODB++ job: there is no matrix/matrix in it.", file=path)
    root = roots[0]
    matrix = next(content for name, content in first.items() if name.lower() == f"{root}matrix/matrix".lower())
    _, arrays = read_structure(matrix, path / "matrix/matrix")
    layers = [each for each in arrays if each.name == "LAYER"]
    steps = [each.named for each in arrays if each.name == "STEP"]
    drilled = [each.named for each in layers if each.kind == "DRILL"]
    kinds = [r"misc/(info|attrlist)", r"steps/[^/]+/(stephdr|profile|attrlist|eda/data)"]
    kinds += [r"steps/[^/]+/layers/[^/]+/(components|attrlist)"]
    drawn = [*drilled, *(each.named for each in layers if _may_score(each))]
    kinds += [rf"steps/[^/]+/layers/{re.escape(name)}/features" for name in drawn]
    needed = re.compile("|".join(kinds), re.IGNORECASE)

    def inner(name: str) -> str:
        return name[len(root) :].lower() if name.lower().startswith(root.lower()) else ""

    _, contents = read_members(path, lambda name: needed.fullmatch(inner(name)) is not None)
    files = {inner(name): content for name, content in contents.items()}
    keys, _ = read_structure(files.get("misc/info", b""), path / "misc/info")
    line = Line(path / "misc/info", 1)
    unit = unit_mm(keys["UNITS"], line) if keys.get("UNITS") else _INCH_MM
    return Job(path, root, names, files, unit), steps, layers


def choose_step(job: Job, steps: Sequence[str]) -> str:
    """Return the step of the board: of those with a profile the first with components.

    Raises:
        BoardError: None has a profile.
    """
    profiles = {step: job.contents[name] for step in steps if (name := f"steps/{step}/profile") in job.contents}
    drawn = [step for step, text in profiles.items() if re.search(rb"^[ \t]*OB\s", text, re.MULTILINE)] or list(
        profiles
    )
    if not drawn:
        raise BoardError(f"no step of the job has a profile: the edge is missing. {AGAIN}", file=job.path)

    def is_bare(step: str) -> bool:
        start = f"steps/{step}/layers/"
        return not any(name.startswith(start) and name.endswith("/components") for name in job.contents)

    return min(drawn, key=is_bare)


def read_odb_panel(path: Path) -> StepPanel | None:
    """Read how another step repeats that of the board; ``None`` where none does. Angles are clockwise.

    Raises:
        BoardError: As for the board; or the panel has too many boards.
    """
    job, steps, _ = read_job(path)
    repeats = _repeats(job, choose_step(job, steps), steps)
    if (name := repeats.panel) is None:
        return None
    loops = [contour.ring for contour in read_contours(job.records(f"steps/{name}/profile"))]
    outline = outline_of(loops, [], file=path, spot=spot_mm) if loops else None
    return StepPanel(repeats.places(), outline, repeats.others())


def _repeats(job: Job, board: str, steps: Sequence[str]) -> StepRepeats:
    found: dict[str, list[tuple[str, Callable[[], list[StepPlace]]]]] = {}
    for step in steps:
        keys, arrays = job.structure(f"steps/{step}/stephdr")
        own = [each for each in arrays if each.name == "STEP-REPEAT"]
        scale = unit_mm(keys["UNITS"], own[0]) if own and keys.get("UNITS") else job.unit_mm
        found[step] = [(each.named, partial(_places, each, scale)) for each in own]
    return StepRepeats(board, found)


def _places(repeat: Array, scale_mm: float) -> list[StepPlace]:
    def number(key: str, bound: float, scale: float = 1.0) -> float:
        value = number_within(repeat.values.get(key, "0"), bound, scale)
        if math.isnan(value):
            raise repeat.error(f"{key} of STEP-REPEAT is {repeat.values[key][:40]!r}, not a number. {AGAIN}")
        return value

    columns, rows = (max(int(number(key, 1e6)), 1) for key in ("NX", "NY"))
    over = any(repeat.values.get(key, "").upper().startswith("Y") for key in ("MIRROR", "FLIP"))
    turn = -math.radians(number("ANGLE", MOST_TURN_DEG))
    x, y, dx, dy = (number(key, FARTHEST_MM, scale_mm) for key in ("X", "Y", "DX", "DY"))
    return StepPanel.grid((columns, rows), StepPlace(x, y, turn, over), (dx, dy), repeat)


def _read_components(job: Job, folder: str, layers: Sequence[Array]) -> list[Component]:
    """Components of both sides; the lower of two component layers in the matrix is the bottom."""
    named = [each.named for each in layers if each.kind == "COMPONENT"]
    found: list[Component] = []
    for place, layer in enumerate(named or ["comp_+_top", "comp_+_bot"]):
        bottom = layer.endswith("bot") or (not layer.endswith("top") and place > 0)
        found += read_components(job.records(f"{folder}/layers/{layer}/components"), "bottom" if bottom else "top")
    return found


def _may_score(layer: Array) -> bool:
    """Whether lines of a layer may score a panel: it is routed, or named so."""
    return layer.kind == "ROUT" or layer.named.startswith("scor") or SCORE_NAME.search(layer.named) is not None


def _read_lines(records: Sequence[Record]) -> list[Points2]:
    """Straight lines (2, 2) of a layer, mm."""
    return [
        np.array([each.point(1), each.point(3)]) for each in records if each.words[:1] == ("L",) and len(each.words) > 5
    ]


def _read_drills(records: Sequence[Record]) -> list[Points2]:
    """Round pads are holes, and lines of a round symbol are slots; symbols are in microns or mils."""
    sizes: dict[str, float] = {}
    drills: list[Points2] = []
    for record in records:
        word = record.words[0] if record.words else ""
        if word.startswith("$") and len(record.words) > 1:
            symbol = _ROUND_SYMBOL.fullmatch(record.words[1])
            metric = record.scale_mm == 1.0 if len(record.words) < 3 else record.words[2].upper() == "M"
            if symbol:
                sizes[word[1:]] = float(symbol[1]) * (0.001 if metric else 0.0254)
        elif word == "P" and len(record.words) > 3:
            size = sizes.get(record.words[3], 0.0)
            if size >= DRILL_MM - _ROUNDED_MM:
                drills.append(slot(record.point(1), np.array([1.0, 0.0]), 0.0, size / 2.0))
        elif word == "L" and len(record.words) > 5:
            size = sizes.get(record.words[5], 0.0)
            start, end = record.point(1), record.point(3)
            length = math.hypot(*(end - start))
            if size >= DRILL_MM - _ROUNDED_MM and length > 0.0:
                drills.append(slot((start + end) / 2.0, (end - start) / length, length / 2.0, size / 2.0))
    return drills


def _attribute(job: Job, name: str, key: str) -> float:
    """Length that an attribute list states, mm; 0 where it does not."""
    lines = job.contents.get(name, b"").decode("utf-8", "replace").splitlines()
    pairs = (line.partition("=") for line in lines)
    plain = {key.strip().lower(): value.strip() for key, _, value in pairs}
    unit = (
        1.0 if plain.get("units", "").upper() == "MM" or (not plain.get("units") and job.unit_mm == 1.0) else _INCH_MM
    )
    value = number_within(plain.get(key, ""), THICKEST_MM, unit)
    return value if value > 0.0 else 0.0
