"""Boards out of CAD: STEP assemblies, glTF scenes and plain meshes become bodies."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from boards.board import Body, Role, Surface
from boards.bounds import beyond
from boards.errors import BoardError
from boards.formats.names import listed, natural_key
from boards.formats.parts import (
    drop_layers,
    height_range,
    join_repeated,
    join_touching,
    name_parts,
    parts_in_order,
    plan_hull,
    split_bodies,
    split_roles,
)
from boards.formats.table import Format
from boards.formats.tree import (
    Node,
    Part,
    corner_key,
    has_refdes,
    is_board_name,
    is_called_board,
    label_of,
    read_tree,
    refdes_of,
    split_parts,
    without_file_order,
)
from boards.formats.tri.tri import SMALLEST_AREA_MM2
from geometry.arrays import Triangles
from geometry.mesh import areas_and_normals
from specs.finding import Finding
from specs.finding_rules import (
    BOARD_NOT_TURNED,
    BOARD_TURNED,
    NESTED_BOARDS,
    NO_COMPONENTS,
    NOT_ON_THE_BOARD,
    UNIT_GUESSED,
)
from specs.progress import Progress, no_progress

_FARTHEST = 1e9  # whatever the unit
_SMALLEST_NAMED_BOARD = 0.1  # of the largest plate; smaller ones are adapters, or parts with a board of their own
_SAME_WAY = 0.999
_THICKNESS_TO_SIDE = 0.35
_LEVEL_MM = 0.1
"""What is nearer in height touches, and boards on a carrier are of one level."""
_NO_AREA = 1e-30
_PLACE = 1e-6
"""Of the length of a plate: places that differ by less are alike."""
_SMALLEST_TURN_RAD = 1e-4

_UNITS_MM = {"mm": 1.0, "inches": 25.4, "metres": 1000.0, "micrometres": 0.001}
"""Units a board file may be in, the most likely first."""


@dataclass(frozen=True, slots=True, eq=False)
class _Flatness:
    """The direction in which most of a body's surface looks, and its size along and across it (units of the file)."""

    normal: NDArray[np.float64]
    """(3,) unit vector; its largest coordinate is positive."""
    area: float
    """Area of one side."""
    thickness: float
    length: float
    """Diameter of the circle about the middle that holds it, across the normal."""

    @property
    def is_plate(self) -> bool:
        """Much wider than thick, and not just a face."""
        return 0.0 < self.thickness < _THICKNESS_TO_SIDE * self.area**0.5


def read_scene(path: Path, progress: Progress = no_progress) -> tuple[tuple[Body, ...], tuple[Finding, ...]]:
    """Read a board from ``.step``/``.stp``, ``.glb``/``.gltf``, ``.stl``, ``.obj`` or ``.ply``.

    The origin of the file is kept; a board that does not lie in the x/y plane is turned. The order of objects
    in the file has no effect: named ones come in the natural order of their names, loose ones by size, then by place.

    Args:
        path: file; its suffix is the format.
        progress: Receives the stage and the share done.

    Raises:
        BoardError: the file cannot be read, is damaged, or holds no board.
    """
    progress("reading", 0.0)
    tree, form, findings = read_tree(path, progress)
    progress("finding parts", 0.96)
    _check_geometry(tree, path)
    # Names are of no help in one mesh, or in a mesh file that names nothing like a component.
    several = sum(1 for node in tree.walk() if node.patches) > 1
    loose = not several or (form.name != "STEP" and not has_refdes(tree))
    if loose:
        bodies = split_bodies(np.concatenate(tree.geometry()))
        tree = Node("", "", (), tuple(Node("", "", (body,)) for body in bodies))
    board, flatness = _find_board(tree, path)
    frame, turned = _find_frame(flatness, form)
    slab = frame.move(Part("board", None, board.patches, is_named=False))
    if not slab.geometry:
        raise BoardError("the board in it has no area in steps of 0.0001 mm. Check the unit of the file.", file=path)
    moved = [frame.move(part) for part in split_parts(tree, board)]
    for part in [slab, *moved]:
        if any(map(beyond, part.geometry)):
            message = f"{part.name or 'a body'} lies more than 10 m away. Check its place, and the unit of the file."
            raise BoardError(message, file=path)
    parts, layers = drop_layers(slab.patches(), parts_in_order(slab.patches(), moved))
    if not loose:
        parts, joined = join_repeated(parts)
    elif parts:
        parts, joined = join_touching(parts), []
    else:
        text = "nothing but the board was found: components must be bodies of their own, not fused with the board."
        joined = [Finding(NO_COMPONENTS, text)]
    slab, parts, carrier = _carried(slab, parts)
    placed, around = split_roles(slab.patches(), parts)
    aside = [part for _, part in placed if carrier is not None and _stands_on(part, carrier)]
    placed: list[tuple[Role, Part]] = [("fixture" if part in aside else role, part) for role, part in placed]
    text = "stand on the carrier of the boards and are kept as obstacles: {}."
    around += listed(NOT_ON_THE_BOARD, [part.name or "unnamed" for part in aside], text)
    boards = [part.name for _, part in placed if not part.is_named and is_board_name(part.name)]
    text = "are boards nested in the assembly, such as those on a carrier, and stand on the largest as parts: {}."
    nested = listed(NESTED_BOARDS, boards, f"{text} Export each alone to clean it.")
    placed, renamed = name_parts(placed)
    progress("finding parts", 1.0)
    made = (_make_body("board", slab), *(_make_body(role, part) for role, part in placed))
    return made, (*findings, *turned, *layers, *joined, *around, *nested, *renamed)


def _carried(slab: Part, parts: list[Part]) -> tuple[Part, list[Part], Part | None]:
    """Take the boards on a carrier for the board, where they are of one level and carry most of the components.

    Returns:
        The bare boards, the other parts with the carrier, and the carrier; ``None`` where there is none.
    """
    plates = [part for part in parts if not part.is_named and is_board_name(part.name)]
    levels = np.array([height_range(part.patches()) for part in plates])
    if len(plates) < 2 or float(np.ptp(levels, axis=0).max()) > _LEVEL_MM:
        return slab, parts, None
    named = [part for part in parts if part.is_named]
    carried = [part for part in named if any(_stands_on(part, plate) for plate in plates)]
    if not all(any(_stands_on(part, plate) for part in carried) for plate in plates) or 2 * len(carried) <= len(named):
        return slab, parts, None
    carrier = replace(slab, name="carrier")
    boards = replace(slab, geometry=tuple(own for plate in plates for own in plate.geometry))
    return boards, [carrier, *(part for part in parts if part not in plates)], carrier


def _stands_on(part: Part, plate: Part) -> bool:
    """Whether a part touches a face of a plate and lies over it for the most part."""
    (low, high), (bottom, top) = height_range(part.patches()), height_range(plate.patches())
    touches = abs(low - top) <= _LEVEL_MM or abs(high - bottom) <= _LEVEL_MM
    return touches and bool(plan_hull(part.patches()).centroid.within(plan_hull(plate.patches())))


def _check_geometry(tree: Node, path: Path) -> None:
    found = False
    for node in tree.walk():
        for patches in node.patches:
            found = found or len(patches) > 0
            if not (np.abs(patches) < _FARTHEST).all():
                at = f"part {label_of(node)!r}" if label_of(node) else "the mesh"
                message = f"{at} has vertices that are not numbers, or absurdly large. Repair it in CAD first."
                raise BoardError(message, file=path)
    if not found:
        raise BoardError("holds no triangles or surfaces. Export the board with its solids.", file=path)


def _find_board(tree: Node, path: Path) -> tuple[Node, _Flatness]:
    """Choose the bare board: the largest plate that is named like one, else the largest plate."""
    plates: list[tuple[Node, _Flatness, bool]] = []
    for node, named in _bare_leaves(tree, path.stem, is_root=True):
        flatness = _measure_flatness(np.concatenate(node.patches))
        if flatness.is_plate:
            plates.append((node, flatness, named))
    if not plates:
        message = "holds no board: nothing in it is a flat plate. Export the bare board with its components."
        raise BoardError(message, file=path)
    # Six digits: rounding must not distinguish two equal plates; their names and places do.
    largest = max(flatness.area for _, flatness, _ in plates)
    named = [plate for plate in plates if plate[2] and plate[1].area > _SMALLEST_NAMED_BOARD * largest]
    step = _PLACE * max(flatness.length for _, flatness, _ in plates)
    node, flatness, _ = without_file_order(
        named or plates,
        lambda plate: -float(f"{plate[1].area:.6g}"),
        lambda plate: (natural_key(label_of(plate[0])), corner_key(np.concatenate(plate[0].patches), step)),
    )[0]
    return node, flatness


def _bare_leaves(node: Node, stem: str, *, is_root: bool = False, named: bool = False) -> Iterator[tuple[Node, bool]]:
    """Yield the nodes with geometry that may be the board, and whether they (or a group they are in) are called so."""
    if refdes_of(node.name) is not None and not any(has_refdes(child) for child in node.children):
        return
    named = named or (not is_root and is_called_board(node, stem) and not has_refdes(node))
    if node.patches:
        yield node, named
    for child in node.children:
        yield from _bare_leaves(child, stem, named=named)


@dataclass(frozen=True, slots=True, eq=False)
class _Frame:
    """From the file's units and axes to the board frame, mm."""

    scale: float
    turn: NDArray[np.float64] | None

    def move(self, part: Part) -> Part:
        """Move a part; coordinates come out in steps of 0.0001 mm, patches that shrink to nothing are left out."""
        geometry: list[Triangles] = []
        for patches in part.geometry:
            scaled = patches * self.scale
            turned = scaled if self.turn is None else scaled @ self.turn.T
            steps = np.round(turned, 4) + 0.0
            steps = steps[areas_and_normals(steps)[0] > SMALLEST_AREA_MM2]
            geometry += [steps] * bool(len(steps))
        return replace(part, geometry=tuple(geometry))


def _find_frame(board: _Flatness, form: Format) -> tuple[_Frame, list[Finding]]:
    findings: list[Finding] = []
    default = next(name for name, unit_mm in _UNITS_MM.items() if unit_mm == form.unit_mm)
    likely = [default] if form.name == "STEP" else sorted(_UNITS_MM, key=lambda name: name != default)
    # Length and thickness decide together: 4 x 0.063 is a board in inches, 0.1 x 0.0016 one in metres.
    fitting = (
        name
        for name in likely
        if 3.0 <= board.length * _UNITS_MM[name] <= 1500.0 and 0.1 <= board.thickness * _UNITS_MM[name] <= 12.0
    )
    unit = next(fitting, default)
    if unit != default:
        size = f"{board.length:.3g} across and {board.thickness:.3g} thick"
        message = f"the board is {size} in the units of the file: looks like {unit}, taken as such (not {default})."
        findings.append(Finding(UNIT_GUESSED, message))
    axis = np.eye(3)[int(np.argmax(np.abs(board.normal)))]
    x, y, z = axis if np.linalg.norm(board.normal - axis) < _SMALLEST_TURN_RAD else board.normal
    turn = None
    if z != 1.0:  # the smallest rotation that takes the normal to z (Rodrigues)
        cross = np.array([[0.0, 0.0, -x], [0.0, 0.0, -y], [x, y, 0.0]])
        turn = np.eye(3) + cross + cross @ cross / (1.0 + z)
        x, y, z = (round(float(value), 3) + 0.0 for value in board.normal)
        message = (
            f"the board did not lie in the x/y plane: turned so that its direction ({x:g}, {y:g}, {z:g}) became z."
        )
        findings.append(Finding(BOARD_TURNED, message))
    elif form.name == "glTF":
        findings.append(Finding(BOARD_NOT_TURNED, "glTF states that y is up, but the board lies in x/y: not turned."))
    return _Frame(_UNITS_MM[unit], turn), findings


def _make_body(role: Role, part: Part) -> Body:
    patches = part.patches()
    surfaces = tuple(Surface(f"surface-{n}", len(own)) for n, own in enumerate(part.geometry, start=1))
    return Body(part.name, role, patches, areas_and_normals(patches)[1], surfaces, package=part.package)


def _measure_flatness(patches: Triangles) -> _Flatness:
    """Find the direction most of the surface looks in. Does not depend on how the body lies in the frame."""
    areas, unit = areas_and_normals(patches)
    if not areas.sum() > _NO_AREA:
        return _Flatness(np.array([0.0, 0.0, 1.0]), 0.0, 0.0, 0.0)
    steps = np.rint(unit * 500.0).astype(np.int64)  # neighbouring directions share a cell
    key = (steps[:, 2] * 2048 + steps[:, 1]) * 2048 + steps[:, 0]
    flip = np.where(key < 0, -1.0, 1.0)
    _, cell = np.unique(np.abs(key), return_inverse=True)
    best = int(np.argmax(np.round(np.bincount(cell, weights=areas) / areas.sum(), 9)))
    chosen = cell == best
    normal = (unit[chosen] * (flip * areas)[chosen, None]).sum(axis=0)
    normal /= np.linalg.norm(normal)
    if normal[int(np.argmax(np.round(np.abs(normal), 6)))] < 0.0:
        normal = -normal
    along = patches.reshape(-1, 3) @ normal
    flat = patches.reshape(-1, 3) - along[:, None] * normal
    middle = (flat.max(axis=0) + flat.min(axis=0)) / 2.0
    area = float(areas[np.abs(unit @ normal) > _SAME_WAY].sum()) / 2.0
    length = 2.0 * float(np.linalg.norm(flat - middle, axis=1).max())
    return _Flatness(normal, area, float(np.ptp(along)), length)
