"""What a moving jet lays on a surface: the rates of segments on cells, and the film of one pass over a flat plate."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.spatial.transform import Rotation

from cleaning.jet.compiled_jet import JetForm, flux_of
from cleaning.jet.jet_coordinates import box_of, directions_of
from geometry.arrays import Directions, Points, Scalars
from geometry.compiled import compiled
from geometry.rays import RayScene, are_blocked
from programs.program import MoveTo, SetNozzle, TimedProgram
from specs.source import Source

_PARTS = 3
"""Pieces of a segment, each of which a place sees or does not see as a whole."""
_SPREAD = 24.0
"""A segment is followed in steps no longer than the spray's width by this."""
_LIFT_MM = 0.02
"""Sight ends this far above a surface."""


@dataclass(frozen=True, slots=True, eq=False)
class Segments:
    """Straight pieces of way with the jet on, n of them: a nozzle that turns on the way turns evenly. mm."""

    tcp: NDArray[np.float64]
    """(n, 2, 3) orifice at begin and end."""
    approach: NDArray[np.float64]
    """(n, 2, 3) unit vectors from the orifice to the surface."""
    reference: NDArray[np.float64]
    """(n, 2, 3) unit vectors at right angles to them."""

    @property
    def lengths(self) -> Scalars:
        """(n,) mm."""
        return np.linalg.norm(self.tcp[:, 1] - self.tcp[:, 0], axis=1)


def cut(segments: Segments, seconds: Scalars, longest_mm: float) -> tuple[Segments, Scalars]:
    """Cut long moves into equal parts: what is hidden from a segment is found a few times on each."""
    counts = np.maximum(np.ceil(segments.lengths / longest_mm - 1e-9), 1).astype(np.int64)
    whole = np.repeat(np.arange(len(counts)), counts)
    first = (np.arange(len(whole)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[whole]

    def parts(ends: NDArray[np.float64]) -> NDArray[np.float64]:
        shares = np.stack([first, first + 1.0 / counts[whole]], axis=1)[:, :, None]
        begin, end = ends[whole, :1], ends[whole, 1:]
        return begin + shares * (end - begin)

    cut = Segments(parts(segments.tcp), parts(segments.approach), parts(segments.reference))
    return cut, seconds[whole] / counts[whole]


def sprayed_moves(program: TimedProgram, chosen: Callable[[Source], bool]) -> tuple[Segments, Scalars]:
    """Moves of a program with the jet on that were made by chosen sources, and the seconds that each takes."""
    last: MoveTo | None = None
    on = False
    found: list[tuple[MoveTo, MoveTo]] = []
    for each in program.instructions:
        if isinstance(each, SetNozzle):
            on = each.spraying
        elif isinstance(each, MoveTo):
            moved = last is not None and (each.position, each.quaternion) != (last.position, last.quaternion)
            if on and last is not None and moved and chosen(each.made_by):
                found.append((last, each))
            last = each
    places = np.array([[one.position, other.position] for one, other in found], dtype=np.float64).reshape(-1, 2, 3)
    turns = np.array([[one.quaternion, other.quaternion] for one, other in found], dtype=np.float64)
    axes = Rotation.from_quat(turns.reshape(-1, 4), scalar_first=True).as_matrix().reshape(len(found), 2, 3, 3)
    seconds = np.array([other.time_s - one.time_s for one, other in found], dtype=np.float64)
    return Segments(places, axes[..., 2].copy(), axes[..., 0].copy()), seconds


def joined(moves: Segments, seconds: Scalars, length_mm: float) -> tuple[Segments, Scalars]:
    """Join short moves that follow each other to about a length: speed and direction hardly change."""
    parts = np.floor((np.cumsum(moves.lengths) - moves.lengths / 2.0) / length_mm)
    begins = np.ones(len(seconds), dtype=np.bool_)
    begins[1:] = (np.diff(parts) > 0) | (moves.tcp[1:, 0] != moves.tcp[:-1, 1]).any(axis=1)
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(seconds))[: len(first)] - 1
    ends = (np.stack([each[first, 0], each[last, 1]], axis=1) for each in (moves.tcp, moves.approach, moves.reference))
    whole = np.bincount(np.cumsum(begins) - 1, seconds, len(first)).astype(np.float64)
    return Segments(*ends), whole


def segment_rates(
    form: JetForm, segments: Segments, points: Points, normals: Directions, scene: RayScene | None = None
) -> csr_array:
    """Find what each segment lays on each place while the nozzle moves evenly along it.

    The flux is integrated along the segment: in its middle alone, 20 mm of a parabola of radius 40 mm are up to a
    fifth off.

    Args:
        form: Of the jet.
        segments: n of them.
        points: (m, 3) places on the surface, mm.
        normals: (m, 3) outward unit vectors.
        scene: What casts shadows; ``None`` where nothing does.

    Returns:
        (m, n) film in um/s.
    """
    width = 2.0 * float(np.sqrt(min(form.steepest, 4.0)))
    columns: list[NDArray[np.int64]] = []
    values: list[Scalars] = []
    points, normals = np.ascontiguousarray(points), np.ascontiguousarray(normals)
    for at in range(len(segments.tcp)):
        way = segments.tcp[at], segments.approach[at], segments.reference[at]
        reached, near = _reached(form, way[0], way[1], points)
        places = points[reached], normals[reached]
        length = float(np.linalg.norm(way[0][1] - way[0][0]))
        count = int(np.clip(np.ceil(length / _PARTS / max(width * near / _SPREAD, 1e-3)), 1, 64))
        pieces = np.zeros((_PARTS, len(reached)))
        _lay(form, way, places, count, pieces)
        if scene is not None:
            _shade(scene, way[0], places, pieces)
        total = pieces.sum(axis=0)
        cells = np.flatnonzero(total)
        columns.append(reached[cells])
        values.append(total[cells] * (MICROMETRES / (_PARTS * count)))
    starts = np.concatenate([[0], np.cumsum([len(each) for each in columns])])
    data = np.concatenate([np.empty(0), *values])
    rows = np.concatenate([np.empty(0, dtype=np.int64), *columns])
    return csr_array(csc_array((data, rows, starts), shape=(len(points), len(segments.tcp))))


@compiled
def _reached(
    form: JetForm, tcp: NDArray[np.float64], approach: NDArray[np.float64], points: NDArray[np.float64]
) -> tuple[NDArray[np.int64], float]:
    """Indices of the places that may be in the jet somewhere on a segment, and the distance of the nearest of all."""
    middle, z = 0.5 * (tcp[0] + tcp[1]), approach[0] + approach[1]
    z /= max(np.sqrt(np.sum(z * z)), 1e-12)
    half, turn = 0.5 * np.sqrt(np.sum((tcp[1] - tcp[0]) ** 2)), np.sqrt(np.sum((approach[1] - approach[0]) ** 2))
    steepest = np.sqrt(form.steepest)
    found = np.empty(len(points), dtype=np.int64)
    count, nearest = 0, np.inf
    for k in range(len(points)):
        dx, dy, dz = points[k, 0] - middle[0], points[k, 1] - middle[1], points[k, 2] - middle[2]
        square = dx * dx + dy * dy + dz * dz
        nearest = min(nearest, square)
        along = dx * z[0] + dy * z[1] + dz * z[2]
        # By no more than this a place moves as seen from the orifice, on the way from the middle to an end.
        spare = half + turn * (np.sqrt(square) + half)
        if along + spare > 0.0 and np.sqrt(max(square - along * along, 0.0)) <= steepest * (along + spare) + spare:
            found[count] = k
            count += 1
    return found[:count].copy(), np.sqrt(nearest) if count else 1.0


@compiled
def _lay(
    form: JetForm,
    way: tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]],
    places: tuple[NDArray[np.float64], NDArray[np.float64]],
    count: int,
    pieces: NDArray[np.float64],
) -> None:
    """Fill (parts, m) sums of the flux over the middles of ``count`` steps in each part of a segment."""
    tcp, approach, reference = way
    points, normals = places
    pieces[:] = 0.0
    steps = count * len(pieces)
    axes = np.empty((3, 3))
    for step in range(steps):
        share = (step + 0.5) / steps
        origin = tcp[0] + share * (tcp[1] - tcp[0])
        z = approach[0] + share * (approach[1] - approach[0])
        z /= np.sqrt(np.sum(z * z))
        x = reference[0] + share * (reference[1] - reference[0])
        x -= np.sum(x * z) * z
        x /= np.sqrt(np.sum(x * x))
        axes[0], axes[2] = x, z
        axes[1, 0] = z[1] * x[2] - z[2] * x[1]
        axes[1, 1] = z[2] * x[0] - z[0] * x[2]
        axes[1, 2] = z[0] * x[1] - z[1] * x[0]
        sums = pieces[step // count]
        for k in range(len(points)):
            dx, dy, dz = points[k, 0] - origin[0], points[k, 1] - origin[1], points[k, 2] - origin[2]
            along = dx * z[0] + dy * z[1] + dz * z[2]
            if along <= 0.0 or dx * dx + dy * dy + dz * dz - along * along > form.steepest * along * along:
                continue
            nx, ny, nz = normals[k, 0], normals[k, 1], normals[k, 2]
            sums[k] += flux_of(
                form,
                (
                    dx * axes[0, 0] + dy * axes[0, 1] + dz * axes[0, 2],
                    dx * axes[1, 0] + dy * axes[1, 1] + dz * axes[1, 2],
                    along,
                ),
                (
                    nx * axes[0, 0] + ny * axes[0, 1] + nz * axes[0, 2],
                    nx * axes[1, 0] + ny * axes[1, 1] + nz * axes[1, 2],
                    nx * axes[2, 0] + ny * axes[2, 1] + nz * axes[2, 2],
                ),
            )


def _shade(scene: RayScene, tcp: Points, places: tuple[Points, Directions], pieces: NDArray[np.float64]) -> None:
    """Take out of (parts, m) sums what is hidden from the middle of each part."""
    points, normals = places
    for part in range(len(pieces)):
        cells = np.flatnonzero(pieces[part])
        orifice = tcp[0] + (part + 0.5) / len(pieces) * (tcp[1] - tcp[0])
        ways = points[cells] + _LIFT_MM * normals[cells] - orifice
        lengths = np.linalg.norm(ways, axis=1)
        origins = np.broadcast_to(np.asarray(orifice - scene.origin, dtype=np.float32), ways.shape).copy()
        directions = np.ascontiguousarray(ways / lengths[:, None], dtype=np.float32)
        pieces[part, cells[are_blocked(scene, origins, directions, lengths.astype(np.float32))]] = 0.0


MICROMETRES = 1e6
"""Of a flux in m/s: film in um/s."""
_ACROSS, _ALONG = 2001, 500
_EDGE_SIGMAS = 5.0
_WIDEST = 20.0
"""Spray farther out than this many times the height is left out."""


def film_of_pass(form: JetForm, height_mm: float) -> tuple[Scalars, Scalars]:
    """Film across one straight pass with the nozzle at right angles to a plate.

    Flat patterns lie across the travel, as paths carry them.

    Args:
        form: Of the jet.
        height_mm: Orifice above the plate.

    Returns:
        (n,) places across the pass, mm, and the (n,) film there times the speed, um mm/s: divided by the speed it is
        the film. For f(r) = (R² - r²) / 8 um/s it is (R² - x²)^1.5 / 6 (Jiangsu 2010, eq. (2)).
    """
    box, around = box_of(form, _EDGE_SIGMAS), np.linspace(0.0, 1.0, 65)
    first = box.first[0] + around * (box.first[1] - box.first[0])
    rays = np.concatenate([directions_of(form, first, np.full(65, second)) for second in box.second])
    slopes = np.minimum((np.abs(rays[:, :2]) / np.maximum(rays[:, 2:], 1e-9)).max(axis=0), _WIDEST)
    # How far from the axis spray lands, along tool x and tool y.
    wide, thin = float(slopes[0] * height_mm) + form.half_slot_mm, float(slopes[1] * height_mm)
    across = np.linspace(-wide, wide, _ACROSS)
    along = (np.arange(_ALONG) + 0.5) / _ALONG * 2.0 * thin - thin
    film = np.empty(_ACROSS)
    _integrate(form, height_mm, (across, along), film)
    return across, film * MICROMETRES * (2.0 * thin / _ALONG)


@compiled
def _integrate(
    form: JetForm, height: float, places: tuple[NDArray[np.float64], NDArray[np.float64]], film: NDArray[np.float64]
) -> None:
    """Fill (n,) sums of the flux along the travel, m/s."""
    across, along = places
    for i in range(len(across)):
        total = 0.0
        for k in range(len(along)):
            total += flux_of(form, (across[i], along[k], height), (0.0, 0.0, -1.0))
        film[i] = total
