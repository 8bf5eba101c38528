"""Edits of a cell's file: its board, a fixture or an orifice elsewhere, wider limits of joints. Millimetres."""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from robotcell.cell.load import CELL
from robotcell.cell.spec import HELD_BY, BodySpec, HeldBy, Hold, Place, Point, ToolSpec
from robotcell.errors import CellError
from robotcell.robot.robot import Poses, roll_pitch_yaw
from specs.errors import EditError, shorten_line
from specs.yaml.edit import own_tree, remove_value, set_value
from specs.yaml.located import Key, Located, YamlPath, read_yaml, spell_path
from specs.yaml.tree import Tree

_WORD = re.compile(r"(?!(true|false|null)$)[A-Za-z][A-Za-z0-9_./-]*", re.IGNORECASE)
"""Text that needs no quotes."""
_INDEX, _DEEPEST = re.compile(r"\[(\d{1,9})\]"), 32
_NOT_STATED = "not stated"
PointChange: TypeAlias = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Moves points (k, 3)."""


@dataclass(frozen=True, slots=True)
class CellEdit:
    """A value written into a cell's file, or taken out of it."""

    path: YamlPath
    value: Tree
    """``None`` takes the key out, so that its default holds."""

    def __str__(self) -> str:
        """Give the key and its value, as in ``board.pose: {xyz_mm: [400, -50, 150]}``."""
        return f"{spell_path(self.path)}: {_flow(self.value)}"


def apply_edits(text: str, edits: Iterable[CellEdit], file: Path) -> str:
    """Write edits into the text of a cell; nothing else changes, comments stay.

    Raises:
        CellError: a key is edited twice, or is shared with another one by an anchor.
    """
    edits = list(edits)
    if twice := next((path for path, count in Counter(edit.path for edit in edits).items() if count > 1), None):
        raise CellError(f"{spell_path(twice)} is given twice; give it once", file=file)
    try:
        for edit in edits:
            if edit.value is not None:
                text = set_value(text, edit.path, edit.value)
            elif own_tree(text).find(edit.path) is not None:
                text = remove_value(text, edit.path)
    except EditError as error:
        raise CellError(str(error), file=file) from None
    return text


def parse_edit(text: str, root: Located) -> CellEdit:
    """Read an edit as ``CellEdit`` writes it: ``KEY: VALUE`` on one line, the key as messages give it.

    Args:
        text: Such as ``"tools.1.tcp.xyz_mm: [0, 0, 300]"``.
        root: The cell's file, whose names may contain dots.

    Raises:
        CellError: it is not of that form, or the value is not YAML.
    """
    key, colon, value = text.partition(": ")
    if not colon or not key.strip() or "\n" in text:
        example = "'board.pose: {xyz_mm: [400, -50, 150]}'"
        raise CellError(f"{shorten_line(repr(text))} is no edit; write KEY: VALUE on one line, such as {example}.")
    try:
        read = read_yaml(f"value: {value}", "<edit>", CELL)
    except CellError as error:
        reason = str(error).partition("<edit>:1: ")[2] or str(error)
        raise CellError(f"{shorten_line(repr(text))}: the value cannot be read: {reason}") from None
    return CellEdit(_split_path(key.strip(), root), read.at(("value",)).plain())


def _split_path(spelt: str, root: Located) -> YamlPath:
    """Divide a path as ``spell_path`` writes it; a name that the file has may contain dots.

    Raises:
        CellError: it is no path, or deeper than any cell.
    """
    path: list[Key] = []
    node, rest = root, spelt
    while rest:
        index = _INDEX.match(rest)
        if index:
            key: Key = int(index[1])
            rest = rest[index.end() :]
        else:
            rest = rest.removeprefix(".") if path else rest
            names = node.value if isinstance(node.value, dict) else ()
            known = [name for name in names if re.match(rf"{re.escape(name)}(?![^.\[])", rest)]
            name = max(known, key=len, default=re.split(r"[.\[]", rest, maxsplit=1)[0])
            key, rest = name, rest[len(name) :]
        path.append(key)
        if key == "" or len(path) > _DEEPEST:
            shown = shorten_line(repr(spelt))
            raise CellError(f"{shown} is no key; write it as in tools.1.tcp.xyz_mm or board.pose.rpy_deg[2].")
        node = node.get(key) or Located(None, node.mark)
    return tuple(path)


def describe_edits(root: Located, edits: Iterable[CellEdit]) -> tuple[str, ...]:
    """Give each edit as ``FILE:LINE: KEY: BEFORE -> AFTER``, the line that of the key, or of what it belongs to."""
    described: list[str] = []
    for edit in edits:
        node, found = root.at(edit.path), root.find(edit.path)
        before = _NOT_STATED if found is None else _flow(found.plain())
        after = _NOT_STATED if edit.value is None else _flow(edit.value)
        described.append(f"{node.mark.file}:{node.mark.line}: {spell_path(edit.path)}: {before} -> {after}")
    return tuple(described)


def place_of(T_cell_held: Poses) -> Place:
    """Round a pose as it is written: tenths of a millimetre, hundredths of a degree."""
    x, y, z = (round(1e3 * float(value), 1) + 0.0 for value in T_cell_held[:3, 3])
    roll, pitch, yaw = (round(float(np.degrees(value)), 2) + 0.0 for value in roll_pitch_yaw(T_cell_held))
    return Place(xyz_mm=(x, y, z), rpy_deg=(roll, pitch, yaw))


def format_place(place: Place, held_by: HeldBy = HELD_BY) -> str:
    """Format ``board`` with the pose of its held point as YAML."""
    hold = "" if held_by == HELD_BY else f"  hold: {held_by}\n"
    return f"board:\n{hold}  pose: {_flow(_place_tree(place))}\n"


def with_place(text: str, place: Place, file: Path, held_by: HeldBy = HELD_BY) -> str:
    """Write the pose of the held point under ``board`` of a cell's text; nothing else changes, comments stay.

    Args:
        text: The cell's file.
        place: The pose of the held point.
        file: Name in errors.
        held_by: That point.

    Raises:
        CellError: ``board`` is shared with another key by an anchor.
    """
    board = read_yaml(text, file, CELL).get("board")
    names_point = board is not None and board.get("hold") is not None
    hold: dict[str, Tree] = {"hold": held_by} if names_point or held_by != HELD_BY else {}
    return apply_edits(text, [CellEdit(("board",), {**hold, "pose": _place_tree(place)})], file)


def board_edit(hold: Hold, place: Place) -> CellEdit:
    """Give the edit that holds the board at another place, by the same point; measured points are replaced."""
    if hold.pose is not None:
        return CellEdit(("board", "pose"), _place_tree(place))
    held: dict[str, Tree] = {} if hold.held_by == HELD_BY else {"hold": hold.held_by}
    return CellEdit(("board",), {**held, "pose": _place_tree(place)})


def pose_edit(path: YamlPath, T: Poses) -> CellEdit:
    """Give the edit that puts what has a pose elsewhere: the robot's base, a tool's orifice on the flange."""
    return CellEdit(path, _place_tree(place_of(T)))


def moved_body_edits(path: YamlPath, spec: BodySpec, offset_mm: Sequence[float]) -> tuple[CellEdit, ...]:
    """Give the edits that move a body of a cell's file along the axes of what carries it."""
    return _edits_between(path, spec, _with_points(spec, lambda points: points + np.array(offset_mm)))


def longest_rod_mm(tool: ToolSpec) -> tuple[float, float] | None:
    """Give where the longest rod of a tool begins and ends along the flange's z; ``None`` where it has no rod."""
    keyed = map(_points_by_key, tool.bodies.values())
    ends = [sorted(point[2] for (point,) in points.values()) for points in keyed if ("from_mm",) in points]
    if not ends:
        return None
    low, high = max(ends, key=lambda pair: (pair[1] - pair[0], -pair[0]))
    return (low, high)


def lengthened_tool(tool: ToolSpec, by_mm: float) -> ToolSpec | None:
    """Give a tool whose orifice is farther along the flange's z, or nearer where ``by_mm`` is negative.

    Its longest rod takes the difference, and what is beyond its end moves along with the orifice. Bodies that all end
    before a nearer orifice stay as they are.

    Returns:
        ``None`` where no rod is long enough to be shortened so far.
    """
    x, y, z = tool.tcp.xyz_mm
    bodies, rod = tool.bodies, longest_rod_mm(tool)
    ends = [point[2] for body in bodies.values() for points in _points_by_key(body).values() for point in points]
    if by_mm < 0.0 and z + by_mm <= 0.0:
        return None
    if rod is not None and max(ends, default=0.0) > z + min(by_mm, 0.0):
        low, high = rod
        if high + by_mm < low + 1.0:
            return None

        def stretched(points: NDArray[np.float64]) -> NDArray[np.float64]:
            z = points[:, 2]
            z = np.where(z >= high - 1e-9, z + by_mm, np.minimum(z, max(high + by_mm, low)))
            return np.column_stack((points[:, :2], z))

        bodies = {name: _with_points(body, stretched) for name, body in bodies.items()}
    tcp = tool.tcp.model_copy(update={"xyz_mm": (x, y, _tenths(z + by_mm))})
    return tool.model_copy(update={"tcp": tcp, "bodies": bodies})


def tool_edits(number: int, before: ToolSpec, after: ToolSpec) -> tuple[CellEdit, ...]:
    """Give the edits that turn a tool of a cell's file into another: its orifice, and the bodies that differ."""
    path: YamlPath = ("tools", str(number))
    edits = [CellEdit((*path, "tcp", "xyz_mm"), _point_tree(after.tcp.xyz_mm))]
    for name, body in after.bodies.items():
        edits += _edits_between((*path, "bodies", name), before.bodies[name], body)
    return tuple(edits)


def _points_by_key(spec: BodySpec) -> dict[tuple[str, ...], list[Point]]:
    """Give the points that place a body, by their keys."""
    match spec.kind:
        case "box" | "mesh":
            return {("at", "xyz_mm"): [spec.at.xyz_mm]}
        case "capsule" | "cylinder":
            return {("from_mm",): [spec.from_mm], ("to_mm",): [spec.to_mm]}
        case "hose":
            return {("along_mm",): spec.along_mm}


def _with_points(spec: BodySpec, change: PointChange) -> BodySpec:
    update: dict[str, object] = {}
    for (key, *inner), points in _points_by_key(spec).items():
        moved = [(_tenths(x), _tenths(y), _tenths(z)) for x, y, z in change(np.array(points)).tolist()]
        value = moved if key == "along_mm" else moved[0]
        update[key] = getattr(spec, key).model_copy(update={inner[0]: value}) if inner else value
    return spec.model_copy(update=update)


def _edits_between(path: YamlPath, before: BodySpec, after: BodySpec) -> tuple[CellEdit, ...]:
    """Give the edits of the points in which two specifications of one body differ."""
    trees = ((key, [_point_tree(point) for point in points]) for key, points in _points_by_key(after).items())
    old = {key: [_point_tree(point) for point in points] for key, points in _points_by_key(before).items()}
    return tuple(
        CellEdit((*path, *key), tree if key == ("along_mm",) else tree[0]) for key, tree in trees if tree != old[key]
    )


def _tenths(value: float) -> float:
    return round(float(value), 1) + 0.0


def _point_tree(point: Point) -> Tree:
    return [int(value) if value == int(value) else value for value in point]


def _place_tree(place: Place) -> dict[str, Tree]:
    turned: dict[str, Tree] = {"rpy_deg": _point_tree(place.rpy_deg)} if any(place.rpy_deg) else {}
    return {"xyz_mm": _point_tree(place.xyz_mm), **turned}


def _flow(value: Tree) -> str:
    """Write a value on one line, as YAML."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_flow(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return f"[{', '.join(_flow(item) for item in value)}]"
    return str(value) if isinstance(value, str) and _WORD.fullmatch(value) else json.dumps(value, ensure_ascii=False)
