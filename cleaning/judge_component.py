"""One component, or the bare board, after all stages: gap, exposed surface, judgements."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from boards.board import Side
from boards.undersides.underside import Underside
from cleaning.exposure.exact import occluder, samples_in_sight
from cleaning.exposure.exposure import Exposure
from cleaning.film.edge_pressure import edge_pressures, pressing_samples
from cleaning.gap.edge_segments import EdgePressure
from cleaning.gap.flow_field import GapField
from cleaning.jet.jet import Jet
from cleaning.parameters.model import Parameters, PartOverride
from cleaning.prepared_board import PreparedBoard
from cleaning.process.stages import Stage
from cleaning.threads import map_in_threads
from cleaning.undersides.residue import GapResult
from cleaning.undersides.sensitivity import FLOOR, Pressures, elasticity, limiting, variants, vary
from cleaning.undersides.washing import residue_left, simulate_gap
from cleaning.verdicts.component_rules import judge_part
from cleaning.verdicts.exposed_area import BARE, cells_beyond, cells_of, exposed_part, together
from cleaning.verdicts.results import Evidence, Part, Reach
from geometry.arrays import Indices
from geometry.disc_grid import DiscGrid
from recipes.classes import ComponentMasks
from recipes.recipe import Use
from specs.progress import Progress
from specs.source import NO_SOURCE, Source

_MOST_MAKERS = 12
_LIQUIDS: tuple[Use, ...] = ("wash", "rinse")
_ALL = PartOverride(match=["*"])


@dataclass(frozen=True, slots=True, eq=False)
class Sprayed:
    """One stage and what it leaves."""

    stage: Stage
    jet: Jet
    exposure: Exposure


@dataclass(frozen=True, slots=True, eq=False)
class UndersideResult:
    """The gap of one component after all stages."""

    underside: Underside
    gaps: tuple[GapResult, ...]
    elasticity: Mapping[str, float]


def gaps_of(
    prepared: PreparedBoard, sprayed: Sequence[Sprayed], progress: Progress, *, sensitivity: bool = True
) -> dict[int, UndersideResult]:
    """Follow the residue under each component with a gap, by the component's index; with elasticities or without."""
    found: dict[int, UndersideResult] = {}
    if not prepared.rows:
        return found
    stages, jets = [each.stage for each in sprayed], [each.jet for each in sprayed]
    varied, near = vary(stages, jets, prepared.edges, prepared.parameters), _near(prepared, sprayed)

    def follow(row: int) -> UndersideResult:
        """Follow one gap in all its cases; what limits it is worked out for the harder one."""
        underside, pressures = prepared.undersides[row], _pressures(prepared, row, sprayed, near)
        cases = range(len(underside.cases))
        gaps = tuple(simulate_gap(*_gap(prepared, row, case, (stages, pressures))) for case in cases)
        elasticities: dict[str, float] = {}
        if sensitivity and gaps[0].residue > FLOOR:
            for name, changed in variants(varied, pressures, prepared.edges.only(row), prepared.parameters).items():
                elasticities[name] = elasticity(gaps[0].residue, residue_left(*_gap(prepared, row, 0, changed)))
        return UndersideResult(underside, gaps, elasticities)

    rows = range(len(prepared.rows))
    for row, underside in enumerate(map_in_threads(follow, rows)):
        progress("flushing under parts", row / len(rows))
        found[prepared.rows[row]] = underside
    return found


def pressures_of(prepared: PreparedBoard, sprayed: Sequence[Sprayed]) -> tuple[Pressures, ...]:
    """Find the pressures on the edges of each underside, for ``gaps_under``: one list per underside."""
    near = _near(prepared, sprayed)
    return tuple(_pressures(prepared, row, sprayed, near) for row in range(len(prepared.rows)))


def _near(prepared: PreparedBoard, sprayed: Sequence[Sprayed]) -> tuple[DiscGrid, ...]:
    """Sort the samples of each stage by the edges that they may press on."""
    edges, film = prepared.edges, prepared.parameters.film
    return tuple(pressing_samples(each.stage, each.jet, edges, film) for each in sprayed)


def _pressures(
    prepared: PreparedBoard, row: int, sprayed: Sequence[Sprayed], near: Sequence[DiscGrid]
) -> list[list[EdgePressure]]:
    """Find the pressures on the edges of one underside, one list per stage."""
    edges, film = prepared.edges.only(row), prepared.parameters.film
    return [edge_pressures(each.stage, each.jet, edges, film, grid) for each, grid in zip(sprayed, near, strict=True)]


def gaps_under(
    prepared: PreparedBoard, stages: Sequence[Stage], pressures: Sequence[Pressures]
) -> list[tuple[GapResult, ...]]:
    """Follow every gap in all its cases under known pressures; one result per underside."""
    gaps: list[tuple[GapResult, ...]] = []
    for row, pressed in enumerate(pressures):
        cases = range(len(prepared.undersides[row].cases))
        gaps.append(tuple(simulate_gap(*_gap(prepared, row, case, (stages, pressed))) for case in cases))
    return gaps


_GapInputs: TypeAlias = tuple[GapField, float, Sequence[Stage], Sequence[EdgePressure | None], Parameters, float | None]
"""Arguments of ``simulate_gap`` and ``residue_left``."""


def _gap(prepared: PreparedBoard, row: int, case: int, process: tuple[Sequence[Stage], Pressures]) -> _GapInputs:
    """What acts on one gap in one case; stages that spray the other side do not."""
    stages, pressures = process
    component = prepared.rows[row]
    side = prepared.board.components[component].side
    acting: list[EdgePressure | None] = [
        pressed[0] if stage.side == side else None for stage, pressed in zip(stages, pressures, strict=True)
    ]
    gap_height_mm = prepared.undersides[row].cases[case].gap_height_mm
    factor = prepared.overrides[component].paste_factor
    return prepared.fields[row][case], gap_height_mm, stages, acting, prepared.parameters, factor


@dataclass(frozen=True, slots=True, eq=False)
class Spraying:
    """All stages, and what those of one use leave on a side together; it serves the judgement of every component."""

    sprayed: tuple[Sprayed, ...]
    groups: Mapping[tuple[Use, Side], tuple[tuple[Sprayed, ...], Exposure]]
    """Stages of liquids by use and side, and what they leave together."""
    in_sight: tuple[DiscGrid | None, ...]
    """``samples_in_sight`` of each stage of liquid."""


def spraying_of(prepared: PreparedBoard, sprayed: Sequence[Sprayed]) -> Spraying:
    """Put the stages of each use and side together."""
    groups: dict[tuple[Use, Side], list[Sprayed]] = {}
    for each in sprayed:
        if each.stage.use in _LIQUIDS:
            groups.setdefault((each.stage.use, each.stage.side), []).append(each)
    return Spraying(
        sprayed=tuple(sprayed),
        groups={key: (tuple(some), together([each.exposure for each in some])) for key, some in groups.items()},
        in_sight=tuple(
            None if each.stage.use == "dry" else samples_in_sight(each.stage, each.jet, prepared.facets.cell_centres)
            for each in sprayed
        ),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Surface:
    name: str
    row: int
    """Of the component in the board, or ``BARE``."""
    side: Side
    place: tuple[float, float, float]
    cells: dict[Side, Indices]
    """Of each side on which it is judged."""
    override: PartOverride
    avoided: bool = False


def component_part(
    row: int, prepared: PreparedBoard, spraying: Spraying, underside: UndersideResult | None, masks: ComponentMasks
) -> Part:
    """Judge component ``row`` of the board."""
    component = prepared.board.components[row]
    middle = component.outline.centroid
    side = component.side
    place = (middle.x, middle.y, prepared.board.surface_z_mm(side))
    cells: dict[Side, Indices] = {side: prepared.cells[row]}
    avoided = component.name in dict(masks.avoided)
    surface = _Surface(component.name, row, side, place, cells, prepared.overrides[row], avoided)
    return _part(surface, prepared, spraying, underside)


def bare_part(prepared: PreparedBoard, spraying: Spraying, masks: ComponentMasks) -> Part:
    """Judge the bare board on all sides that are sprayed, but within the margins of what masks avoid."""
    board = prepared.board
    sides: dict[Side, None] = dict.fromkeys(each.stage.side for each in spraying.sprayed)
    margins = dict(masks.avoided)
    cells: dict[Side, Indices] = {
        side: cells_beyond(cells_of(prepared.facets, board, BARE, side), prepared.facets, board, side, margins)
        for side in sides
    }
    middle = board.outline.centroid
    surface = _Surface("board", BARE, "top", (middle.x, middle.y, board.top_z_mm), cells, _ALL)
    return _part(surface, prepared, spraying, None)


def _part(surface: _Surface, prepared: PreparedBoard, spraying: Spraying, underside: UndersideResult | None) -> Part:
    acting = [surface.cells.get(each.stage.side) for each in spraying.sprayed]
    exposed = tuple(
        None if cells is None else exposed_part(each.exposure, prepared.facets, cells)
        for each, cells in zip(spraying.sprayed, acting, strict=True)
    )
    reached: list[Reach] = []
    for use in _LIQUIDS:
        for side, cells in surface.cells.items():
            if (use, side) in spraying.groups:
                group, exposure = spraying.groups[use, side]
                alone = len(group) == 1
                own = exposed[spraying.sprayed.index(group[0])] if alone else None
                names = " and ".join(dict.fromkeys(each.stage.function for each in group))
                made_by = group[0].stage.made_by if alone else NO_SOURCE
                repeats = min(each.stage.repeats for each in group)
                reached.append(
                    Reach(use, names, made_by, repeats, own or exposed_part(exposure, prepared.facets, cells))
                )
    evidence = Evidence(
        component=surface.name,
        side=surface.side,
        place=surface.place,
        stages=tuple(each.stage for each in spraying.sprayed),
        exposed=exposed,
        reached=reached,
        underside=None if underside is None else underside.underside,
        gaps=() if underside is None else underside.gaps,
        override=surface.override,
        occluder=_occluder(surface, prepared, spraying),
        parameters=prepared.parameters,
        avoided=surface.avoided,
    )
    judgements = judge_part(evidence)
    elasticities = {} if underside is None else dict(underside.elasticity)
    return Part(
        component=surface.name,
        verdict=judgements[0].verdict,
        grade=judgements[0].grade,
        judgements=judgements,
        exposed=exposed,
        underside=evidence.underside,
        gaps=tuple(evidence.gaps),
        elasticity=elasticities,
        limiting=limiting(elasticities),
        makers=_makers(surface.row, spraying.sprayed),
        reached=tuple(reached),
    )


def _occluder(surface: _Surface, prepared: PreparedBoard, spraying: Spraying) -> str:
    """Name what stands before the cells that a stage of liquid misses, the first that misses any; else nothing."""
    for each, in_sight in zip(spraying.sprayed, spraying.in_sight, strict=True):
        cells = surface.cells.get(each.stage.side)
        if in_sight is None or cells is None:
            continue
        missed = cells[prepared.facets.cell_exposed[cells] & (each.exposure.cone_s[cells] <= 0)]
        if len(missed):
            body = occluder(missed, each.stage, each.jet, prepared.facets, prepared.scene, in_sight)
            return "" if body < 0 else prepared.board.bodies[body].name
    return ""


def _makers(row: int, sprayed: Sequence[Sprayed]) -> tuple[tuple[Source, float], ...]:
    """Who sprays the surface, with the share of the volume on it that each gives."""
    volumes: dict[Source, float] = {}
    for each in sprayed:
        given = each.exposure.by_maker_mm3
        entries = slice(given.indptr[:-1][row], given.indptr[1:][row])  # the last row is the bare board's
        for index, volume in sorted(zip(given.indices[entries].tolist(), given.data[entries].tolist(), strict=True)):
            maker = each.stage.samples.makers[index]
            volumes[maker] = volumes.get(maker, 0.0) + volume
    total = sum(volumes.values())
    most = sorted(volumes, key=lambda maker: -volumes[maker])[:_MOST_MAKERS]
    return tuple((maker, volumes[maker] / total) for maker in most)
