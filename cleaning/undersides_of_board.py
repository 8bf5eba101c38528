"""The gaps of all components through all stages, and what limits each."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from cleaning.film.edge_pressure import edge_pressures
from cleaning.gap.edge_segments import EdgePressure, Edges
from cleaning.judge_component import Beneath, Sprayed
from cleaning.prepared_board import Subject
from cleaning.process.stages import Stage
from cleaning.undersides.gap_result import GapResult
from cleaning.undersides.sensitivity import FLOOR, Pressures, elasticity, variants
from cleaning.undersides.washing import under_component
from specs.progress import Progress

_THREADS = 2
"""Gaps do not know each other, and their loops let other threads run."""


def gaps_of(subject: Subject, sprayed: Sequence[Sprayed], progress: Progress) -> dict[int, Beneath]:
    """Follow the residue under each component with a gap, by the component's index."""
    found: dict[int, Beneath] = {}
    with ThreadPoolExecutor(_THREADS) as threads:
        rows = range(len(subject.rows))
        for row, beneath in enumerate(threads.map(partial(_beneath, subject, sprayed), rows)):
            progress("flushing under parts", row / len(rows))
            found[subject.rows[row]] = beneath
    return found


def _beneath(subject: Subject, sprayed: Sequence[Sprayed], row: int) -> Beneath:
    """Follow one gap in all its cases; what limits it is worked out for the harder one."""
    parameters, underside = subject.parameters, subject.undersides[row]
    edges = _only(subject.edges, row)
    stages = tuple(each.stage for each in sprayed)
    pressures = [edge_pressures(each.stage, each.jet, edges, parameters.film) for each in sprayed]
    gaps = tuple(_gap(subject, sprayed, row, case, (stages, pressures)) for case in range(len(underside.cases)))
    elasticities: Mapping[str, float] = {}
    if gaps[0].residue > FLOOR:
        changed = variants(stages, [each.jet for each in sprayed], pressures, edges, parameters)
        after = {name: _gap(subject, sprayed, row, 0, each).residue for name, each in changed.items()}
        elasticities = {name: elasticity(gaps[0].residue, residue) for name, residue in after.items()}
    return Beneath(underside, gaps, elasticities)


def _gap(
    subject: Subject, sprayed: Sequence[Sprayed], row: int, case: int, process: tuple[Sequence[Stage], Pressures]
) -> GapResult:
    """Follow one gap in one case; stages that spray the other side do not act on it."""
    stages, pressures = process
    component = subject.rows[row]
    side = subject.board.components[component].side
    acting: list[EdgePressure | None] = [
        pressed[0] if each.stage.side == side else None for each, pressed in zip(sprayed, pressures, strict=True)
    ]
    gap_height_mm = subject.undersides[row].cases[case].gap_height_mm
    factor = subject.overrides[component].paste_factor
    return under_component(subject.fields[row][case], gap_height_mm, stages, acting, subject.parameters, factor)


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
