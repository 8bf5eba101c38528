"""Rule R14 as far as it concerns how the nozzle is held: where the model of its spray does not hold."""

from collections.abc import Sequence

import numpy as np

from boards.board import Board
from cleaning.process.stages import Stage
from cleaning.verdicts.results import Judgement, Number
from cleaning.verdicts.rules import MODEL_LIMIT
from geometry.arrays import Scalars
from recipes.footprint import mid_angles
from recipes.nozzles import FullCone, HollowCone

NEAREST_MM, FARTHEST_MM = 20.0, 200.0
"""Heights of the orifice over the board at which the spray is taken to be as at the height of its data sheet."""
_SHARE = 0.05
"""Share of the spraying time that may lie outside without a word: entering and leaving the board."""


def judge_range(stages: Sequence[Stage], board: Board) -> list[Judgement]:
    """R14 for stages of liquid whose spray does not close on the board, or that spray from too near or too far."""
    return [judgement for stage in stages if stage.use != "dry" for judgement in _judge(stage, board)]


def _judge(stage: Stage, board: Board) -> list[Judgement]:
    up = 1.0 if stage.side == "top" else -1.0
    heights = up * (stage.samples.tcp[:, 2] - board.surface_z_mm(stage.side))
    shares = {
        "its spray does not close on the board": (_opening(stage, up) <= 0.0, "Tilt it less."),
        f"its nozzle is nearer than {NEAREST_MM:g} mm": (heights < NEAREST_MM, "Spray from further away."),
        f"its nozzle is farther than {FARTHEST_MM:g} mm": (heights > FARTHEST_MM, "Spray from nearer."),
    }
    found: list[Judgement] = []
    for what, (outside, advice) in shares.items():
        share = float(stage.samples.seconds[outside].sum()) / stage.spray_s if stage.spray_s > 0 else 0.0
        if share > _SHARE:
            number = Number("time outside of the model", 100.0 * share, "%", 100.0 * _SHARE)
            because = (
                f"In {number.value:.0f} % of the spraying time of {stage.function} {what}: the model does not hold."
            )
            found.append(
                Judgement(
                    rule=MODEL_LIMIT,
                    verdict="no verdict",
                    numbers=(number,),
                    because=because,
                    advice=advice,
                    stage=stage.made_by,
                )
            )
    return found


def _opening(stage: Stage, up: float) -> Scalars:
    """(samples,) least fall towards the board of the rays around the spray, per length along its axis.

    At or below 0 a ray never meets the board. For a cone of half angle a that leans by b it is cos b - sin b tan a,
    which has the sign of cos² b - sin² a, the discriminant of its footprint.
    """
    x, y, along = (-up * stage.samples.axes[:, 2, axis] for axis in range(3))
    nozzle = stage.nozzle
    if isinstance(nozzle, HollowCone | FullCone):
        widest = mid_angles(nozzle, np.linspace(0.0, 2.0 * np.pi, 360, endpoint=False, dtype=np.float64)).max()
        return np.asarray(along - np.hypot(x, y) * np.tan(widest), dtype=np.float64)
    wide, thin = np.tan(np.radians([nozzle.half_angle_deg, nozzle.thickness_half_angle_deg]))
    return np.asarray(along - np.abs(x) * wide - np.abs(y) * thin, dtype=np.float64)
