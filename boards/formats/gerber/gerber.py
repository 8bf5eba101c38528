"""Gerber files of a board: its profile, and the pads of its components where X2 attributes name them."""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import chain
from pathlib import Path

import numpy as np
import shapely
from shapely import LineString, MultiPolygon, Polygon

from boards.board import Contradiction, Pad, Side, SourceFile
from boards.bounds import FARTHEST_MM, number_within
from boards.errors import BoardError, Line, read_bytes
from boards.formats.archive import is_archive, read_members
from boards.formats.gerber.apertures import AGAIN, Aperture, lengths, macro_aperture, standard_aperture
from boards.formats.gerber.job import SUFFIX as JOB_SUFFIX
from boards.formats.gerber.job import GerberJob, read_jobs
from boards.formats.layout import EdgeDrawing, LayoutNotes, LayoutWords, first_thickness, read_outline
from boards.formats.loops import SCORE_NAME, Point2, arc_about
from boards.formats.names import listed, may_be_text
from geometry.arrays import Points2
from specs.finding import Finding
from specs.finding_rules import LAYERS_MISSING

_FORMAT = re.compile(r"FS([LTD]?)([AI])X(\d)(\d)Y(\d)(\d)")
_APERTURE = re.compile(r"ADD(\d{1,9})([A-Za-z_.$][\w.$-]*)(?:,(.*))?", re.DOTALL)
_WORD = re.compile(r"([GDXYIJM])([+-]?\d{1,12})")
_REPEAT = re.compile(r"SR(?:X(\d{1,6})Y(\d{1,6})(?:I([-+]?[\d.]{1,20}))?(?:J([-+]?[\d.]{1,20}))?)?")
_MOST_STEPS = 10_000
_FORMAT_MARK = re.compile(rb"^%?\s{0,9}FS[LTD]?[AI]X\d\dY\d\d", re.MULTILINE)
_ESCAPE = re.compile(r"\\u([0-9A-Fa-f]{4})")
_PERCENT_IN_COMMENT = re.compile(r"(G04[^*%]{0,2000})%([^*%]{0,2000}\*)%?")
"""Eagle writes attributes into comments with their percent sign, which begins nothing there."""
_MOST_POINTS = 2_000_000
_SAME_MM = 1e-9
_UNITS_MM = {"MM": 1.0, "IN": 25.4}
SUFFIXES = (".gbr", ".gm1", ".gko", ".gml", ".ger", ".pho", ".art")
_SCORING = (("Vcut",), ("Other",), ("OtherDrawing",))
"""Functions of layers that may show scores, as KiCad's for Cmts.User."""
_EDGE_NAME = re.compile(
    r"edge[._ -]?cuts|outline|profile|contour|board[._ -]?(?:edge|geometry|shape)|dimension|keep-?out|umriss|kontur"
    r"|\.(?:gm\d{0,2}|gko|gml|gdo|dim|oln|out|bor|mill?)$",
    re.IGNORECASE,
)
_LAYERS = re.compile(
    rf".*\.(?:g[a-z0-9]{{1,3}}|pho|art|gbrjob|gerber|gbx|top|bot|cmp|sol|[stcb]{{2}}[12]?)|(?!.*\.\w*(?:pdf|st.?p|csv|zip|txt|"
    rf"xls.?|dxf|png|html?|xml|drl)$).*(?:{_EDGE_NAME.pattern}).*",
    re.IGNORECASE,
)
_INNER = re.compile(r"\.(?:g\d+|gp\d+|g[12]l|gbrjob)$|in\d+[._ -]?cu|inner", re.IGNORECASE)
_HEAD = 20_000
_LEAST_HELD = 0.95
"""Part of all flashes that the board's edge holds; marks for the makers of films lie beside it."""


_VIA_MM = 0.8
"""Round copper in both layers up to this diameter is no pad: pins of 0.5 mm and more have wider ones."""
_SPOT_MM = 0.05
"""Pads of two layers whose middles are as near lie upon each other."""


def _sides(top: str, bottom: str) -> tuple[tuple[Side, re.Pattern[str]], ...]:
    return ("top", re.compile(top, re.IGNORECASE)), ("bottom", re.compile(bottom, re.IGNORECASE))


_LAYER_NAMES = (
    (
        "Soldermask",
        _sides(
            r"\.gts$|\.stc$|f[._]mask|mask[._ -]?top|top[._ -]?(?:solder)?[._ -]?mask",
            r"\.gbs$|\.sts$|b[._]mask|mask[._ -]?bot|bot(?:tom)?[._ -]?(?:solder)?[._ -]?mask",
        ),
    ),
    (
        "Copper",
        _sides(
            r"\.(?:gtl|cmp|top)$|f[._]cu|copper[._ -]?top|top[._ -]?(?:layer|copper|cu)?\.(?:gbr|ger|art|pho)$",
            r"\.(?:gbl|sol|bot)$|b[._]cu|copper[._ -]?bot|bot(?:tom)?[._ -]?(?:layer|copper|cu)?\.(?:gbr|ger|art|pho)$",
        ),
    ),
)
"""Of files without a function, as tools name them."""

WORDS = LayoutWords("Gerber", "the profile layer", "a larger body in the library")


@dataclass(frozen=True, slots=True)
class _Flash:
    """A pad. Frame of the file, mm."""

    pad: Pad
    component: str
    """Reference designator; empty where no attribute names it."""
    pin: str
    is_flat: bool
    """Whether it is soldered flat, by the function of its aperture."""


@dataclass(frozen=True, slots=True, eq=False)
class _Layer:
    """One Gerber file."""

    path: Path
    function: tuple[str, ...]
    """The words of its file function, such as ``Profile``, ``NP``; none without X2 attributes."""
    lines: tuple[Points2, ...]
    """Centre lines of what is drawn, and the edges of regions, mm."""
    flashes: tuple[_Flash, ...]
    places: Points2
    """Where anything is flashed, (n, 2), mm."""
    pen_mm: float
    """Finest round pen that lines are drawn with; 0 without one."""


@dataclass(slots=True)
class _State:
    """What the commands so far have set."""

    path: Path
    scale_mm: float = math.nan
    decimals: tuple[int, int] | None = None
    digits: tuple[int, int] = (0, 0)
    trailing: bool = False
    here: Point2 = field(default_factory=lambda: np.zeros(2))
    mode: int = 1
    is_multi_quadrant: bool = True
    operation: int = 2
    aperture: int = -1
    in_region: bool = False
    apertures: dict[int, Aperture] = field(default_factory=dict[int, Aperture])
    functions: dict[int, str] = field(default_factory=dict[int, str])
    macros: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    attributes: dict[str, str] = field(default_factory=dict[str, str])
    file_function: tuple[str, ...] = ()
    lines: list[Points2] = field(default_factory=list[Points2])
    flashes: list[_Flash] = field(default_factory=list[_Flash])
    places: list[Point2] = field(default_factory=list[Point2])
    pens: set[int] = field(default_factory=set[int])
    points: int = 0
    keeps_lines: bool = True
    """Of copper only the pads are used."""
    steps: Points2 = field(default_factory=lambda: np.zeros((1, 2)))
    """Places at which the block of a step and repeat stands, mm, the first at 0, 0."""
    block: tuple[int, int, int] = (0, 0, 0)
    """Lines, flashes and places before it."""

    def repeat(self, steps: Points2, line: Line) -> None:
        """End the block of a step and repeat, and begin another."""
        lines, flashes, places = (
            self.lines[self.block[0] :],
            self.flashes[self.block[1] :],
            self.places[self.block[2] :],
        )
        self.points += (len(self.steps) - 1) * (sum(map(len, lines)) + len(places))
        if self.points > _MOST_POINTS:
            raise line.error(f"repeats more than {_MOST_POINTS:,} points and pads. That is no board's layer.")
        for step in self.steps[1:]:
            x, y = step.tolist()
            self.lines += [each + step for each in lines]
            self.places += [each + step for each in places]
            pads = (replace(each.pad, x_mm=each.pad.x_mm + x, y_mm=each.pad.y_mm + y) for each in flashes)
            self.flashes += [replace(each, pad=pad) for each, pad in zip(flashes, pads, strict=True)]
        self.steps, self.block = steps, (len(self.lines), len(self.flashes), len(self.places))


@dataclass(frozen=True, slots=True, eq=False)
class GerberBoard:
    """What Gerber files state of a board. Frame of the files, mm."""

    path: Path
    outline: Polygon | MultiPolygon
    thickness_mm: float
    pads: Mapping[str, tuple[tuple[str, Pad, Side, bool], ...]]
    """By reference designator: pin, pad, side, and whether it is soldered flat."""
    unnamed: Mapping[Side, tuple[tuple[Pad, bool], ...]]
    """Pads that no attribute names, where none is named at all, and whether each is on one side only."""
    notes: LayoutNotes
    layers: tuple[SourceFile, ...]
    """Each file with what it is."""
    contradictions: tuple[Contradiction, ...] = ()
    """Between the layers and their job files."""
    findings: tuple[Finding, ...] = ()
    open_layers: Mapping[str, tuple[Pad, ...]] = field(default_factory=dict[str, tuple[Pad, ...]])
    """Pads of layers of which neither function nor name states what they are, where no pad is named."""


def read_gerber(path: Path) -> GerberBoard:
    """Read the Gerber files of a board: of a folder, an archive, or the one file of its profile.

    The profile is the layer whose file function states it, else the one whose name does. The copper of the outer
    layers is read for the pads whose attributes name their component; drills are not read.

    Raises:
        BoardError: There is no profile, it does not close, or a file cannot be read.
    """
    if is_archive(path):
        names, contents = read_members(path, lambda name: is_layer_name(name) or may_be_text(name))
        contents = {name: each for name, each in contents.items() if is_layer_name(name) or is_gerber(each)}
    else:
        contents = {path.name: read_bytes(path)}
        names = tuple(contents)
    jobs = read_jobs(contents)
    job = next((each for each in jobs if each.is_read), GerberJob())
    own = {name: _function_of(content) for name, content in contents.items() if not name.lower().endswith(JOB_SUFFIX)}
    functions = {name: function or job.function(name) for name, function in own.items()}
    folder = path if is_archive(path) else path.parent

    @cache
    def layer(name: str, *, with_lines: bool = False) -> _Layer:
        return _read_layer(contents[name], folder / name, with_lines=with_lines)

    notes = LayoutNotes()
    stated = {
        name: each
        for name, each in functions.items()
        if each or len(functions) == 1 or _EDGE_NAME.search(name) or b"%FS" in contents[name][:_HEAD]
    }
    outline, edges = _read_edge(stated, layer, path, notes)
    pads: dict[str, list[tuple[str, Pad, Side, bool]]] = {}
    bare: dict[Side, list[Pad]] = {"top": [], "bottom": []}
    opened: dict[Side, list[Pad]] = {"top": [], "bottom": []}
    layers: list[SourceFile] = []
    unknown: list[str] = []
    for name, function in functions.items():
        kind, side = _outer_layer(name, function)
        words = ", ".join([kind.lower(), side or "inner"]) if kind else ", ".join(function[:1])
        layers.append(SourceFile(name, "layer", "edge" if name in edges else words or "not read"))
        if side is None:
            if not kind and not function and name not in edges and not _INNER.search(name):
                unknown.append(name)
            continue
        for flash in layer(name).flashes:
            if kind != "Copper":
                opened[side].append(flash.pad)
            elif flash.component:
                pads.setdefault(flash.component, []).append((flash.pin, flash.pad, side, flash.is_flat))
            else:
                bare[side].append(flash.pad)
    notes.lines += _scores(functions, layer)
    layers += (SourceFile(each.name, "job file", each.describe()) for each in jobs)
    held = {name: tuple(each) for name, each in pads.items()}
    unnamed = _unnamed(bare, opened) if not held else {}
    seen = [name for name in unknown if is_gerber(contents[name])] if not held and not all(bare.values()) else []
    open_layers = {name: tuple(flash.pad for flash in layer(name).flashes) for name in seen}
    thickness_mm = first_thickness(each.thickness_mm for each in jobs)
    missing = sorted({name for each in jobs for name in each.missing(names)})
    text = "files that the job file lists are not there: {}."
    return GerberBoard(
        path,
        outline,
        thickness_mm,
        held,
        unnamed,
        notes,
        tuple(layers),
        tuple(found for each in jobs for found in each.compare(outline, thickness_mm, own)),
        tuple(listed(LAYERS_MISSING, missing, text)),
        {name: pads for name, pads in open_layers.items() if pads},
    )


def _scores(functions: Mapping[str, tuple[str, ...]], layer: Callable[..., "_Layer"]) -> Iterator[Points2]:
    """Yield the lines of layers that may show scores."""
    for name, function in functions.items():
        if function[:1] in _SCORING or (not function and SCORE_NAME.search(name)):
            with suppress(BoardError):  # nothing else of it is needed
                yield from layer(name, with_lines=True).lines


def with_copper(board: GerberBoard, names: Mapping[Side, str]) -> GerberBoard:
    """The board with layers, whose names do not state it, as the copper of sides."""
    bare: dict[Side, Sequence[Pad]] = {side: [pad for pad, _ in each] for side, each in board.unnamed.items()}
    bare |= {side: board.open_layers[name] for side, name in names.items()}
    sides = {name: side for side, name in names.items()}
    layers = (
        replace(each, states=f"copper, {sides[each.name]}, by the places of parts") if each.name in sides else each
        for each in board.layers
    )
    return replace(board, unnamed=_unnamed(bare, {"top": (), "bottom": ()}), layers=tuple(layers), open_layers={})


def is_layer_name(name: str) -> bool:
    """Whether the name of a file is one of a layer or of a job file."""
    return _LAYERS.fullmatch(name) is not None


def is_gerber(content: bytes) -> bool:
    """Whether the beginning of a file is that of a Gerber layer, whatever it is called."""
    return _FORMAT_MARK.search(content[:_HEAD]) is not None


def board_sets(names: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Layers of each board: of a folder with an edge and copper, or of what names begin with in one.

    Returns:
        Files by folder, or by folder and beginning of the name; all layers under an empty name where they are of one
        board or cannot be separated, and nothing where there is none.
    """
    layers = list(names)
    copper_names = dict(_LAYER_NAMES)["Copper"]

    def beginnings(patterns: Sequence[re.Pattern[str]]) -> set[tuple[str, str]]:
        split = [(folder, base) for folder, _, base in (name.rpartition("/") for name in layers)]
        hits = ((folder, base, hit) for folder, base in split for each in patterns if (hit := each.search(base)))
        return {(folder, base[: hit.start()].strip("._- ")) for folder, base, hit in hits}

    edges, copper = beginnings([_EDGE_NAME]), beginnings([pattern for _, pattern in copper_names])
    folders = {folder for folder, _ in edges} & {folder for folder, _ in copper}
    stems = {each for each in edges & copper if each[1]}
    if len(folders) > 1:
        return {
            each: tuple(name for name in layers if name.startswith(f"{each}/" if each else ""))
            for each in sorted(folders)
        }
    if len(stems) < 2:
        return {"": tuple(layers)} if layers else {}
    paths = sorted((f"{folder}/{stem}" if folder else stem for folder, stem in stems), key=len, reverse=True)
    owner = {name: next((each for each in paths if name.startswith(each)), "") for name in layers}
    return {each: tuple(name for name in layers if owner[name] == each) for each in sorted(paths)}


def _outer_layer(name: str, function: Sequence[str]) -> tuple[str, Side | None]:
    """Whether a file is copper or the openings of a mask, by its function or else by its name; and of which side."""
    if function:
        words = [word.lower() for word in function[1:]]
        side: Side | None = "top" if "top" in words else "bottom" if "bot" in words else None
        return function[0], side if function[0] in ("Copper", "Soldermask") else None
    for kind, names in _LAYER_NAMES:
        for layer_side, pattern in names:
            if pattern.search(name.rpartition("/")[2]):
                return kind, layer_side
    return "", None


def _unnamed(
    bare: Mapping[Side, Sequence[Pad]], opened: Mapping[Side, Sequence[Pad]]
) -> dict[Side, tuple[tuple[Pad, bool], ...]]:
    """Pads of each side that the mask leaves open, where a mask is there, and no small round ones of both: vias."""
    spots: dict[Side, set[tuple[int, int]]] = {side: {_spot(pad) for pad in bare[side]} for side in bare}
    found: dict[Side, tuple[tuple[Pad, bool], ...]] = {}
    pairs: tuple[tuple[Side, Side], ...] = (("top", "bottom"), ("bottom", "top"))
    for side, other in pairs:
        open_spots = {_spot(pad) for pad in opened[side]}
        soldered = [pad for pad in bare[side] if _spot(pad) in open_spots] or bare[side]
        flat = [(pad, _spot(pad) not in spots[other]) for pad in soldered]
        found[side] = tuple(each for each in flat if each[1] or not each[0].round or each[0].length_mm > _VIA_MM)
    return found


def _spot(pad: Pad) -> tuple[int, int]:
    return round(pad.x_mm / _SPOT_MM), round(pad.y_mm / _SPOT_MM)


def _read_edge(
    functions: Mapping[str, tuple[str, ...]], layer: Callable[..., _Layer], path: Path, notes: LayoutNotes
) -> tuple[Polygon | MultiPolygon, Sequence[str]]:
    """Read the outline: of the layers whose function is the profile, else of the one that holds what is flashed.

    Layers that are called like an edge come first; of several the smallest that holds the copper is the edge, and the
    others are dimensions, frames and keep-outs.

    Args:
        functions: Of each layer by its name.
        layer: Reads one by its name, on demand with its lines.
        path: For messages.
        notes: Takes what is noticed.

    Returns:
        The outline, and the layers that it is drawn in.

    Raises:
        BoardError: There is no edge, or it does not close.
    """
    edges = [name for name, function in functions.items() if function[:1] == ("Profile",)]
    edges = edges or (list(functions) if len(functions) == 1 else [])
    named = [name for name in functions if _EDGE_NAME.search(name)]
    others = [name for name in functions if name not in (edges or named) and not _INNER.search(name)]
    copper = [name for name in others if _outer_layer(name, functions[name])[0] == "Copper"]
    flashed = {name: layer(name).places for name in copper or others}
    held = [places for places in flashed.values() if len(places)]
    holds = np.concatenate(held) if held else None

    def read(names: Sequence[str], noted: LayoutNotes) -> Polygon | MultiPolygon:
        drawn = [layer(name, with_lines=True) for name in names]
        lines = [line for each in drawn for line in each.lines]
        drawing = EdgeDrawing(lines, pens_mm=[each.pen_mm for each in drawn], holds=holds)
        return read_outline(drawing, path, WORDS, noted)

    if edges or (holds is None and named):
        return read(edges or named, notes), edges or named
    refused: BoardError | None = None
    for names in (named, [name for name in others if name not in copper and not functions[name]]):
        fitting: list[tuple[float, str]] = []
        for name in names:
            try:
                outline = read([name], LayoutNotes())
            except BoardError as error:
                refused = refused or error if names is named else refused
                continue
            share = shapely.contains_xy(outline.convex_hull, holds).mean() if holds is not None else 0.0
            if share >= _LEAST_HELD or names == named[:1]:
                fitting.append((round(outline.area, 4), name))
        if fitting:
            taken = min(fitting)[1]
            outline = read([taken], notes)
            inner = outline.buffer(-_SPOT_MM)
            for name in (each for each in named if each != taken):
                drawn = [LineString(line) for line in layer(name, with_lines=True).lines if len(line) > 1]
                if shapely.contains(inner, drawn).any():
                    notes.edges.append(name)
            return outline, [taken]
    raise refused or BoardError(
        "holds no ODB++ job, no IPC-2581 file and no Gerber layer that is the board's profile by its file function, "
        "its name or a closed line around all copper. Export the board's edge as well, with X2 attributes.",
        file=path,
    )


def _read_layer(content: bytes, path: Path, *, with_lines: bool) -> _Layer:
    """Read a Gerber file (RS-274X, X2); polarity is not looked at, and aperture blocks are refused.

    Raises:
        BoardError: It is no Gerber file, or a command cannot be read.
    """
    text = _PERCENT_IN_COMMENT.sub(r"\1\2", content.decode("latin-1"))
    state = _State(path, keeps_lines=with_lines)
    for line, command, is_extended in _commands(text, path):
        (_extended if is_extended else _plain)(state, command, line)
    if state.decimals is None:
        raise Line(path, 1).error(f"not a Gerber file: it states no format (%FS…*%). {AGAIN}")
    state.repeat(np.zeros((1, 2)), Line(path, 1))
    pens = [state.apertures[pen].width_mm for pen in state.pens if pen in state.apertures]
    return _Layer(
        path,
        state.file_function,
        tuple(state.lines),
        tuple(state.flashes),
        np.array(state.places).reshape(-1, 2),
        min((pen for pen in pens if pen > 0.0), default=0.0),
    )


def _function_of(content: bytes) -> tuple[str, ...]:
    """Return the words of a file's function, none where its beginning states none; it need not be a Gerber file."""
    hit = re.search(rb"(?:%|G04 #@! ?%?)TF\.FileFunction,([^*\r\n]{1,200})\*", content[:_HEAD])
    return tuple(word.strip() for word in hit[1].decode("latin-1").split(",")) if hit else ()


def _commands(text: str, path: Path) -> Iterator[tuple[Line, str, bool]]:
    """Yield each command without its ``*``, and whether it stood between ``%``."""
    line, begin, is_extended = 1, 0, False
    for end in chain((hit.start() for hit in re.finditer(r"[*%]", text)), (len(text),)):
        command = text[begin:end]
        if plain := command.replace("\r", "").replace("\n", "").strip():
            lines = command[: len(command) - len(command.lstrip())].count("\n")
            yield Line(path, line + lines), plain, is_extended
        line, begin = line + command.count("\n"), end + 1
        is_extended ^= text[end : end + 1] == "%"


def _extended(state: _State, command: str, line: Line) -> None:
    head = command[:2].upper()
    if state.macros and head not in _HEADS and (command[:1].isdigit() or command.startswith("$")):
        state.macros[next(reversed(state.macros))].append(command)  # blocks of a macro follow its name
    elif head == "FS":
        _format(state, command, line)
    elif head == "MO":
        if command[2:4].upper() not in _UNITS_MM:
            raise line.error(f"the unit {command[2:10]!r} is not known; it is MM or IN. {AGAIN}")
        state.scale_mm = _UNITS_MM[command[2:4].upper()]
    elif head == "AM":
        state.macros[command[2:].strip()] = []
    elif head == "AD":
        _define(state, command, line)
    elif head in _ATTRIBUTES:
        _attribute(state, command)
    elif head in ("SR", "AB"):
        state.repeat(_steps(state, command, line), line)


def _format(state: _State, command: str, line: Line) -> None:
    hit = _FORMAT.match(command.upper())
    if hit is None or hit[2] == "I":
        raise line.error(f"the format {command[:40]!r} is not read; coordinates must be absolute. {AGAIN}")
    state.trailing = hit[1] == "T"
    state.decimals = (int(hit[4]), int(hit[6]))
    state.digits = (int(hit[3]) + int(hit[4]), int(hit[5]) + int(hit[6]))


def _steps(state: _State, command: str, line: Line) -> Points2:
    """Places at which a block is repeated, mm: ``SRX2Y1I70J0``, and ``SR`` where one ends."""
    if command[:2].upper() == "AB":
        raise line.error("aperture blocks (%AB…*%) are not read. Export the layer without them.")
    hit = _REPEAT.fullmatch(command.upper())
    if hit is None or math.isnan(state.scale_mm):
        raise line.error(f"the step and repeat {command[:40]!r} cannot be read. {AGAIN}")
    across, up = (max(int(word or 1), 1) for word in hit.group(1, 2))
    steps = [number_within(word or "0", FARTHEST_MM, state.scale_mm) for word in hit.group(3, 4)]
    if across * up > _MOST_STEPS or not all(map(math.isfinite, steps)):
        raise line.error(f"the step and repeat {command[:40]!r} is more than a panel has. {AGAIN}")
    return np.array([(x * steps[0], y * steps[1]) for y in range(up) for x in range(across)])


_ATTRIBUTES = frozenset({"TF", "TA", "TO", "TD"})
_HEADS = frozenset(
    {"FS", "MO", "AM", "AD", "TF", "TA", "TO", "TD", "LP", "LM", "LR", "LS", "SR", "AB", "IP", "OF", "IN"}
)


def _define(state: _State, command: str, line: Line) -> None:
    hit = _APERTURE.fullmatch(command)
    if hit is None or math.isnan(state.scale_mm):
        raise line.error(f"the aperture {command[:40]!r} cannot be read, or the unit is not stated before. {AGAIN}")
    words = [word for word in (hit[3] or "").replace("x", "X").split("X") if word.strip()]
    if hit[2] in ("C", "R", "O", "P"):
        aperture = standard_aperture(hit[2], lengths(words, state.scale_mm, line), line)
    elif hit[2] in state.macros:
        aperture = macro_aperture(state.macros[hit[2]], lengths(words, 1.0, line), state.scale_mm, line)
    else:
        raise line.error(f"the aperture template {hit[2][:40]!r} is not defined. {AGAIN}")
    state.apertures[int(hit[1])] = aperture
    state.functions[int(hit[1])] = state.attributes.get(".AperFunction", "")


def _unescaped(text: str) -> str:
    """Text of an attribute with the characters whose codes it states."""
    return _ESCAPE.sub(lambda hit: chr(int(hit[1], 16)), text) if "\\" in text else text


def _attribute(state: _State, command: str) -> None:
    kind, (name, _, value) = command[:2].upper(), command[2:].partition(",")
    if kind == "TF" and name == ".FileFunction":
        state.file_function = tuple(word.strip() for word in value.split(","))
    elif kind in ("TA", "TO"):
        state.attributes[name] = value
    elif kind == "TD" and name:
        state.attributes.pop(name, None)
    elif kind == "TD":
        state.attributes.clear()


def _plain(state: _State, command: str, line: Line) -> None:
    if command.startswith("G04") or command.startswith("G4 "):
        if (hit := re.match(r"G04 #@! ?(T[FAOD].*)", command)) is not None:  # X1 files carry attributes in comments
            _attribute(state, hit[1])
        return
    words = _WORD.findall(command.replace(" ", ""))
    if not words and command[:1] not in "MG":
        raise line.error(f"the command {command[:40]!r} is not read. {AGAIN}")
    places = {"X": state.here[0], "Y": state.here[1], "I": 0.0, "J": 0.0}
    is_move = False
    for letter, number in words:
        if letter == "G":
            _mode(state, int(number))
        elif letter == "D" and int(number) >= 10:
            state.aperture = int(number)
        elif letter == "D":
            state.operation, is_move = int(number), True
        elif letter in places:
            places[letter] = _coordinate(state, number, "XYIJ".index(letter) % 2, line)
            is_move = is_move or letter in "XY"
    if is_move:
        _operate(state, np.array([places["X"], places["Y"]]), np.array([places["I"], places["J"]]), line)


def _mode(state: _State, code: int) -> None:
    match code:
        case 1 | 2 | 3:
            state.mode = code
        case 36 | 37:
            state.in_region = code == 36
        case 70 | 71:
            state.scale_mm = 25.4 if code == 70 else 1.0
        case 74 | 75:
            state.is_multi_quadrant = code == 75
        case _:
            pass


def _coordinate(state: _State, number: str, axis: int, line: Line) -> float:
    if state.decimals is None or math.isnan(state.scale_mm):
        raise line.error(f"a coordinate stands before the format or the unit. {AGAIN}")
    sign, digits = ("-", number[1:]) if number.startswith("-") else ("", number.lstrip("+"))
    if state.trailing:
        digits = digits.ljust(state.digits[axis], "0")
    value = float(sign + digits) / 10.0 ** state.decimals[axis] * state.scale_mm
    if abs(value) > FARTHEST_MM:
        raise line.error(f"a coordinate is farther than {FARTHEST_MM / 1000.0:g} m. {AGAIN}")
    return value


def _operate(state: _State, target: Point2, offset: Point2, line: Line) -> None:
    start, state.here = state.here, target
    if state.operation == 1 and state.keeps_lines:
        stroke = np.array([start, target]) if state.mode == 1 else _curve(state, start, target, offset, line)
        state.lines.append(stroke)
        state.pens |= set() if state.in_region else {state.aperture}
        state.points += len(stroke)
        if state.points > _MOST_POINTS:
            raise line.error(f"draws more than {_MOST_POINTS:,} points, arcs as chords. That is no board's layer.")
    elif state.operation == 3:
        aperture = state.apertures.get(state.aperture)
        if aperture is None:
            raise line.error(f"the aperture D{state.aperture} is not defined. {AGAIN}")
        state.places.append(target)
        state.points += 1
        if state.points > _MOST_POINTS:
            raise line.error(f"has more than {_MOST_POINTS:,} pads. That is no board's layer.")
        stated, _, rest = state.attributes.get(".P", "").partition(",")
        component = _unescaped(stated or state.attributes.get(".C", ""))
        kind = state.functions.get(state.aperture, "").partition(",")[0]
        if kind not in ("ViaPad", "FiducialPad", "Conductor"):
            x, y = (target + aperture.middle).tolist()
            pad = Pad(x, y, aperture.length_mm, aperture.width_mm, aperture.turn_rad, aperture.is_round)
            state.flashes.append(_Flash(pad, component, _unescaped(rest.partition(",")[0]), kind != "ComponentPad"))


def _curve(state: _State, start: Point2, end: Point2, offset: Point2, line: Line) -> Points2:
    centre = start + offset
    clockwise = state.mode == 2
    if not state.is_multi_quadrant:  # the signs of the offset are left to the reader: the arc is at most a quarter

        def misfit(centre: Point2) -> tuple[bool, float]:
            (ax, ay), (bx, by) = start - centre, end - centre
            sweep = math.atan2(ax * by - ay * bx, ax * bx + ay * by) * (-1.0 if clockwise else 1.0)
            off = round(abs(math.hypot(ax, ay) - math.hypot(bx, by)), 6)
            return not -1e-6 <= sweep <= math.pi / 2.0 + 1e-6, off

        centre = min((start + offset * [x, y] for x in (1.0, -1.0) for y in (1.0, -1.0)), key=misfit)
        if float(np.hypot(*(end - start))) < _SAME_MM:
            return np.array([start, end])
    points = arc_about(start, end, centre, clockwise=clockwise, same_mm=_SAME_MM)
    if points is None:
        raise line.error(f"the ends of an arc are not equally far from its centre. {AGAIN}")
    return points
