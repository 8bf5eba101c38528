"""The gaps of all components through all stages, and what limits each."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from cleaning.film.edge_pressure import edge_pressures
from cleaning.gap.edge_segments import EdgePressure, Edges
from cleaning.judge_component import Sprayed, UndersideResult
from cleaning.prepared_board import PreparedBoard
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult
from cleaning.undersides.sensitivity import FLOOR, Pressures, elasticity, variants
from cleaning.undersides.washing import simulate_gap
from specs.progress import Progress

_THREADS = 2
"""Gaps do not know each other, and their loops let other threads run."""


def gaps_of(prepared: PreparedBoard, sprayed: Sequence[Sprayed], progress: Progress) -> dict[int, UndersideResult]:
    """Follow the residue under each component with a gap, by the component's index."""
    found: dict[int, UndersideResult] = {}
    with ThreadPoolExecutor(_THREADS) as threads:
        rows = range(len(prepared.rows))
        for row, beneath in enumerate(threads.map(partial(_beneath, prepared, sprayed), rows)):
            progress("flushing under parts", row / len(rows))
            found[prepared.rows[row]] = beneath
    return found


def _beneath(prepared: PreparedBoard, sprayed: Sequence[Sprayed], row: int) -> UndersideResult:
    """Follow one gap in all its cases; what limits it is worked out for the harder one."""
    parameters, underside = prepared.parameters, prepared.undersides[row]
    edges = _only(prepared.edges, row)
    stages = tuple(each.stage for each in sprayed)
    pressures = [edge_pressures(each.stage, each.jet, edges, parameters.film) for each in sprayed]
    gaps = tuple(_gap(prepared, sprayed, row, case, (stages, pressures)) for case in range(len(underside.cases)))
    elasticities: Mapping[str, float] = {}
    if gaps[0].residue > FLOOR:
        changed = variants(stages, [each.jet for each in sprayed], pressures, edges, parameters)
        after = {name: _gap(prepared, sprayed, row, 0, each).residue for name, each in changed.items()}
        elasticities = {name: elasticity(gaps[0].residue, residue) for name, residue in after.items()}
    return UndersideResult(underside, gaps, elasticities)


def _gap(
    prepared: PreparedBoard, sprayed: Sequence[Sprayed], row: int, case: int, process: tuple[Sequence[Stage], Pressures]
) -> GapResult:
    """Follow one gap in one case; stages that spray the other side do not act on it."""
    stages, pressures = process
    component = prepared.rows[row]
    side = prepared.board.components[component].side
    acting: list[EdgePressure | None] = [
        pressed[0] if each.stage.side == side else None for each, pressed in zip(sprayed, pressures, strict=True)
    ]
    gap_height_mm = prepared.undersides[row].cases[case].gap_height_mm
    factor = prepared.overrides[component].paste_factor
    return simulate_gap(prepared.fields[row][case], gap_height_mm, stages, acting, prepared.parameters, factor)


def _only(edges: Edges, row: int) -> Edges:
    """One row of the edges."""
    some = np.array([row])
    return replace(
        edges,
        component=edges.component[some],
        middles=edges.middles[some],
        outward=edges.outward[some],
        heights_mm=edges.heights_mm[some],
        sheltered=edges.sheltered[some],
        facing=edges.facing[some],
    )
