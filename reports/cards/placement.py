"""What the configurations of a robot reach at a placement, and the best place of a board or a part."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reports.cards.robot import cell_title
from reports.tables.table import Block, Card, Cell, FactList, Facts, FindingList, Table, Text, Verbatim, capital
from reports.tables.wording import amount, clock
from robotcell.cell.cell_edits import format_place
from robotcell.placement.configurations import SHARES, ConfigurationValues, FailingPoint, PlacementDetails
from robotcell.placement.evaluate import Criterion, PlacementGoal
from robotcell.placement.optimise import Placement
from robotcell.placement.reachability import Metric

if TYPE_CHECKING:
    from robotcell.placement.placement_map import PlacementMap
    from robotcell.search_placement import Relocation

METRICS: dict[Metric, str] = {
    "manipulability": "manipulability w",
    "condition": "inverse condition",
    "limits": "distance from limits",
    "clearance": "clearance",
}
CRITERIA: dict[Criterion, str] = {"least": "the least", "mean": "the mean", "p5": "the 5th percentile"}
_MOST_FAILING = 12
_SMALL = 0.001
_PLACE = ("", ">least", ">mean", ">radius", ">turned")


def value_text(value: float, metric: Metric) -> str:
    """Write a value of a metric; a dash where there is none."""
    if not math.isfinite(value):
        return "-"
    match metric:
        case "limits":
            return f"{value:.1%}"
        case "clearance":
            return f"{1e3 * value:.1f} mm"
        case "manipulability" | "condition":
            return f"{value:.4f}"


def configuration_table(details: PlacementDetails) -> Table:
    """List what each configuration reaches, with the numbers of its box plot; those that are used are marked."""
    metric = details.goal.metric
    rows: list[tuple[Cell, ...]] = []
    for each in details.configurations:
        used, numbers = each.branch in details.score.branches, (each.score.least, each.score.mean)
        there = np.isfinite(each.values)
        if each.reached < 1.0:
            weights = each.weight[there]
            mean = float(each.values[there] @ weights / weights.sum()) if there.any() else np.nan
            numbers = least_reached(each), mean
        rows.append((
            each.name, "used" if used else "", f"{each.reached:.0%}",
            *(value_text(value, metric) for value in (*numbers, *each.box.tolist())),
        ))  # fmt: skip
    headings = (">reached", ">least", ">mean", *(f">p{100 * share:g}" for share in SHARES))
    return Table.of(("configuration", "", *headings), rows)


def least_reached(each: ConfigurationValues) -> float:
    """Least value of the points that a configuration reaches; NaN where it reaches none."""
    there = each.values[np.isfinite(each.values)]
    return float(there.min()) if len(there) else np.nan


def failing_table(details: PlacementDetails) -> Table:
    """List the points that keep a placement from being feasible, with how much is missing."""
    rows: list[tuple[str, ...]] = []
    for each in details.failing[:_MOST_FAILING]:
        at = (f"{value:z.1f}" for value in 1e3 * details.place_of(each.target)[0])
        rows.append((str(each.target), *at, _name(details, each.branch), _missing(details, each)))
    return Table.of((">point", ">x", ">y", ">z", "configuration", "what is missing"), rows)


def _missing(details: PlacementDetails, each: FailingPoint) -> str:
    if math.isfinite(each.value):
        metric = details.goal.metric
        floor = value_text(details.goal.floor, metric)
        return f"{value_text(each.value, metric)}, {value_text(each.missing, metric)} below the floor of {floor}"
    if not math.isfinite(each.missing):
        return "not reached"
    if each.missing == 0.0:
        return "within reach, but the arm or its tool collides there"
    if each.missing > 0.0:
        return f"not reached: {1e3 * each.missing:.0f} mm too far from the shoulder"
    return f"not reached: {-1e3 * each.missing:.0f} mm too near to the shoulder"


def worst_words(details: PlacementDetails) -> str:
    """Name the worst point: its place on the workpiece, its value, its configuration."""
    worst = details.worst
    point, on = details.place_of(worst)
    at = ", ".join(f"{value:z.1f}" for value in 1e3 * point)
    at = f"{f'{on}, ' if on else 'orifice '}{at}"
    value = value_text(float(details.values[worst]), details.goal.metric)
    if details.region[worst] < 0:
        return f"point {worst} at {at} mm: not reached"
    return f"point {worst} at {at} mm: {value}, {_name(details, int(details.region[worst]))}"


def placement_facts(details: PlacementDetails, mapped: PlacementMap | None) -> Facts:
    """Value of the criterion, the worst point, the regions of two configurations, what fails, the map's best node."""
    goal, score = details.goal, details.score
    value = f"{CRITERIA[goal.criterion]} of {METRICS[goal.metric]}"
    feasible = score.value >= 0.0
    missing = len(details.failing)
    stated = value_text(score.value, goal.metric) if feasible else f"infeasible, {amount(missing, 'point')} fail"
    facts = [(value, stated if missing != 1 or feasible else "infeasible, 1 point fails")]
    if not feasible and math.isfinite(score.least):
        facts.append(("best least", value_text(score.least, goal.metric)))
    facts.append(("worst", worst_words(details)))
    if len(score.branches) == 2:
        parts = [f"{_name(details, each)}: {np.mean(details.region == each):.0%}" for each in score.branches]
        facts.append(("regions", f"{'; '.join(parts)} of the points"))
    if mapped is not None:
        i, j, k = mapped.best
        node = node_words(float(mapped.x[i]), float(mapped.y[j]), float(mapped.yaw[k]))
        value = value_text(mapped.score.value, goal.metric) if mapped.score.value >= 0.0 else "infeasible"
        facts.append(("best node", f"{node}: {value}"))
        if mapped.refined is not None and mapped.refined_at is not None:
            value = value_text(mapped.refined.value, goal.metric)
            facts.append(("refined", f"{node_words(*mapped.refined_at)}: {value}"))
    return facts


def node_words(x: float, y: float, yaw: float) -> str:
    """Place of a node of a map, m and rad, in words."""
    return f"x {1e3 * x:z.0f}, y {1e3 * y:z.0f} mm, yaw {math.degrees(yaw):z.0f} deg"


def _name(details: PlacementDetails, branch: int) -> str:
    names = [each.name for each in details.configurations if each.branch == branch]
    return names[0] if names else f"configuration {branch + 1}"


def details_blocks(details: PlacementDetails, mapped: PlacementMap | None) -> tuple[Block, ...]:
    """What each configuration reaches at a placement, its worst point, and the points that fail."""
    failing = (failing_table(details), f"{amount(len(details.failing), 'point')} in all.") if details.failing else ()
    return configuration_table(details), FactList(placement_facts(details, mapped)), *failing


def relocation_card(found: Relocation, goal: PlacementGoal) -> Card:
    """Show a row for each place that was checked, what was found at the best, and its YAML."""
    best, present = found.best, found.present
    blocks: list[Block] = [result_words(found), _places(found, goal), *details_blocks(found.details, found.mapped)]
    if best is not None:
        blocks.append(FindingList(best.report.findings))
        if present.cell.fixtures:
            blocks.append(
                "Fixtures stay where they are: a holder that goes with the board has to be moved, then check."
            )
        blocks.append(Verbatim(format_place(best.held_at, best.cell.held_by)))
    elif present.stopped_by:
        blocks.append(FindingList((found.tried[-1] if found.tried else present).report.findings))
        blocks.append("No place was found where the robot can do the program.")
    else:
        blocks.append("No better place was found: the board stays where it is.")
    searched = f"{METRICS[goal.metric]}, {amount(found.evaluated, 'place')} looked at"
    return Card(cell_title(present.report, searched), tuple(blocks))


def part_relocation_card(workpiece: str, found: Relocation, standoff_mm: float) -> Card:
    """Show the values before and there, what each configuration reaches, and the place's YAML."""
    cell, goal, best = found.present.cell, found.details.goal, found.tried[-1].placement
    rows = [_place_row("as it is", found.present.placement, goal), _place_row("best", best, goal)]
    place = Verbatim(format_place(found.tried[-1].held_at, cell.held_by))
    return Card(
        (
            Text(workpiece, "strong"), " in ", Text(cell.name, "strong"), f" ({cell.robot.name}): ",
            f"{METRICS[goal.metric]} of {amount(len(found.details.targets.tool), 'point')}, orifice {standoff_mm:g} mm "
            f"from the surface, {amount(best.tried, 'place')} looked at",
        ),
        (
            result_words(found),
            Table.of(_PLACE, rows),
            *details_blocks(found.details, found.mapped),
            place if best.value >= 0.0 else "No place was found where the robot reaches all points well enough.",
        ),
    )  # fmt: skip


def result_words(found: Relocation) -> str:
    """State in a line where the workpiece goes, and how much better that is."""
    goal, before = found.details.goal, found.present.placement
    name = "worst" if goal.criterion == "least" else CRITERIA[goal.criterion].removeprefix("the ")
    what = f"{name} {METRICS[goal.metric]}"
    best = found.tried[-1] if found.tried and not found.tried[-1].stopped_by else None
    if best is None or (found.best is None and best.placement.value <= before.value):
        return f"It stays where it is: {what} {_brief(before, goal)}."
    after = best.placement
    nearer = 1e3 * (before.distance - after.distance)
    turned, around = math.degrees(after.yaw), math.degrees(after.direction)
    lifted = 1e3 * float((best.cell.T_cell_board - found.present.cell.T_cell_board)[2, 3])
    words = [
        f"{abs(nearer):.0f} mm {'nearer' if nearer > 0 else 'farther'}" if abs(nearer) >= 0.5 else "",
        f"turned {turned:.0f} deg" if abs(turned) >= 0.5 else "",
        f"carried {around:.0f} deg around the robot" if abs(around) >= 0.5 else "",
        f"{abs(lifted):.0f} mm {'higher' if lifted > 0 else 'lower'}" if abs(lifted) >= 0.5 else "",
    ]
    moved = ", ".join(word for word in words if word) or "Hardly moved"
    return f"{capital(moved)}: {what} {_brief(before, goal)} -> {_brief(after, goal)}."


def _brief(placement: Placement, goal: PlacementGoal) -> str:
    """Write the value of a placement, with enough digits where it is small."""
    if not math.isfinite(placement.least):
        return f"{2.0 + placement.value:.0%} reached"
    value = placement.value if placement.value >= 0.0 else placement.least
    if goal.metric in ("manipulability", "condition") and 0.0 < value < _SMALL:
        return f"{value:.5f}"
    return value_text(value, goal.metric)


def _places(found: Relocation, goal: PlacementGoal) -> Table:
    trials = [("as it is", found.present)]
    trials += [("best" if each is found.best else "refused", each) for each in found.tried]
    rows: list[tuple[str, ...]] = []
    for name, trial in trials:
        place, stopped = trial.held_at, f"refused: {', '.join(trial.stopped_by)}"
        rows.append((
            *_place_row(name, trial.placement, goal),
            *(f"{value:z.1f}" for value in place.xyz_mm),
            f"{place.rpy_deg[2]:z.2f} deg",
            stopped if trial.stopped_by else clock(trial.report.program.totals.duration_s),
        ))  # fmt: skip
    return Table.of((*_PLACE, ">x", ">y", ">z", ">yaw", ">the robot takes"), rows)


def _place_row(name: str, placement: Placement, goal: PlacementGoal) -> tuple[str, ...]:
    """Give the least and the mean, or the share of points that are reached where it is not all; distance and turn."""
    values = (f"{2.0 + placement.value:.0%} reached", "")
    if math.isfinite(placement.least):
        values = value_text(placement.least, goal.metric), value_text(placement.mean, goal.metric)
    return (name, *values, f"{1e3 * placement.distance:z.0f} mm", f"{math.degrees(placement.yaw):z.1f} deg")
