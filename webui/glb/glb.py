"""Lines and triangles with a colour at each vertex as binary glTF, which browsers draw fastest.

The viewer maps the light of a scene to the screen by three.js's ``ACESFilmicToneMapping`` at an exposure of 1, which is
Stephen Hill's fit of the ACES curves (BakingLab, ``ACES.hlsl``): two matrices around a rational function per channel.
``as_seen`` inverts it, so that plain colours look like the legend beside them.
"""

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from boards.board import Workpiece
from geometry.arrays import Points, Scalars

Colours = NDArray[np.uint8]
"""(n, 3) red, green, blue."""

_DIMMED = 0.52
"""Base colour factor of lit surfaces: light falls from so many sides that colours would be washed out."""
_UNLIT: dict[str, Any] = {"doubleSided": True, "extensions": {"KHR_materials_unlit": {}}}
_LINES, _TRIANGLES = 1, 4
_CHANNELS = np.array([1 << 16, 1 << 8, 1], np.uint32)
_FLOAT, _BYTE, _INT, _VERTEX_DATA, _INDEX_DATA = 5126, 5121, 5125, 34962, 34963
_EXPOSURE = 1.0 / 0.6
_INPUT = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
_OUTPUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
_A, _B, _C, _D, _E = 0.0245786, 0.000090537, 0.983729, 0.4329510, 0.238081
"""Of ``(v (v + a) - b) / (v (c v + d) + e)``."""


def lines_glb(ends: Points, colours: Colours) -> bytes:
    """Write separate line segments, one pixel wide and not lit.

    Args:
        ends: (2 n, 3) begin and end of each segment in turn.
        colours: (2 n, 3) at each of them.
    """
    return _glb(ends, colours, _LINES, [{"extensions": {"KHR_materials_unlit": {}}}])


def triangles_glb(corners: Points, colours: Colours) -> bytes:
    """Write triangles, lit from both sides and flat; corners in one place and colour are written once.

    A browser works out a flat triangle's normal from the picture, so triangles can share corners and stay flat.

    Args:
        corners: (3 n, 3) corners of each triangle in turn, counterclockwise seen from outside.
        colours: (3 n, 3) at each of them.
    """
    surface = {"metallicFactor": 0.0, "roughnessFactor": 0.9, "baseColorFactor": [_DIMMED] * 3 + [1.0]}
    kept, index = shared_corners(corners, np.asarray(colours, dtype=np.uint32) @ _CHANNELS)
    materials = [{"doubleSided": True, "pbrMetallicRoughness": surface}]
    return _glb(corners[kept], colours[kept], _TRIANGLES, materials, index)


def flat_indexed_glb(corners: Points, colours: Colours, index: NDArray[np.uint32]) -> bytes:
    """Write triangles that share corners in their plain colours, the same from all sides and in any light.

    Args:
        corners: (n, 3) each once.
        colours: (n, 3) at each of them.
        index: (3 k,) corners of each triangle in turn, counterclockwise seen from outside.
    """
    return _glb(corners, colours, _TRIANGLES, [_UNLIT], index)


def shared_corners(corners: Points, labels: NDArray[np.integer[Any]]) -> tuple[NDArray[np.intp], NDArray[np.uint32]]:
    """Corners that are the same in the precision of a browser.

    Args:
        corners: (n, 3)
        labels: (n,) below 2^32; corners with different labels stay apart.

    Returns:
        (m,) the corners to keep, the first of each; (n,) index of each corner among those.
    """
    place = np.ascontiguousarray(corners + 0.0, dtype=np.float32).view(np.uint32)  # + 0.0: there is no minus zero
    rows = np.column_stack([place, labels.astype(np.uint32)])
    order = np.lexsort(rows.T)
    fresh = np.concatenate([np.ones(min(len(rows), 1), bool), (rows[order[1:]] != rows[order[:-1]]).any(axis=1)])
    group = np.empty(len(rows), dtype=np.int64)
    group[order] = np.cumsum(fresh) - 1
    kept = order[fresh]  # the sort is stable: the first of each
    ranks = np.empty(len(kept), dtype=np.uint32)
    ranks[np.argsort(kept)] = np.arange(len(kept), dtype=np.uint32)
    return np.sort(kept), ranks[group]


def flat_triangles_glb(corners: Points, colours: Colours) -> bytes:
    """Write separate triangles in their plain colours, the same from all sides and in any light.

    Args:
        corners: (3 n, 3) corners of each triangle in turn.
        colours: (3 n, 3) at each of them.
    """
    return _glb(corners, colours, _TRIANGLES, [_UNLIT])


def _glb(
    points: Points,
    colours: Colours,
    mode: int,
    materials: list[dict[str, Any]],
    index: NDArray[np.uint32] | None = None,
) -> bytes:
    """One mesh of one primitive (glTF 2.0, binary container); no bytes where there are no points."""
    if len(points) == 0:
        return b""
    place = np.ascontiguousarray(points, dtype=np.float32)
    tint = np.ascontiguousarray(
        np.column_stack([np.round(light_of(colours) * 255), np.full(len(colours), 255)]), dtype=np.uint8
    )
    binary = place.tobytes() + tint.tobytes()
    views = [(0, place.nbytes), (place.nbytes, tint.nbytes)]
    document: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "extensionsUsed": ["KHR_materials_unlit"],
        "nodes": [{"mesh": 0}],
        "materials": materials,
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "mode": mode, "material": 0}]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": length, "target": _VERTEX_DATA} for start, length in views
        ],
        "accessors": [
            {
                "bufferView": 0,
                "componentType": _FLOAT,
                "count": len(place),
                "type": "VEC3",
                "min": place.min(axis=0).tolist(),
                "max": place.max(axis=0).tolist(),
            },
            {"bufferView": 1, "componentType": _BYTE, "normalized": True, "count": len(place), "type": "VEC4"},
        ],
    }
    if index is not None:
        document["meshes"][0]["primitives"][0]["indices"] = 2
        document["accessors"].append({"bufferView": 2, "componentType": _INT, "count": len(index), "type": "SCALAR"})
        view = {"buffer": 0, "byteOffset": len(binary), "byteLength": index.nbytes, "target": _INDEX_DATA}
        document["bufferViews"].append(view)
        binary += index.tobytes()
        document["buffers"][0]["byteLength"] = len(binary)
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(binary), 0x004E4942) + binary
    return struct.pack("<III", 0x46546C67, 2, 12 + len(chunks)) + chunks


def light_of(colours: Colours) -> Scalars:
    """(n, 3) screen colours linear in light, 0 to 1 (IEC 61966-2-1)."""
    screen = np.asarray(colours, dtype=np.float64) / 255
    return np.where(screen <= 0.04045, screen / 12.92, ((screen + 0.055) / 1.055) ** 2.4)


def as_seen(colours: Colours) -> Colours:
    """(n, 3) plain colours that appear as (n, 3) colours; the nearest where a screen shows no such colour."""
    y = np.clip(light_of(colours) @ np.linalg.inv(_OUTPUT).T, 0.0, 1.0)
    half, square = y * _D - _A, y * _C - 1.0  # square v^2 + half v + (y e + b) = 0
    v = (-half - np.sqrt(half**2 - 4 * square * (y * _E + _B))) / (2 * square)
    light = np.clip(v @ np.linalg.inv(_INPUT).T / _EXPOSURE, 0.0, 1.0)
    screen = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)  # IEC 61966-2-1
    return np.round(255 * screen).astype(np.uint8)


_SAME_MM = 0.001


def unlike_segments(segments: NDArray[np.float64]) -> NDArray[np.intp]:
    """Indices of distinct segments among (n, 2, 3), in order: the first of those that coincide, in either direction.

    Segments of no length are left out.
    """
    rounded = np.round(segments / _SAME_MM).astype(np.int64)
    forwards, backwards = rounded.reshape(-1, 6), rounded[:, ::-1].reshape(-1, 6)
    differs = forwards != backwards
    first = np.argmax(differs, axis=1)
    rows = np.arange(len(forwards))
    turned = np.where((forwards[rows, first] > backwards[rows, first])[:, None], backwards, forwards)
    _, index = np.unique(turned, axis=0, return_index=True)
    kept = np.sort(index)
    return kept[differs[kept].any(axis=1)]


def ribbons(
    segments: NDArray[np.float64], colours: Colours | tuple[int, int, int], width_mm: float
) -> tuple[Points, Colours]:
    """Two crossed strips for every segment, one lying and one on edge, so that it is seen from all sides.

    Args:
        segments: (n, 2, 3) begin and end.
        colours: (n, 3) of each segment, or one for all.
        width_mm: Of the strips.

    Returns:
        (12 n, 3) corners of triangles and their colours.
    """
    aside, upward = _across(segments)
    half = width_mm / 2
    strips = [_strip(segments, aside * half), _strip(segments, upward * half)]
    return np.concatenate(strips, axis=1).reshape(-1, 3), _of_corners(colours, len(segments), 12)


def bars(
    segments: NDArray[np.float64], colours: Colours | tuple[int, int, int], width_mm: float
) -> tuple[Points, Colours]:
    """Four sides for every segment, which hide narrower ribbons inside.

    Args:
        segments: (n, 2, 3) begin and end.
        colours: (n, 3) of each segment, or one for all.
        width_mm: Of the sides.

    Returns:
        (24 n, 3) corners of triangles and their colours.
    """
    aside, upward = (direction * width_mm / 2 for direction in _across(segments))
    sides = ((upward, aside), (-upward, aside), (aside, upward), (-aside, upward))
    strips = [_strip(segments + shift[:, None], half) for shift, half in sides]
    return np.concatenate(strips, axis=1).reshape(-1, 3), _of_corners(colours, len(segments), 24)


def size_mm(workpiece: Workpiece) -> float:
    """Diagonal of the box around a workpiece."""
    low, high = workpiece.box
    return float(np.linalg.norm(high - low))


def line_width_mm(size_mm: float) -> float:
    """Line width that is about two pixels where a workpiece of this diagonal fills half of a page."""
    return size_mm / 260


def lengths_of(segments: NDArray[np.float64]) -> Scalars:
    """(n,) lengths of (n, 2, 3) segments."""
    return np.asarray(np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1), dtype=np.float64)


def _of_corners(colours: Colours | tuple[int, int, int], segments: int, corners: int) -> Colours:
    each = np.broadcast_to(np.array(colours, dtype=np.uint8).reshape(-1, 3), (segments, 3))
    return np.repeat(each, corners, axis=0)


def _across(segments: NDArray[np.float64]) -> tuple[Points, Points]:
    """(n, 3) directions normal to (n, 2, 3) segments: a horizontal one, and the one normal to both."""
    along = segments[:, 1] - segments[:, 0]
    unit = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    aside = np.cross(unit, [0.0, 0.0, 1.0])
    lengths = np.linalg.norm(aside, axis=1, keepdims=True)
    aside = np.where(lengths > 1e-6, aside / np.maximum(lengths, 1e-12), [1.0, 0.0, 0.0])
    return aside, np.cross(aside, unit)


def _strip(segments: NDArray[np.float64], half: Points) -> NDArray[np.float64]:
    """(n, 6, 3) two triangles for each segment."""
    begin, end = segments[:, 0], segments[:, 1]
    left, right = (begin + half, end + half), (begin - half, end - half)
    return np.stack([right[0], right[1], left[1], right[0], left[1], left[0]], axis=1)
