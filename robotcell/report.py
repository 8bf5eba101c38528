"""The check of a program in a cell as plain data, for ``--report`` and the card. Millimetres and degrees."""

import numpy as np

from programs.program import MoveTo, TimedProgram, Totals
from robotcell.motion.retime import Rates, rates_of
from robotcell.robot.robot import Joint
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
        worst = int(np.argmin(np.round(distances, 6)))
        touch = report.clearance.touches[worst]
        nearest = {
            "least_mm": _digits(distances[worst] * 1e3),
            "pair": None if touch is None else [touch.body, touch.other],
            "at": _moment(report.program, int(report.clearance_at[worst])),
            "looked_at": len(distances),
        }
    rates = rates_of(report.program, report.joints)
    motion: dict[str, Json] = {
        "done": _totals(report.program.totals),
        "added": {
            "from_home_s": _digits(report.added.from_home),
            "tool_changes_s": _digits(report.added.tool_changes),
            "to_home_s": _digits(report.added.to_home),
        },
        "joints": [joint_use(joint, rates, index) for index, joint in enumerate(report.cell.robot.joints)],
        "singularity": {
            "least_w": _digits(report.singularity.min()),
            "mean_w": _digits(report.singularity.mean()),
            "least_inverse_condition": _digits(report.condition.min()),
            "at": _moment(report.program, int(np.argmin(report.condition))),
        },
        "clearance": nearest,
    }
    return data | motion


def joint_use(joint: Joint, rates: Rates, index: int) -> dict[str, Json]:
    """Give the use of a joint and its limits; degrees where it turns, millimetres where it slides."""
    scale, unit = (180.0 / np.pi, "deg") if joint.kind == "revolute" else (1e3, "mm")
    q = rates.q[:, index]
    return {
        "name": joint.name,
        f"lowest_{unit}": _finite(scale * joint.lowest),
        f"highest_{unit}": _finite(scale * joint.highest),
        f"from_{unit}": _digits(scale * q.min()),
        f"to_{unit}": _digits(scale * q.max()),
        f"greatest_speed_{unit}_s": _digits(scale * np.abs(rates.speed[:, index]).max(initial=0.0)),
        f"speed_limit_{unit}_s": _digits(scale * joint.speed),
        f"greatest_acceleration_{unit}_s2": _digits(scale * np.abs(rates.acceleration[:, index]).max(initial=0.0)),
        f"acceleration_limit_{unit}_s2": _digits(scale * joint.acceleration),
    }


def _moment(program: TimedProgram, number: int) -> dict[str, Json]:
    """Give when and where a move ends, and its recipe path."""
    move = [item for item in program.instructions if isinstance(item, MoveTo)][number]
    return {
        "time_s": round(move.time_s, 4),
        "where": [round(value, 3) for value in move.position],
        "made_by": str(move.made_by),
    }


def _totals(totals: Totals) -> dict[str, Json]:
    return {
        "duration_s": round(totals.duration_s, 4),
        "spray_s": round(totals.spray_s, 4),
        "travel_mm": round(totals.travel_mm, 3),
        "moves": totals.moves,
    }


def _finite(value: float) -> float | None:
    return round(float(value), 4) if np.isfinite(value) else None


def _digits(value: float) -> float:
    return round(float(value), 5)
