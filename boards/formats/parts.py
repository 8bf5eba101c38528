"""The parts of a CAD file: loose triangles cut into bodies, layers dropped, roles and names given."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from boards.board import Role
from boards.bounds import check_crowds
from boards.formats.names import listed, natural_key
from boards.formats.tree import Part, corner_key, without_file_order
from geometry.arrays import Triangles
from geometry.gridframe import find_grid_frame
from geometry.mesh import areas_and_normals
from geometry.polygons import project
from specs.finding import Finding
from specs.finding_rules import BOARD_LAYERS, COMPONENT_WITHOUT_HEIGHT, MODELS_JOINED, NOT_ON_THE_BOARD, REPEATED_NAME

_LAYER_MM = 0.15  # copper, mask and print are thinner than this; no component is
_NO_HEIGHT_MM = 0.01
_STANDS_MM = 5.0
_SAME_PART_MM = 0.5
_TOUCH_MM = 0.005
_CELLS = 1_000_000.0
_LEVEL_COSINE = 0.99
_PLACE_MM = 0.02
"""Places that differ by less are alike: a board that was moved has coordinates that are rounded elsewhere."""
_CORNER_MM = 1e-3
_POINT = 1e-290
"""A heap that is no larger is one point, whose cells have no size that can be written."""


def split_bodies(patches: Triangles) -> list[Triangles]:
    """Cut a heap into bodies connected over edges that exactly two patches share, in file order.

    An edge of four patches is where two closed bodies touch: it does not connect them.
    """
    from trimesh.graph import connected_component_labels, face_adjacency

    points = patches.reshape(-1, 3)
    low = points.min(axis=0)
    size = float((points.max(axis=0) - low).max())
    # Vertices are equal in the same cell of a millionth of the heap's size.
    cells = np.rint((points - low) * (_CELLS / size if size > _POINT else 1.0)).astype(np.int64)
    keys = (cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2]
    faces = np.unique(keys, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    solid = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    faces, patches = faces[solid], patches[solid]
    if not len(faces):
        return []
    labels = np.asarray(connected_component_labels(face_adjacency(faces), node_count=len(faces)), dtype=np.int64)
    _, first, label = np.unique(labels, return_index=True, return_inverse=True)
    rank = np.argsort(np.argsort(first))[label]
    order = np.argsort(rank, kind="stable")
    return np.split(patches[order], np.flatnonzero(np.diff(rank[order])) + 1)


def plan_hull(patches: Triangles) -> BaseGeometry:
    """Convex hull of the projection onto the board's plane."""
    return shapely.LineString(patches[:, :, :2].reshape(-1, 2)).convex_hull


def height_range(patches: Triangles) -> tuple[float, float]:
    """Lowest and highest z."""
    z = patches[:, :, 2]
    return float(z.min()), float(z.max())


def touching_groups(heaps: Sequence[Triangles], within_mm: float) -> list[list[int]]:
    """Group the heaps that come as close as that both in plan and in height; groups in the order of their first.

    Hulls find the candidates, true projections decide: what stands in the recess of another part stays apart.

    Raises:
        BoardError: So many lie upon each other that it cannot be a board.
    """
    from trimesh.graph import connected_component_labels

    hulls = np.array([plan_hull(heap) for heap in heaps], dtype=object)
    check_crowds(shapely.bounds(hulls))
    pairs = shapely.STRtree(hulls).query(hulls, predicate="dwithin", distance=within_mm).T.astype(np.int64)
    spans = np.array([height_range(heap) for heap in heaps])
    i, j = pairs[:, 0], pairs[:, 1]
    level = (spans[i, 0] <= spans[j, 1] + within_mm) & (spans[j, 0] <= spans[i, 1] + within_mm)
    pairs = pairs[level & (i < j)]
    shadows = hulls.copy()
    for row in np.unique(pairs).tolist():
        shadow = project(heaps[row])
        shadows[row] = hulls[row] if shadow.is_empty else shadow  # a sheet on edge has no shadow
    close = shapely.distance(shadows[pairs[:, 0]], shadows[pairs[:, 1]]) <= within_mm
    labels = connected_component_labels(pairs[close], node_count=len(heaps))
    groups: dict[int, list[int]] = {}
    for row, label in enumerate(np.asarray(labels).tolist()):
        groups.setdefault(label, []).append(row)
    return list(groups.values())


def parts_in_order(board: Triangles, parts: Sequence[Part]) -> list[Part]:
    """Sort parts, and the geometry of each, by name, by place, then by corners: their order in the file has no effect.

    Args:
        board: Patches of the bare board. Places are taken in its own frame, so that they move with it.
        parts: In any order.
    """
    up = board[areas_and_normals(board)[1][:, 2] > _LEVEL_COSINE]
    frame = find_grid_frame(up if len(up) else board)

    def place(patches: Triangles) -> tuple[float, ...]:
        corners = frame.triangles_to_frame(patches).reshape(-1, 3)
        # Away from the middle of a cell, where the coordinates of drawings seldom are.
        cells = np.rint(np.concatenate([corners.min(axis=0), corners.max(axis=0)]) / _PLACE_MM + 0.31)
        return *cells.tolist(), len(patches)

    def corners(patches: Triangles) -> tuple[int, ...]:
        return corner_key(frame.triangles_to_frame(patches), _CORNER_MM)

    return without_file_order(
        (replace(part, geometry=tuple(without_file_order(part.geometry, place, corners))) for part in parts),
        lambda part: (natural_key(part.name), *map(place, part.geometry)),
        lambda part: (tuple(map(corners, part.geometry)), part.package or ""),
    )


def join_touching(bodies: Sequence[Part]) -> list[Part]:
    """Join unnamed bodies that lie over each other in plan and touch: the pins and the case of one part.

    Returns:
        Parts, the largest in plan first, equal ones as they came.
    """
    if not bodies:
        return []
    groups = touching_groups([body.patches() for body in bodies], _TOUCH_MM)
    parts = [Part("", None, tuple(own for row in rows for own in bodies[row].geometry), False) for rows in groups]
    return sorted(parts, key=lambda part: -round(float(plan_hull(part.patches()).area), 2))


def drop_layers(board: Triangles, parts: Sequence[Part]) -> tuple[list[Part], list[Finding]]:
    """Leave out what lies within the board: copper, mask, print, plugs of holes."""
    bottom, top = height_range(board)
    plan = plan_hull(board)
    kept: list[Part] = []
    layers: list[str] = []
    flat: list[str] = []
    for part in parts:
        margin = _NO_HEIGHT_MM if part.is_named else _LAYER_MM
        low, high = height_range(part.patches()) if part.geometry else (bottom, top)
        # A second board of a panel is as thin, but beside the first.
        beside = bool(part.geometry) and not plan_hull(part.patches()).centroid.within(plan)
        if beside or low < bottom - margin or high > top + margin:
            kept.append(part)
        else:
            (flat if part.is_named else layers).append(part.name or "unnamed")
    findings = listed(BOARD_LAYERS, layers, "lie within the board's thickness and are left out: {}.")
    text = "have no height above the board and are left out; check their models: {}."
    return kept, findings + listed(COMPONENT_WITHOUT_HEIGHT, flat, text)


def split_roles(board: Triangles, parts: Sequence[Part]) -> tuple[list[tuple[Role, Part]], list[Finding]]:
    """Separate components from what only surrounds the board: an enclosure, a carrier, a part elsewhere.

    A part with a reference designator is a component wherever it is.
    """
    bottom, top = height_range(board)
    plan = plan_hull(board)
    placed: list[tuple[Role, Part]] = []
    around: list[str] = []
    for part in parts:
        low, high = height_range(part.patches())
        hull = plan_hull(part.patches())
        stands = max(low - top, bottom - high) < _STANDS_MM and hull.distance(plan) < _SAME_PART_MM
        if part.is_named or (stands and hull.area < plan.area):
            placed.append(("component", part))
        else:
            placed.append(("fixture", part))
            around.append(part.name or "unnamed")
    return placed, listed(NOT_ON_THE_BOARD, around, "do not stand on the board and are kept as obstacles: {}.")


def join_repeated(parts: Sequence[Part]) -> tuple[list[Part], list[Finding]]:
    """Join parts of one name that touch: a footprint with several 3-D models comes as several parts."""
    rows: dict[str, list[int]] = {}
    for row, part in enumerate(parts):
        if part.is_named:
            rows.setdefault(part.name, []).append(row)
    merged = dict(enumerate(parts))
    names: list[str] = []
    for same in (same for same in rows.values() if len(same) > 1):
        for group in touching_groups([parts[row].patches() for row in same], _SAME_PART_MM):
            first, *others = (same[member] for member in group)
            geometry = parts[first].geometry + tuple(own for row in others for own in merged.pop(row).geometry)
            merged[first] = replace(parts[first], geometry=geometry)
            names += [parts[first].name] * bool(others)
    return list(merged.values()), listed(MODELS_JOINED, names, "come in several touching bodies, joined: {}.")


def name_parts(placed: Iterable[tuple[Role, Part]]) -> tuple[list[tuple[Role, Part]], list[Finding]]:
    """Give every part a name that the board file can hold and that no other has."""
    taken = {"board"}
    numbers: dict[str, int] = {}
    """The last one that was given to a name; each is tried once."""
    named: list[tuple[Role, Part]] = []
    renamed: list[str] = []
    for role, part in placed:
        base = re.sub(r"[\s\"'#=\x00-\x1f]+", "_", part.name).strip("_")
        name, number = base or "part-1", numbers.get(base, 1)
        while name in taken:
            number += 1
            name = f"{base or 'part'}-{number}"
        numbers[base] = number
        if base and number > 1:
            renamed.append(f"{base} -> {name}")
        taken.add(name)
        named.append((role, replace(part, name=name)))
    return named, listed(REPEATED_NAME, renamed, "names occur more than once; the later ones were renamed: {}.")
