"""What the configurations of a robot reach at a placement, as tables and words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from reports.tables.table import Cell, Facts, Table
from reports.tables.wording import amount
from robotcell.placement.configurations import SHARES, ConfigurationValues, FailingPoint, PlacementDetails
from robotcell.placement.criteria import Criterion
from robotcell.placement.reachability import Metric

if TYPE_CHECKING:
    from robotcell.placement.placement_map import PlacementMap

METRICS: dict[Metric, str] = {
    "manipulability": "manipulability w",
    "condition": "inverse condition",
    "limits": "distance from limits",
    "clearance": "clearance",
}
CRITERIA: dict[Criterion, str] = {"least": "the least", "mean": "the mean", "p5": "the 5th percentile"}
_MOST_FAILING = 12


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
        used = each.branch in details.score.branches
        numbers = (each.score.least, each.score.mean) if each.reached == 1.0 else _of_reached(each)
        rows.append((
            each.name, "used" if used else "", f"{each.reached:.0%}",
            *(value_text(value, metric) for value in (*numbers, *each.box.tolist())),
        ))  # fmt: skip
    headings = (">reached", ">least", ">mean", *(f">p{100 * share:g}" for share in SHARES))
    return Table.of(("configuration", "", *headings), rows)


def _of_reached(each: ConfigurationValues) -> tuple[float, float]:
    there = np.isfinite(each.values)
    if not there.any():
        return np.nan, np.nan
    weight = each.weight[there]
    return float(each.values[there].min()), float(each.values[there] @ weight / weight.sum())


def failing_table(details: PlacementDetails) -> Table:
    """List the points that keep a placement from being feasible, with how much is missing."""
    shown = details.failing[:_MOST_FAILING]
    return Table.of(
        (">point", ">x", ">y", ">z", "configuration", "what is missing"), [_failing(details, x) for x in shown]
    )


def _failing(details: PlacementDetails, each: FailingPoint) -> tuple[str, ...]:
    at = 1e3 * details.targets.T_board_tcp[each.target, :3, 3]
    return (str(each.target), *(f"{value:.1f}" for value in at), _name(details, each.branch), _missing(details, each))


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
    at = ", ".join(f"{value:.1f}" for value in 1e3 * details.targets.T_board_tcp[worst, :3, 3])
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
        feasible = mapped.score.value >= 0.0
        facts.append(
            ("best node", f"{node}: {value_text(mapped.score.value, goal.metric) if feasible else 'infeasible'}")
        )
        if mapped.refined is not None and mapped.refined_at is not None:
            facts.append(
                ("refined", f"{node_words(*mapped.refined_at)}: {value_text(mapped.refined.value, goal.metric)}")
            )
    return facts


def node_words(x: float, y: float, yaw: float) -> str:
    """Place of a node of a map, m and rad, in words."""
    return f"x {1e3 * x:.0f}, y {1e3 * y:.0f} mm, yaw {math.degrees(yaw):.0f} deg"


def _name(details: PlacementDetails, branch: int) -> str:
    names = [each.name for each in details.configurations if each.branch == branch]
    return names[0] if names else f"configuration {branch + 1}"
