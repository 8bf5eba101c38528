"""Where a board is held now, and where it is held best, as a person wants to read it in a terminal."""

import math

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from reports.tables.summary import amount, clock, print_findings
from robotcell.placement.optimise import Placement, PlacementGoal
from robotcell.placement.reachability import Metric
from robotcell.search_placement import PlacementTrial, Relocation, format_place, place_of

_WORDS: dict[Metric, str] = {
    "manipulability": "manipulability w",
    "condition": "inverse condition",
    "limits": "distance from limits",
    "clearance": "clearance",
}


def print_relocation(console: Console, found: Relocation, goal: PlacementGoal) -> None:
    """Head line, a row for each place that was checked, what was found at the best, and its YAML."""
    report, best = found.present.report, found.best
    origin = report.requested.origin
    console.print(
        f"[bold]{escape(origin.board)}[/bold] with [bold]{escape(origin.recipe)}[/bold] in "
        f"[bold]{escape(report.cell.name)}[/bold] ({escape(report.cell.robot.name)}): "
        f"{_WORDS[goal.metric]}, {amount(found.evaluated, 'place')} looked at"
    )
    console.print(_table(found, goal))
    if best is not None:
        print_findings(console, best.report.findings)
        if report.cell.fixtures:
            console.print(
                "Fixtures stay where they are: a holder that goes with the board has to be moved, then check."
            )
        console.print(format_place(place_of(best.placement.T_cell_board)), markup=False, soft_wrap=True, end="")
    elif found.present.stopped_by:
        print_findings(console, (found.tried[-1] if found.tried else found.present).report.findings)
        console.print("No place was found where the robot can do the program.")
    else:
        console.print("No better place was found: the board stays where it is.")


def _table(found: Relocation, goal: PlacementGoal) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("")
    for heading in ("least", "mean", "radius", "turned", "x", "y", "z", "yaw", "the robot takes"):
        table.add_column(heading, justify="right", no_wrap=True)
    rows = [("as it is", found.present)]
    rows += [("best" if each is found.best else "refused", each) for each in found.tried]
    for name, trial in rows:
        place = place_of(trial.placement.T_cell_board)
        table.add_row(
            name,
            *_values(trial.placement, goal.metric),
            f"{1e3 * trial.placement.distance:.0f} mm",
            f"{math.degrees(trial.placement.yaw):.1f} deg",
            *(f"{value:.1f}" for value in place.xyz_mm),
            f"{place.rpy_deg[2]:.2f} deg",
            _takes(trial),
        )
    return table


def _values(placement: Placement, metric: Metric) -> tuple[str, str]:
    """Give the least and the mean; how many points are reached where it is not all."""
    if not math.isfinite(placement.least):
        return f"{2.0 + placement.value:.0%} reached", ""
    match metric:
        case "limits":
            return f"{placement.least:.1%}", f"{placement.mean:.1%}"
        case "clearance":
            return f"{1e3 * placement.least:.1f} mm", f"{1e3 * placement.mean:.1f} mm"
        case "manipulability" | "condition":
            return f"{placement.least:.4f}", f"{placement.mean:.4f}"


def _takes(trial: PlacementTrial) -> str:
    if trial.stopped_by:
        return f"refused: {', '.join(trial.stopped_by)}"
    return clock(trial.report.program.totals.duration_s)
