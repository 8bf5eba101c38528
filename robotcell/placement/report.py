"""A placement as plain data, for ``--report``. Millimetres and degrees."""

import numpy as np

from robotcell.placement.configurations import SHARES, ConfigurationValues, FailingPoint, PlacementDetails
from robotcell.placement.criteria import Score
from robotcell.placement.optimise import Placement
from robotcell.placement.placement_map import PlacementMap
from robotcell.robot.robot import Poses
from specs.json import Json


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
        "score": score_data(details.score),
        "T_cell_board": _pose_data(details.cell.T_cell_board),
        "configurations": [_configuration(details, each) for each in details.configurations],
        "worst": point_data(details, details.worst),
        "failing": [_failing(details, each) for each in details.failing],
    }
    if mapped is not None:
        data["map"] = {
            "x_mm": [_digits(1e3 * each, 3) for each in mapped.x.tolist()],
            "y_mm": [_digits(1e3 * each, 3) for each in mapped.y.tolist()],
            "yaw_deg": [_digits(float(np.degrees(each)), 3) for each in mapped.yaw.tolist()],
            "values": [[[_digits(each) for each in row] for row in rows] for rows in mapped.values.tolist()],
            "best": list(mapped.best),
            "best_score": score_data(mapped.score),
            "refined": None if mapped.refined is None else _place_data(mapped.refined),
        }
    return data


def _pose_data(T_cell_board: Poses) -> list[Json]:
    return [[_digits(each, 9) for each in row] for row in T_cell_board.tolist()]


def _place_data(place: Placement) -> dict[str, Json]:
    return {"T_cell_board": _pose_data(place.T_cell_board), "score": score_data(place.score)}


def score_data(score: Score) -> dict[str, Json]:
    """Give a score; null where a point is not reached."""
    return {
        "value": _digits(score.value),
        "least": _known(score.least),
        "mean": _known(score.mean),
        "p5": _known(score.p5),
        "branches": list(score.branches),
    }


def point_data(details: PlacementDetails, target: int) -> dict[str, Json]:
    """Give a target with its value and its joints; null where it is not reached."""
    joints = details.joints[target]
    turning = np.where(details.cell.robot.turning, np.degrees(joints), 1e3 * joints)
    return {
        "target": target,
        "at_mm": [_digits(1e3 * each, 3) for each in details.targets.T_board_tcp[target, :3, 3].tolist()],
        "jet": [_digits(each) for each in details.targets.T_board_tcp[target, :3, 2].tolist()],
        "value": _known(float(details.values[target])),
        "configuration": int(details.region[target]) if details.region[target] >= 0 else None,
        "joints_deg_mm": [_digits(each, 4) for each in turning.tolist()] if np.isfinite(joints).all() else None,
    }


def _configuration(details: PlacementDetails, each: ConfigurationValues) -> dict[str, Json]:
    return {
        "branch": each.branch,
        "name": each.name,
        "reached": _digits(each.reached),
        "score": score_data(each.score),
        "box": {f"p{100 * share:g}": _known(value) for share, value in zip(SHARES, each.box.tolist(), strict=True)},
        "worst_target": each.worst,
        "share_of_points": _digits(float(np.mean(details.region == each.branch))),
    }


def _failing(details: PlacementDetails, each: FailingPoint) -> dict[str, Json]:
    reached = np.isfinite(each.value)
    missing = _known(each.missing if reached else 1e3 * each.missing)
    how: dict[str, Json] = {"below_floor": missing} if reached else {"nearer_mm": missing, "collides": missing == 0.0}
    point = point_data(details, each.target)
    return {
        "target": each.target,
        "at_mm": point["at_mm"],
        "configuration": each.branch,
        "value": point["value"],
        **how,
    }


def _known(value: float) -> float | None:
    return _digits(value) if np.isfinite(value) else None


def _digits(value: float, places: int = 6) -> float:
    return round(float(value), places) + 0.0
