"""Result of a study on the terminal."""

from collections.abc import Sequence

from rich.console import Console

from reports.tables.table import Table
from reports.tables.wording import amount, clock
from reports.terminal.console import print_line, print_table
from studies.planned_study import PlannedStudy
from studies.results.summary import CaseSummary, Level, Summary

CAVEAT = "It is a prediction for comparing recipes, no proof of cleanliness."
_MOST_FRONT = 5
_FRONT = ("case", "recipe", "values", ">time", ">litres", ">clean", ">all clean", "least often clean")
_EFFECTS = ("main effects", "level", ">runs", ">time", ">litres", ">clean")


def print_study(console: Console, planned: PlannedStudy, summary: Summary, computed: int) -> None:
    """Print the Pareto front of each board, and the main effects."""
    failed = f"; {amount(summary.failed, 'run')} ended in an error, see the table" if summary.failed else ""
    print_line(
        console,
        (planned.study.study, "bold"),
        f": {amount(len(summary.cases), 'combination')}, {amount(computed, 'job')} computed now{failed}",
    )
    print_line(console, (CAVEAT, "dim"))
    for board, front in summary.fronts.items():
        if front:
            print_table(console, front_table(planned, front[:_MOST_FRONT], f"{board}: Pareto front"))
        if len(front) > _MOST_FRONT:
            print_line(console, (f"and {len(front) - _MOST_FRONT} more on the front of {board}, in the table", "dim"))
    if summary.effects:
        print_table(console, effects_rows(summary.effects))


def front_table(planned: PlannedStudy, front: Sequence[CaseSummary], title: str = "") -> Table:
    """List combinations of a Pareto front: values, time, liquid, clean components, how they bear the tolerances."""
    rows: list[tuple[str, ...]] = []
    for each in front:
        case, result = each.planned.case, each.planned.result
        values = ", ".join(f"{path[-1]} {value}" for path, value in zip(planned.paths, case.point, strict=True))
        weakest = min(each.shares, key=lambda share: share.share, default=None)
        rarest = ""
        if weakest is not None:
            low, high = weakest.interval
            rarest = f"{weakest.component} {weakest.share:.0%} ({low:.0%} to {high:.0%})"
        rows.append((
            str(case.number),
            case.recipe.name,
            values,
            clock(result.seconds),
            f"{result.litres:.2f}",
            f"{each.planned.clean} of {each.planned.components}",
            f"{each.all_clean} of {each.samples}" if each.samples else "",
            rarest,
        ))  # fmt: skip
    return Table.of(_FRONT, rows, title)


def effects_rows(levels: Sequence[Level]) -> Table:
    """List main effects, the name of each factor once."""
    rows: list[tuple[str, ...]] = []
    before = ""
    for each in levels:
        name = each.factor if each.factor != before else ""
        before = each.factor
        rows.append((
            name,
            each.level,
            str(each.runs),
            f"{each.seconds_effect:+.1f} s",
            f"{each.litres_effect:+.2f}",
            f"{each.clean_pct_effect:+.1f} %",
        ))  # fmt: skip
    return Table.of(_EFFECTS, rows)
