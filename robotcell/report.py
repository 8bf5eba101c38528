"""The check of a program in a cell, and a placement, as plain data for ``--report``. Millimetres and degrees."""

import numpy as np

from programs.program import MoveTo, TimedProgram, Totals
from robotcell.motion.retime import Rates, rates_of
from robotcell.placement.configurations import SHARES, ConfigurationValues, FailingPoint, PlacementDetails
from robotcell.placement.evaluate import Score
from robotcell.placement.placement_map import PlacementMap
from robotcell.robot.robot import Joint, Poses
from robotcell.track import CellReport
from specs.finding import finding_data
from specs.json import Json


def cell_report(report: CellReport) -> dict[str, Json]:
    """Collect totals, the use of every joint, singularity, distances, findings; the same report gives the same data."""
    origin = report.requested.origin
    data: dict[str, Json] = {
        "washboard_cell_report": 1,
        "board": {"name": origin.board, "sha256": origin.board_sha256},
        "recipe": {"name": origin.recipe, "sha256": origin.recipe_sha256},
        "cell": report.cell.name,
        "robot": report.cell.robot.name,
        "possible": report.possible,
        "requested": _totals(report.requested.totals),
        "findings": [finding_data(finding) for finding in report.findings],
    }
    if not report.possible:
        return data
    distances = report.clearance.distances
    nearest: dict[str, Json] = {}
    if len(distances):
        worst = report.clearance.nearest
        touch = report.clearance.touches[worst]
        nearest = {
            "least_mm": _known(distances[worst] * 1e3),
            "pair": None if touch is None else [touch.body, touch.other],
            "at": _moment(report.program, int(report.clearance_at[worst])),
            "looked_at": len(distances),
        }
    rates = rates_of(report.program, report.joints)
    motion: dict[str, Json] = {
        "done": _totals(report.program.totals),
        "added": {
            "from_home_s": _known(report.added.from_home),
            "tool_changes_s": _known(report.added.tool_changes),
            "to_home_s": _known(report.added.to_home),
        },
        "joints": [_joint_use(joint, rates, index) for index, joint in enumerate(report.cell.robot.joints)],
        "singularity": {
            "least_w": _known(report.singularity.min()),
            "mean_w": _known(report.singularity.mean()),
            "least_inverse_condition": _known(report.condition.min()),
            "at": _moment(report.program, int(np.argmin(report.condition))),
        },
        "clearance": nearest,
    }
    return data | motion


def _joint_use(joint: Joint, rates: Rates, index: int) -> dict[str, Json]:
    """Give the use of a joint and its limits; degrees where it turns, millimetres where it slides."""
    scale, unit, q = joint.unit.per_si, joint.unit.key, rates.q[:, index]
    return {
        "name": joint.name,
        f"lowest_{unit}": _known(scale * joint.lowest, 4),
        f"highest_{unit}": _known(scale * joint.highest, 4),
        f"from_{unit}": _known(scale * q.min()),
        f"to_{unit}": _known(scale * q.max()),
        f"greatest_speed_{unit}_s": _known(scale * np.abs(rates.speed[:, index]).max(initial=0.0)),
        f"speed_limit_{unit}_s": _known(scale * joint.speed),
        f"greatest_acceleration_{unit}_s2": _known(scale * np.abs(rates.acceleration[:, index]).max(initial=0.0)),
        f"acceleration_limit_{unit}_s2": _known(scale * joint.acceleration),
    }


def _moment(program: TimedProgram, number: int) -> dict[str, Json]:
    """Give when and where a move ends, and its recipe path."""
    move = [item for item in program.instructions if isinstance(item, MoveTo)][number]
    where: list[Json] = [round(value, 3) for value in move.position]
    return {"time_s": round(move.time_s, 4), "where": where, "made_by": str(move.made_by)}


def _totals(totals: Totals) -> dict[str, Json]:
    return {
        "duration_s": round(totals.duration_s, 4),
        "spray_s": round(totals.spray_s, 4),
        "travel_mm": round(totals.travel_mm, 3),
        "moves": totals.moves,
    }


def placement_report(details: PlacementDetails, mapped: PlacementMap | None, evaluated: int) -> dict[str, Json]:
    """Collect the value, the eight configurations, the worst point, what fails, the map; the same gives the same."""
    goal = details.goal
    data: dict[str, Json] = {
        "washboard_placement": 1,
        "cell": details.cell.name,
        "robot": details.cell.robot.name,
        "metric": goal.metric,
        "criterion": goal.criterion,
        "floor": goal.floor,
        "targets": len(details.targets.tool),
        "evaluated": evaluated,
        "feasible": details.score.value >= 0.0,
        "score": _score(details.score),
        "T_cell_board": _pose(details.cell.T_cell_board),
        "configurations": [_configuration(details, each) for each in details.configurations],
        "worst": _point(details, details.worst),
        "failing": [_failing(details, each) for each in details.failing],
    }
    if mapped is not None:
        place = mapped.refined
        data["map"] = {
            "x_mm": _digits(1e3 * mapped.x, 3),
            "y_mm": _digits(1e3 * mapped.y, 3),
            "yaw_deg": _digits(np.degrees(mapped.yaw), 3),
            "values": [[_digits(row) for row in rows] for rows in mapped.values],
            "best": list(mapped.best),
            "best_score": _score(mapped.score),
            "refined": place and {"T_cell_board": _pose(place.T_cell_board), "score": _score(place.score)},
        }
    return data


def _pose(T_cell_board: Poses) -> list[Json]:
    return [_digits(row, 9) for row in T_cell_board]


def _score(score: Score) -> dict[str, Json]:
    """Give a score; null where a point is not reached."""
    values: dict[str, Json] = {key: _known(getattr(score, key), 6) for key in ("value", "least", "mean", "p5")}
    return {**values, "branches": list(score.branches)}


def _point(details: PlacementDetails, target: int) -> dict[str, Json]:
    """Give a target with its value and its joints; null where it is not reached."""
    joints, T_board_tcp = details.joints[target], details.targets.T_board_tcp[target]
    turning = np.where(details.cell.robot.turning, np.degrees(joints), 1e3 * joints)
    return {
        "target": target,
        "at_mm": _digits(1e3 * details.place_of(target)[0], 3),
        "on": details.place_of(target)[1],
        "orifice_mm": _digits(1e3 * T_board_tcp[:3, 3], 3),
        "jet": _digits(T_board_tcp[:3, 2]),
        "value": _known(details.values[target], 6),
        "configuration": int(details.region[target]) if details.region[target] >= 0 else None,
        "joints_deg_mm": _digits(turning, 4) if np.isfinite(joints).all() else None,
    }


def _configuration(details: PlacementDetails, each: ConfigurationValues) -> dict[str, Json]:
    return {
        "branch": each.branch,
        "name": each.name,
        "reached": _known(each.reached, 6),
        "score": _score(each.score),
        "box": {f"p{100 * share:g}": _known(value, 6) for share, value in zip(SHARES, each.box, strict=True)},
        "worst_target": each.worst,
        "share_of_points": _known(np.mean(details.region == each.branch), 6),
    }


def _failing(details: PlacementDetails, each: FailingPoint) -> dict[str, Json]:
    reached = np.isfinite(each.value)
    missing = _known(each.missing if reached else 1e3 * each.missing, 6)
    how: dict[str, Json] = {"below_floor": missing} if reached else {"nearer_mm": missing, "collides": missing == 0.0}
    point = _point(details, each.target)
    return {
        "target": each.target,
        "at_mm": point["at_mm"],
        "configuration": each.branch,
        "value": point["value"],
        **how,
    }


def _known(value: float, places: int = 5) -> float | None:
    """Round a number; null where it is not finite."""
    return round(float(value), places) + 0.0 if np.isfinite(value) else None


def _digits(values: Poses, places: int = 6) -> list[Json]:
    return [round(float(value), places) + 0.0 for value in values]
