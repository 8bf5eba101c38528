"""A cleaning report on the board ``tiny``, made by hand: every verdict, every kind of number, nothing calculated.

A wash and a rinse from the top. U1 is dirty at both of its standoffs, R1 marginal, C1 and R2 clean, J1 has no verdict.
"""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
from cleaning_surface import exposure_of, facets_of, run_offs_of
from made_findings import made_finding

from boards.board import Board
from boards.load import load_board
from boards.undersides.underside import GapCase, Joint, Underside
from cleaning.gap.flow_field import GapField
from cleaning.parameters.load import load_parameters
from cleaning.process.stages import Samples, Stage
from cleaning.undersides.residue import GapResult, GapStage
from cleaning.verdicts.results import CleaningReport, ExposedPart, Judgement, Number, Part
from cleaning.verdicts.rules import (
    INCOMPLETE_RINSE,
    MODEL_LIMIT,
    ONE_SIDED,
    RESIDUE_LEFT,
    SPENT_BATH,
    UNDER_EXPOSED,
    WET_GAP,
)
from programs.plan import Origin
from recipes.nozzles import HollowCone
from specs.source import Source

STAGES = 2
_MAKER = Source(0, "around", ("U1",))
WET = Judgement(rule=WET_GAP, verdict="marginal", because="It stays wet.", advice="Bake it.")


@cache
def small_board() -> Board:
    """``tiny`` with its components in the order of ``_PARTS``, by whose numbers tests take them."""
    board, names = load_board(Path("tiny")), list(_PARTS)
    components = sorted(board.components, key=lambda component: names.index(component.name))
    return replace(board, components=tuple(components))


@cache
def small_report() -> CleaningReport:
    """Give the report; the same object every time, so do not change its arrays."""
    board = small_board()
    parameters = load_parameters()
    facets = facets_of(board)
    stages = tuple(_stage(index, parameters) for index in range(STAGES))
    parts = tuple(_PARTS[component.name](component) for component in board.components)
    return CleaningReport(
        origin=Origin(board.name, board.sha256, "smt-aqueous", "77b0" * 16),
        board=board,
        parameters=parameters,
        parameters_sha256="5eed" * 16,
        stages=stages,
        facets=facets,
        exposures=tuple(exposure_of(facets, stage) for stage in stages),
        run_off=run_offs_of(board, facets, parameters),
        bare=_part("board", _CLEAN_SURFACE, volume=9.0),
        parts=parts,
        process=(
            _judge(SPENT_BATH, "clean", numbers=(Number("bath residue", 1.0, "%", 3.0),)),
            _judge(INCOMPLETE_RINSE, "clean", numbers=(Number("resistivity", 1.0, "MOhm cm", 0.2),)),
        ),
        verdict="dirty",
        duration_s=92.5,
        litres=(("clean", 1.62), ("rinse", 0.98)),
        findings=(
            made_finding(
                "r7-residue", "warning", "U1: 31 % of the residue is left under it.", _MAKER, (9.0, 12.0, 0.0)
            ),
            made_finding("r14-model-limit", "info", "J1: fewer than 30 rays landed on it.", "", (25.0, 10.0, 0.0)),
            made_finding(
                "loop-once",
                "info",
                "rinse is repeated until a sensor ends it; it is analysed done once.",
                "sequence[1]",
            ),
        ),
    )


def soaked(part):
    """The part with water left under it."""
    if part.verdict == "clean":
        return replace(part, verdict="marginal", judgements=(WET, *part.judgements))
    return replace(part, judgements=(*part.judgements, WET))


def soaked_report() -> CleaningReport:
    """Give the report with water left under every part."""
    report = small_report()
    return replace(report, parts=tuple(map(soaked, report.parts)))


def _stage(index, parameters) -> Stage:
    """Stripes along x, one above the other, 40 s of spraying each stage."""
    rows, columns = 5, 16
    x, y = np.meshgrid(np.linspace(-5, 35, columns), np.linspace(-5, 25, rows))
    tcp = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 50.0)])
    seconds = np.full(len(tcp), 40.0 / len(tcp))
    begin = 46.0 * index
    return Stage(
        made_by=Source.parse(f"sequence[{index}]"),
        function=("clean", "rinse")[index],
        use=("wash", "rinse")[index],
        nozzle_name="ring60",
        nozzle=HollowCone(flow_lpm=2.0, half_angle_deg=30.0),
        solution=("saponifier-15", "di-water")[index],
        liquid=parameters.liquids[("saponifier-15", "di-water")[index]],
        pressure_pa=(3.5e5, 2.5e5)[index],
        temperature_c=60.0,
        begin_s=begin,
        end_s=begin + 46.0,
        samples=Samples(
            times=begin + 3.0 + np.cumsum(seconds) - seconds / 2,
            seconds=seconds,
            tcp=tcp,
            axes=np.broadcast_to(np.diag([1.0, -1.0, -1.0]), (len(tcp), 3, 3)),
            made_by=np.arange(len(tcp)) % 2,
            makers=(Source(index, "sweep"), Source(index, "around", ("U1",))),
        ),
    )


def field_of(length_mm, width_mm, gap_height_mm, joints) -> GapField:
    """A smooth pressure by distance from each segment; cells under joints are left out."""
    rows = columns = 16
    x = (np.arange(columns) + 0.5) / columns * length_mm - length_mm / 2
    y = (np.arange(rows) + 0.5) / rows * width_mm - width_mm / 2
    gx, gy = np.meshgrid(x, y)
    quarter = ((-0.25, -0.5), (0.25, -0.5), (0.5, -0.25), (0.5, 0.25), (0.25, 0.5), (-0.25, 0.5), (-0.5, 0.25),
               (-0.5, -0.25))  # fmt: skip
    weight = np.stack([1 / (0.02 + (gx / length_mm - a) ** 2 + (gy / width_mm - b) ** 2) for a, b in quarter])
    pressure = weight / weight.sum(axis=0)
    mobility = (gap_height_mm / 1000) ** 2 / 12
    slope = [np.gradient(each, width_mm / rows / 1000, length_mm / columns / 1000) for each in pressure]
    velocity = -mobility * np.stack([np.stack([down_x, down_y], axis=-1) for down_y, down_x in slope])
    solid = np.zeros(gx.shape, dtype=bool)
    for joint in joints:
        solid |= (abs(gx - joint.x_mm) < joint.length_mm / 2) & (abs(gy - joint.y_mm) < joint.width_mm / 2)
    cells = np.flatnonzero(~solid)
    return GapField(
        height_m=gap_height_mm / 1000,
        length_m=length_mm / 1000,
        width_m=width_mm / 1000,
        shape=(rows, columns),
        cells=cells,
        centres=np.column_stack([gx.ravel(), gy.ravel()])[cells] / 1000,
        pressure=pressure.reshape(8, -1)[:, cells].astype(np.float32),
        velocity=velocity.reshape(8, -1, 2)[:, cells].astype(np.float32),
        path_m=min(length_mm, width_mm) / 2000,
        open_share=len(cells) / gx.size,
        coverage=1 - len(cells) / gx.size,
    )


def _gap(underside: Underside, number: int, residue: float, margin_pa: float) -> GapResult:
    case = underside.cases[number]
    field = field_of(underside.length_mm, underside.width_mm, case.gap_height_mm, case.joints)
    far = 1 - np.hypot(field.centres[:, 0] / field.length_m, field.centres[:, 1] / field.width_m)
    left = np.clip(residue * far / far.mean(), 0, 1).astype(np.float32)
    shear = (0.1 + 2.0 * (1 - far)).astype(np.float32)
    after = tuple(
        GapStage(
            margin_pa=margin_pa - 90 * index,
            entered=margin_pa > 90 * index,
            edge_pa=(820.0, 790.0, 410.0, 400.0, 640.0, 650.0, 380.0, 390.0),
            side_shear_pa=(0.4, 0.2, 0.3, 0.05),
            shear_pa=shear,
            weak_share=float((shear < 0.1).mean()),
            exchanges=(38.0, 5.5)[index],
            reynolds=0.8,
            wet_s=(31.0, 18.0)[index],
            residue=left,
        )
        for index in range(STAGES)
    )
    worst = np.argsort(-left, kind="stable")[: max(1, len(left) // 10)]
    place = field.centres[worst].mean(axis=0) * 1000
    return GapResult(
        gap_height_mm=case.gap_height_mm,
        field=field,
        fill=0.3,
        stages=after,
        exchanges_needed=12.0,
        residue=residue,
        residue_worst=float(left[worst].mean()),
        worst_at=(float(place[0]), float(place[1])),
        ionic_ug_cm2=0.4,
        blow_off_um=None,
        dry_s=None,
    )


def _judge(rule, verdict, variant="", **more) -> Judgement:
    numbers = more.pop("numbers", ())
    told = ", ".join(f"{each.name} {each.value:g} {each.unit}" for each in numbers)
    return Judgement(
        rule=rule,
        variant=variant,
        verdict=verdict,
        numbers=numbers,
        because=f"{variant or rule.title}: {told}.",
        advice=more.pop("advice", ""),
        **more,
    )


_CLEAN_SURFACE = (_judge(UNDER_EXPOSED, "clean", numbers=(Number("volume p5", 7.0, "mm", 5.0),)),)


def _part(name, judgements, volume, underside=None, gaps=()) -> Part:
    """Put one together; the elasticities are the same for all that have a gap."""
    seen = ExposedPart(9.0, 3.0, 0.01, *[(0.0, volume / 2, volume)] * 2, (0.0, 1.1, 2.6), (0.0, 4.0, 7.5), 0.2, 310.0)
    elasticity = {"time": -2.1, "temperature": -1.4, "chemistry": -1.9, "pressure": -0.4, "standoff": -0.3}
    return Part(
        component=name,
        verdict=judgements[0].verdict,
        grade=judgements[0].grade,
        judgements=judgements,
        exposed=(seen,) * STAGES,
        underside=underside,
        gaps=gaps,
        elasticity=elasticity if gaps else {},
        limiting="time" if gaps else "",
        makers=((_MAKER, 0.62), (Source(0, "sweep"), 0.38)),
    )


def _underside(component, length_mm, width_mm, standoffs, joints) -> Underside:
    middle = component.footprint.centroid
    cases = tuple(GapCase(standoff, joints) for standoff in standoffs)
    return Underside(
        component.name, middle.x, middle.y, 0.0, length_mm, width_mm, cases, "family QFN", "unknown: none and many"
    )


def _dirty(component) -> Part:
    underside = _underside(component, 3.0, 3.0, (0.05, 0.075), (Joint(0.0, 0.0, 1.6, 1.6),))
    residue = (Number("residue", 31.0, "%", 20.0), Number("worst tenth", 58.0, "%", 50.0))
    judgements = (
        _judge(RESIDUE_LEFT, "dirty", numbers=residue, stage=Source.parse("sequence[0]"), where=(8.8, 12.2, 0.0),
               advice="Wash it longer: time limits it most."),
        _judge(ONE_SIDED, "marginal", variant="one-sided flow", sides=((-1.0, 0.0),), stage=Source.parse("sequence[0]"),
               numbers=(Number("weak share", 31.0, "%", 25.0),), advice="Add a pass from the left."),
        *_CLEAN_SURFACE,
    )  # fmt: skip
    return _part(
        component.name, judgements, 11.0, underside, (_gap(underside, 0, 0.31, 60.0), _gap(underside, 1, 0.24, 180.0))
    )


def _marginal(component) -> Part:
    underside = _underside(component, 1.6, 0.8, (0.03,), (Joint(-0.6, 0.0, 0.3, 0.8), Joint(0.6, 0.0, 0.3, 0.8)))
    judgements = (
        _judge(INCOMPLETE_RINSE, "marginal", numbers=(Number("exchanges", 5.5, "", 7.0),),
               stage=Source.parse("sequence[1]"), advice="Rinse it longer."),
    )  # fmt: skip
    return _part(component.name, judgements, 8.0, underside, (_gap(underside, 0, 0.04, 120.0),))


def _clean(component) -> Part:
    return _part(component.name, _CLEAN_SURFACE, 12.0)


def _no_verdict(component) -> Part:
    few = _judge(MODEL_LIMIT, "no verdict", numbers=(Number("hits", 12.0, "", 30.0),),
                 advice="Verify it: washboard analyse --verify J1.")  # fmt: skip
    return _part(component.name, (few,), 1.0)


_PARTS = {"U1": _dirty, "C1": _clean, "R1": _marginal, "R2": _clean, "J1": _no_verdict}
