"""What flows over a surface after it has landed elsewhere: the film on the board, and from tops down their walls.

The film carries what landed outwards from the rim of the spray, and inwards into the pool. It is counted as volume per
area, as what lands is: the flow per width at a place over the distance from the pole, which is what the flow gives to
each bit of its way if it gives as much to every bit of the same length in all directions. A still jet so gives its
outward flow ``log(3)`` times, and half of its inward flow, over all places within its reach: every litre counts about
once where it lands, and once where it flows.
"""

import math
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from boards.board import Board, Side
from cleaning.film.film import REACH, Rim, farthest, film_around, rim_of
from cleaning.gap.edge_segments import Edges
from cleaning.jet.jet import Jet
from cleaning.parameters.model import Film
from cleaning.process.stages import Stage
from cleaning.surface.facets import Facets
from geometry.arrays import Indices, Points, Points2, Scalars
from geometry.compiled import quick

_STEP_MM = 4.0
_MOST_STEPS = 64
_TOP = 0.5
"""Cosine between a cell's normal and that of its side above which what lands on it runs off over the rim."""


@dataclass(frozen=True, slots=True, eq=False)
class FilmNodes:
    """Nodes of a grid over a board, turned with it, at which the film is evaluated. Board frame, mm."""

    corner: Points2
    """(2,) of the first node."""
    axes: NDArray[np.float64]
    """(2, 2) rows: unit vectors along the grid."""
    steps_mm: Scalars
    """(2,)"""
    counts: tuple[int, int]
    on_board: NDArray[np.bool_]
    """(counts) whether a node lies on the board: no film begins elsewhere."""


@dataclass(frozen=True, slots=True, eq=False)
class RunOff:
    """How film and run-off of tops spread over the c cells of a surface, on one side of a board."""

    side: Side
    surface_z_mm: float
    nodes: FilmNodes
    cell: Indices
    """(k,) the cells that the film flows over: those lower than the puddle."""
    corner: Indices
    """(k, 4) the nodes around each, by their number in the grid."""
    weight: NDArray[np.float64]
    """(k, 4) of these nodes, all together the share of the film that neighbours leave."""
    top: Indices
    """(t,) cells of tops."""
    top_part: Indices
    """(t,) the component of each."""
    wall: Indices
    """(w,) cells of walls that get what runs off a top."""
    wall_part: Indices
    """(w,)"""
    areas_mm2: Scalars
    """(c,) exposed area of each cell."""
    wall_areas_mm2: Scalars
    """(components,) of all walls of each."""

    def on_cells(self, volume_mm: Scalars, film_mm: Scalars) -> Scalars:
        """Give what flows over each cell.

        Args:
            volume_mm: (c,) what landed.
            film_mm: (nodes,) film at the nodes.

        Returns:
            (c,) mm.
        """
        found = np.zeros(len(volume_mm))
        found[self.cell] = np.einsum("ij,ij->i", film_mm[self.corner], self.weight)
        if len(self.wall):
            landed = volume_mm[self.top] * self.areas_mm2[self.top]
            runs_off = np.bincount(self.top_part, landed, len(self.wall_areas_mm2))
            found[self.wall] += (runs_off / np.maximum(self.wall_areas_mm2, 1e-30))[self.wall_part]
        return found


def run_off_of(side: Side, board: Board, facets: Facets, cells: Indices, edges: Edges, film: Film) -> RunOff:
    """Find which cells of a side the film flows over, and which walls get what runs off their tops.

    Args:
        side: Of the board.
        board: Has the components.
        facets: ``build_facets`` of the board.
        cells: Those of this side, of its components and of the bare board.
        edges: Of components with a gap: neighbours that stand close leave only a share of the film. Of other components
            that are lower than the puddle nothing is known, and they get that share.
        film: The film's numbers.
    """
    facing = 1.0 if side == "top" else -1.0
    nodes = _nodes_over(board)
    surface = board.surface_z_mm(side)
    low = cells[facing * (facets.cell_centres[cells, 2] - surface) < film.puddle_mm]
    share = np.append(np.full(len(board.components), film.shelter), 1.0)  # the bare board is the last
    share[edges.component] = np.where(edges.sheltered <= film.shelter_mm, film.shelter, 1.0).mean(axis=1)
    corner, weight = _around(nodes, facets.cell_centres[low, :2])
    of_part = cells[facets.cell_component[cells] >= 0]
    upward = facing * facets.cell_normals[of_part, 2] > _TOP
    top, wall = of_part[upward & facets.cell_exposed[of_part]], of_part[~upward]
    part = facets.cell_component
    return RunOff(
        side=side,
        surface_z_mm=surface,
        nodes=nodes,
        cell=low,
        corner=corner,
        weight=weight * share[part[low]][:, None],
        top=top,
        top_part=part[top],
        wall=wall,
        wall_part=part[wall],
        areas_mm2=facets.cell_areas_mm2,
        wall_areas_mm2=np.bincount(part[wall], facets.cell_areas_mm2[wall], len(board.components)).astype(np.float64),
    )


def _nodes_over(board: Board) -> FilmNodes:
    cosine, sine = board.axis
    axes = np.array([[cosine, sine], [-sine, cosine]])
    corners = shapely.get_coordinates(board.outline.exterior) @ axes.T
    low, extent = corners.min(axis=0), np.ptp(corners, axis=0)
    step = max(_STEP_MM, float(extent.max()) / _MOST_STEPS)
    intervals = np.maximum(np.ceil(np.round(extent / step, 6)), 1.0)
    steps = extent / intervals
    counts = (int(intervals[0]) + 1, int(intervals[1]) + 1)
    local = np.stack(np.meshgrid(*(low[i] + steps[i] * np.arange(counts[i]) for i in range(2)), indexing="ij"), axis=-1)
    places = local @ axes
    # A little more than the board, whose rim the outermost nodes lie on.
    on_board = shapely.contains_xy(shapely.buffer(board.outline, 0.01 * step), places[..., 0], places[..., 1])
    return FilmNodes(low @ axes, axes, steps, counts, on_board)


def _around(nodes: FilmNodes, places: Points2) -> tuple[Indices, NDArray[np.float64]]:
    """(n, 4) nodes around (n, 2) places and their weights, bilinear."""
    local = (places - nodes.corner) @ nodes.axes.T / nodes.steps_mm
    most = np.array(nodes.counts) - 2
    first = np.clip(np.floor(local), 0, most).astype(np.int64)
    x, y = np.clip(local - first, 0.0, 1.0).T
    base = first[:, 0] * nodes.counts[1] + first[:, 1]
    corner = base[:, None] + np.array([0, 1, nodes.counts[1], nodes.counts[1] + 1])
    return corner, np.column_stack([(1 - x) * (1 - y), (1 - x) * y, x * (1 - y), x * y])


def film_supply(stage: Stage, jet: Jet, run_off: RunOff, film: Film, until_s: Scalars) -> NDArray[np.float32]:
    """Add up what the film of a stage supplies to the nodes of its side of the board.

    Args:
        stage: Its samples.
        jet: ``jet_of`` the stage; a liquid.
        run_off: Of the side that the stage sprays.
        film: The film's numbers.
        until_s: (b,) ends of the blocks of time in which it is added up, ascending, from the program's beginning.

    Returns:
        (b, nodes) mm.
    """
    samples, nodes = stage.samples, run_off.nodes
    block = np.minimum(np.searchsorted(until_s, samples.times), len(until_s) - 1)
    found = np.zeros((len(until_s), *nodes.counts))
    flow_mm3_s = jet.flow_m3_s * 1e9
    facing = 1.0 if run_off.side == "top" else -1.0
    poses = (np.ascontiguousarray(samples.tcp), np.ascontiguousarray(samples.axes), flow_mm3_s * samples.seconds)
    grid = (nodes.corner, nodes.axes, nodes.steps_mm, nodes.on_board)
    across = nodes.counts[1]
    room = (np.empty(across), np.empty(across), np.empty(across), np.empty(across))
    surface = (run_off.surface_z_mm, facing)
    _supply(rim_of(jet, film), poses, block.astype(np.int64), surface, (*grid, room), found)
    return found.reshape(len(until_s), -1).astype(np.float32)


@quick
def _supply(
    rim: Rim,
    poses: tuple[Points, NDArray[np.float64], Scalars],
    block: Indices,
    surface: tuple[float, float],
    grid: tuple[Points2, NDArray[np.float64], Scalars, NDArray[np.bool_], tuple[Scalars, Scalars, Scalars, Scalars]],
    found: NDArray[np.float64],
) -> None:
    """Add to (b, nx, ny) what each sample supplies, mm; the grid has room for four numbers of each node along y."""
    tcp, turns, volumes = poses
    corner, axes, steps, on_board, room = grid
    z_mm, side = surface
    for at in range(len(tcp)):
        turn = turns[at]
        facing, height = -turn[2, 2] * side, (tcp[at, 2] - z_mm) * side
        if facing <= 0.0 or height <= 0.0:
            continue
        standoff = height / facing
        x, y = tcp[at, 0] + standoff * turn[0, 2] - corner[0], tcp[at, 1] + standoff * turn[1, 2] - corner[1]
        # The pole in the frame of the grid, and the nodes that may be within reach.
        pole_x, pole_y = axes[0, 0] * x + axes[0, 1] * y, axes[1, 0] * x + axes[1, 1] * y
        reach = min(REACH * farthest(rim, standoff, facing), 1e6)
        first_x, last_x = _range(pole_x, reach, steps[0], on_board.shape[0])
        first_y, last_y = _range(pole_y, reach, steps[1], on_board.shape[1])
        count = max(0, last_y - first_y)
        ways, film = (room[0][:count], room[1][:count]), (room[2][:count], room[3][:count])
        for i in range(first_x, last_x):
            x = i * steps[0] - pole_x
            for j in range(count):
                y = (first_y + j) * steps[1] - pole_y
                ways[0][j], ways[1][j] = axes[0, 0] * x + axes[1, 0] * y, axes[0, 1] * x + axes[1, 1] * y
            film_around(rim, turn, (standoff, facing), ways, film)
            for j in range(count):
                y, far = (first_y + j) * steps[1] - pole_y, film[0][j]
                away = math.sqrt(x * x + y * y)
                if away > reach or away < 1e-9 or away > REACH * far:
                    continue
                # What comes from beyond the rim of the board is none.
                share = far / away
                begin_x, begin_y = round((pole_x + share * x) / steps[0]), round((pole_y + share * y) / steps[1])
                if not (0 <= begin_x < on_board.shape[0] and 0 <= begin_y < on_board.shape[1]):
                    continue
                if on_board[begin_x, begin_y]:
                    found[block[at], i, first_y + j] += volumes[at] * abs(film[1][j]) / away


@quick
def _range(middle: float, reach: float, step: float, count: int) -> tuple[int, int]:
    """First and last + 1 of the nodes that are no farther than ``reach``."""
    return max(0, math.ceil((middle - reach) / step)), min(count, math.floor((middle + reach) / step) + 1)
