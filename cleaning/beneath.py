"""The gaps of all components through all stages, and what limits each."""

from collections.abc import Sequence

from cleaning.edges import EdgePressure
from cleaning.elasticity import Pressures, elasticity, variants
from cleaning.parts import Beneath, Sprayed, facing_up
from cleaning.pressure import edge_pressures
from cleaning.subject import Subject
from cleaning.washing import under_component
from geometry.progress import Progress


def gaps_of(subject: Subject, sprayed: Sequence[Sprayed], tell: Progress) -> dict[int, Beneath]:
    """Follow the residue under each component with a gap, by the component's index.

    What limits it is worked out for the harder of its cases.
    """
    parameters, stages = subject.parameters, tuple(each.stage for each in sprayed)
    tell("pressing at the edges", 0.0)
    pressures = [edge_pressures(each.stage, each.jet, subject.edges, parameters.film) for each in sprayed]
    changed = variants(stages, pressures, subject.edges, parameters)
    found: dict[int, Beneath] = {}
    for row, (component, underside) in enumerate(zip(subject.rows, subject.undersides, strict=True)):
        tell("flushing under parts", 0.3 + 0.7 * row / len(subject.rows))
        acts = [each.up == facing_up(subject.board.components[component]) for each in sprayed]
        factor = subject.overrides[component].paste_factor
        gaps = tuple(
            under_component(field, case.standoff_mm, stages, _row(pressures, acts, row), parameters, factor)
            for case, field in zip(underside.cases, subject.fields[row], strict=True)
        )
        standoff, field = underside.cases[0].standoff_mm, subject.fields[row][0]
        after = {
            name: under_component(field, standoff, others, _row(pressed, acts, row), parameters, factor).residue
            for name, (others, pressed) in changed.items()
        }
        elasticities = {name: elasticity(gaps[0].residue, residue) for name, residue in after.items()}
        found[component] = Beneath(underside, gaps, elasticities)
    return found


def _row(pressures: Pressures, acts: Sequence[bool], row: int) -> list[EdgePressure | None]:
    """Per stage the pressures on one underside; nothing of the stages that spray the other side."""
    return [stage[row] if act else None for stage, act in zip(pressures, acts, strict=True)]
