"""What reaches the surface of a small board, made by hand: facets, cells, and an exposure that has a missed corner."""

import numpy as np
import shapely

from boards.board import Board, Side
from cleaning.exposure.exposure import Exposure, Growth
from cleaning.film.run_off import RunOff, run_off_of
from cleaning.gap.edge_segments import SEGMENTS, Edges
from cleaning.parameters.model import Parameters
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from cleaning.verdicts.exposed_area import cells_of_side
from geometry.mesh import areas_and_normals

_DIRECTIONS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=float)


def facets_of(board) -> Facets:
    """Squares of 1 mm on the top of the bare board, and each component's own patches gathered by direction."""
    x0, y0, x1, y1 = board.outline.bounds
    xs, ys = np.meshgrid(np.arange(x0, x1), np.arange(y0, y1))
    low = np.column_stack([xs.ravel(), ys.ravel(), np.full(xs.size, board.top_z_mm)])
    corners = [low + np.array(shift) for shift in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0))]
    squares = np.stack([np.stack([corners[0], corners[i], corners[i + 1]], axis=1) for i in (1, 2)], axis=1)
    under = shapely.contains_xy(shapely.union_all([c.footprint for c in board.components]), *(low[:, :2] + 0.5).T)
    triangles, body, component = [squares.reshape(-1, 3, 3)], [np.zeros(2 * len(low))], [np.full(2 * len(low), -1)]
    cell, exposed = [np.repeat(np.arange(len(low)), 2)], [np.repeat(~under, 2)]
    for index, part in enumerate(board.components):
        number = next(i for i, each in enumerate(board.bodies) if each.name == part.name)
        patches = board.bodies[number].patches
        facing = np.argmax(areas_and_normals(patches)[1] @ _DIRECTIONS.T, axis=1)
        triangles.append(patches)
        body.append(np.full(len(patches), number))
        component.append(np.full(len(patches), index))
        cell.append(len(low) + 6 * index + facing)
        exposed.append(facing != 5)
    return _gathered(*(np.concatenate(each) for each in (triangles, body, component, cell, exposed)))


def _gathered(triangles, body, component, cell, exposed) -> Facets:
    areas, normals = areas_and_normals(triangles)
    _, cell = np.unique(cell, return_inverse=True)
    count = int(cell.max()) + 1
    cell_areas = np.bincount(cell, areas, count)
    centres = np.column_stack([np.bincount(cell, areas * triangles[:, :, k].mean(axis=1), count) for k in range(3)])
    first = np.unique(cell, return_index=True)[1]
    return Facets(
        triangles=triangles,
        normals=normals,
        areas_mm2=areas,
        body=body.astype(np.int64),
        cell=cell.astype(np.int64),
        cell_areas_mm2=cell_areas,
        cell_centres=centres / cell_areas[:, None],
        cell_normals=normals[first],
        cell_component=component[first].astype(np.int64),
        exposed=exposed.astype(bool),
        cell_exposed=exposed[first].astype(bool),
    )


def exposure_of(facets: Facets, stage: Stage) -> Exposure:
    """Most in the middle of the board, nothing in its back right corner; deposited stripe by stripe."""
    x, y, _ = facets.cell_centres.T
    volume = 14.0 * np.exp(-(((x - 15) / 14) ** 2) - ((y - 10) / 11) ** 2)
    volume *= np.clip(1 + facets.cell_normals[:, 2], 0.0, 1.0) * ~((x > 27) & (y > 16))
    blocks = 20
    until = np.linspace(stage.begin_s, stage.end_s, blocks + 1)[1:]
    shares = np.exp(-(((np.arange(blocks)[:, None] / blocks) - y / 20) ** 2) / 0.02)
    gained = shares / shares.sum(axis=0) * volume
    wet = np.flatnonzero(volume > 0)
    growth = Growth(
        until_s=until,
        start=np.arange(blocks + 1) * len(wet),
        cell=np.tile(wet, blocks),
        volume_mm=gained[:, wet].ravel().astype(np.float32),
    )
    landed = float(volume @ facets.cell_areas_mm2)
    return Exposure(
        cone_s=volume * 0.8,
        front_s=volume * 0.3,
        volume_mm=volume,
        peak_pa=np.where(volume > 0, 330.0 * (1 - volume / 40), 0.0),
        impulse_n_pa_s=volume * 20,
        impulse_t_pa_s=volume * 9,
        hits=np.round(volume * 40).astype(np.int64),
        cone_error_s=volume * 0.05,
        cone_shared_error_s=volume * 0.01,
        sprayed_mm3=1.5 * landed,
        landed_mm3=landed,
        rays=5120,
        growth=growth,
    )


def no_edges() -> Edges:
    """Of a board without a thin gap."""
    shape = (0, SEGMENTS, 3)
    return Edges(
        np.zeros(0, np.int64), np.zeros(shape), np.zeros(shape), np.zeros(0), np.zeros((0, SEGMENTS)), np.zeros(0)
    )


def run_offs_of(board: Board, facets: Facets, parameters: Parameters) -> dict[Side, RunOff]:
    """How film and run-off spread over each side of a board, no gap of which is known."""
    sides: tuple[Side, ...] = ("top", "bottom")
    return {
        side: run_off_of(side, board, facets, cells_of_side(facets, board, side), no_edges(), parameters.film)
        for side in sides
    }
