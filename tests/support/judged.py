"""Numbers for the rules, made by hand: one component after a wash, a rinse and a drying, all well unless said."""

from dataclasses import replace
from functools import cache

import numpy as np

from boards.undersides.underside import GapCase, Underside
from cleaning.gap.flow_field import GapField
from cleaning.parameters.load import load_parameters
from cleaning.parameters.model import PartOverride
from cleaning.process.stages import Samples, Stage
from cleaning.undersides.residue import GapResult, GapStage
from cleaning.verdicts.results import Evidence, ExposedPart, Reach
from recipes.nozzles import HollowCone

USES = ("wash", "rinse", "dry")
SOLUTIONS = ("saponifier-15", "di-water", "hot-air")


@cache
def library_parameters():
    return load_parameters()


def stage(use="wash", **changes):
    index = USES.index(use)
    liquid = library_parameters().liquids[SOLUTIONS[index]]
    none = Samples(np.empty(0), np.empty(0), np.empty((0, 3)), np.empty((0, 3, 3)), np.empty(0, dtype=np.int64), ())
    first = Stage(
        f"sequence[{index}]", ("clean", "rinse", "dry")[index], use, "ring60",
        HollowCone(flow_lpm=2, half_angle_deg=30), SOLUTIONS[index], liquid, 3.5e5, 60.0, 0.0, 10.0, none,
    )  # fmt: skip
    return replace(first, **changes)


def exposed(missed=0.0, low=20.0, front=2.0, peak=300.0, area=12.0):
    return ExposedPart(
        area, 3.0, missed, *[(low / 2, low, 2 * low)] * 2, (front / 2, front, front), (9.0, 9.0, 9.0), 0.2, peak
    )


def gap_stage(**changes):
    first = GapStage(
        margin_pa=800.0, entered=True, edge_pa=(800.0,) * 8, side_shear_pa=(1.0, 1.0, 1.0, 1.0),
        shear_pa=np.full(4, 2.0, np.float32), weak_share=0.0, exchanges=40.0, reynolds=0.5, wet_s=300.0,
        residue=np.zeros(4, np.float32),
    )  # fmt: skip
    return replace(first, **changes)


def gap(wash=None, rinse=None, **changes):
    field = GapField(
        5e-5, 5e-3, 5e-3, (2, 2), np.arange(4), np.zeros((4, 2)), np.zeros((8, 4), np.float32),
        np.zeros((8, 4, 2), np.float32), 5e-3, 1.0, 0.0,
    )  # fmt: skip
    first = GapResult(
        gap_height_mm=0.05, field=field, fill=0.3, stages=(gap_stage(**(wash or {})), gap_stage(**(rinse or {})), None),
        exchanges_needed=10.0, residue=0.01, residue_worst=0.05, worst_at=(1.0, 0.0), ionic_ug_cm2=0.1,
        blow_off_um=30.0, dry_s=20.0,
    )  # fmt: skip
    return replace(first, **changes)


def underside(turn_rad=0.0):
    return Underside("U1", 10.0, 20.0, turn_rad, 5.0, 5.0, (GapCase(0.05, ()),), "stated", "board file")


def evidence(gaps=(), parameters=None, **changes):
    stages = tuple(stage(use) for use in USES)
    seen = (exposed(), exposed(), exposed())
    first = Evidence(
        "U1", "top", (10.0, 20.0, 0.0), stages, seen,
        (Reach("wash", "clean", "sequence[0]", 1, seen[0]), Reach("rinse", "rinse", "sequence[1]", 1, seen[1])),
        underside() if gaps else None, gaps, PartOverride(match=["U1"]), "", parameters or library_parameters(),
    )  # fmt: skip
    return replace(first, **changes)
