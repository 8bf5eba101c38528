"""A board made ready for analysis: what depends on no program, so that it serves for many."""

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase
from functools import partial
from itertools import product

from boards.board import Board, Component, Side
from boards.undersides.underside import GapCase, Joint, Underside, undersides_of
from cleaning.film.run_off import RunOff, run_off_of
from cleaning.gap.edge_segments import Edges, build_edges
from cleaning.gap.flow_field import GapField, solve_gap
from cleaning.parameters.model import Parameters, PartOverride
from cleaning.surface.facets import Facets, build_facets, build_scene
from cleaning.verdicts.exposed_area import cells_of_each, cells_of_side
from geometry.arrays import Indices
from geometry.rays import RayScene, cast
from specs.progress import Progress

_MM = 1e-3
_NOTHING = PartOverride(match=["*"])


@dataclass(frozen=True, slots=True, eq=False)
class PreparedBoard:
    """One board with what is known of its parts, and the parameters of the model."""

    board: Board
    parameters: Parameters
    scene: RayScene
    facets: Facets
    cells: tuple[Indices, ...]
    """Per component the cells that it has on its own side."""
    overrides: tuple[PartOverride, ...]
    """One per component; empty where nothing special is known."""
    undersides: tuple[Underside, ...]
    """Of the components that have a thin gap, in the board's order."""
    rows: tuple[int, ...]
    """(undersides,) index of the component of each."""
    edges: Edges
    """Row i belongs to underside i."""
    run_off: Mapping[Side, RunOff]
    """How film and run-off of tops spread over the cells of each side."""
    fields: tuple[tuple[GapField, ...], ...]
    """Per underside one per case."""
    tanks_g_m3: tuple[float, ...] = ()
    """What each rinse tank of the parameters carries when the board comes; left out, what they settle at."""


def prepare(board: Board, parameters: Parameters, progress: Progress) -> PreparedBoard:
    """Cut the surface into facets, find the gaps, and solve the flow in each kind of gap once."""
    progress("cutting the surface", 0.0)
    scene = build_scene(board)
    facets = build_facets(board, scene)
    progress("solving the gaps", 0.7)

    def known_of(component: Component) -> PartOverride:
        names = (component.name, component.package)
        found = (each for each in parameters.parts if any(fnmatchcase(*pair) for pair in product(names, each.match)))
        return next(found, _NOTHING)

    overrides = tuple(map(known_of, board.components))
    index = {component.name: row for row, component in enumerate(board.components)}
    stated = {name: overrides[row].standoff_um for name, row in index.items()}
    known_mm = {name: (_MM * both[0], _MM * both[1]) for name, both in stated.items() if both is not None}
    undersides = undersides_of(board, known_mm)
    solved: dict[tuple[float, float, GapCase], GapField] = {}
    cells = parameters.gap.cells
    fields = tuple(tuple(_field(each, case, cells, solved) for case in each.cases) for each in undersides)
    edges = build_edges(undersides, board, partial(cast, scene))
    sides: tuple[Side, ...] = ("top", "bottom")
    progress("done", 1.0)
    return PreparedBoard(
        board=board,
        parameters=parameters,
        scene=scene,
        facets=facets,
        cells=cells_of_each(facets, board),
        overrides=overrides,
        undersides=undersides,
        rows=tuple(index[each.component] for each in undersides),
        edges=edges,
        run_off={
            side: run_off_of(side, board, facets, cells_of_side(facets, board, side), edges, parameters.film)
            for side in sides
        },
        fields=fields,
    )


def _field(
    underside: Underside, case: GapCase, cells: int, solved: dict[tuple[float, float, GapCase], GapField]
) -> GapField:
    """Solve a gap, or take the result of one like it: to a micrometre it is the same package."""
    joints: list[Joint] = []
    for joint in case.joints:
        numbers = (joint.x_mm, joint.y_mm, joint.length_mm, joint.width_mm)
        x, y, length, width = (round(number, 3) + 0.0 for number in numbers)
        joints.append(Joint(x, y, length, width, joint.round, round(joint.turn_rad, 4) + 0.0))
    length, width, rounded = (round(underside.length_mm, 3), round(underside.width_mm, 3), round(case.gap_height_mm, 5))
    key = (length, width, GapCase(rounded, tuple(joints)))
    if key not in solved:
        solved[key] = solve_gap(_MM * length, _MM * width, _MM * rounded, joints, cells)
    return solved[key]
