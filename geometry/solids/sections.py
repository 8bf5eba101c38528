"""Sections of a surface by parallel planes, as polylines with the surface's normals along them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Directions, Indices, Points, Scalars, Triangles
from geometry.mesh import areas_and_normals

_ASIDE = 1e-7
"""Of the level: a plane does not go through a corner, where a line would fork."""


@dataclass(frozen=True, slots=True, eq=False)
class Section:
    """One line that a plane cuts out of a surface."""

    points: Points
    """(k, 3) in order; a closed one does not repeat its first point."""
    normals: Directions
    """(k, 3) of the surface there, smoothed over the patches that meet at a corner."""
    closed: bool


def vertex_normals(patches: Triangles, corners: Indices) -> Directions:
    """(corners, 3) mean normals of the patches that meet at each corner, weighted by area; (n, 3) corners."""
    areas, normals = areas_and_normals(patches.copy())
    count = int(corners.max()) + 1
    weighted = np.repeat(normals * areas[:, None], 3, axis=0)
    sums = np.column_stack([np.bincount(corners.ravel(), weighted[:, axis], count) for axis in range(3)])
    return sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)


def cut_section(patches: Triangles, corners: Indices, normals: Directions, axis: Points, level: float) -> list[Section]:
    """Cut a surface with the plane ``point · axis = level``.

    Args:
        patches: (n, 3, 3) mm.
        corners: (n, 3) numbers of their corners: an edge that two patches share has the same two.
        normals: (corners, 3) of the surface at the corners.
        axis: (3,) unit normal of the plane.
        level: mm along it.

    Returns:
        The lines, in the order of their first patches; of a closed surface all are closed.
    """
    heights = patches @ axis - level
    heights = np.where(np.abs(heights) < _ASIDE, _ASIDE, heights)
    above = heights > 0
    crossed = np.flatnonzero(above.any(axis=1) & ~above.all(axis=1))
    ends: dict[tuple[int, int], tuple[Points, Points]] = {}
    segments: list[tuple[tuple[int, int], tuple[int, int]]] = []
    for patch in crossed.tolist():
        keys: list[tuple[int, int]] = []
        for a, b in ((0, 1), (1, 2), (2, 0)):
            if above[patch, a] != above[patch, b]:
                key, at = _crossing(patches[patch], corners[patch], normals, heights[patch], (a, b))
                ends.setdefault(key, at)
                keys.append(key)
        segments.append((keys[0], keys[1]))
    return [_section(chain, ends, closed=closed) for chain, closed in _chains(segments)]


def _crossing(
    patch: Points, corners: Indices, normals: Directions, heights: Scalars, edge: tuple[int, int]
) -> tuple[tuple[int, int], tuple[Points, Points]]:
    a, b = edge
    if corners[a] > corners[b]:
        a, b = b, a
    share = heights[a] / (heights[a] - heights[b])
    normal = normals[corners[a]] * (1 - share) + normals[corners[b]] * share
    place = patch[a] * (1 - share) + patch[b] * share
    return (int(corners[a]), int(corners[b])), (place, normal / max(float(np.linalg.norm(normal)), 1e-12))


def _chains(segments: list[tuple[tuple[int, int], tuple[int, int]]]) -> list[tuple[list[tuple[int, int]], bool]]:
    at: dict[tuple[int, int], list[int]] = {}
    for number, pair in enumerate(segments):
        for key in pair:
            at.setdefault(key, []).append(number)
    left = dict.fromkeys(range(len(segments)))
    chains: list[tuple[list[tuple[int, int]], bool]] = []
    ends = [number for number, pair in enumerate(segments) if any(len(at[key]) == 1 for key in pair)]
    for start in (*ends, *range(len(segments))):  # open lines from their ends first, then rings
        if start not in left:
            continue
        one, two = segments[start]
        chain = [one, two] if len(at[one]) == 1 or len(at[two]) != 1 else [two, one]
        del left[start]
        while True:
            onward = next((number for number in at[chain[-1]] if number in left), None)
            if onward is None:
                break
            del left[onward]
            first, second = segments[onward]
            chain.append(second if first == chain[-1] else first)
        closed = len(chain) > 3 and chain[0] == chain[-1]
        chains.append((chain[:-1] if closed else chain, closed))
    return chains


def _section(
    chain: list[tuple[int, int]], ends: dict[tuple[int, int], tuple[Points, Points]], *, closed: bool
) -> Section:
    points, normals = (np.array([ends[key][k] for key in chain]) for k in (0, 1))
    return Section(points, normals, closed)


def resample(section: Section, step_mm: float) -> Section:
    """Place points evenly along a section, no farther apart than a step; ends and first points stay."""
    points, normals = section.points, section.normals
    if section.closed:
        points, normals = np.vstack([points, points[:1]]), np.vstack([normals, normals[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    kept = np.concatenate([[True], np.diff(along) > 1e-9])
    points, normals, along = points[kept], normals[kept], along[kept]
    count = max(1, int(np.ceil(along[-1] / step_mm - 1e-6)))
    places = np.linspace(0.0, along[-1], count + 1)
    placed = np.column_stack([np.interp(places, along, points[:, axis]) for axis in range(3)])
    turned = np.column_stack([np.interp(places, along, normals[:, axis]) for axis in range(3)])
    turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-12)
    last = len(placed) - 1 if section.closed else len(placed)
    return Section(placed[:last], turned[:last], section.closed)


def length_of(section: Section) -> float:
    """Length of a section, mm."""
    points = np.vstack([section.points, section.points[:1]]) if section.closed else section.points
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def least_bent_axis(normals: Directions, areas_mm2: NDArray[np.float64], first: Points) -> Points:
    """(3,) direction that the normals are least along, such as the axis of a cylinder; ``first`` decides its sign.

    Where two directions are as good (a ball, a plane's two), the one nearest to ``first`` (3,) is taken.
    """
    spread = np.einsum("n,ni,nj->ij", areas_mm2, normals, normals) / areas_mm2.sum()
    values, vectors = np.linalg.eigh(spread)
    good = vectors[:, values < values[0] + 0.02]
    inside = good @ (good.T @ first)
    length = float(np.linalg.norm(inside))
    axis = inside / length if length > 1e-3 else good[:, 0]
    return axis / np.linalg.norm(axis)
